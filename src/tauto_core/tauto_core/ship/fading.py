"""Motion in a sea that changes: sums of harmonics that fade into one another (theory F1).

Between two states, at t_k and t_k+1, the motion is

    x(t) = cos(½π s(u)) x_k(t) + sin(½π s(u)) x_k+1(t),    u = (t − t_k)/(t_k+1 − t_k),
    s(u) = 35 u⁴ − 84 u⁵ + 70 u⁶ − 20 u⁷.

The two are independent, so the variance is cos² σ_k² + sin² σ_k+1², without a dip in between.
Three derivatives of s vanish at both ends. The process is an evolutionary one (Priestley,
Evolutionary spectra and non-stationary processes, J. R. Stat. Soc. B 27, 1965).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tauto_core.samples import FloatArray
from tauto_core.ship.waves import TOGETHER, Harmonics, SampledHarmonics

KEPT = 3
"""Number of sums kept in memory: two during a change, and one that has ended or comes next."""


@dataclass(frozen=True)
class Fades:
    """x(t) for states at increasing times; before the first and after the last it does not change.

    Attributes:
        at_ns: time of each state from the start of the scene, possibly before it, (n,), n > 0.
        sums: number of the sum of harmonics of each state, (n,); equal to that of the state before
            where the motion continues. A sum is present in successive states only.
        of: function that gives the harmonics of a sum; None: a calm, x = 0.
    """

    at_ns: tuple[int, ...]
    sums: tuple[int, ...]
    of: Callable[[int], Harmonics | None]

    def most(self, order: int) -> float:
        """Return a bound of the size of the motion's derivative of some order, 0 to 2.

        During a change the derivatives of the angle contribute. They are below 1/s (and 1/s2) in
        changes of ten seconds or more.
        """
        sums = [self.of(number) for number in set(self.sums)]
        sizes = [sum(each.most(n) for n in range(order + 1)) for each in sums if each is not None]
        return 4.0 * max(sizes, default=0.0)


class SampledFades:
    """Values and derivatives of a motion that fades, at sample indices k, t = k step.

    A sample's bits depend on its index alone. Only the sums that are present are computed: none in
    a calm, one in a steady sea, two in a change. Where a single sum is present, its samples are
    those of `SampledHarmonics`, unchanged.

    Args:
        fades: the motion.
        step_ns: time between samples [ns], > 0.
    """

    def __init__(self, fades: Fades, step_ns: int) -> None:
        self._fades, self._step_ns = fades, step_ns
        # the first sample at or after each state
        self._begins = [-(-at // step_ns) for at in fades.at_ns]
        self._kept: dict[int, SampledHarmonics | None] = {}
        self._zeros = np.zeros(0)

    def between(self, first: int, last: int, *orders: int) -> list[FloatArray]:
        """Return samples k = first ... last - 1 of each order asked for, shape (last - first,).

        Args:
            first: >= 0.
            last: > first.
            orders: the orders of the derivatives, rising, as for `SampledHarmonics`.
        """
        parts = []
        while first < last:
            state = bisect_right(self._begins, first) - 1
            following = state + 1
            end = last
            if following < len(self._begins):
                end = min(end, self._begins[following])
            parts.append(self._part(max(state, 0), following, (first, end), orders))
            first = end
        if len(parts) == 1:
            return parts[0]
        return [np.concatenate(columns) for columns in zip(*parts, strict=True)]

    def _part(
        self, state: int, following: int, span: tuple[int, int], orders: tuple[int, ...]
    ) -> list[FloatArray]:
        """Return samples from one state on, none beyond the following one."""
        sums = self._fades.sums
        old = sums[state]
        new = sums[following] if following < len(sums) else old
        if old == new:
            return self._alone(old, span, orders)
        return self._fading(state, (old, new), span, orders)

    def _alone(
        self, number: int, span: tuple[int, int], orders: tuple[int, ...]
    ) -> list[FloatArray]:
        """Return samples of one sum; zeros in a calm, one array for all orders."""
        found = self._sampled(number)
        if found is not None:
            return found.between(*span, *orders)
        samples = span[1] - span[0]
        if len(self._zeros) < samples:
            self._zeros = np.zeros(samples)
        return [self._zeros[:samples] for _ in orders]

    def _fading(
        self,
        state: int,
        numbers: tuple[int, int],
        span: tuple[int, int],
        orders: tuple[int, ...],
    ) -> list[FloatArray]:
        from tauto_core.ship.fade_kernels import fade  # imports kernels

        motions = []
        for number in numbers:
            parts = self._alone(number, span, tuple(range(orders[-1] + 1)))
            # derivatives that no output needs are not read
            motions.append((*parts, *[parts[0]] * (3 - len(parts))))
        samples = span[1] - span[0]
        outputs: list[FloatArray | None] = [None, None, None]
        for order in orders:
            outputs[order] = np.empty(-(-samples // TOGETHER) * TOGETHER)
        begin_ns, end_ns = self._fades.at_ns[state : state + 2]
        fade(span[0], self._step_ns, begin_ns, end_ns - begin_ns, *motions, *outputs)
        return [out[:samples] for out in outputs if out is not None]

    def _sampled(self, number: int) -> SampledHarmonics | None:
        """Return a sum ready to be sampled; None in a calm."""
        if number not in self._kept:
            harmonics = self._fades.of(number)
            while len(self._kept) >= KEPT:
                self._kept.pop(next(iter(self._kept)))
            self._kept[number] = (
                None if harmonics is None else SampledHarmonics(harmonics, self._step_ns)
            )
        return self._kept[number]
