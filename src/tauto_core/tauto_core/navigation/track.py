"""The recent run of the filter, kept so that it can be repeated when an observation comes late."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from tauto_core.navigation.filtering import REFUSED, REOPENED, Filtered, Known, filter_phases
from tauto_core.navigation.kalman import ClockModel, estimate_of
from tauto_core.samples import State

REMEMBERED = 64
"""Least number of recent observations that the filter can repeat."""

Observed: TypeAlias = tuple[int, float, float, tuple[float, ...]]
"""Stamp [ns], phase and its sigma [s], and integrals of the covariates [s]."""


class Seen(NamedTuple):
    """An observation that the filter has seen, and its fate (`filtering`)."""

    stamp_ns: int
    phase_s: float
    sigma_s: float
    fate: int
    integrals_s: tuple[float, ...] = ()

    @property
    def observed(self) -> Observed:
        """The observation as it was given."""
        return self.stamp_ns, self.phase_s, self.sigma_s, self.integrals_s


class Track:
    """Takes observations in any order, and gives the state as if they had come in order.

    Args:
        start: the state when the dial was set.
        model: noise, variance of the observations, gate.
    """

    def __init__(self, start: Known, model: ClockModel) -> None:
        self._model = model
        self._base = self._last = start
        self._oldest_ns = start.stamp_ns
        self._seen: list[Seen] = []
        self._counts = {REFUSED: 0, REOPENED: 0}

    @property
    def oldest_ns(self) -> int:
        """The earliest stamp that an observation may still have."""
        return self._oldest_ns

    @property
    def last(self) -> Known:
        """The state after all observations so far."""
        return self._last

    def has(self, stamp_ns: int) -> bool:
        """Return whether an observation of this stamp is among those kept."""
        return any(seen.stamp_ns == stamp_ns for seen in reversed(self._seen))

    def count(self, fate: int) -> int:
        """Return the number of observations that were REFUSED or REOPENED the state."""
        return self._counts[fate] + sum(seen.fate == fate for seen in self._seen)

    def use(
        self,
        stamp_ns: Sequence[int],
        phase_s: Sequence[float],
        sigma_s: Sequence[float] | None = None,
        integrals_s: Sequence[tuple[float, ...]] = (),
    ) -> Filtered:
        """Take observations of new stamps, none before `oldest_ns`; return the repeated run.

        It begins at the last state before the first of them, or earlier. Arguments are those of
        `filter_phases`.
        """
        if sigma_s is None:
            sigma_s = [self._model.observation_sigma_s] * len(stamp_ns)
        integrals_s = integrals_s or [()] * len(stamp_ns)
        new = sorted(zip(stamp_ns, phase_s, sigma_s, integrals_s, strict=True))
        start, kept = self._last, self._seen
        if kept and new and new[0][0] < kept[-1].stamp_ns:
            start, kept = self._base, []
            new = sorted(new + [seen.observed for seen in self._seen])
        way = self._filtered(start, new)
        self._last = way.after(len(new))
        self._remember(kept, new, way)
        return way

    def _filtered(self, start: Known, new: Sequence[Observed]) -> Filtered:
        stamps, phases, sigmas, integrals = zip(*new, strict=True) if new else ((), (), (), ())
        return filter_phases(start, stamps, phases, self._model, sigmas, integrals)

    def _remember(self, kept: list[Seen], new: list[Observed], way: Filtered) -> None:
        """Move the base forward when more than enough observations have been seen since.

        Args:
            kept: observations since the base, before those of the run.
            new: the observations of the run.
            way: the result of the filter for them.
        """
        total = len(kept) + len(new)
        first = max(total - REMEMBERED - len(kept), 0) if total >= 2 * REMEMBERED else 0
        fates = way.fate[first:].tolist()
        tail = [
            Seen(stamp, phase, sigma, fate, integrals)
            for (stamp, phase, sigma, integrals), fate in zip(new[first:], fates, strict=True)
        ]
        self._seen = kept + tail
        if total < 2 * REMEMBERED:
            return
        if first:
            self._base = way.after(first)
            self._oldest_ns = new[first - 1][0] + 1
            gone = [*(seen.fate for seen in kept), *way.fate[:first].tolist()]
        else:
            old, tail = self._seen[:-REMEMBERED], self._seen[-REMEMBERED:]
            again = [seen.observed for seen in old]
            self._base = self._filtered(self._base, again).after(len(old))
            self._oldest_ns = old[-1].stamp_ns + 1
            gone = [seen.fate for seen in old]
        self._seen = tail
        for fate in self._counts:
            self._counts[fate] += gone.count(fate)

    def state(self) -> State:
        """Return all that the next result depends on."""
        return {
            'base': _plain(self._base),
            'last': _plain(self._last),
            'oldest_ns': self._oldest_ns,
            'seen': [tuple(seen) for seen in self._seen],
            'counts': dict(self._counts),
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._base, self._last = self._known(state['base']), self._known(state['last'])
        self._oldest_ns = state['oldest_ns']
        self._seen = [Seen(*seen) for seen in state['seen']]
        self._counts = dict(state['counts'])

    def _known(self, plain: tuple[Any, ...]) -> Known:
        stamp_ns, estimate, *others = plain
        return Known(stamp_ns, estimate_of(self._model.names)(*estimate), *others)


def _plain(known: Known) -> tuple[Any, ...]:
    stamp_ns, estimate, *others = known
    return stamp_ns, tuple(estimate), *others
