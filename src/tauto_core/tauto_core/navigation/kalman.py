"""The navigator's clock model: a linear Kalman filter on phase, rate, ageing and coefficients.

State: offset x of the dial [s, fast is positive], rate y = dx/dt [1], ageing d = dy/dt [1/s].
Over a time τ without observations (Brown and Hwang; Zucca and Tavella, Metrologia 2005):

    x' = x + τ y + τ²/2 d,   y' = y + τ d,   d' = d,   P' = F P Fᵀ + Q(τ)

    Q = | q1 τ + q2 τ³/3   q2 τ²/2   0 |
        | q2 τ²/2          q2 τ      0 |
        | 0                0         0 |

An observation is a scalar phase z = x + noise of variance R. With two states d and its variances
stay zero. Formulas are sums and products in a fixed order: floats and arrays, one sample or many,
give the same bits. With covariates the rate is y + Σ k_j x_j, and the coefficients k_j are
further states.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement, repeat
from operator import sub
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.ship.source import LANDFALL, LUNAR, PORT

# -----------------------------------------------------------------------------
# The coefficients of the rate equation as further states of the drift filter (rate.md).
#
# The rate of the dial is y + Σ k_j x_j, with regressors x_j from an inertial sensor and constant
# coefficients k_j. Over a time τ in which the integrals of the regressors grow by ΔX_j, they enter
# the row of the offset:
#
#     x' = x + τ y + τ²/2 d + Σ ΔX_j k_j,   k_j' = k_j.


class Coefficient(NamedTuple):
    """Prior of a coefficient, before any observation.

    Attributes:
        name: name of its covariate.
        value: expected k [1].
        sigma: its standard deviation [1], > 0.
    """

    name: str
    value: float
    sigma: float


def pairs(size: int) -> list[tuple[int, int]]:
    """Return the indices of a covariance's upper triangle, row by row."""
    return list(combinations_with_replacement(range(size), 2))


@cache
def places(size: int) -> list[list[int]]:
    """Return the place of each covariance in an estimate of `size` states, as a square."""
    number = {pair: size + k for k, pair in enumerate(pairs(size))}
    return [[number[min(i, j), max(i, j)] for j in range(size)] for i in range(size)]


Real = TypeVar('Real', float, FloatArray)

WHITE_FM_FLOOR_S = 0.01**2 / DAY_S
"""Least q1 of a real clock [s]: a random walk of the phase by 0.01 s in a day."""

RANDOM_WALK_FM_FLOOR_PER_S = (0.001 / DAY_S) ** 2 / DAY_S
"""Least q2 of a real clock [1/s]: a random walk of the rate by 0.001 s/day in a day."""

AGEING_TIME_S = 100.0 * DAY_S
"""Time in which ageing may change the rate by one prior sigma of the rate [s]."""


LUNAR_SIGMA_S = 60.0
"""Default sigma of lunar distances [s] (`scene.sections.Lunars`)."""

GNSS_SIGMA_S = 0.2
"""Default sigma of the time by a GNSS receiver's messages, without its pulse [s]."""

SOURCES = ('', PORT, LANDFALL, 'sextant', LUNAR, 'gnss', 'gps')
"""Possible sources of a `clock/observation`. Each has a sigma (`ClockModel.sigma_of`)."""

SETTING_SIGMAS = 10.0
"""Prior sigma of the dial's offset, in sigmas of an observation. The first observation determines
the offset, however the dial was set.
"""


class Estimate(NamedTuple, Generic[Real]):
    """Mean and covariance of the state, floats or arrays of one shape.

    Units: x [s], y [1], d [1/s]. `xy` is the covariance of x and y, and so on. `estimate_of` adds
    coefficients.
    """

    x: Real
    y: Real
    d: Real
    xx: Real
    xy: Real
    xd: Real
    yy: Real
    yd: Real
    dd: Real


def same_fields(like: Estimate[Any], values: Iterable[Any]) -> Estimate[Any]:
    """Return an estimate of the same class as another, from its values in order."""
    return type(like)(*values)


@cache
def estimate_of(coefficients: tuple[str, ...]) -> type[Estimate[Any]]:
    """Return the class of estimates with these coefficients, `Estimate` without any.

    Their means follow those of `Estimate`, by name. Covariances are `x_heave`, `heave_roll` and so
    on.
    """
    names = ('x', 'y', 'd', *coefficients)
    fields = [*names, *covariances(names)]
    return cast(type[Estimate[Any]], namedtuple('Estimate', fields)) if coefficients else Estimate


def covariances(names: tuple[str, ...]) -> list[str]:
    """Return the names of the covariances of states, upper triangle, row by row."""
    name_pairs = [(names[i], names[j]) for i, j in pairs(len(names))]
    return [f'{row}{col}' if len(col) == 1 else f'{row}_{col}' for row, col in name_pairs]


@dataclass(frozen=True)
class ClockModel:
    """The navigator's assumptions about the clock and the observations.

    Args:
        observation_sigma_s: sigma of one phase observation in port or at a landfall [s].
        prior_rate_sigma: sigma of the rate before any observation [1].
        states: 2 (offset, rate) or 3 (and ageing).
        white_fm_s: q1 [s], >= 0.
        random_walk_fm_per_s: q2 [1/s], >= 0.
        gate: largest accepted innovation in its own sigmas, > 0. `None`: any.
        patience_s: time after the last used observation for which outliers are refused in a
            simulation [s], > 0. Infinite for real observers: then three outliers must agree.
        lunar_sigma_s: sigma of one phase observation by a lunar distance [s].
        gnss_sigma_s: sigma of one phase observation by a GNSS receiver [s].
        coefficients: the coefficients of the rate equation with their priors.
        under_way_per_s: additional q2 once the ship has sailed [1/s], >= 0.
        sails_ns: when it sails [ns].
    """

    observation_sigma_s: float
    prior_rate_sigma: float
    states: int = 2
    white_fm_s: float = WHITE_FM_FLOOR_S
    random_walk_fm_per_s: float = RANDOM_WALK_FM_FLOOR_PER_S
    gate: float | None = None
    patience_s: float = math.inf
    lunar_sigma_s: float = LUNAR_SIGMA_S
    gnss_sigma_s: float = GNSS_SIGMA_S
    coefficients: tuple[Coefficient, ...] = ()
    under_way_per_s: float = 0.0
    sails_ns: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coefficients."""
        return tuple(coefficient.name for coefficient in self.coefficients)

    def under_way_s(self, since_ns: int, until_ns: int) -> float:
        """Return for how long the ship is under way between two stamps [s]."""
        return max(until_ns - max(since_ns, self.sails_ns), 0) / NS_PER_S

    def sigma_of(self, source: str) -> float:
        """Return sigma of an observation by the source that its message states [s].

        Other sources than `SOURCES` have the sextant's.
        """
        by = {LUNAR: self.lunar_sigma_s, 'gnss': self.gnss_sigma_s, 'gps': self.gnss_sigma_s}
        return by.get(source, self.observation_sigma_s)


def prior(model: ClockModel) -> Estimate[float]:
    """Return the state just after the dial was set: x = 0 ± `SETTING_SIGMAS` observations."""
    rate = model.prior_rate_sigma
    ageing = rate / AGEING_TIME_S if model.states == 3 else 0.0
    sigma = SETTING_SIGMAS * model.observation_sigma_s
    kind = estimate_of(model.names)
    values = dict.fromkeys(kind._fields, 0.0)
    values |= {'xx': sigma * sigma, 'yy': rate * rate, 'dd': ageing * ageing}
    for name, value, deviation in model.coefficients:
        values |= {name: value, f'{name}_{name}': deviation * deviation}
    return kind(**values)


def predict(
    now: Estimate[Real],
    elapsed_s: Real,
    model: ClockModel,
    gained_s: tuple[Real, ...] = (),
    under_way_s: Real | float = 0.0,
) -> Estimate[Real]:
    """Return the state `elapsed_s` >= 0 later, without an observation in between.

    F P Fᵀ + Q(τ) in exact discrete form (see the module). `gained_s` is the growth of the integral
    of each covariate [s], `under_way_s` the last part of the time, in which the ship is under way:
    then P also grows by q (t³/3, t²/2; t²/2, t), whatever the time before.
    """
    size: int = 3 + len(model.coefficients)
    t: Any = elapsed_s
    way: Any = under_way_s
    h = 0.5 * t * t
    transition: dict[int, list[tuple[int, Any]]] = {
        0: [(1, t), (2, h), *zip(range(3, size), gained_s, strict=True)],
        1: [(2, t)],
    }
    mean: list[Any] = list(now[:size])
    p: list[list[Any]] = [[now[place] for place in row] for row in places(size)]
    for row, terms in transition.items():
        for column, factor in terms:
            mean[row] = mean[row] + factor * mean[column]
            p[row] = [a + factor * b for a, b in zip(p[row], p[column], strict=True)]
    for row, terms in transition.items():
        for above in range(row + 1):
            for column, factor in terms:
                p[above][row] = p[above][row] + factor * p[above][column]
    q1, q2, q = model.white_fm_s, model.random_walk_fm_per_s, model.under_way_per_s
    p[0][0] = p[0][0] + t * (q1 + t * t * (q2 / 3.0)) + q * (way * way * way / 3.0)
    p[0][1] = p[0][1] + h * q2 + q * (0.5 * way * way)
    p[1][1] = p[1][1] + t * q2 + q * way
    return same_fields(now, (*mean, *(p[i][j] for i, j in pairs(size))))


def corrected(
    ahead: Estimate[float], innovation_s: float, variance: float, r: float, model: ClockModel
) -> Estimate[float]:
    """Return a predicted state after an observed phase, in Joseph's form.

    The innovation ν has the variance P_xx + r, with r of the observation [s²].
    """
    size = 3 + len(model.coefficients)
    p = [[ahead[place] for place in row] for row in places(size)]
    gain = [covariance / variance for covariance in p[0]]
    # 1 - P_xx/s would lose digits for a precise observation
    g = r / variance
    first_row = [g * covariance for covariance in p[0]]

    def less(i: int, j: int) -> float:
        if i == 0:
            return g * first_row[j] if j else g * g * p[0][0]
        return (p[i][j] - gain[i] * p[0][j]) - gain[j] * first_row[i]

    mean = (ahead[i] + gain[i] * innovation_s for i in range(size))
    return same_fields(
        ahead, (*mean, *(less(i, j) + gain[i] * gain[j] * r for i, j in pairs(size)))
    )


def reopen(ahead: Estimate[Real], innovation_s: Real, elapsed_s: Real) -> Estimate[Real]:
    """Return a predicted state with its variance widened after an outlier (navigator.md).

    Either the offset may have jumped by the innovation ν, or the rate may have changed by ν/τ just
    after the last used observation, τ > 0 ago. P grows by ν² for the first and by (ν/τ)² (τ,
    1)ᵀ(τ, 1) for the second. τ is infinite if only the offset can have changed.
    """
    v, w = innovation_s, innovation_s / elapsed_s
    return ahead._replace(xx=ahead.xx + 2.0 * (v * v), xy=ahead.xy + v * w, yy=ahead.yy + w * w)


# -----------------------------------------------------------------------------
# The filter over a run of observations: which of them it uses, and the state after each.
#
# An observation with an innovation ν beyond `gate` sigmas, ν² > gate² (xx + R), is refused as a
# blunder. But a clock that has jumped, or is worse than assumed, disagrees with all later ones. So
# the third in a row is used if the three agree (`agree`), after the state has been reopened
# (`reopen`), which widens its covariance.
#
# Observers of a simulated voyage make no blunders. There `patience_s` is finite, and an outlier is
# also used if it comes later than this after the last used one, if it is the first of all, or the
# second in a row until three have been used since the beginning or the last reopening.

REFUSED_IN_A_ROW = 2
"""Number of outliers in a row that are refused, whether or not they agree."""

TRUSTED = 3
"""Number of used observations from which this also holds in a simulated voyage."""

USED, REFUSED, REOPENED = 0, 1, 2
"""The fate of an observation: used, refused as an outlier, or used after reopening the state."""


AGREEMENT = 0.25
"""Largest departure of three outliers from a line, relative to the least of them."""

Outlier: TypeAlias = tuple[int, float, float]
"""Stamp [ns], innovation [s] and variance [s²] of a refused observation."""


def agree(outliers: Sequence[Outlier], model: ClockModel) -> bool:
    """Return whether three outliers agree: the second is on the line of the others.

    It may depart by `gate` sigmas of their errors and of the wandering of the clock, which departs
    from its chord by the variance q1 ab/T + q2 a²b²/(3T), with the times a and b between them and
    T = a + b; and by `AGREEMENT` of the least, which allows for a wild clock. Fewer than three
    always agree.
    """
    if len(outliers) < 3:
        return True
    (first, u, r), (second, v, s), (third, w, t) = outliers
    a, b = (second - first) / NS_PER_S, (third - second) / NS_PER_S
    part = a / (a + b) if third > first else 0.5
    deviation = v - (1.0 - part) * u - part * w
    variance = s + (1.0 - part) ** 2 * r + part * part * t
    walk = model.random_walk_fm_per_s + model.under_way_per_s
    variance += part * b * (model.white_fm_s + walk * a * b / 3.0)
    smallest, limit = min(abs(u), abs(v), abs(w)), (model.gate or 0.0) * math.sqrt(variance)
    return abs(deviation) <= max(AGREEMENT * smallest, limit)


class Known(NamedTuple):
    """The state at the beginning of a run of observations.

    Args:
        stamp_ns: stamp of the last used observation, or of the setting of the dial.
        estimate: the estimate at that stamp.
        outliers: the last outliers in a row since then, at most two.
        used: number of used observations since the beginning or the last reopening.
        integrals_s: integrals of the model's covariates at that stamp [s].
    """

    stamp_ns: int
    estimate: Estimate[float]
    outliers: tuple[Outlier, ...] = ()
    used: int = 0
    integrals_s: tuple[float, ...] = ()


@dataclass(frozen=True)
class Filtered:
    """The result of the filter for n observations, of which it used m.

    Args:
        stamp_ns: stamps of the start and of the used observations, (m + 1,).
        states: the states at these stamps, (m + 1,).
        fate: USED, REFUSED or REOPENED for each observation, (n,).
        start: the state at the beginning.
        refused: the refused observations in order.
        integrals_s: integrals of the c covariates at these stamps [s], (m + 1, c).
    """

    stamp_ns: IntArray
    states: Estimate[FloatArray]
    fate: NDArray[np.int8]
    start: Known
    refused: tuple[Outlier, ...]
    integrals_s: FloatArray

    def after(self, count: int) -> Known:
        """Return the state after the first `count` observations, 0 to n."""
        fate = self.fate[:count]
        used = np.flatnonzero(fate != REFUSED)
        reopened = np.flatnonzero(fate == REOPENED)
        place = len(used)
        estimate = same_fields(self.states, (float(column[place]) for column in self.states))
        since = count - int(used[-1]) - 1 if place else count
        outliers = self.refused[count - place - since : count - place]
        return Known(
            int(self.stamp_ns[place]),
            estimate,
            (outliers if place else self.start.outliers + outliers)[-REFUSED_IN_A_ROW:],
            int(np.sum(used >= reopened[-1])) if len(reopened) else self.start.used + place,
            tuple(self.integrals_s[place].tolist()) if self.start.integrals_s else (),
        )


def filter_phases(
    start: Known,
    stamp_ns: Sequence[int],
    phase_s: Sequence[float],
    model: ClockModel,
    sigma_s: Sequence[float] | None = None,
    integrals_s: Sequence[Sequence[float]] = (),
) -> Filtered:
    """Return the result of the filter for n observed phases, in order of their stamps.

    Single observations and batches give the same bits, since each is predicted in one step from
    the last used one. Phases are reading minus observed true time [s]. Stamps are not before the
    start. Without `sigma_s` each has the model's. With covariates `integrals_s` has their
    integrals at each observation, n rows [s].
    """
    if sigma_s is None:
        sigma_s = [model.observation_sigma_s] * len(stamp_ns)
    limit = math.inf if model.gate is None else model.gate * model.gate
    since, now, last_integrals = start.stamp_ns, start.estimate, start.integrals_s
    outliers, trust, left_out = list(start.outliers), start.used, list[Outlier]()
    stamps, states, fate = [since], [now], bytearray()
    integrals, gained = list(last_integrals), tuple[float, ...]()
    rows = integrals_s if model.coefficients else repeat(last_integrals, len(stamp_ns))
    for stamp, phase, sigma, reached in zip(stamp_ns, phase_s, sigma_s, rows, strict=True):
        r = sigma * sigma
        elapsed = (stamp - since) / NS_PER_S
        if last_integrals:
            gained = tuple(map(sub, reached, last_integrals))
        ahead = predict(now, elapsed, model, gained, model.under_way_s(since, stamp))
        innovation = phase - ahead.x
        s = ahead.xx + r
        if innovation * innovation > limit * s:
            # Simulated: the first observation is always used, since only a prior contradicts it.
            # Of two that disagree either may be the blunder, and the next one decides.
            patience = (
                REFUSED_IN_A_ROW
                if math.isinf(model.patience_s) or trust >= TRUSTED
                else min(trust, 1)
            )
            row = [*outliers[len(outliers) - patience :], (stamp, innovation, r)]
            if elapsed <= model.patience_s and (len(row) <= patience or not agree(row, model)):
                outliers = row[-REFUSED_IN_A_ROW:]
                left_out.append(row[-1])
                fate.append(REFUSED)
                continue
            # in zero time the rate cannot have changed
            ahead = reopen(ahead, innovation, elapsed or math.inf)
            s, trust = ahead.xx + r, 0
            fate.append(REOPENED)
        else:
            fate.append(USED)
        now, since, outliers = corrected(ahead, innovation, s, r, model), stamp, []
        trust += 1
        stamps.append(stamp)
        states.append(now)
        if last_integrals:
            last_integrals = tuple(reached)
            integrals += last_integrals
    return Filtered(
        np.array(stamps, np.int64),
        same_fields(now, np.array(states, np.float64).T),
        np.frombuffer(bytes(fate), np.int8),
        start,
        tuple(left_out),
        np.array(integrals, np.float64).reshape(len(stamps), len(last_integrals)),
    )
