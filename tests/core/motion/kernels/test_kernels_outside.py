"""The piece of forcing laid out in compiled code, against NumPy's polynomials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from motion_cases import on_land, scene_of
from numpy.polynomial import Polynomial

from tauto_core.kernels import entry
from tauto_core.machines import compile_machine
from tauto_core.motion.collocation import Collocation
from tauto_core.motion.gauss_step import MOST_POWERS, make_work
from tauto_core.motion.system import ForcingPieces, outside_at, set_piece
from tauto_core.ship.buffer import newton_basis
from tauto_core.ship.sampling import FORCE_BEFORE, MAX_STRIDE, ROLL_BEFORE


@entry
def at_instant(forcing, k, x, work, out):
    length, terms = set_piece(forcing, k, True, work)
    at = outside_at(terms, x, work)
    out[0], out[1], out[2] = at.drive
    out[3], out[4], out[5] = at.tilt
    out[6], out[7] = at.gravity, length


def found(forcing, k, x, work):
    out = np.full(8, np.nan)
    at_instant(forcing, k, x, work, out)
    return out


def pieces(seed, *terms):
    """Lengths of three pieces, and channels of so many powers with falling coefficients."""
    random = np.random.default_rng(seed)
    falling = [random.standard_normal((3, n)) * 0.5 ** np.arange(n) for n in terms]
    return ForcingPieces(random.uniform(0.1, 3.0, 3), *falling)


def wanted(channel, k, x, length):
    series = Polynomial(channel[k])
    return [series(x), series.deriv(1)(x) / length, series.deriv(2)(x) / length**2]


@pytest.mark.parametrize(
    'terms', [(MOST_POWERS, MOST_POWERS, 20), (1, 1, 1), (7, 2, 4), (2, 3, 9)]
)
@pytest.mark.parametrize('x', [0.0, 0.3, 1.0])
def test_all_channels_and_their_derivatives_at_once(terms, x):
    """A long piece comes first and must leave no trace."""
    work = make_work(1, ())
    found(pieces(1, MOST_POWERS, MOST_POWERS, MOST_POWERS), 0, 0.7, work)
    forcing = pieces(2, *terms)
    for k in range(3):
        length = forcing[0][k]
        said = found(forcing, k, x, work)
        exact = wanted(forcing[1], k, x, length) + wanted(forcing[2], k, x, length)
        exact += [Polynomial(forcing[3][k])(x), length]
        # sums of two dozen terms that grow at most 23 · 22 fold, over length squared
        np.testing.assert_allclose(said, exact, rtol=1e-13, atol=1e-13 / length**2)


def test_absent_channels_are_zero():
    length, line, *_ = pieces(3, 6, 6, 6)
    said = found(ForcingPieces(length, line, None, None), 1, 0.4, make_work(1, ()))
    np.testing.assert_allclose(said[:3], wanted(line, 1, 0.4, length[1]), rtol=1e-13)
    assert not said[3:7].any()
    assert not found(ForcingPieces(length, None, None, None), 1, 0.4, make_work(1, ()))[:7].any()


def test_polynomials_longer_than_of_ship_motion_are_refused():
    widths = [
        newton_basis(MAX_STRIDE, ROLL_BEFORE, slopes=True).shape[0],
        newton_basis(MAX_STRIDE, FORCE_BEFORE, slopes=False).shape[0],
    ]
    assert max(widths) <= MOST_POWERS
    machine = compile_machine(scene_of())
    whole = replace(on_land(1, 1.0), neutral=np.zeros((1, MOST_POWERS + 1)))
    words = rf'neutral has {MOST_POWERS + 1} powers of x, at most {MOST_POWERS}'
    with pytest.raises(ValueError, match=words):
        Collocation(machine).advance(whole)
