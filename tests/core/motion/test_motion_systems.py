"""Properties of all systems that are integrated in steps: a table of systems by properties.

Each system is also compared with an independent integrator: the wheel in test_motion_reference,
lever and swinging thread in test_motion_real_threads, the case in test_motion_axle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from motion_cases import (
    SEA,
    TIED,
    arc,
    assert_same_bits,
    impulse,
    moved,
    moved_in_chunks,
    on_land,
    sampled,
    scene_of,
    weight_of,
)
from thread_references import HELD

from tauto_core.machines import compile_machine
from tauto_core.motion import Forcing, make_collocation
from tauto_core.motion.gauss_step import LEAST_SETTLED
from tauto_core.motion.suspended_case import AxleSwing, BearingMotion

WHEEL = weight_of(0.05, 0.02)
TROCHLEAS: dict[str, dict[str, Any]] = {
    'wheel': WHEEL,
    'cheek': {**WHEEL, 'cam': arc(0.02, 0.02)},
    'lever': {**WHEEL, 'thread': TIED},
    'thread': {**WHEEL, 'thread': {'kind': 'hanging', 'length': 0.6}},
}
UNBALANCED = {**WHEEL, 'imbalance': {'moment': 1e-4, 'direction': 0.7}}
RECOILING = {'drag': {'viscous': 2e-5}, 'escapement': impulse(1e-5, 0.01, recoil=4e-4)}
CLOCKS: dict[str, tuple[str, dict[str, Any]]] = {
    **{f'{name}, kept going': (name, HELD) for name in TROCHLEAS},
    'wheel, recoil': ('wheel', RECOILING),
    'lever, recoil': ('lever', RECOILING),
    'thread, recoil': ('thread', RECOILING),
    'unbalanced wheel, kept going': ('unbalanced wheel', HELD),
}
CASE = 0.015, 0.1, 0.05, 9.80665
"""e, c, k [m] of a suspended case, and gravity."""


def machine(name: str, release: float = 1.0, **more: Any) -> Any:
    trochlea, sections = CLOCKS.get(name, (name, {}))
    wheel = {**TROCHLEAS.get(trochlea, UNBALANCED), 'release_angle': release}
    return compile_machine(scene_of(trochlea=wheel, **{**sections, **more}))


def at_sea(felt_by: Any, duration_s: float, interval_s: float, rate: float = 20.0) -> Forcing:
    """The ship's motion as a machine feels it."""
    scene = scene_of(ship={**SEA, 'rate': rate}, duration=duration_s, log={'interval': interval_s})
    return sampled(scene, felt_by)


def bearing(count: int, step_ns: int) -> BearingMotion:
    """Pieces of a bearing that rests."""
    begin, length = np.arange(count) * step_ns, np.full(count, step_ns)
    still, lift = np.zeros((count, 1)), np.full((count, 1), CASE[3])
    return BearingMotion(begin, length, np.ones(count, int), still, lift)


# Restart and chunks


@pytest.mark.parametrize('name', CLOCKS)
def test_a_run_in_chunks_each_restored_anew_has_the_same_bits(name):
    """The sea moves the wheel more than its own swing."""
    swinging = machine(name, 0.02)
    forcing = at_sea(swinging, 12.0, 0.5)
    whole = moved(make_collocation(swinging), forcing)
    for spans in (1, 9):
        parts = moved_in_chunks(lambda: make_collocation(swinging), forcing, spans)
        assert_same_bits(parts, whole)


# Reversal: all of these keep their energy, so that the way back is the way there


@dataclass(frozen=True)
class Reversible:
    """A conservative system on land, and steps of a length."""

    engine: Any
    omega: float

    @property
    def planes(self) -> np.ndarray:
        """The state of each plane: a view."""
        return self.engine._state['planes']

    @property
    def places(self) -> np.ndarray:
        """X and Y of each plane, without what rounding left over, (2P,)."""
        return np.concatenate([self.planes['x'], self.planes['y']])

    def reverse(self) -> None:
        """Turn back in time."""
        for name in ('y', 'y_rest'):
            self.planes[name] *= -1.0

    def step(self, count: int, angle: float) -> None:
        """Go on by so many steps, together an angle [rad] of the swing."""
        step_s = angle / count / self.omega
        if isinstance(self.engine, AxleSwing):
            self.engine.advance(bearing(count, round(step_s * 1e9)))
        else:
            self.engine.advance(on_land(count, step_s))


def conservative(name: str) -> Reversible:
    if name == 'case':
        case = AxleSwing(*CASE)
        case.release(-CASE[3] * math.tan(0.4), CASE[3])
        return Reversible(case, max(case._omega))
    swinging = machine(name)
    engine = make_collocation(swinging)
    engine.release(on_land(1, 0.1))
    return Reversible(engine, swinging.frequency)


@pytest.mark.parametrize('name', [*TROCHLEAS, 'case'])
def test_swings_forward_and_back_end_where_they_began(name):
    """A thousand steps: rounding leaves a few 1e-13 rad of the amplitude."""
    swing = conservative(name)
    began = swing.places
    swing.step(1000, 500.0)
    assert np.max(np.abs(swing.places - began)) > 0.1
    swing.reverse()
    swing.step(1000, 500.0)
    swing.reverse()
    np.testing.assert_allclose(swing.places, began, rtol=0, atol=5e-12)


# Order: eight stages of Gauss make sixteen, whatever they are the stages of

HEAVY = {**WHEEL, 'power': {'kind': 'weight', 'mass': 2.0}}
"""A weight that triples the inertia on its way: less would leave rounding only."""


def swung(name: str, angle: float, count: int) -> np.ndarray:
    """X and Y after an angle of the swing [rad] in so many steps, none of which is halved."""
    if name == 'case':
        swing = conservative(name)
        engine: Any = swing.engine
        engine._tolerance = engine._tolerance._replace(step=1.0)
        # whole nanoseconds that all counts divide
        whole_ns = round(angle / swing.omega * 1e9 / 960) * 960
        engine.advance(bearing(count, whole_ns // count))
    else:
        trochlea = HEAVY if name == 'heavy wheel' else TROCHLEAS[name]
        swinging = compile_machine(scene_of(trochlea=trochlea))
        engine = make_collocation(swinging, 1.0)
        engine._tolerance = engine._tolerance._replace(settled=LEAST_SETTLED)
        engine.longest_step_s = math.inf
        engine.release(on_land(1, 0.1))
        swing = Reversible(engine, swinging.frequency)
        # away from the release, about which the error would be symmetric
        swing.step(1, 0.3)
        swing.step(count, angle)
    return swing.places


@pytest.mark.parametrize(
    ('name', 'angle', 'count'),
    [('heavy wheel', 8.0, 12), ('lever', 8.0, 5), ('thread', 8.0, 5), ('case', 24.0, 12)],
)
def test_half_the_step_errs_by_two_to_the_minus_sixteen(name, angle, count):
    """Over a few steps the leading term does not rule alone: within two of the order."""
    exact = swung(name, angle, 96)
    coarse, fine = (np.max(np.abs(swung(name, angle, n) - exact)) for n in (count, 2 * count))
    assert fine > 1e-15
    assert math.log2(coarse / fine) == pytest.approx(16.0, abs=2.0)


# Counts: beats and turns that are found at the nodes of long steps


@pytest.mark.parametrize('name', CLOCKS)
@pytest.mark.parametrize('release', [-0.05, 0.005])
def test_long_steps_count_the_signs_of_a_fine_log(name, release):
    """From swings that outweigh the sea to ones that it outweighs thirtyfold."""
    swinging = machine(name, release)
    runs = {}
    for interval_s in (0.02, 2.0):
        forcing = at_sea(swinging, 14.0, interval_s, rate=50.0)
        engine = make_collocation(swinging)
        begun = engine.release(forcing)
        runs[interval_s] = begun, engine.advance(forcing)
    (begun, fine), (_, coarse) = runs.values()
    every = slice(99, None, 100)
    below = np.concatenate([begun.angle, fine.angle]) < 0.0
    np.testing.assert_array_equal(coarse.beats, np.cumsum(below[1:] != below[:-1])[every])
    turned = np.concatenate([[0.0], fine.half_turns + fine.fraction])
    assert np.max(np.abs(np.diff(turned))) < 1.0
    np.testing.assert_allclose(
        coarse.half_turns + coarse.fraction, turned[1:][every], rtol=0, atol=1e-6
    )
