"""The rate equation: the change of the clock's rate by the ship's motion (rate.md).

The rate is y + Σ k_j x_j with the regressors x_j (`regressors`). Short runs of the scene's own
machine give the coefficients k_j.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple, cast

import numpy as np

from tauto_core.clockwork import TrochleaStage
from tauto_core.clockwork.trochlea import nominal_period_s
from tauto_core.curves.numerics import integrate
from tauto_core.machines import (
    AnyMachine,
    LeverMachine,
    Machine,
    NoSteadySwing,
    OtherRegulator,
    compile_machine,
    steady_swing,
)
from tauto_core.navigation.kalman import (
    GNSS_SIGMA_S,
    LUNAR_SIGMA_S,
    RANDOM_WALK_FM_FLOOR_PER_S,
    WHITE_FM_FLOOR_S,
    ClockModel,
    Coefficient,
)
from tauto_core.navigation.regressors import HEAT, SHAKEN_BY, Regressors
from tauto_core.samples import READING, SHIP_IMU, FloatArray, ImuSamples, TimeSamples
from tauto_core.scene import Scene
from tauto_core.scene.errors import ABSENT, SceneError, TautoError
from tauto_core.scene.sections import Clock, DriftSettings, Log, Solver, walk_per_s, white_s
from tauto_core.scene.times import DAY_S, NS_PER_S, nanoseconds, step_of_rate
from tauto_core.ship import ShipMotion
from tauto_core.ship.airs import BoxTemperature, ConstantAir
from tauto_core.ship.motions import Component, ComponentsShip, ShipKind
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.wording import significant

# -----------------------------------------------------------------------------
# The assumptions of the navigator about the clock and the observations before the voyage.

PATIENCE = 3.0
"""Number of observation intervals for which the filter rejects outliers."""


def clock_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with covariates.

    Coefficients that the scene does not state come from trial runs of its machine.
    """
    model = dial_model(scene)
    if not scene.drift.covariates:
        return model
    return replace(model, coefficients=coefficients(scene))


def expected_walk_per_s(scene: Scene) -> float:
    """Return the density of the random walk of the rate that the navigator expects [1/s].

    It is the larger of the dial's own, which is simulated, and the scene's `drift`.
    """
    return max(scene.clock.random_walk_fm_per_s, walk_per_s(scene.drift.random_walk_fm or 0.0))


def dial_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with at least the noise of a good clock.

    Outliers are rejected for three observation intervals. After that, as at a landfall, a change
    of the clock is more likely than an error of the observer.
    """
    drift, clock, voyage = scene.drift, scene.clock, scene.voyage
    return ClockModel(
        observation_sigma_s=drift.observation_sigma,
        prior_rate_sigma=drift.prior_rate_sigma / DAY_S,
        states=drift.states,
        white_fm_s=max(WHITE_FM_FLOOR_S, clock.white_fm_s, white_s(drift.white_fm or 0.0)),
        random_walk_fm_per_s=max(RANDOM_WALK_FM_FLOOR_PER_S, expected_walk_per_s(scene)),
        gate=drift.gate,
        patience_s=PATIENCE * drift.observation_interval,
        lunar_sigma_s=LUNAR_SIGMA_S if drift.lunars is None else drift.lunars.sigma,
        gnss_sigma_s=drift.gnss_sigma or GNSS_SIGMA_S,
        under_way_per_s=climate_walk(scene).density_per_s,
        sails_ns=0 if voyage is None else scene.starts_at_ns + nanoseconds(voyage.sails_at),
    )


# -----------------------------------------------------------------------------
# The wandering of the rate under way that a navigator expects by default (navigator.md), from the
# clock's response to air, gravity and sea, and their changes on a passage.

PASSAGE_KELVIN, PASSAGE_GRAVITY, PASSAGE_SEA = 1.6, 1.12e-4, 1.7e-5
"""Random walks in a day of the causes on a passage: air [K], covariate `gravity` [1], and mean of
the covariate `heave` [1].

The double integral of a walk has the mean square of the air's (by the climate) and of gravity's on
every second of the 185 passages of docs/trial.csv. The sea's is the rest of a weight's error.
"""

AIR_WITH_GRAVITY = -0.94
"""Their correlation there: towards the equator it is warmer, and gravity smaller."""

CLIMATE_KELVIN = 7.0
"""Change of temperature for the clock's response: root mean square of the mean change of the air
on those passages [K].
"""


class ClimateWalk(NamedTuple):
    """Density of the random walk of the rate under way [1/s], and the names of its causes."""

    density_per_s: float = 0.0
    causes: tuple[str, ...] = ()


@lru_cache(maxsize=16)  # the air of a passage takes 10 ms to set up, and six callers need it
def climate_walk(scene: Scene) -> ClimateWalk:
    """Return the wandering of the rate under way that the navigator expects.

    It is zero if the scene states one. Causes that its rate equation follows do not count.
    """
    drift, named = scene.drift, scene.drift.covariates or ()
    stated = drift.random_walk_fm is not None or drift.white_fm is not None
    if scene.voyage is None or stated:
        return ClimateWalk()
    warms = scene.air is not None and not isinstance(scene.air, ConstantAir)
    weathers = isinstance(scene.ship, SeaShip) and scene.ship.weather is not None
    meets = {
        'air': warms and 'temperature' not in named,
        'gravity': scene.gravity == 'normal' and 'gravity' not in named,
        'sea': weathers and 'heave' not in named,
    }
    if not any(meets.values()):
        return ClimateWalk()
    machine = compile_machine(scene)
    colder = warmer = 0.0
    if meets['air'] and not isinstance(machine, OtherRegulator) and machine.heat.feels_temperature:
        begins = float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0])
        colder, warmer = _per_kelvin(_Tried(_alone(scene)), begins)
    weighs = float(machine.feels_gravity)
    lighter = weighs * PASSAGE_GRAVITY * meets['gravity']
    shaken = weighs * PASSAGE_SEA * meets['sea']
    variance = 0.5 * PASSAGE_KELVIN**2 * (colder**2 + warmer**2) + lighter**2 + shaken**2
    variance += AIR_WITH_GRAVITY * PASSAGE_KELVIN * (colder + warmer) * lighter
    sizes = {'air': abs(colder) + abs(warmer), 'gravity': lighter, 'sea': shaken}
    return ClimateWalk(variance / DAY_S, tuple(name for name in meets if sizes[name]))


@lru_cache(maxsize=64)
def _per_kelvin(tried: _Tried, begins: float) -> tuple[float, float]:
    """Return the change of the rate per kelvin [1/K] below and above `begins` [°C], or 0."""
    built = cast(AnyMachine, compile_machine(tried.scene))
    base, slopes = built.at_celsius(begins), [0.0, 0.0]
    nominal_s = nominal_period_s(tried.scene, base)
    with suppress(TautoError):
        calm = _warm_rate(tried.scene, base, base, nominal_s)
        for place, step in enumerate((-CLIMATE_KELVIN, CLIMATE_KELVIN)):
            warm = built.at_celsius(begins + step)
            slopes[place] = (_warm_rate(tried.scene, warm, base, nominal_s) - calm) / step
    return slopes[0], slopes[1]


def assumption(scene: Scene) -> str:
    """Return the navigator's assumption about the rate, on which all his ± rest."""
    model, names = dial_model(scene), (scene.drift.covariates or ())
    words = []
    if names:
        words.append(f'to follow {_listed(name.replace("_", " ") for name in names)}')
    if model.random_walk_fm_per_s > RANDOM_WALK_FM_FLOOR_PER_S:
        words.append(f'to wander by {_in_a_day(model.random_walk_fm_per_s)}')
    if causes := climate_walk(scene).causes:
        words.append(
            f'to wander under way by {_in_a_day(model.under_way_per_s)}, by {_listed(causes)}'
        )
    if model.white_fm_s > WHITE_FM_FLOOR_S:
        white = significant(math.sqrt(model.white_fm_s * DAY_S), 2)
        words.append(f'to scatter by {white} s in a day')
    rate = 'the rate' if names else 'the rate found in port'
    if scene.voyage is None and not names:
        rate = 'the rate that he observed'
    return f'{rate} {" and ".join(words or ["to last"])}'


def _in_a_day(density_per_s: float) -> str:
    return f'{significant(math.sqrt(density_per_s * DAY_S) * DAY_S, 2)} s/day in a day'


def _listed(names: Iterable[str]) -> str:
    return ' and '.join(', '.join(names).rsplit(', ', 1))


# -----------------------------------------------------------------------------
# The coefficients of the rate equation, from short runs of the scene's own machine.
#
# The ship only heaves, or only rolls, in a small wave of one period. The coefficient is the change
# of the rate divided by the mean of the regressor, averaged over several phases of the wave at the
# release (random in a real sea) and over several periods. Its standard deviation is the spread of
# the periods, with an allowance for effects that a single wave cannot show.
#
# Small regular waves do not excite the motions that make some machines chaotic, such as the swing
# of a thread. So the clock also runs for some hours in a moderate sea. The remaining error of the
# equation there is compared with its sigma by the priors of the coefficients (`fit`).

HEAVE_PERIODS_S = (2.0, 3.0, 4.0, 6.0, 9.0)
"""Periods of the waves of the trial runs in heave [s]. The shorter waves of a sea accelerate most,
more so at encounter frequencies: in a winter's Atlantic almost all between 2 and 8 s.
"""

ROLL_PERIODS_S = (6.0, 9.0, 13.0)
"""Periods of the waves of the trial runs in roll [s], not below natural roll periods of ships."""

LEAST_SAMPLES = 10
"""Least number of samples of `ship.rate` in a wave of a trial run. Shorter waves are left out,
except the two longest.
"""

PHASES = tuple(0.5 * math.pi * k for k in range(4))
"""Phases of the wave at the release. Odd effects of the wave cancel between opposite phases,
effects of twice its phase between quarters.
"""

HEAVE = 0.05
"""Acceleration of the heave in the trial runs over gravity. The effect is proportional to its
square, and the next power is 3e-4 of that.
"""

ROLL_RAD = 0.05
"""Amplitude of the roll in the trial runs."""

RUN_S = 600.0
"""Length of a run after the swing has settled [s]: 46 of the longest waves."""

SETTLED = 6.0
"""Number of time constants after which the steady swing has settled: e⁻⁶ is 1/400."""

LONGEST_SETTLING_S = 3600.0
"""Longest time for a swing to settle [s]."""

PART, LEAST = 0.05, 0.005
"""Allowance in the standard deviation for effects that one small wave cannot show: as a fraction
of the coefficient, and its least value.
"""

GRAVITY_STEPS = (-0.005, 0.005)
"""Relative changes of gravity in the trial runs. From pole to equator it is 0.0053."""

RAMP_S = 300.0
"""Time in which a trial run changes gravity [s]. It is many swings, so an undamped wheel keeps its
action, as on a voyage.
"""

HEAT_STEP = 5.0
"""Least change of temperature to either side of the start that is tried [K]. A larger change in
the scene's air replaces it.
"""

ALLOWANCES = {
    'gravity': (0.01, 0.001),
    'temperature': (0.1, 1e-6),
    'temperature_squared': (0.1, 1e-8),
}
"""The same as PART and LEAST for changes that the voyage really has.

For gravity the sea changes the amplitude and with it the response. For heat the materials differ:
chronometers with a steel spring and a plain brass balance lost 11.0 (Airy 1859) and 11.8 s/day/K
(Berthoud 1773), 3 and 10 % more than by the table of materials, and oils of one name differ by as
much. The least is 0.09 s/day/K.
"""

ACTION_STEPS = 40
"""Iterations for the amplitude of equal action. Each at least halves the error."""

SEA = {'spectrum': 'bretschneider', 'significant_wave_height': 2.5, 'peak_period': 9.0}
SLOPE, SEA_RATE_HZ = 0.7, 5.0
"""Sea of the test of fit, from abeam, with the wave-slope coefficient and sampling rate of most
built-in scenes.
"""

SEAS, SEA_S, SEA_LOG_S = 6, 10_800.0, 60.0
"""Number, length and log interval [s] of the runs in that sea."""

SEA_TOLERANCE = 1e-6
"""Relative error of a step in that sea, which is 0.01 s/day in the rate."""

RESPONSE_TOLERANCE = 2e-12
"""Relative error of a step in single waves."""

FITS = 2.0
"""Largest departure from a fitting equation, in sigmas of its priors. All runs share the
coefficients, so an honest prior exceeds it for one machine in 22. Of the built-in machines the
fitting ones depart by 0.3 at most, the others by more than 2.6.
"""


@dataclass(frozen=True)
class Runs:
    """The coefficient of the covariate `name` by trial runs.

    It is given for each wave period [s], relative change of gravity, or change of temperature [K].
    """

    name: str
    at: dict[float, float]

    @property
    def coefficient(self) -> Coefficient:
        """Mean and standard deviation."""
        values = list(self.at.values())
        mean = float(np.mean(values))
        spread = float(np.std(values, ddof=1))
        part, floor = ALLOWANCES.get(self.name, (PART, LEAST))
        return Coefficient(self.name, mean, math.hypot(spread, part * mean, floor))


def coefficients(scene: Scene) -> tuple[Coefficient, ...]:
    """Return the priors of the coefficients of a scene's covariates, in their order.

    Raises:
        SceneError: the machine cannot be run in the waves of the trials, or no rate equation fits
            it and the scene does not assume a random walk of its rate.
    """
    tried, settings = (
        {run.name: run.coefficient for run in runs(scene)},
        scene.drift.coefficients,
    )
    priors = []
    for name in scene.drift.covariates or ():
        stated = getattr(settings, name, None)
        priors.append(
            tried[name] if stated is None else Coefficient(name, stated.value, stated.sigma)
        )
    moves = tuple(tried[name] for name in tried if name in SHAKEN_BY)
    if not moves:
        return tuple(priors)
    # stated coefficients are not tested
    try:
        fitted = fit(scene, moves)
    except TautoError as error:
        raise SceneError(
            scene.name,
            'drift.coefficients',
            ABSENT,
            f'cannot be tested by running the machine in a sea of 2.5 m: {error}',
            f'Give value and sigma of {" and ".join(coefficient.name for coefficient in moves)}.',
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
    return tuple(priors)


def runs(scene: Scene) -> tuple[Runs, ...]:
    """Return the trial runs for the coefficients that a scene does not state.

    Raises:
        SceneError: the machine cannot be run in the small waves of the trial.
    """
    settings = scene.drift.coefficients
    names = tuple(n for n in scene.drift.covariates or () if getattr(settings, n, None) is None)
    if not names:
        return ()
    stated = None if settings is None else settings.heave
    try:
        tried = _Tried(_alone(scene))
        motions = tuple(name for name in names if name not in HEAT)
        results = _runs(tried, motions, 0.0 if stated is None else stated.value)
        if len(motions) < len(names):
            temperatures = BoxTemperature(scene).at(
                np.arange(0, scene.log_count, max(scene.log_count // 1000, 1))
            )
            warmth = float(temperatures[0]), float(temperatures.min()), float(temperatures.max())
            powers = sorted(HEAT[name] for name in scene.drift.covariates or () if name in HEAT)
            warmed = _by_heat(tried, warmth, tuple(powers))
            results += tuple(run for run in warmed if run.name in names)
        return results
    except TautoError as error:
        raise SceneError(
            scene.name,
            'drift.coefficients',
            ABSENT,
            f'cannot be found by running the machine: {error}',
            f'Give value and sigma of {" and ".join(names)}.',
        ) from error


class Fit(NamedTuple):
    """How a clock's rate in a moderate sea departs from a rate equation.

    Attributes:
        sigmas: root mean square of the remaining error at the end of the runs, in its standard
            deviations by the priors of the coefficients.
        random_walk_fm: random walk that explains the change of the remaining rate from the first
            half of a run to the second, as `drift.random_walk_fm` [s/day].
    """

    sigmas: float
    random_walk_fm: float

    def is_expected(self, model: ClockModel, factor: float = 1.0) -> bool:
        """Return whether a model's noise explains the bend of the error within a factor."""
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
    """Return how a scene's clock in a moderate sea departs from a rate equation with these priors.

    Without priors the rate is compared with a constant. A machine that cannot be run in that sea
    is a TautoError.
    """
    return _fit(_Tried(_alone(scene)), priors)


@lru_cache(maxsize=16)
def _fit(tried: _Tried, priors: tuple[Coefficient, ...]) -> Fit:
    base, names = tried.scene, tuple(prior.name for prior in priors)
    # with an equation the ship moves only in the motions that it contains
    moves = names or ('heave', 'roll')
    slope = SLOPE if 'roll' in moves else 0.0
    ship = SeaShip.model_validate(
        {
            'sea': SEA,
            'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': slope},
            'heave': 'heave' in moves,
            'rate': SEA_RATE_HZ,
            'height': base.ship.height,
        }
    )
    tolerance = None if base.solver is None else base.solver.tolerance
    scene = base.model_copy(
        update={
            'ship': ship,
            'drift': DriftSettings.model_validate({'covariates': names or None}),
            'log': Log(interval=SEA_LOG_S),
            'solver': Solver(tolerance=max(tolerance or 0.0, SEA_TOLERANCE)),
        }
    )
    run = _Run(scene, SEA_S)
    calm = run.error_s(ComponentsShip(rate=SEA_RATE_HZ, height=ship.height))
    middle, sigmas = (len(calm) - 1) // 2, np.array([prior.sigma for prior in priors])
    ends, allowed, bent = [], [], []
    for seed in range(SEAS):
        gained = run.error_s(ship, seed) - calm
        gained -= gained[0]
        grown = run.integrals_s(ship, seed) if names else np.zeros((len(calm), 0))
        residual = gained - grown @ np.array([prior.value for prior in priors])
        ends.append(residual[-1])
        allowed.append(float(np.sum((sigmas * grown[-1]) ** 2)))
        bent.append(residual[2 * middle] - 2.0 * residual[middle] + residual[0])
    # a random walk of density q bends the error by a variance of 2/3 q τ³
    density = float(np.mean(np.square(bent))) / (2.0 / 3.0 * (middle * SEA_LOG_S) ** 3)
    return Fit(
        math.sqrt(float(np.mean(np.square(ends))) / float(np.mean(allowed))) if names else 0.0,
        math.sqrt(density * DAY_S) * DAY_S,
    )


def _alone(scene: Scene) -> Scene:
    """Return the scene's machine on a ship that only the trial waves move."""
    # the response depends neither on the accuracy of a voyage nor on a `ship.rate` for it
    ship = ComponentsShip(height=scene.ship.height)
    if scene.accuracy is None:
        ship = ship.model_copy(update={'rate': scene.ship.rate})
    step_ns = step_of_rate(ship.rate)
    interval_s = max(NS_PER_S // step_ns, 1) * step_ns / NS_PER_S
    exact = Solver(tolerance=RESPONSE_TOLERANCE)
    return scene.model_copy(
        update={
            'name': '',
            'ship': ship,
            'starts_at': 1.0,
            'seed': 0,
            'clock': Clock(nominal_period=scene.clock.nominal_period),
            'voyage': None,
            'air': None,
            'drift': DriftSettings(covariates=('heave',)),
            'gravity': scene.g,
            'solver': scene.solver if scene.accuracy is None else exact,
            'log': Log(interval=interval_s),
        }
    )


class _Tried(NamedTuple):
    """The input of trial runs. Equal inputs have equal hashes."""

    scene: Scene

    def __hash__(self) -> int:
        return hash(self.scene.model_dump_json())


@lru_cache(maxsize=16)
def _runs(tried: _Tried, names: tuple[str, ...], heave: float) -> tuple[Runs, ...]:
    """Return the trial runs. `heave` is its stated coefficient, else 0 until it is found."""
    ship, gravity, results = tried.scene.ship, tried.scene.g, []
    assert isinstance(ship, ComponentsShip)
    if moves := sorted(name for name in names if name in SHAKEN_BY):
        run = _Run(tried.scene)
        calm = run.error_s(ship)
    for name in moves:
        heaves, at = name == 'heave', {}
        periods_s = HEAVE_PERIODS_S if heaves else ROLL_PERIODS_S
        mean = -(HEAVE**2) / 16.0 if heaves else 0.5 * ROLL_RAD**2  # of the regressor
        for period_s in periods_s:
            if period_s * ship.rate < LEAST_SAMPLES and period_s < periods_s[-2]:
                continue
            rates = []
            for phase in PHASES:
                size = HEAVE * gravity * (period_s / math.tau) ** 2 if heaves else ROLL_RAD
                wave = (Component(amplitude=size, period=period_s, phase=phase),)
                ship_in_waves = ship.model_copy(update={'heave' if heaves else 'components': wave})
                gained = run.error_s(ship_in_waves) - calm
                if heave:  # roll shakes a clock above its axis, which the first covariate includes
                    gained = gained - heave * run.integrals_s(ship_in_waves, 0)[: len(calm), 0]
                rates.append(_slope(gained, run.interval_s))
            at[period_s] = float(np.mean(rates)) / mean
        results.append(Runs(name, at))
        heave = results[-1].coefficient.value
    if 'gravity' in names:
        run = _Run(tried.scene, changes=True)
        calm = run.error_s(ship)
        tail = slice(-math.ceil(RUN_S / run.interval_s), None)
        rates = [
            _slope((run.error_s(ship, 0, step) - calm)[tail], run.interval_s)
            for step in GRAVITY_STEPS
        ]
        at = {step: rate / (0.5 * step) for step, rate in zip(GRAVITY_STEPS, rates, strict=True)}
        results.append(Runs('gravity', at))
    return tuple(results)


@lru_cache(maxsize=16)
def _by_heat(
    tried: _Tried, warmth: tuple[float, float, float], powers: tuple[int, ...]
) -> tuple[Runs, ...]:
    """Return the coefficients of `powers` of temperature, from rates at the ends of its range."""
    machine, (begins, lowest, highest) = compile_machine(tried.scene), warmth
    ends = np.array([min(lowest - begins, -HEAT_STEP), max(highest - begins, HEAT_STEP)])
    groups = list(ends[:, None]) if len(powers) == 1 else [0.5 * ends, ends]
    solutions = np.zeros((len(groups), len(powers)))
    if not isinstance(machine, OtherRegulator) and machine.heat.feels_temperature:
        base = machine.at_celsius(begins)
        nominal_s = nominal_period_s(tried.scene, base)
        calm = _warm_rate(tried.scene, base, base, nominal_s)
        for row, group in zip(solutions, groups, strict=True):
            warm = (machine.at_celsius(begins + step) for step in group.tolist())
            gained = [_warm_rate(tried.scene, variant, base, nominal_s) - calm for variant in warm]
            row[:] = np.linalg.solve(group[:, None] ** np.array(powers), np.array(gained))
    steps = [float(group[-1]) for group in groups]
    names = sorted(HEAT, key=HEAT.__getitem__)
    return tuple(
        Runs(names[power - 1], dict(zip(steps, column, strict=True)))
        for power, column in zip(powers, solutions.T.tolist(), strict=True)
    )


def _warm_rate(scene: Scene, machine: AnyMachine, base: AnyMachine, nominal_s: float) -> float:
    """Return the rate of the steady swing, at equal action if it is free, or else of a run."""
    steady = isinstance(machine, LeverMachine) or (
        isinstance(machine, Machine) and machine.imbalance is None
    )
    swing = steady_swing(machine) if isinstance(machine, Machine | LeverMachine) else None
    if swing is None or isinstance(swing, NoSteadySwing):
        if swing is not None and steady and machine.escapement is not None:
            raise TautoError(f'at {machine.heat.at_celsius:.4g} °C {swing.why}')
        clock = scene.clock.model_copy(update={'nominal_period': nominal_s})
        run = _Run(scene.model_copy(update={'clock': clock}), machine=machine)
        return _slope(run.error_s(scene.ship), run.interval_s)
    period_s = swing.period
    free = steady and math.isinf(swing.time_constant) and swing.amplitude > 0.0
    if free and isinstance(machine, Machine) and isinstance(base, Machine):
        action, amplitude = _action(base, swing.amplitude), swing.amplitude
        for _ in range(ACTION_STEPS):
            amplitude *= math.sqrt(action / _action(machine, amplitude))
        period_s = machine.period(amplitude)
    return nominal_s / period_s - 1.0


def _action(machine: Machine, amplitude: float) -> float:
    """Return ∮ Mϑ̇ dϑ of a free swing [J s], which is proportional to A² in a harmonic well."""
    top = float(machine.potential(amplitude))
    joints = machine.cam.joints[machine.cam.joints < amplitude]
    cuts = np.arcsin(np.sqrt(machine.potential(joints) / top))
    edges = np.array([0.0, *cuts, 0.5 * math.pi])

    def integrand(u: FloatArray) -> FloatArray:
        return np.asarray(np.cos(u) ** 2 * machine.swing(amplitude, u)[1])

    return 8.0 * top * float(np.sum(integrate(integrand, edges[:-1], edges[1:])))


class _Run:
    """Runs of a clock on one ship after the other, `length_s` long once the swing has settled."""

    def __init__(
        self,
        scene: Scene,
        length_s: float = RUN_S,
        *,
        changes: bool = False,
        machine: AnyMachine | None = None,
    ) -> None:
        self.interval_s = scene.log.interval
        clock, settling_s = machine or compile_machine(scene), 0.0
        if isinstance(clock, Machine | LeverMachine):
            swing = steady_swing(clock)
            if not isinstance(swing, NoSteadySwing) and math.isfinite(swing.time_constant):
                settling_s = min(SETTLED * swing.time_constant, LONGEST_SETTLING_S)
        self._settled = math.ceil(settling_s / self.interval_s)
        if changes:
            length_s += RAMP_S + settling_s
        logs = self._settled + math.ceil(length_s / self.interval_s)
        self._scene = scene.model_copy(update={'duration': logs * self.interval_s})
        self._stage = TrochleaStage(self._scene, machine=clock)
        self._fresh = self._stage.state()

    def error_s(self, ship: ShipKind, seed: int = 0, heavier: float = 0.0) -> FloatArray:
        """Return the error of the dial at the logged instants once the swing has settled [s].

        From then on all forces grow smoothly by the fraction `heavier`.
        """
        imu = self._motion(ship, seed)
        if heavier:
            since = (imu.stamp_ns - imu.stamp_ns[0]) / NS_PER_S - self._settled * self.interval_s
            u = np.clip(since / RAMP_S, 0.0, 1.0)
            smooth = u**4 * (35.0 + u * (-84.0 + u * (70.0 - 20.0 * u)))
            force = imu.linear_acceleration * (1.0 + heavier * smooth)[:, None]
            imu = replace(imu, linear_acceleration=force)
        self._stage.restore(self._fresh)
        batches = self._stage.feed({SHIP_IMU: imu}), self._stage.finish()
        readings = [cast(TimeSamples, batch[READING]) for batch in batches if READING in batch]
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


def _slope(error_s: FloatArray, interval_s: float) -> float:
    """Return the mean rate of even errors. The weights cos⁴ remove oscillations of any period."""
    count = len(error_s)
    at = (np.arange(count) - 0.5 * (count - 1)) * interval_s
    weight = np.cos(math.pi * at / (count * interval_s)) ** 4
    return float(np.sum(weight * at * error_s) / np.sum(weight * at * at))
