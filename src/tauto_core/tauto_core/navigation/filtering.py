"""The filter over a run of observations: which of them it uses, and the state after each.

An observation whose innovation ν exceeds `gate` sigmas, ν² > gate² (xx + R), is refused: once or
twice in a row it is taken for a blunder of the observer. Where the clock itself has jumped, or was
never as good as assumed, all later observations disagree. So the third in a row, and any that
comes later than `patience_s` after the last one used, is used after all. The covariance is widened
first: the state is reopened (`reopen`). The filter must first be confirmed by observations. The
first one is always used, and until three have been used since the beginning or the last reopening,
the second outlier in a row is used too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import repeat
from operator import sub
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tauto_core.navigation.kalman import (
    ClockModel,
    Estimate,
    law_of,
    noise_of,
    predict,
    reopen,
    same_fields,
)
from tauto_core.samples import NS_PER_S, FloatArray, IntArray

REFUSED_IN_A_ROW = 2
"""Largest number of outliers in a row that are taken for blunders; with one more the clock is
assumed to have changed.
"""

TRUSTED = 3
"""Number of observations that must have been used before two outliers in a row are refused."""

USED, REFUSED, REOPENED = 0, 1, 2
"""The fate of an observation: used, refused as an outlier, or used after reopening the state."""


class Known(NamedTuple):
    """The state at the beginning of a run of observations.

    Args:
        stamp_ns: stamp of the last observation used, or of the setting of the dial.
        estimate: the estimate at that stamp.
        refused: number of outliers in a row since then.
        used: number of observations used since the beginning or the last reopening.
        integrals_s: integrals of the model's covariates at that stamp [s].
    """

    stamp_ns: int
    estimate: Estimate[float]
    refused: int = 0
    used: int = 0
    integrals_s: tuple[float, ...] = ()


@dataclass(frozen=True)
class Filtered:
    """The result of the filter for n observations, of which it used m.

    Args:
        stamp_ns: stamps of the start and of the observations used, (m + 1,).
        states: the states at these stamps, (m + 1,).
        phase_s: the phases used, (m,).
        sigma_s: sigma of each of them, (m,).
        opened_s: the innovation on which the state was reopened, 0 where it was not, (m,).
        fate: USED, REFUSED or REOPENED for each observation, (n,).
        start: the state at the beginning.
        integrals_s: integrals of the c covariates at these stamps [s], (m + 1, c).
    """

    stamp_ns: IntArray
    states: Estimate[FloatArray]
    phase_s: FloatArray
    sigma_s: FloatArray
    opened_s: FloatArray
    fate: NDArray[np.int8]
    start: Known
    integrals_s: FloatArray

    def after(self, count: int) -> Known:
        """Return the state after the first `count` observations, 0 to n."""
        fate = self.fate[:count]
        used = np.flatnonzero(fate != REFUSED)
        reopened = np.flatnonzero(fate == REOPENED)
        place = len(used)
        estimate = same_fields(self.states, (float(column[place]) for column in self.states))
        return Known(
            int(self.stamp_ns[place]),
            estimate,
            count - int(used[-1]) - 1 if place else self.start.refused + count,
            int(np.sum(used >= reopened[-1])) if len(reopened) else self.start.used + place,
            tuple(self.integrals_s[place].tolist()) if self.start.integrals_s else (),
        )

    def elapsed_s(self) -> FloatArray:
        """Return the time from each observation used to the next [s], (m,)."""
        return np.diff(self.stamp_ns) / NS_PER_S

    def gained_s(self) -> tuple[FloatArray, ...]:
        """Return the growth of each integral from each observation used to the next [s], (m,)."""
        return tuple(np.diff(self.integrals_s, axis=0).T)

    def expected(self, model: ClockModel) -> Estimate[FloatArray]:
        """Return the states just before each observation used, widened where reopened, (m,)."""
        elapsed = self.elapsed_s()
        before = same_fields(self.states, (column[:-1] for column in self.states))
        ahead = predict(before, elapsed, model, self.gained_s())
        return reopen(ahead, self.opened_s, np.where(elapsed > 0.0, elapsed, np.inf))


def _patience(used: int) -> int:
    """Return how many outliers in a row are refused after so many observations were used.

    Zero before the first observation, since only a prior could contradict it. One after that: of
    two observations that disagree either may be the blunder, and the next one decides.
    """
    return REFUSED_IN_A_ROW if used >= TRUSTED else min(used, 1)


def filter_phases(
    start: Known,
    stamp_ns: Sequence[int],
    phase_s: Sequence[float],
    model: ClockModel,
    sigma_s: Sequence[float] | None = None,
    integrals_s: Sequence[Sequence[float]] = (),
) -> Filtered:
    """Return the result of the filter for observed phases, in order of their stamps.

    Single observations and batches give the same bits, since each is predicted in one step from
    the last one used.

    Args:
        start: state at the beginning.
        stamp_ns: stamps of the observations, increasing, none before the start; n values.
        phase_s: reading minus observed true time [s]; n values.
        model: noise, variance of the observations, gate.
        sigma_s: sigma of each observation; n values. None: that of the model.
        integrals_s: with covariates, their integrals at each observation [s]; n rows.
    """
    law, noise = law_of(model), noise_of(model)
    ahead_of, corrected, xx = law.ahead, law.corrected, law.xx
    if sigma_s is None:
        sigma_s = [model.observation_sigma_s] * len(stamp_ns)
    limit = math.inf if model.gate is None else model.gate * model.gate
    since, now, moved = start.stamp_ns, law.part(start.estimate), start.integrals_s
    refused, trust = start.refused, start.used
    stamps, numbers, fate = [since], list(now), bytearray()
    used: list[float] = []
    sigmas: list[float] = []
    opened: dict[int, float] = {}
    integrals, gained = list(moved), tuple[float, ...]()
    rows = integrals_s if model.coefficients else repeat(moved, len(stamp_ns))
    for stamp, phase, sigma, reached in zip(stamp_ns, phase_s, sigma_s, rows, strict=True):
        r = sigma * sigma
        elapsed = (stamp - since) / NS_PER_S
        if moved:
            gained = tuple(map(sub, reached, moved))
        ahead = ahead_of(now, elapsed, *noise, *gained)
        innovation = phase - ahead[0]
        s = ahead[xx] + r
        if innovation * innovation > limit * s:
            if refused < _patience(trust) and elapsed <= model.patience_s:
                refused += 1
                fate.append(REFUSED)
                continue
            opened[len(used)] = innovation
            # in zero time the rate cannot have changed
            whole = law.whole(start.estimate, ahead)
            ahead = law.part(reopen(whole, innovation, elapsed or math.inf))
            s, trust = ahead[xx] + r, 0
            fate.append(REOPENED)
        else:
            fate.append(USED)
        now, since, refused = corrected(ahead, innovation, s, r), stamp, 0
        trust += 1
        stamps.append(stamp)
        used.append(phase)
        sigmas.append(sigma)
        numbers += now
        if moved:
            moved = tuple(reached)
            integrals += moved
    table = np.array(numbers, np.float64).reshape(len(stamps), len(law.fields))
    rest = same_fields(start.estimate, (np.full(len(stamps), each) for each in start.estimate))
    opened_s = np.zeros(len(used))
    opened_s[list(opened)] = list(opened.values())
    return Filtered(
        np.array(stamps, np.int64),
        law.whole(rest, tuple(table.T)),
        np.array(used, np.float64),
        np.array(sigmas, np.float64),
        opened_s,
        np.frombuffer(bytes(fate), np.int8),
        start,
        np.array(integrals, np.float64).reshape(len(stamps), len(moved)),
    )
