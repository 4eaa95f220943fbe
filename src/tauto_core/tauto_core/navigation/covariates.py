"""The rate equation: what the motion of the ship adds to the rate of the clock (theory.md, E11).

The rate is y + Σ k_j x_j. Here are the regressors x_j, integrated from `ship/imu`; the clock model
of a scene; and the coefficients k_j, from short runs of the scene's own machine.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple, Protocol, cast

import numpy as np

from tauto_core.clockwork import TrochleaStage
from tauto_core.kernels import entry
from tauto_core.machines import LeverMachine, Machine, NoSteadySwing, compile_machine, steady_swing
from tauto_core.navigation.kalman import (
    LUNAR_SIGMA_S,
    RANDOM_WALK_FM_FLOOR_PER_S,
    WHITE_FM_FLOOR_S,
    ClockModel,
    Coefficient,
)
from tauto_core.navigation.longitude import BEFORE_ALL, in_order
from tauto_core.samples import (
    READING,
    SHIP_IMU,
    FloatArray,
    ImuSamples,
    IntArray,
    JointSamples,
    Samples,
    State,
    TimeSamples,
    take,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import ABSENT, SceneError, TautoError
from tauto_core.scene.sections import Clock, DriftSettings, Log, Solver, walk_per_s, white_s
from tauto_core.scene.times import DAY_S, MAX_GAP_S, NS_PER_S, step_of_rate
from tauto_core.ship import ShipMotion
from tauto_core.ship.imu import Continuity, content_reasons, contiguous, imu_from_roll, screen
from tauto_core.ship.motion_kind import ShipKind
from tauto_core.ship.motions.components import Component, ComponentsShip
from tauto_core.ship.motions.sea import SeaShip

# -----------------------------------------------------------------------------
# The regressors, integrated from `ship/imu`.
#
# For each sample, with f the apparent gravity that pulls a weight at the clock and ⟨f⟩ its running
# mean,
#
#     x_heave = -(f - ⟨f⟩)²/(8 g²),    x_roll = ρ².
#
# Between samples the regressors are linear, and their integral X is exact.


@entry
def followed(value: FloatArray, share: FloatArray, mean: float, out: FloatArray) -> None:
    """Fill the running mean m of values v (n,), which becomes m + c (v - m) at each sample."""
    for i in range(len(value)):
        mean = mean + share[i] * (value[i] - mean)
        out[i] = mean


MEAN_S = 300.0
"""Time constant of ⟨f⟩, a first-order high-pass [s]. It removes an accelerometer's bias, and
1/(Ω · 300 s)² of a wave's square, 3e-5 at 10 s and 1e-4 at 20 s.
"""

USUAL_S = 600.0
"""Time constant of the mean that bridges a gap in the motion [s]: several groups of waves, and
short compared with the hours in which a sea changes.
"""

HELD_S = 10.0
"""Time, by their stamps, for which readings of a live graph wait for the motion [s]."""


class MotionRegressors(Protocol):
    """A source of the integrals of the regressors."""

    inputs: tuple[str, ...]

    @property
    def reached_ns(self) -> int:
        """Stamp up to which motion has arrived; BEFORE_ALL if none has."""
        ...

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take new samples of any of its inputs."""
        ...

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c), and forget those before them."""
        ...

    def state(self) -> State:
        """Return all that the next result depends on."""
        ...

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        ...

    def health(self) -> dict[str, int]:
        """Return counters."""
        ...


def integral_names(covariates: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the integrals on `drift/estimate`."""
    return tuple(f'{name}_integral_s' for name in covariates)


class Regressors:
    """Integrates the regressors over `ship/imu`; the result does not depend on batches.

    Args:
        scene: names the covariates, and gives gravity and the sampling rate of the ship.
        live: whether the samples are a live sensor's. Those that do not continue the ones before
            are then left out, and over a gap the integrals grow as usual.
    """

    inputs: tuple[str, ...] = (SHIP_IMU,)

    def __init__(self, scene: Scene, *, live: bool) -> None:
        known = {'heave': self._heave, 'roll': _roll}
        self._columns = [known[name] for name in scene.drift.covariates or ()]
        self._gravity = self._mean = scene.g
        self._continuity: Continuity | None = None
        if live:
            longest_ns = max(round(MAX_GAP_S * NS_PER_S), 2 * scene.step_ns * scene.lies_still)
            self._continuity = Continuity(scene.step_ns, longest_ns)
        width = len(self._columns)
        self._stamp: IntArray = np.empty(0, np.int64)
        self._value, self._integral = np.empty((0, width)), np.empty((0, width))
        self._last, self._usual = np.zeros((1, width)), np.zeros(width)
        self._health = {'motion_refused': 0, 'motion_gaps': 0, 'motion_unknown': 0}
        begun = self.state()
        none = np.zeros(1)
        self._add(imu_from_roll(np.zeros(1, np.int64), none, none, none, none))  # compiles
        self.restore(begun)

    @property
    def reached_ns(self) -> int:
        """Stamp of the last sample; BEFORE_ALL if none has arrived."""
        return int(self._stamp[-1]) if len(self._stamp) else BEFORE_ALL

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Take motion samples; bad ones are counted and left out."""
        imu = batches.get(SHIP_IMU)
        if not isinstance(imu, ImuSamples) or not len(imu.stamp_ns):
            return
        if self._continuity is None:
            last_ns = self.reached_ns if len(self._stamp) else None
            imu, refused = screen(imu, last_ns, compiled=True)
            self._health['motion_refused'] += sum(refused.values())
            self._add(imu)
            return
        good = content_reasons(imu) == 0
        self._health['motion_refused'] += int(np.count_nonzero(~good))
        for run in self._continuity.feed(imu if good.all() else take(imu, good)):
            if run.begins and len(self._stamp):
                self._bridge(int(run.imu.stamp_ns[0]))
            self._add(run.imu)

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at increasing stamps [s], (n, c); earlier ones are forgotten.

        Stamps before the first sample have its integrals; after the last one they grow as usual.
        Such stamps are counted.
        """
        known = self._stamp
        if not len(known) or not len(stamp_ns):
            self._health['motion_unknown'] += len(stamp_ns)
            return np.repeat(self._last, len(stamp_ns), axis=0)
        at = np.maximum(stamp_ns, known[0])
        before = np.searchsorted(known, at, 'right') - 1
        after = np.minimum(before + 1, len(known) - 1)
        since = ((at - known[before]) / NS_PER_S)[:, None]
        step = (np.maximum(known[after] - known[before], 1) / NS_PER_S)[:, None]
        rise = (self._value[after] - self._value[before]) / step
        late = at > known[-1]
        growth = since * (self._value[before] + 0.5 * rise * since)
        growth = np.where(late[:, None], self._usual * since, growth)
        self._health['motion_unknown'] += int(np.count_nonzero(late | (at > stamp_ns)))
        found: FloatArray = self._integral[before] + growth
        first = int(before[-1])
        self._stamp, self._value = known[first:], self._value[first:]
        self._integral = self._integral[first:]
        return found

    def _add(self, imu: ImuSamples) -> None:
        """Take samples that continue the ones before."""
        stamps = imu.stamp_ns
        if not len(stamps):
            return
        before = self._stamp[-1:] if len(self._stamp) else stamps[:1]
        steps = np.diff(stamps, prepend=before) / NS_PER_S
        value = np.column_stack([column(imu, steps) for column in self._columns])
        if self._continuity is not None:
            for j, column in enumerate(value.T):
                self._usual[j] = _followed(column, steps, USUAL_S, float(self._usual[j]))[-1]
        self._append(stamps, value)

    def _heave(self, imu: ImuSamples, steps: FloatArray) -> FloatArray:
        """Return -a²/(8 g²), with a the apparent gravity less its running mean."""
        from tauto_core.ship.kernels import force_of

        force = np.empty(len(imu.stamp_ns))
        force_of(contiguous(imu.linear_acceleration), None, force)
        means = np.concatenate(([self._mean], _followed(force, steps, MEAN_S, self._mean)))
        self._mean = float(means[-1])
        # centred between two steps of the mean; otherwise a wave would lose Δ/τ of its square
        heaved = (force - 0.5 * (means[:-1] + means[1:])) / self._gravity
        return -0.125 * heaved * heaved

    def _append(self, stamps: IntArray, value: FloatArray) -> None:
        """Integrate the regressors up to further points."""
        times = np.concatenate((self._stamp[-1:], stamps))
        values = np.concatenate((self._value[-1:], value))
        areas = 0.5 * (np.diff(times) / NS_PER_S)[:, None] * (values[:-1] + values[1:])
        sums = np.cumsum(np.concatenate((self._last, areas)), axis=0)
        self._stamp = np.concatenate((self._stamp, stamps))
        self._value = np.concatenate((self._value, value))
        self._integral = np.concatenate((self._integral, sums[len(sums) - len(stamps) :]))
        self._last = self._integral[-1:].copy()

    def _bridge(self, begins_ns: int) -> None:
        """Bridge the time from the last sample to another run with the usual growth."""
        self._health['motion_gaps'] += 1
        edges = np.array([self._stamp[-1] + 1, begins_ns - 1], np.int64)
        if edges[1] > edges[0]:
            self._append(edges, np.stack([self._usual, self._usual]))
        elif begins_ns <= self._stamp[-1]:  # stamps have gone back, so another time begins
            none = slice(0, 0)
            self._stamp, self._value = self._stamp[none], self._value[none]
            self._integral = self._integral[none]

    def state(self) -> State:
        """Return all that the next result depends on."""
        return {
            'stamp': self._stamp.copy(),
            'value': self._value.copy(),
            'integral': self._integral.copy(),
            'last': self._last.copy(),
            'mean': self._mean,
            'usual': self._usual.copy(),
            'continuity': self._continuity and self._continuity.state(),
            'health': dict(self._health),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._stamp, self._value = state['stamp'], state['value']
        self._integral, self._last = state['integral'], state['last']
        self._mean, self._usual = state['mean'], state['usual'].copy()
        if self._continuity is not None:
            self._continuity.restore(state['continuity'])
        self._health = dict(state['health'])

    def health(self) -> dict[str, int]:
        """Return counters of samples refused, gaps, and stamps where the motion is not known."""
        return dict(self._health)


class RecordedIntegrals:
    """Gives the integrals of the covariates by a `drift/estimate` of at least one sample."""

    inputs: tuple[str, ...] = ()

    def __init__(self, estimate: JointSamples, covariates: tuple[str, ...]) -> None:
        columns = [estimate.name.index(name) for name in integral_names(covariates)]
        kept = in_order(estimate.stamp_ns, BEFORE_ALL)
        self._stamp = estimate.stamp_ns[kept]
        self._integral = estimate.position[kept][:, columns]
        self._unknown = 0

    @property
    def reached_ns(self) -> int:
        """Stamp of the last estimate."""
        return int(self._stamp[-1])

    def feed(self, batches: Mapping[str, Samples]) -> None:
        """Ignore the samples; all integrals are known."""

    def at(self, stamp_ns: IntArray) -> FloatArray:
        """Return the integrals at stamps [s], (n, c), linear between estimates."""
        first, known = self._stamp[0], self._stamp
        self._unknown += int(np.count_nonzero((stamp_ns < first) | (stamp_ns > known[-1])))
        at, times = (stamp_ns - first) / NS_PER_S, (known - first) / NS_PER_S
        return np.column_stack([np.interp(at, times, column) for column in self._integral.T])

    def state(self) -> State:
        """Return an empty state, since nothing changes."""
        return {'unknown': self._unknown}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._unknown = state['unknown']

    def health(self) -> dict[str, int]:
        """Return the number of stamps outside the estimates."""
        return {'motion_unknown': self._unknown}


def _followed(value: FloatArray, steps: FloatArray, time_s: float, mean: float) -> FloatArray:
    """Return the running mean of a value with a time constant τ, where c = Δ/(τ + Δ)."""
    means = np.empty_like(value)
    followed(np.ascontiguousarray(value), steps / (time_s + steps), mean, means)
    return means


def _roll(imu: ImuSamples, steps: FloatArray) -> FloatArray:
    """Return ρ²."""
    from tauto_core.ship.kernels import roll_of

    del steps
    roll = np.empty(len(imu.stamp_ns))
    roll_of(contiguous(imu.orientation), None, roll, None)
    return roll * roll


# -----------------------------------------------------------------------------
# The assumptions of the navigator about the clock and the observations before the voyage.

PATIENCE = 3.0
"""Number of observation intervals for which the filter rejects outliers."""


def clock_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with covariates.

    The coefficients are those of the scene or, where it gives none, those from trial runs of its
    machine.
    """
    model = dial_model(scene)
    if not scene.drift.covariates:
        return model
    return replace(model, coefficients=coefficients(scene))


def expected_walk_per_s(scene: Scene) -> float:
    """Return the density of the random walk of the rate that the navigator expects [1/s].

    The dial's own, which is simulated, or what the scene's `drift` says, whichever is larger.
    """
    return max(scene.clock.random_walk_fm_per_s, walk_per_s(scene.drift.random_walk_fm or 0.0))


def dial_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with at least the noise of a good clock.

    Outliers are refused for three observation intervals. After that, as at a landfall, a change of
    the clock is more likely than an error of the observer.
    """
    drift, clock = scene.drift, scene.clock
    return ClockModel(
        observation_sigma_s=drift.observation_sigma,
        prior_rate_sigma=drift.prior_rate_sigma / DAY_S,
        states=drift.states,
        white_fm_s=max(WHITE_FM_FLOOR_S, clock.white_fm_s, white_s(drift.white_fm or 0.0)),
        random_walk_fm_per_s=max(RANDOM_WALK_FM_FLOOR_PER_S, expected_walk_per_s(scene)),
        gate=drift.gate,
        patience_s=PATIENCE * drift.observation_interval,
        lunar_sigma_s=LUNAR_SIGMA_S if drift.lunars is None else drift.lunars.sigma,
    )


# -----------------------------------------------------------------------------
# The coefficients of the rate equation, from short runs of the scene's own machine.
#
# The clock is run on a ship that only heaves, or only rolls, in a small wave of one period. The
# coefficient is the change of the rate divided by the mean of the regressor. It is averaged over
# several phases of the wave at the release, since in a real sea that phase is random. The
# coefficient is the mean over several periods of the waves. Its standard deviation is their
# spread, with an allowance for what a single wave cannot show.
#
# Small regular waves do not excite what makes some machines chaotic, as the swing of a thread. So
# the clock is also run for some hours in a moderate sea, and what the equation leaves of its error
# is compared with what the priors of the coefficients allow (`fit`).

HEAVE_PERIODS_S = (2.0, 3.0, 4.0, 6.0, 9.0)
"""Periods of the waves of the trial runs in heave [s]. The acceleration of a sea is in its shorter
waves, more so at encounter frequencies: nearly all of that of a winter's Atlantic lies between 2
and 8 s.
"""

ROLL_PERIODS_S = (6.0, 9.0, 13.0)
"""Periods of the waves of the trial runs in roll [s], none shorter than ships roll naturally."""

LEAST_SAMPLES = 10
"""Least number of samples of `ship.rate` in a wave of a trial run; shorter waves are left out, but
for the two longest.
"""

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
    """The coefficient of one covariate for each period of the waves [s], by trial runs."""

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

    It is a SceneError if the machine cannot be run in the waves of the trials, or if no rate
    equation fits it and the scene does not assume that its rate walks at random.
    """
    tried, given = (
        {found.name: found.coefficient for found in runs(scene)},
        scene.drift.coefficients,
    )
    found = []
    for name in scene.drift.covariates or ():
        stated = getattr(given, name, None)
        found.append(
            tried[name] if stated is None else Coefficient(name, stated.value, stated.sigma)
        )
    if not tried:
        return tuple(found)
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
    return tuple(found)


def runs(scene: Scene) -> tuple[Runs, ...]:
    """Return the results of trial runs for the coefficients that a scene does not give.

    It is a SceneError if the machine cannot be run in the small waves of the trial.
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
    """Return how a scene's clock in a moderate sea departs from a rate equation with these priors.

    Without priors the rate is compared with a constant. A machine that cannot be run in that sea
    is a TautoError.
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
        math.sqrt(density * DAY_S) * DAY_S,
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
    run, ship, gravity = _Run(tried.scene), tried.scene.ship, tried.scene.g
    assert isinstance(ship, ComponentsShip)
    calm = run.error_s(ship)
    found = []
    for name in names:
        heaves, at_periods = name == 'heave', {}
        periods_s = HEAVE_PERIODS_S if heaves else ROLL_PERIODS_S
        mean = -(HEAVE**2) / 16.0 if heaves else 0.5 * ROLL_RAD**2  # of the regressor
        for period_s in periods_s:
            if period_s * ship.rate < LEAST_SAMPLES and period_s < periods_s[-2]:
                continue
            rates = []
            for phase in PHASES:
                size = HEAVE * gravity * (period_s / math.tau) ** 2 if heaves else ROLL_RAD
                wave = (Component(amplitude=size, period=period_s, phase=phase),)
                moved = ship.model_copy(update={'heave' if heaves else 'components': wave})
                rates.append(_slope(run.error_s(moved) - calm, run.interval_s))
            at_periods[period_s] = float(np.mean(rates)) / mean
        found.append(Runs(name, at_periods))
    return tuple(found)


class _Run:
    """Runs the clock of a scene on one ship after the other; its stage is built once.

    A run lasts `length_s` after the swing has settled.
    """

    def __init__(self, scene: Scene, length_s: float = RUN_S) -> None:
        self.interval_s = scene.log.interval
        machine, settling_s = compile_machine(scene), 0.0
        if isinstance(machine, Machine | LeverMachine):
            swing = steady_swing(machine)
            if not isinstance(swing, NoSteadySwing) and math.isfinite(swing.time_constant):
                settling_s = min(SETTLED * swing.time_constant, LONGEST_SETTLING_S)
        self._settled = math.ceil(settling_s / self.interval_s)
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


def _slope(error_s: FloatArray, interval_s: float) -> float:
    """Return the mean rate of evenly spaced errors; oscillations do not change it.

    The straight line is fitted with weights that fall to zero smoothly at both ends (cos⁴), so
    that oscillations about it, of any period, cancel.
    """
    count = len(error_s)
    at = (np.arange(count) - 0.5 * (count - 1)) * interval_s
    weight = np.cos(math.pi * at / (count * interval_s)) ** 4
    return float(np.sum(weight * at * error_s) / np.sum(weight * at * at))
