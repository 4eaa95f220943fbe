"""The papers paragraph by paragraph: whole, with every claim, and figures that are right."""

from __future__ import annotations

import itertools
import math
import re
import shlex
from itertools import takewhile
from pathlib import Path

import numpy as np
import pytest
from command_line import invoke
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm

from tauto_core.cli.terminal import given_values
from tauto_core.euler import trochlea_1727
from tauto_core.euler.axle_1780 import C, E, K
from tauto_core.euler.axle_edition import PUSH
from tauto_core.euler.edition import Edition, EulerFigure, G
from tauto_core.euler.site import EDITIONS, all_claims
from tauto_core.samples import FloatArray
from tauto_core.scene import load_scene

TENS = ['', 'X', 'XX', 'XXX']
ROMAN = [
    f'{ten}{one}'
    for ten in TENS[:3]
    for one in ('', 'I', 'II', 'III', 'IV', 'V', 'VI', 'VII', 'VIII', 'IX')
][1:] + TENS[3:]
PARAGRAPHS = {'A': ROMAN, 'B': [str(k) for k in range(1, 36)], 'C': [str(k) for k in range(1, 54)]}
FIGURES = {
    'A': ROMAN[:11],
    'B': [str(k) for k in range(1, 6)],
    'C': [*(f'Tab. IV, {k}' for k in range(3, 7)), 'Tab. V, 1', 'Tab. V, 2'],
}
EACH = pytest.mark.parametrize('edition', EDITIONS, ids=lambda each: each.file)


@EACH
def test_every_paragraph_and_every_figure_of_the_paper_is_there(edition: Edition) -> None:
    assert [each.number for each in edition.paragraphs] == PARAGRAPHS[edition.paper]
    assert [each.name for each in edition.figures] == FIGURES[edition.paper]
    shown = [name for each in edition.paragraphs for name in each.figures]
    assert sorted(shown) == sorted(FIGURES[edition.paper])


@EACH
def test_a_paragraph_has_two_sentences(edition: Edition) -> None:
    for each in edition.paragraphs:
        assert len(re.findall(r'[.?](?: |$)', each.argues)) == 2, each.number


@EACH
def test_every_claim_stands_beside_its_paragraph(edition: Edition) -> None:
    claims = all_claims()
    beside = edition.checked(claims)
    own = [claim for claim in claims if claim.paper == edition.paper]
    assert [claim for each in beside.values() for claim in each] == own
    for number, each in beside.items():
        assert all(re.match(rf'{number}\b', claim.paragraph) for claim in each)


@EACH
def test_each_command_belongs_to_one_paragraph(edition: Edition) -> None:
    runs = [line for each in edition.paragraphs for line in each.runs]
    assert len(set(runs)) == len(runs) > 20
    for each in edition.paragraphs:
        assert each.lacks == '' or each.lacks.endswith('.')


SINGLE = {'b|h', 'b′|h′', 'z|2', 'v|ν', 'a|α', 'a′|α′'}
"""Letters that the transcription confuses throughout. The claims have the right ones."""


def _as_in_text(words: str, keep: set[str]) -> str:
    """Return a text with the faults that are kept, without spaces, points and asterisks."""
    words = re.sub(r'‹([^|›]*)\|([^›]*)›', lambda m: m[1 if m[0][1:-1] in keep else 2], words)
    words = re.sub(r'\^\{([23])\}', lambda m: '²³'[int(m[1]) - 2], words)
    for latin, sign in ((' ad ', ':'), (' ita ', '='), ('est aequale vel majus quam', '≥')):
        words = words.replace(latin, sign)
    return re.sub(r'[\s.*]', '', words)


@EACH
def test_claims_quote_the_latin_with_its_faults_marked(edition: Edition) -> None:
    latin = {each.number: each.latin for each in edition.paragraphs}
    faults = set(re.findall(r'‹([^|›]*\|[^›]*)›', ' '.join(latin.values())))
    claims = [each for each in all_claims() if each.paper == edition.paper and each.euler]
    quoted = [each for each in claims if each.stands]
    assert len(quoted) > 20
    for claim in quoted:
        words = ' '.join(latin[number] for number in edition.covered(claim))
        stands = _as_in_text(words, faults), _as_in_text(words, faults - SINGLE)
        for each in claim.stands.split(', '):
            assert any(_as_in_text(each, set()) in text for text in stands), (
                claim.paragraph,
                each,
            )
        for each in claim.must.split(', '):
            assert _as_in_text(each, set()) in _as_in_text(words, set()), (claim.paragraph, each)


@EACH
def test_the_commands_run(
    edition: Edition, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a voyage only the scene is loaded, with its settings."""
    monkeypatch.chdir(tmp_path)
    for line in sorted({line for each in edition.paragraphs for line in each.runs}):
        words = shlex.split(line)
        assert words[0] == 'tauto'
        if words[1] in ('sail', 'compare') or words[1:3] == ['scene', 'check']:
            named = words[3 if words[1] == 'scene' else 2 :]
            scenes = list(takewhile(lambda each: not each.startswith('--'), named))
            settings = [each for each in words[2:] if '=' in each]
            for scene in scenes:
                load_scene(scene, **given_values(settings))
        elif words[1] == 'plot':
            _runs([*words[1:], '--out', 'picture.svg'], line)
        elif words[1] != 'euler':  # tests/cli/test_cli_euler_page.py
            _runs(words[1:], line)


def _runs(words: list[str], line: str) -> None:
    said = invoke(*words)
    assert said.exit_code == 0, (line, said.output)


def _shown(figure: EulerFigure) -> list[tuple[tuple[float, ...], str, str]]:
    """Return the values of the controls, the words and the drawing, for all values."""
    every = itertools.product(*(each.values for each in figure.controls))
    frames = [(values, figure.draw(*values)) for values in every]
    return [
        (values, shown.says.replace('*', ''), shown.drawing.markup) for values, shown in frames
    ]


def _figure(paper: str, name: str) -> EulerFigure:
    (edition,) = (each for each in EDITIONS if each.paper == paper)
    (figure,) = (each for each in edition.figures if each.name == name)
    return figure


def _numbers(text: str) -> list[float]:
    return [float(each) for each in re.findall(r'-?\d+(?:\.\d+)?(?:e-?\d+)?', text)]


@EACH
def test_a_control_moves_its_figure_with_letters_on_it(edition: Edition) -> None:
    for figure in edition.figures:
        for each in figure.controls:
            assert 0 <= each.begin < len(each.values)
            assert not each.names or len(each.names) == len(each.values)
        every = list(itertools.product(*(each.values for each in figure.controls)))
        drawings = [figure.draw(*values).drawing for values in every]
        assert len({drawing.markup for drawing in drawings}) == len(every), figure.name
        for values, drawing in zip(every, drawings, strict=True):
            # all lines have finite places
            assert not re.search('nan|inf', drawing.markup), (figure.name, values)
            wide, high = drawing.size
            for x, y in re.findall(r'<text class="letter" x="(\S+)" y="(\S+)"', drawing.markup):
                assert 0.0 < float(x) < wide, (figure.name, values)
                assert 0.0 < float(y) < high, (figure.name, values)


def test_the_recipe_of_figure_vi_leads_to_the_unrolled_circle() -> None:
    for (z,), says, _ in _shown(_figure('A', 'VI')):
        x, y = trochlea_1727.circle_unrolled(np.array(z))
        polar, radius = float(np.arctan2(y, x)), float(np.hypot(x, y))
        shown = _numbers(says.replace('BP − BN', ''))
        assert shown[:2] == [z, pytest.approx(np.arctan(z), abs=6e-6)]
        assert shown[2:5] == pytest.approx([polar, radius, radius], abs=6e-6)


def test_figure_ix_has_the_distance_of_its_equation() -> None:
    for (ratio, _), says, _ in _shown(_figure('A', 'IX')):
        _, arm, drawn, stated = _numbers(says)
        # lines of the thread that neighbour each other, found without the cam
        if arm + 0.25 < ratio:
            assert drawn == pytest.approx(trochlea_1727.envelope_distance(arm, ratio), abs=6e-6)
        assert drawn == pytest.approx(stated, abs=1.1e-5)


@pytest.mark.parametrize(('name', 'small'), [('V', 0.02), ('XI', 0.02)])
def test_neighbouring_points_run_together(name: str, small: float) -> None:
    frames = _shown(_figure('A', name))
    assert frames[-1][0] == (small,)
    off = []
    for (step,), says, _ in frames:
        first, second = _numbers(says)[:2]
        # V: the distance of R from T, XI: both ratios
        off.append(first / step if name == 'V' else abs(first - second) / step)
    assert off[-1] * small < 0.02
    # of first order in the step
    assert max(off) / min(off) < 1.6


def test_thread_of_figure_iii_keeps_its_length() -> None:
    """300 mm, one unit of the page each, with 41 points rounded to a tenth."""
    for (turn,), _, markup in _shown(_figure('A', 'III')):
        (path,) = re.findall(r'class="thread" d="M([^"]*)"', markup)
        x, y = np.array([each.split() for each in path.split('L')], np.float64).T
        assert np.hypot(np.diff(x), np.diff(y)).sum() == pytest.approx(300.0, abs=0.6), turn


def test_descents_of_figure_1_take_the_same_time_on_every_curve() -> None:
    frames = _shown(_figure('B', '1'))
    found = [_numbers(says)[-1] for _, says, _ in frames]
    # (π/2)√(f/g) with f = 1 m, against the figure's quadrature
    assert found == pytest.approx([0.5 * math.pi / math.sqrt(G)] * len(frames), abs=6e-7)


@pytest.mark.parametrize('at', [0, 17, 38, 63])
def test_swings_of_figure_2_agree_with_the_integrated_motion(at: int) -> None:
    (descent, ascent), says, _ = _shown(_figure('B', '2'))[at]
    *_, half_swing, begin, end = _numbers(says)
    kappa = 0.75

    def motion(_: float, state: FloatArray) -> list[float]:
        arc, rate = state
        length = descent if arc > 0.0 else ascent
        force = math.expm1(kappa * arc) / (kappa * length)
        return [rate, -G * force + kappa * rate * rate]

    def at_rest(_: float, state: FloatArray) -> float:
        return float(state[1]) + (1e-9 if state[0] > 0.0 else 0.0)

    at_rest.terminal, at_rest.direction = True, 1.0
    run = solve_ivp(
        motion, (0.0, 5.0), [begin, 0.0], 'DOP853', rtol=1e-10, atol=1e-12, events=at_rest
    )
    # the drag acts against motion towards −s only: up to the other side
    assert run.t_events[0][-1] == pytest.approx(half_swing, abs=2e-5)
    assert -run.y_events[0][-1][0] == pytest.approx(end, abs=3e-5)


def test_figures_3_and_4_have_the_cusps_of_the_curve() -> None:
    for (kappa,), says, _ in _shown(_figure('B', '3')):
        arc, height = _numbers(says)[:2]
        # γκf dx/ds = e^{κs} − 1, f = 1 m, and its integral
        slope = math.expm1(kappa * arc) / (0.9 * kappa) if kappa else arc / 0.9
        assert slope == pytest.approx(1.0, abs=2e-5)
        area = quad(lambda s, k=kappa: math.expm1(k * s) / (0.9 * k) if k else s / 0.9, 0.0, arc)
        assert height == pytest.approx(area[0], abs=2e-5)
    without = [
        ascent for (ascent,), says, _ in _shown(_figure('B', '4')) if 'no point of return' in says
    ]
    assert without == [1.5, 1.7, 2.0]  # γκh ≥ 1 from h = 1.4815 m


def _small_swings(e: float, c: float, k: float) -> FloatArray:
    """Return the matrix of the small swings, (θ, Φ)'' = −matrix (θ, Φ), from their equations."""
    mass = np.array([[e, c], [0.0, k * k]])
    pull = np.array([[G, 0.0], [-G * c, G * c]])
    return np.asarray(np.linalg.solve(mass, pull))


@pytest.mark.parametrize(
    ('name', 'side'), [('Tab. IV, 4', 1.0), ('Tab. V, 1', -1.0), ('Tab. V, 2', 1.0)]
)
def test_lengths_of_both_modes_are_those_of_the_eigenvalues(name: str, side: float) -> None:
    for (e, c, k), says, _ in _shown(_figure('C', name)):
        found = sorted(float(each) for each in re.findall(r'h′? = (-?\d+\.\d{5}) m', says))
        squares = np.linalg.eigvals(_small_swings(side * e, c, k)).real
        assert found == pytest.approx(sorted(G / squares), abs=6e-6), (e, c, k)
        assert says.count('falls') == sum(squares < 0.0)
        # every body falls from a convex support, and a cradle with its centre of gravity above C
        assert ('falls' in says) == (side < 0.0 or c < 0.0)


def test_motions_of_figure_5_are_those_of_the_equations() -> None:
    motion, _ = _figure('C', 'Tab. IV, 5').controls
    matrix = _small_swings(E, C, K)
    for (which, seconds), says, _ in _shown(_figure('C', 'Tab. IV, 5')):
        theta, phi = (float(each) for each in re.findall(r'(?:AOa|Ahg) = (-?\d+\.\d+)', says))
        if motion.names[int(which)] == 'push n at G':
            system = np.block([[np.zeros((2, 2)), np.eye(2)], [-matrix, np.zeros((2, 2))]])
            state = expm(system * seconds) @ [0.0, 0.0, PUSH / E, 0.0]
            assert [theta, phi] == pytest.approx(list(state[:2]), abs=6e-6)
        elif abs(theta) > 0.05:
            # a mode keeps the ratio of its eigenvector
            vectors = np.linalg.eig(matrix)[1]
            assert min(abs(vectors[1] / vectors[0] - phi / theta)) < 4e-4


def test_figure_6_keeps_the_centre_of_gravity_in_its_vertical() -> None:
    for (phi, c, k), says, _ in _shown(_figure('C', 'Tab. IV, 6')):
        aside, swing, _ = _numbers(says)
        assert aside + c * math.sin(phi) == pytest.approx(0.0, abs=6e-5)
        # k² Φ'' = −g c Φ
        assert swing == pytest.approx(math.pi * k / math.sqrt(G * c), abs=6e-6)
