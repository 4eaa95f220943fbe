"""Sully's lever and the swinging thread in changing temperatures, against a full integration.

The references grow every length of the lever with its thread, or the wheel and its involute, in
Lagrangians with time-dependent inertia and lengths.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from motion_cases import LEVER, LEVER_WHEEL, LONG_THREAD, impulse, moved, on_land, scene_of
from test_motion_heat import warmed
from test_motion_systems import at_sea
from thread_references import HangingReference, Inputs, LeverReference, swing

from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.machines import HangingMachine, LeverMachine, compile_machine
from tauto_core.machines.heat import NO_HEAT
from tauto_core.motion import make_propagator, propagator_name

DAMPED = {**LEVER_WHEEL, 'thread': {'kind': 'hanging', 'length': 0.3, 'damping_ratio': 0.3}}
DRIVEN = {
    'drag': {'viscous': 1e-5, 'quadratic': 1e-5, 'oil': {'thins_per_kelvin': 0.035}},
    'escapement': impulse(1e-4, 0.1, recoil=1e-4),
}
AGEING = {'drag': {'viscous': 1e-5, 'oil': 'sperm', 'thickens_per_month': 9.0}}
BRASS = {'material': 'brass'}
MACHINES: dict[str, Any] = {
    'lever of zinc': ({**LEVER, 'material': 'zinc'}, {}),
    'lever, compensated': (
        {**LEVER, **BRASS, 'compensation': {'takes': -10.7, 'leaves': -0.01, 'middle': 15.0}},
        {},
    ),
    'lever of brass, oil, recoil': ({**LEVER, **BRASS}, DRIVEN),
    'lever, oil that ages': (LEVER, AGEING),
    'thread, zinc': ({**LONG_THREAD, 'material': 'zinc'}, {}),
    'thread, cam of zinc alone': (
        {**DAMPED, 'cam': {**LEVER_WHEEL['cam'], 'material': 'zinc'}},
        {},
    ),
    'thread, brass, oil, recoil': ({**LONG_THREAD, **BRASS}, DRIVEN),
}


def machine(name: str) -> LeverMachine | HangingMachine:
    trochlea, sections = MACHINES[name]
    made = compile_machine(scene_of(trochlea={**trochlea, 'release_angle': 1.0}, **sections))
    assert isinstance(made, LeverMachine | HangingMachine)
    return replace(made, heat=replace(made.heat, varies=True))


class Grown:
    """The parts of a machine at a time of a span, by hand."""

    machine: Any

    def __init__(self, cold: Any) -> None:
        super().__init__(cold)  # type: ignore[call-arg]
        self.cold = cold

    def grow(self, outside: Inputs, t: float) -> None:
        cold, heat = self.cold, self.cold.heat
        forcing, k = outside.forcing, outside.k
        felt, row = forcing.temperatures, int(forcing.temperatures.interval[k])
        since_s = float(forcing.end_ns[k]) * 1e-9 - outside.seconds + t
        first, last = felt.celsius[row].tolist()
        self.per_s = (last - first) / felt.interval_s
        celsius = first + (since_s - felt.begin_s[row]) * self.per_s
        delta = celsius - heat.at_celsius
        self.grown, self.grown_cam = 1.0 + heat.wheel * delta, 1.0 + heat.cam * delta
        rate = heat.leaves * ((celsius - heat.middle) ** 2 - (heat.at_celsius - heat.middle) ** 2)
        self.kept = (1.0 + (rate - heat.takes * delta) / 86400.0) ** 2
        changes: dict[str, Any] = {'inertia': cold.inertia * self.grown**2}
        if cold.drag is not None:
            thin = -heat.oil.rate * delta / (1.0 + heat.oil.per_kelvin * delta)
            thin = cold.drag.viscous * math.exp(thin + heat.thickening * since_s)
            changes['drag'] = cold.drag.model_copy(update={'viscous': thin})
        if isinstance(cold, LeverMachine):
            shape = cold.geometry
            lengths = shape.base_radius, shape.arm, shape.length
            changes['geometry'] = LeverGeometry(*(self.grown * each for each in lengths))
            changes['weight_arm'] = self.grown * cold.weight_arm
        else:
            changes['base_radius'] = self.grown_cam * cold.base_radius
        self.machine = replace(cold, **changes)

    def growth(self) -> tuple[float, float]:
        cold, heat = self.cold, self.cold.heat
        inertia_rate = 2.0 * cold.inertia * self.grown * heat.wheel * self.per_s
        return cold.base_radius * heat.cam * self.per_s, inertia_rate

    def slopes(self, t: float, y: np.ndarray, outside: Any, signs: Any) -> list[float]:
        self.grow(outside, t)
        kept = self.kept

        def compensated(at_s: float) -> tuple[float, ...]:
            vertical, tilt, turn, gravity = outside(at_s)
            return vertical, tilt, turn, kept * gravity

        return super().slopes(t, y, compensated, signs)  # type: ignore[misc]

    def start(self, outside: Inputs) -> np.ndarray:
        self.grow(outside, 0.0)
        return super().start(outside)  # type: ignore[misc]

    def angle(self, y: np.ndarray, outside: Inputs, t: float) -> tuple[float, float]:
        self.grow(outside, t)
        return super().angle(y, outside, t)  # type: ignore[misc]

    def struck(self, y: np.ndarray, outside: Inputs, t: float, direction: float) -> np.ndarray:
        self.grow(outside, t)
        return super().struck(y, outside, t, direction)  # type: ignore[misc]


class HotLever(Grown, LeverReference):  # type: ignore[misc]
    """State: θ and M θ̇ + (I + J β′) α̇, with a rate independent of İ and J̇."""


class HotHanging(Grown, HangingReference):  # type: ignore[misc]
    """With r(t) and I(t)."""


def compared(wheel: Any, forcing: Any) -> tuple[float, float]:
    """Largest error of angle and rate, and the largest effect of heat on the angle."""
    exact = swing((HotLever if isinstance(wheel, LeverMachine) else HotHanging)(wheel), forcing)
    found, cold = (
        moved(make_propagator(each, still=forcing.neutral is None), forcing)
        for each in (wheel, replace(wheel, heat=NO_HEAT))
    )
    effect = np.max(np.abs(cold.angle - exact[:, 0]))
    error = np.abs(np.stack([found.angle, found.rate], axis=1) - exact)
    return float(np.max(error)), float(effect)


CHANGES = np.array([0.0, 13.0, 6.0, -12.0, -12.0, 3.0])


@pytest.mark.parametrize(
    ('name', 'forced'),
    [
        *((name, at_sea) for name in MACHINES),
        ('lever of brass, oil, recoil', on_land),
    ],
)
def test_a_thread_that_warms_and_cools_moves_as_integrated(
    name: str, forced: Callable[..., Any]
) -> None:
    """To rounding, and with oil to the cubic that replaces its exponential (heat.md)."""
    wheel, interval_s = machine(name), 2.0
    forcing = on_land(5, interval_s) if forced is on_land else at_sea(wheel, 10.0, interval_s)
    changes = CHANGES if wheel.drag is None else 0.5 * CHANGES
    error, effect = compared(wheel, warmed(forcing, interval_s, 20.0 + changes))
    assert effect > 1e-4
    assert error < 2e-10 + (1e-8 if wheel.drag is None else 1e-3) * effect


@pytest.mark.parametrize('name', ['lever, compensated', 'lever of zinc', 'thread, zinc'])
def test_at_constant_temperature_it_moves_as_a_machine_made_so(name: str) -> None:
    """The lever's period is the same with lengths grown by hand."""
    wheel, spans = machine(name), warmed(on_land(40, 0.31), 0.31, np.full(41, 35.0))
    assert propagator_name(wheel, still=True) == 'collocation'
    hot = wheel.at_celsius(35.0)
    assert not hot.heat.acts
    found = [moved(make_propagator(each, still=True), spans) for each in (wheel, hot)]
    np.testing.assert_allclose(found[0].angle, found[1].angle, rtol=0, atol=1e-10)
    np.testing.assert_allclose(found[0].torque, found[1].torque, rtol=0, atol=1e-12)
    if name == 'lever of zinc':
        grown, shape = 1.0 + 30.2e-6 * 15.0, LeverGeometry(0.02, 0.1, 0.3)
        by_hand = replace(
            wheel,
            inertia=wheel.inertia * grown**2,
            weight_arm=0.15 * grown,
            geometry=LeverGeometry(*(grown * each for each in vars(shape).values())),
        )
        assert hot.period(0.8) == pytest.approx(by_hand.period(0.8), rel=1e-13)
