"""The coefficients of the rate equation, from short runs of the scene's own machine.

The clock is run on a ship that only heaves, or only rolls, in a small wave of one period. The
coefficient is the change of the rate divided by the mean of the regressor. It is averaged over
several phases of the wave at the release, since in a real sea that phase is random. The
coefficient is the mean over several periods of the waves. Its standard deviation is their spread,
with an allowance for what a single wave cannot show (theory E11).

Small regular waves do not excite what makes some machines chaotic, as the swing of a thread. So
the clock is also run for some hours in a moderate sea, and what the equation leaves of its error
is compared with what the priors of the coefficients allow (`fit`).
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
from tauto_core.navigation.drift import dial_model
from tauto_core.navigation.kalman import ClockModel, Coefficient
from tauto_core.navigation.regressors import Regressors
from tauto_core.samples import (
    NS_PER_S,
    READING,
    SECONDS_PER_DAY,
    SHIP_IMU,
    FloatArray,
    ImuSamples,
    TimeSamples,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import ABSENT, SceneError, TautoError
from tauto_core.scene.sections import Clock, DriftSettings, Log, Solver, walk_per_s
from tauto_core.scene.times import step_of_rate
from tauto_core.ship import ShipMotion
from tauto_core.ship.motion_kind import ShipKind
from tauto_core.ship.motions.components import Component, ComponentsShip
from tauto_core.ship.motions.sea import SeaShip

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

SEA = {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0}
SLOPE, SEA_RATE_HZ = 0.7, 5.0
"""Sea of the test of fit, which comes from abeam; wave-slope coefficient and sampling rate of the
ship. They are those of most shipped scenes.
"""

SEAS, SEA_S, SEA_LOG_S = 6, 10_800.0, 60.0
"""Number, length and log interval [s] of the runs in that sea."""

SEA_TOLERANCE = 1e-6
"""Relative error of a step in that sea, as in the clocks to compare; the rate is right to 0.01
s/day.
"""

FITS = 2.0
"""Largest departure from the equation, in the sigmas of its priors, at which it fits. All runs
share the coefficients, so an honest prior exceeds it for one machine in 22. Of the shipped
machines those that fit depart by 0.3 at most, the others by more than 2.6.
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
        SceneError: the machine cannot be run in the waves of the trials; or no rate equation fits
            it, and the scene does not assume that its rate walks at random.
    """
    tried = {found.name: found.coefficient for found in runs(scene)}
    found = tuple(tried.get(name) or _stated(scene, name) for name in scene.drift.covariates or ())
    if not tried:
        return found
    # what the scene states is not tested
    try:
        fitted = fit(scene, tuple(tried.values()))
    except TautoError as error:
        raise SceneError(
            scene.name,
            'drift.coefficients',
            ABSENT,
            f'cannot be tested by running the machine in a sea of 2.5 m: {error}',
            f'Give value and sigma of {" and ".join(tried)}.',
        ) from error
    if fitted.sigmas > FITS and not fitted.is_expected(dial_model(scene)):
        raise SceneError(
            scene.name,
            'drift.covariates',
            list(scene.drift.covariates or ()),
            f'no rate equation fits this machine: in {SEAS} trial runs of {SEA_S / 3600.0:g} '
            f'hours in a sea of 2.5 m its error departs from the equation by {fitted.sigmas:.2g} '
            f'of its standard deviations, where at most {FITS:g} are allowed. The rate walks at '
            f'random, by at least about {fitted.advised:g} s/day in a day',
            f'Write, with or without drift.covariates, drift.random_walk_fm: {fitted.advised:g}.',
        )
    return found


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


class Fit(NamedTuple):
    """How a clock's rate in a moderate sea departs from a rate equation.

    Attributes:
        sigmas: root mean square of what the equation leaves of the error at the end of the runs,
            in the standard deviations that the priors of the coefficients give it.
        random_walk_fm: the random walk that explains by how much the rate that is left changes
            from the first half of a run to the second, as `drift.random_walk_fm` [s/day].
    """

    sigmas: float
    random_walk_fm: float

    def is_expected(self, model: ClockModel, factor: float = 1.0) -> bool:
        """Return whether a model has noise that bends the error as much, but for a factor."""
        tau_s = 0.5 * SEA_S
        third = tau_s * tau_s / 3.0
        noise = model.white_fm_s + model.random_walk_fm_per_s * third
        return noise >= walk_per_s(self.random_walk_fm / factor) * third

    @property
    def advised(self) -> float:
        """The random walk, rounded up to two digits [s/day]."""
        unit = 10.0 ** (math.floor(math.log10(self.random_walk_fm)) - 1)
        return float(f'{math.ceil(self.random_walk_fm / unit) * unit:.2g}')


def fit(scene: Scene, priors: tuple[Coefficient, ...]) -> Fit:
    """Return how a scene's clock in a moderate sea departs from a rate equation.

    Args:
        scene: gives the machine and its height in the ship.
        priors: the coefficients of the equation; none: the rate is compared with a constant.

    Raises:
        TautoError: the machine cannot be run in that sea.
    """
    return _fit(_Tried(_alone(scene)), priors)


@lru_cache(maxsize=16)
def _fit(tried: _Tried, priors: tuple[Coefficient, ...]) -> Fit:
    own, names = tried.scene, tuple(each.name for each in priors)
    # where there is an equation the ship moves only in the ways that it knows
    moves = names or ('heave', 'roll')
    slope = SLOPE if 'roll' in moves else 0.0
    ship = SeaShip.model_validate(
        {
            'sea': SEA,
            'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': slope},
            'heave': 'heave' in moves,
            'rate': SEA_RATE_HZ,
            'height': own.ship.height,
        }
    )
    given = None if own.solver is None else own.solver.tolerance
    scene = own.model_copy(
        update={
            'ship': ship,
            'drift': DriftSettings.model_validate({'covariates': names or None}),
            'log': Log(interval=SEA_LOG_S),
            'solver': Solver(tolerance=max(given or 0.0, SEA_TOLERANCE)),
        }
    )
    run = _Run(scene, SEA_S)
    calm = run.error_s(ComponentsShip(rate=SEA_RATE_HZ, height=ship.height))
    half, sigmas = (len(calm) - 1) // 2, np.array([each.sigma for each in priors])
    left, allowed, bent = [], [], []
    for seed in range(SEAS):
        gained = run.error_s(ship, seed) - calm
        gained -= gained[0]
        grown = run.integrals_s(ship, seed) if names else np.zeros((len(calm), 0))
        rest = gained - grown @ np.array([each.value for each in priors])
        left.append(rest[-1])
        allowed.append(float(np.sum((sigmas * grown[-1]) ** 2)))
        bent.append(rest[2 * half] - 2.0 * rest[half] + rest[0])
    # a random walk of density q bends the error by a variance of 2/3 q τ³
    density = float(np.mean(np.square(bent))) / (2.0 / 3.0 * (half * SEA_LOG_S) ** 3)
    return Fit(
        math.sqrt(float(np.mean(np.square(left))) / float(np.mean(allowed))) if names else 0.0,
        math.sqrt(density * SECONDS_PER_DAY) * SECONDS_PER_DAY,
    )


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
    """Runs the clock of a scene on one ship after the other; its stage is built once.

    Args:
        scene: the machine and the log.
        length_s: length of a run after the swing has settled [s].
    """

    def __init__(self, scene: Scene, length_s: float = RUN_S) -> None:
        self.interval_s = scene.log.interval
        self._settled = math.ceil(_settling_s(scene) / self.interval_s)
        logs = self._settled + math.ceil(length_s / self.interval_s)
        self._scene = scene.model_copy(update={'duration': logs * self.interval_s})
        self._stage = TrochleaStage(self._scene)
        self._fresh = self._stage.state()

    def error_s(self, ship: ShipKind, seed: int = 0) -> FloatArray:
        """Return the error of the dial at the logged instants once the swing has settled [s]."""
        self._stage.restore(self._fresh)
        said = self._stage.feed({SHIP_IMU: self._motion(ship, seed)}), self._stage.finish()
        readings = [cast(TimeSamples, each[READING]) for each in said if READING in each]
        parts = [(reading.time_ref_ns - reading.stamp_ns) / NS_PER_S for reading in readings]
        return np.concatenate(parts)[self._settled :]

    def integrals_s(self, ship: ShipKind, seed: int) -> FloatArray:
        """Return the growth of the integrals of the regressors at the same instants [s]."""
        imu, regressors = self._motion(ship, seed), Regressors(self._scene, live=False)
        regressors.feed({SHIP_IMU: imu})
        every_ns = self._scene.log_interval_ns
        first_ns = int(imu.stamp_ns[0]) + self._settled * every_ns
        grown = regressors.at(np.arange(first_ns, int(imu.stamp_ns[-1]) + 1, every_ns))
        return np.asarray(grown - grown[0], np.float64)

    def _motion(self, ship: ShipKind, seed: int) -> ImuSamples:
        motion = ShipMotion(self._scene.model_copy(update={'ship': ship, 'seed': seed}))
        return motion.produce(motion.total)


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
