"""Machines with parameters that change with temperature, against a full integration.

The reference takes the printed equation (heat.2): the cam grows, I changes and İψ̇ acts, the
spring and the oil change continuously.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import arc, impulse, involute, moved, on_land, scene_of, weight_of
from reference_propagator import HotReference
from test_motion_systems import at_sea

from tauto_core.curves.cam import smooth_lever
from tauto_core.curves.cams.table import Fitted
from tauto_core.machines import Machine, compile_machine
from tauto_core.machines.heat import NO_HEAT, Heat
from tauto_core.motion import Forcing, make_propagator
from tauto_core.motion.forcing import Temperatures
from tauto_core.motion.free_end import FreeEndCollocation

CAM = involute(0.005)
WEIGHT = weight_of(0.322, 0.005)
OILED = {'drag': {'viscous': 1.25e-5, 'oil': {'thins_per_kelvin': 0.035}}}
KEPT_GOING = {**OILED, 'escapement': impulse(1.23052e-4)}
PULL = {'kind': 'force', 'force': 3.158, 'material': 'steel'}
BRASS = {'material': 'brass'}
MACHINES: dict[str, Any] = {
    'steel spring, brass wheel': ({**WEIGHT, **BRASS, 'power': PULL}, {}),
    'all of steel': (
        {**WEIGHT, 'power': {**PULL, 'kind': 'spring', 'stiffness': 50.0}, 'material': 'steel'},
        {},
    ),
    'cam of steel': ({**WEIGHT, **BRASS, 'cam': {**CAM, 'material': 'steel'}}, {}),
    'unbalanced, of zinc': (
        {
            **WEIGHT,
            'power': {'kind': 'force', 'force': 3.158},
            'material': 'zinc',
            'imbalance': {'moment': 2e-4, 'direction': 0.4},
        },
        {},
    ),
    'oil': ({**WEIGHT, **BRASS}, KEPT_GOING),
    'oil of a table that ages': (
        {**WEIGHT, **BRASS},
        {'drag': {'viscous': 1.25e-5, 'oil': 'sperm', 'thickens_per_month': 9.0}},
    ),
    'recoil and air': (
        {**WEIGHT, 'material': 'zinc'},
        {
            'drag': {'viscous': 1e-5, 'quadratic': 1e-5, 'oil': {'thins_per_kelvin': 0.05}},
            'escapement': impulse(1e-4, 0.1, recoil=1e-4),
        },
    ),
    'compensated': (
        {
            **WEIGHT,
            **BRASS,
            'power': PULL,
            'compensation': {'takes': -10.7, 'leaves': -0.01, 'middle': 15.0},
        },
        {},
    ),
}


def machine(name: str, **instead: Any) -> Machine:
    trochlea, sections = MACHINES[name]
    trochlea = {**trochlea, 'release_angle': 1.0, **instead}
    made = compile_machine(scene_of(trochlea=trochlea, **sections))
    assert isinstance(made, Machine)
    return replace(made, heat=replace(made.heat, varies=True))


def warmed(forcing: Forcing, interval_s: float, celsius: np.ndarray) -> Forcing:
    """Give spans the temperatures at the ends of their log intervals."""
    log_ns = round(interval_s * 1e9)
    interval = (forcing.end_ns - 1) // log_ns
    end_s = (forcing.end_ns - interval * log_ns) * 1e-9
    temperatures = Temperatures(
        celsius=np.stack([celsius[:-1], celsius[1:]], axis=1),
        begin_s=np.arange(len(celsius) - 1) * interval_s,
        interval_s=interval_s,
        interval=interval,
        place=(end_s - forcing.end * forcing.length_s) / interval_s,
    )
    return replace(forcing, temperatures=temperatures)


def reading_s(engine: Any, wheel: Machine, forcing: Forcing) -> np.ndarray:
    """Return the reading of a dial [s]."""
    motion = moved(engine, forcing)
    return 0.5 * wheel.small_period * (motion.half_turns + motion.fraction)


def compared(wheel: Machine, forcing: Forcing) -> tuple[float, float]:
    """Largest error of the reading, and the effect of heat on it at the end [s]."""
    still = forcing.neutral is None
    cold = make_propagator(replace(wheel, heat=NO_HEAT), still=still)
    engines = make_propagator(wheel, still=still), HotReference(wheel), cold
    found, exact, unheated = (reading_s(engine, wheel, forcing) for engine in engines)
    return float(np.max(np.abs(found - exact))), abs(float(exact[-1] - unheated[-1]))


@pytest.mark.parametrize(
    ('name', 'swings'),
    [*((name, 6.37) for name in MACHINES), ('cam of steel', 6.0)],
)
def test_a_clock_that_warms_on_land_reads_as_integrated(name: str, swings: float) -> None:
    """Also if logged instants keep step with the swing.

    To rounding without oil. A cubic per log interval replaces the oil's exponential: it errs by at
    most 2e-4 of the effect of 18 K in one interval, and falls with the fourth power.
    """
    wheel = machine(name)
    interval_s = round(swings * wheel.small_period, 9)
    spans, changes = on_land(4, interval_s), np.array([0.0, 13.0, 6.0, -12.0, -12.0])
    error_s, effect_s = compared(wheel, warmed(spans, interval_s, 20.0 + changes))
    assert effect_s > 5e-5
    if wheel.drag is None:
        assert error_s < 1e-10
        return
    assert error_s < 3e-4 * effect_s
    smaller_s, effect_s = compared(wheel, warmed(spans, interval_s, 20.0 + changes / 4.0))
    assert smaller_s < 0.01 * error_s


@pytest.mark.parametrize('name', ['cam of steel', 'oil'])
def test_a_clock_that_warms_at_sea_reads_as_integrated(name: str) -> None:
    wheel = machine(name)
    forcing = warmed(at_sea(wheel, 20.0, 5.0), 5.0, np.array([20.0, 35.0, 30.0, 10.0, 12.0]))
    error_s, effect_s = compared(wheel, forcing)
    assert error_s < 1e-11 + 1e-4 * effect_s * (wheel.drag is not None)


@pytest.mark.parametrize(
    ('cam', 'log_s', 'celsius'),
    [
        (CAM, 12.0, [20.0, 35.0, 30.0, 10.0, 12.0]),
        (arc(0.001, 0.005), 10.0, [20.0, 23.0, 22.0]),
    ],
    ids=['involute', 'circular_arc'],
)
def test_event_to_event_steps_with_heat_read_as_integrated(
    cam: dict[str, Any], log_s: float, celsius: list[float]
) -> None:
    """Log intervals end within half swings, and the oil's cubic errs as above."""
    wheel = machine('oil', cam=cam)
    run_s = log_s * (len(celsius) - 1)
    forcing = warmed(at_sea(wheel, run_s, log_s), log_s, np.array(celsius))
    exact = reading_s(HotReference(wheel), wheel, forcing)
    read = []
    for each in (wheel, replace(wheel, heat=NO_HEAT)):
        engine = FreeEndCollocation(each, None, 6)
        read.append(reading_s(engine, wheel, forcing))
        assert engine.missed <= 2
    error_s, effect_s = np.max(np.abs(read[0] - exact)), abs(read[1][-1] - exact[-1])
    assert effect_s > 1e-6
    assert error_s < 1e-11 + 1e-4 * effect_s


def test_chunks_of_free_end_steps_have_the_same_bits_with_heat() -> None:
    """Also if a chunk ends, and a state is saved, within a log interval."""
    wheel = machine('oil')
    forcing = warmed(at_sea(wheel, 20.0, 10.0), 10.0, np.array([20.0, 35.0, 30.0]))
    assert np.count_nonzero(forcing.logged) == 2
    wanted = moved(FreeEndCollocation(wheel, None, 3), forcing)
    count = len(forcing.begin)
    for cut in (1, count // 2 - 1, count // 2, count - 3):
        engine, resumed = (FreeEndCollocation(wheel, None, 3) for _ in range(2))
        angles = list(moved(engine, first_spans(forcing, cut)).angle)
        resumed.restore(engine.state())
        angles += list(resumed.advance(forcing.part(cut)).angle)
        np.testing.assert_array_equal(angles, wanted.angle)


def first_spans(forcing: Forcing, count: int) -> Forcing:
    """Return the first spans, with their log intervals."""
    first = forcing.part(0, count)
    felt = first.temperatures
    assert felt is not None
    known = int(felt.interval[-1]) + 1
    felt = replace(felt, celsius=felt.celsius[:known], begin_s=felt.begin_s[:known])
    return replace(first, temperatures=felt)


def test_an_anharmonic_swing_keeps_its_action_as_its_force_grows() -> None:
    """θ̈ = −ω²(θ + 0.1 θ³) from 1 rad, ω up by 1e-3 over 320 periods: 4.831e-4 of the phase.

    Time warped by ω alone would give 5.000e-4 (the action in mpmath: dlnΩ/dlnω = 0.9663).
    """
    law = smooth_lever(
        lambda q: 0.005 * (q + 0.1 * q**3), lambda q: 0.005 * (0.5 * q * q + 0.025 * q**4), 3.0
    )
    heat = Heat(force=1e-4)
    still = Machine(
        4e-4, 0.0, 0.0, 3.158, 0.0, 9.80665, Fitted('cubic', law, math.inf), False, None, None, 1.0
    )
    wheel = replace(still, heat=heat)
    step_s = round(wheel.period(1.0) / 200.0, 9)
    interval_s = round(6400.0 * step_s, 9)
    celsius = 20.0 + (((1.0 + 1e-4 * np.arange(11)) ** 2) - 1.0) / heat.force
    forcing = warmed(on_land(64_000, step_s), interval_s, celsius)
    motion = moved(make_propagator(wheel, still=True), forcing)
    # the time of 320 turns: at turning points the phase does not depend on the amplitude
    turned = float(np.interp(640.0, motion.half_turns + motion.fraction, forcing.end_ns * 1e-9))
    assert 320.0 * wheel.period(1.0) / turned - 1.0 == pytest.approx(4.831e-4, abs=3e-7)
