"""The peers against closed forms and SciPy (ship.md, machine_at_sea.md)."""

from __future__ import annotations

import math
import sys
from functools import cache

import pytest

from benchmarks.work_precision.peer import MissingPeerError
from benchmarks.work_precision.peers import heyoka as heyoka_peers
from benchmarks.work_precision.peers.dop853 import CompiledDop853
from benchmarks.work_precision.peers.heyoka import Heyoka, HeyokaBatch, HeyokaTuned
from benchmarks.work_precision.problems import Problem, problems
from benchmarks.work_precision.runner import measure


@cache
def peer(kind):
    pytest.importorskip('heyoka')
    return kind()


def problem(key: str) -> Problem:
    return next(each for each in problems() if each.key == key)


@pytest.mark.parametrize('kind', [Heyoka, HeyokaTuned, HeyokaBatch])
def test_missing_library_is_named_with_what_installs_it(kind, monkeypatch):
    monkeypatch.setitem(sys.modules, 'heyoka', None)
    words = r'heyoka is not installed.*benchmarks/requirements'
    with pytest.raises(MissingPeerError, match=words):
        kind()


@pytest.mark.parametrize('key', 'abcdef')
def test_plain_heyoka_ends_at_the_reference(key):
    assert measure(problem(key), peer(Heyoka), '1e-15', 60.0).error_rad < 1e-9


@pytest.mark.parametrize(
    ('key', 'setting', 'bound'),
    [
        # bounds in rad after ten minutes: some three times what is left at these settings
        ('b', '1e-14', 2e-12),
        ('c', '1e-15 1 s 14 points', 2e-12),
        ('d', '1e-24 2 s 14 points', 3e-13),
        ('e', '1e-15 1 s 14 points', 2e-12),
        ('f', '1e-16', 3e-11),
    ],
)
def test_heyokas_best_formulations_end_at_the_reference(key, setting, bound):
    assert setting in peer(HeyokaTuned).settings(problem(key))
    assert measure(problem(key), peer(HeyokaTuned), setting, 600.0).error_rad < bound


@pytest.mark.parametrize(
    'key', ['a', 'b', 'c waves', 'c pieces', 'd waves', 'd pieces', 'e pieces']
)
def test_compiled_dop853_ends_where_the_reference_does(key):
    # 1e-12 a step, some 60 steps a swing, over a minute
    key, *way = key.split()
    setting = ' '.join(['1e-12', *way])
    assert setting in CompiledDop853().settings(problem(key))
    assert measure(problem(key), CompiledDop853(), setting, 60.0).error_rad < 1e-9 * 6.3


@pytest.mark.parametrize('way', ['waves', 'pieces'])
def test_compiled_dop853_has_its_order(way):
    """With steps h the error of a step is proportional to h^8, and their number to 1/h."""
    coarse, fine = (
        measure(problem('e'), CompiledDop853(), f'{tolerance} {way}', 600.0).error_rad
        for tolerance in ('1e-8', '1e-11')
    )
    # the tolerance holds for h^8: the error over a run goes like its power 7/8
    assert math.log10(coarse / fine) == pytest.approx(3.0 * 7.0 / 8.0, abs=0.4)


@pytest.mark.parametrize(
    ('key', 'setting'), [('c', '3e-13 0.5 s 8 points'), ('e', '1e-9 1 s 10 points')]
)
def test_each_ship_of_a_batch_sails_as_it_would_alone(key, setting):
    """Two compilations of the same steps; their lengths differ as the others' do not matter."""
    pytest.importorskip('heyoka')
    tolerance, length_s, points = heyoka_peers.piece_of(setting)
    numbers = problem(key).numbers
    fleet = heyoka_peers._Fleet(numbers, tolerance, length_s, points)
    fleet.advance(0.0, 100.3)
    for lane, own in enumerate(heyoka_peers.eight_seas(numbers)):
        alone = heyoka_peers._Pieces(own, own.sea, tolerance, length_s, points)
        alone.advance(0.0, 100.3)
        assert fleet.state[:2, lane] == pytest.approx(alone._state[:2], abs=1e-9)
    assert len({*fleet.state[0]}) == heyoka_peers.SHIPS


@pytest.mark.parametrize(
    ('key', 'setting', 'bound'),
    [('c', '3e-13 0.5 s 8 points', 1e-9), ('e', '1e-8 0.5 s 6 points', 1e-7)],
)
def test_the_first_ship_of_a_batch_meets_the_reference(key, setting, bound):
    row = measure(problem(key), peer(HeyokaBatch), setting, 60.0)
    assert row.error_s_per_day < 10.0 * bound
