"""The coefficients of the rate equation, from short runs of the scene's own machine.

The clock is run on a ship that only heaves, or only rolls, in a small wave of one period. The
coefficient is the change of the rate divided by the mean of the regressor. It is averaged over
several phases of the wave at the release, since in a real sea that phase is random. The
coefficient is the mean over several periods of the waves. Its standard deviation is their spread,
with an allowance for what a single wave cannot show (theory E11).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from tauto_core.clockwork import TrochleaStage
from tauto_core.machines import LeverMachine, Machine, NoSteadySwing, compile_machine, steady_swing
from tauto_core.navigation.coefficients import Coefficient
from tauto_core.samples import NS_PER_S, READING, SHIP_IMU, FloatArray, TimeSamples
from tauto_core.scene import Scene
from tauto_core.scene.errors import ABSENT, SceneError, TautoError
from tauto_core.scene.sections import Clock, DriftSettings, Log
from tauto_core.scene.times import step_of_rate
from tauto_core.ship import ShipMotion
from tauto_core.ship.motion_kind import ShipKind
from tauto_core.ship.motions.components import Component, ComponentsShip

HEAVE_PERIODS_S = (2.0, 3.0, 4.0, 6.0, 9.0)
"""Periods of the waves of the trial runs in heave [s]. The acceleration of a sea is in its shorter
waves, more so at encounter frequencies: nearly all of that of a winter's Atlantic lies between 2
and 8 s.
"""

ROLL_PERIODS_S = (6.0, 9.0, 13.0)
"""Periods of the waves of the trial runs in roll [s], none shorter than ships roll naturally."""

LEAST_SAMPLES = 10
"""Least number of samples of `ship.rate` in a wave of a trial run; shorter waves are left out."""

PHASES = tuple(0.5 * math.pi * k for k in range(4))
"""Phases of the wave at the release. Odd effects of the wave cancel between opposite phases,
effects of twice its phase between quarters.
"""

HEAVE = 0.05
"""Acceleration of the heave in the trial runs over gravity. The effect is proportional to the
square; the next power is 3e-4 of that.
"""

ROLL_RAD = 0.05
"""Amplitude of the roll in the trial runs."""

RUN_S = 600.0
"""Length of a run after the swing has settled [s]: 46 of the longest waves."""

SETTLED = 6.0
"""Number of time constants after which the steady swing counts as settled: e⁻⁶ is 1/400."""

LONGEST_SETTLING_S = 3600.0
"""Longest time allowed for a swing to settle [s]."""

PART, LEAST = 0.05, 0.005
"""Allowance in the standard deviation for what one small wave cannot show: as a share of the
coefficient, and its least value.
"""


@dataclass(frozen=True)
class Runs:
    """The result of the trial runs for one covariate.

    Attributes:
        name: name of the covariate.
        at_periods: the coefficient for each period of the waves [s].
    """

    name: str
    at_periods: dict[float, float]

    @property
    def coefficient(self) -> Coefficient:
        """Mean and standard deviation."""
        found = list(self.at_periods.values())
        mean = float(np.mean(found))
        spread = float(np.std(found, ddof=1))
        return Coefficient(self.name, mean, math.hypot(spread, PART * mean, LEAST))


def coefficients(scene: Scene) -> tuple[Coefficient, ...]:
    """Return the priors of the coefficients of a scene's covariates, in their order.

    Raises:
        SceneError: the machine cannot be run in the small waves of the trial.
    """
    tried = {found.name: found.coefficient for found in runs(scene)}
    return tuple(tried.get(name) or _stated(scene, name) for name in scene.drift.covariates or ())


def _stated(scene: Scene, name: str) -> Coefficient:
    given = getattr(scene.drift.coefficients, name)
    return Coefficient(name, given.value, given.sigma)


def runs(scene: Scene) -> tuple[Runs, ...]:
    """Return the results of trial runs for the coefficients that a scene does not give.

    Raises:
        SceneError: the machine cannot be run in the small waves of the trial.
    """
    given = scene.drift.coefficients
    names = tuple(n for n in scene.drift.covariates or () if getattr(given, n, None) is None)
    if not names:
        return ()
    try:
        return _runs(_Tried(_alone(scene)), names)
    except TautoError as error:
        raise SceneError(
            scene.name,
            'drift.coefficients',
            ABSENT,
            f'cannot be found by running the machine in small waves: {error}',
            f'Give value and sigma of {" and ".join(names)}.',
        ) from error


def _alone(scene: Scene) -> Scene:
    """Return the scene's machine on a ship that only the trial waves move."""
    ship = ComponentsShip(rate=scene.ship.rate, height=scene.ship.height)
    step_ns = step_of_rate(ship.rate)
    interval_s = max(NS_PER_S // step_ns, 1) * step_ns / NS_PER_S
    return scene.model_copy(
        update={
            'name': '',
            'ship': ship,
            'starts_at': 1.0,
            'seed': 0,
            'clock': Clock(nominal_period=scene.clock.nominal_period),
            'voyage': None,
            'drift': DriftSettings(),
            'log': Log(interval=interval_s),
        }
    )


class _Tried(NamedTuple):
    """The input of trial runs; equal inputs have equal parts."""

    scene: Scene

    def __hash__(self) -> int:
        return hash(self.scene.model_dump_json())


@lru_cache(maxsize=16)
def _runs(tried: _Tried, names: tuple[str, ...]) -> tuple[Runs, ...]:
    run, ship, gravity = _Run(tried.scene), tried.scene.ship, tried.scene.gravity
    assert isinstance(ship, ComponentsShip)
    calm = run.error_s(ship)
    found = []
    for name in names:
        move = _MOVES[name]
        at_periods = {}
        for period_s in _sampled(move.periods_s, ship.rate):
            moved = (move.ship(ship, gravity, period_s, phase) for phase in PHASES)
            rates = [_slope(run.error_s(each) - calm, run.interval_s) for each in moved]
            at_periods[period_s] = float(np.mean(rates)) / move.mean
        found.append(Runs(name, at_periods))
    return tuple(found)


def _sampled(periods_s: tuple[float, ...], rate_hz: float) -> tuple[float, ...]:
    """Return the periods that are sampled often enough at a rate; at least the two longest."""
    long_enough = (each for each in periods_s if each * rate_hz >= LEAST_SAMPLES)
    return (*long_enough,) if periods_s[-2] * rate_hz >= LEAST_SAMPLES else periods_s[-2:]


class _Run:
    """Runs the clock of a scene on one ship after the other; its stage is built once."""

    def __init__(self, scene: Scene) -> None:
        self.interval_s = scene.log.interval
        self._settled = math.ceil(_settling_s(scene) / self.interval_s)
        logs = self._settled + math.ceil(RUN_S / self.interval_s)
        self._scene = scene.model_copy(update={'duration': logs * self.interval_s})
        self._stage = TrochleaStage(self._scene)
        self._fresh = self._stage.state()

    def error_s(self, ship: ShipKind) -> FloatArray:
        """Return the error of the dial at the logged instants once the swing has settled [s]."""
        motion = ShipMotion(self._scene.model_copy(update={'ship': ship}))
        self._stage.restore(self._fresh)
        said = self._stage.feed({SHIP_IMU: motion.produce(motion.total)}), self._stage.finish()
        readings = [cast(TimeSamples, each[READING]) for each in said if READING in each]
        parts = [(reading.time_ref_ns - reading.stamp_ns) / NS_PER_S for reading in readings]
        return np.concatenate(parts)[self._settled :]


def _heave(ship: ComponentsShip, gravity: float, period_s: float, phase: float) -> ComponentsShip:
    amplitude = HEAVE * gravity * (period_s / math.tau) ** 2
    wave = Component(amplitude=amplitude, period=period_s, phase=phase)
    return ship.model_copy(update={'heave': (wave,)})


def _roll(ship: ComponentsShip, gravity: float, period_s: float, phase: float) -> ComponentsShip:
    del gravity
    wave = Component(amplitude=ROLL_RAD, period=period_s, phase=phase)
    return ship.model_copy(update={'components': (wave,)})


class _Move(NamedTuple):
    """The motion of a ship in a wave of one period and phase, and the mean of the regressor."""

    ship: Callable[[ComponentsShip, float, float, float], ComponentsShip]
    periods_s: tuple[float, ...]
    mean: float


_MOVES = {
    'heave': _Move(_heave, HEAVE_PERIODS_S, -(HEAVE**2) / 16.0),
    'roll': _Move(_roll, ROLL_PERIODS_S, 0.5 * ROLL_RAD**2),
}


def _settling_s(scene: Scene) -> float:
    """Return the time allowed for the swing to settle [s]."""
    machine = compile_machine(scene)
    if not isinstance(machine, Machine | LeverMachine):
        return 0.0
    swing = steady_swing(machine)
    if isinstance(swing, NoSteadySwing) or not math.isfinite(swing.time_constant):
        return 0.0
    return min(SETTLED * swing.time_constant, LONGEST_SETTLING_S)


def _slope(error_s: FloatArray, interval_s: float) -> float:
    """Return the mean rate of evenly spaced errors; oscillations do not change it.

    The straight line is fitted with weights that fall to zero smoothly at both ends (cos⁴), so
    that oscillations about it, of any period, cancel.
    """
    count = len(error_s)
    at = (np.arange(count) - 0.5 * (count - 1)) * interval_s
    weight = np.cos(math.pi * at / (count * interval_s)) ** 4
    return float(np.sum(weight * at * error_s) / np.sum(weight * at * at))
