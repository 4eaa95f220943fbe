"""Half swings over branches that differ, with constant friction or without, each by two integrals.

On Euler's curve and on symmetric ones `fluid_pendulum` has shorter ways.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tauto_core.curves.branches import Quarter
from tauto_core.curves.fluid import DescentCurve
from tauto_core.curves.numerics import root_of
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

if TYPE_CHECKING:
    from tauto_core.machines.linear_resistance import ResistedWay

# Numbers held at once to compute places within half swings.
_PLACES_AT_ONCE = 2**19


class Course(NamedTuple):
    """A half swing."""

    duration: float
    """Time from rest to rest [s]; inf where friction holds the body."""
    end: float
    """Signed arc where it ends [m]."""


class OneWay:
    """The half swings in one direction: the body falls on one branch and rises on the other.

    Args:
        curve: the curve.
        friction: μ, constant friction over the weight in the fluid.
        falls_to: −1 for half swings towards −s, 1 for those towards +s.
        start: signed arc of the farthest start [m].

    Raises:
        DescentError: the body would come beyond the end of the branch on which it rises.
    """

    def __init__(self, curve: DescentCurve, friction: float, falls_to: int, start: float) -> None:
        self._way, self.zero = falls_to, zero_of_force(curve, -falls_to * friction)
        zero, kappa, gamma = self.zero, curve.kappa, curve.gamma
        # friction as the slope at the rounded zero has it, so that the force there is 0 exactly;
        # a rest of one rounding has a root for r, of which no series converges
        held = -falls_to * float(curve.slope(zero))

        def fall(arc: FloatArray) -> FloatArray:
            return -falls_to * curve.slope(zero - falls_to * arc) - held

        def rise(arc: FloatArray) -> FloatArray:
            return falls_to * curve.slope(zero + falls_to * arc) + held

        joints = curve.joints - zero
        self._fall = Quarter(
            fall, kappa, gamma, falling=True, reach=abs(start - zero), joints=-falls_to * joints
        )
        # the rise, as far as it takes the fall's τ
        root = float(self._fall.roots[-1])
        edge = curve.descent_cusp if falls_to > 0 else curve.ascent_cusp
        room, reach = abs(edge - zero), abs(start - zero)
        while True:
            reach = min(reach, room)
            self._rise = Quarter(
                rise, kappa, gamma, falling=False, reach=reach, joints=falls_to * joints
            )
            found = float(self._rise.roots[-1])
            if found >= root:
                break
            # a start at the very limit may lack some roundings of τ at the edge
            if reach == room and found < root * (1.0 - 1e-12):
                raise DescentError(
                    f'start = {start!r} m: the body would come beyond the end of the other '
                    f'branch, at the arc {edge!r} m and the height '
                    f'{float(curve.height(edge)):.6g} m; start nearer to A, or take a longer '
                    'pendulum'
                )
            if reach == room:
                break
            # τ goes about as the arc; half as much again makes another turn unlikely
            reach *= 1.5 * root / found

    def course(self, start: float, gravity: float) -> Course:
        """Return the half swing from rest at a signed arc [m]."""
        top = self._fall.root(np.array([abs(start - self.zero)]))
        quarter = np.array([0.5 * math.pi])
        time = float(self._fall.time(top, quarter)[0] + self._rise.time(top, quarter)[0])
        end = self.zero + self._way * float(self._rise.arc(top)[0])
        return Course(time / math.sqrt(2.0 * gravity), end)

    def fall_time(self, start: float, gravity: float) -> float:
        """Return the time from rest at a signed arc [m] to the zero of the force [s]."""
        top = self._fall.root(np.array([abs(start - self.zero)]))
        time = self._fall.time(top, np.array([0.5 * math.pi]))
        return float(time[0]) / math.sqrt(2.0 * gravity)

    def place(
        self, start: FloatArray, time: FloatArray, gravity: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and ds/dt [m/s] at times since rest at signed arcs, (n,) each."""
        arc, rate = np.empty_like(start), np.empty_like(start)
        rows = max(1, _PLACES_AT_ONCE // (64 * (len(self._fall.roots) + len(self._rise.roots))))
        for first in range(0, len(start), rows):
            part = slice(first, first + rows)
            arc[part], rate[part] = self._place(start[part], time[part], math.sqrt(2.0 * gravity))
        return arc, rate

    def _place(
        self, start: FloatArray, time: FloatArray, pace: float
    ) -> tuple[FloatArray, FloatArray]:
        top = self._fall.root(np.abs(start - self.zero))
        quarter = np.full_like(top, 0.5 * math.pi)
        before = self._fall.time(top, quarter) - pace * time
        arc, rate = np.empty_like(start), np.empty_like(start)
        for branch, rows, side in (
            (self._fall, before > 0.0, -self._way),
            (self._rise, before <= 0.0, self._way),
        ):
            high, left = top[rows], np.abs(before[rows])
            left = np.minimum(left, branch.time(high, quarter[rows]))
            angle = branch.angle_at(high, left)
            x = branch.arc(high * np.sin(angle))
            arc[rows] = self.zero + side * x
            rate[rows] = self._way * pace * branch.speed(x, high, angle)
        return arc, rate


def zero_of_force(curve: DescentCurve, pull: float) -> float:
    """Return the signed arc where the slope p equals `pull` [m], nearest to A.

    DescentError: the slope reaches it nowhere.
    """
    if float(curve.slope(0.0)) == pull:
        return 0.0
    way = 1.0 if float(curve.slope(0.0)) < pull else -1.0
    edge = curve.descent_cusp if way > 0.0 else curve.ascent_cusp
    # the bracket grows from A, so that it holds the nearest zero alone
    far = min(abs(edge), 1e-3 * curve.pendulum_length)
    while way * (float(curve.slope(way * far)) - pull) < 0.0:
        if far >= abs(edge):
            raise DescentError(
                f'friction of {abs(pull)!r} of the weight: it holds the body everywhere on the '
                'curve; give less'
            )
        far = min(2.0 * far, abs(edge))
    # weak friction moves the zero by next to nothing, which must be right to its own last digits
    return root_of(lambda s: float(curve.slope(s)) - pull, 0.0, way * far, 1e-300)


class BothWays:
    """The half swings in both directions, from a release on.

    Args:
        curve: the curve.
        gravity: g in vacuum [m/s2].
        friction: μ, constant friction over the weight in the fluid.
        release: signed arc of the first start [m].
        viscous: λ, linear resistance over the speed and the mass that moves [1/s].

    Raises:
        DescentError: the body would come beyond the end of a branch, or does not swing.
    """

    def __init__(
        self,
        curve: DescentCurve,
        gravity: float,
        friction: float,
        release: float,
        viscous: float = 0.0,
    ) -> None:
        self._curve, self._gravity, self._friction = curve, gravity, friction
        self._ways: dict[int, OneWay | ResistedWay] = {}
        start = release
        for _ in range(2):
            if self.holds(start):
                break
            way = self._direction(start)
            if way in self._ways:
                break
            if viscous:
                from tauto_core.machines.linear_resistance import ResistedWay

                self._ways[way] = ResistedWay(curve, friction, viscous, gravity, way, start)
            else:
                self._ways[way] = OneWay(curve, friction, way, start)
            start = self._ways[way].course(start, gravity).end

    def holds(self, arc: float) -> bool:
        """Return whether friction holds the body at rest at a signed arc [m]."""
        return abs(float(self._curve.slope(arc))) <= self._friction

    def course(self, start: float) -> Course:
        """Return the half swing from rest at a signed arc [m], no wider than the release."""
        if self.holds(start):
            return Course(math.inf, start)
        return self._ways[self._direction(start)].course(start, self._gravity)

    def fall_time(self, start: float) -> float:
        """Return the time from rest at a signed arc [m] to where nothing pulls it along [s]."""
        return self._ways[self._direction(start)].fall_time(start, self._gravity)

    def with_friction(self, start: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the arcs where nothing pulls bodies along, and slopes less or more friction.

        `start` are the signed arcs from which they came, `slope` the slopes where they are, (n,).
        Of a body that friction holds both are 0.
        """
        zero, pull = np.zeros_like(start), np.zeros_like(slope)
        first = self._curve.slope(start)
        for way, one in self._ways.items():
            rows = -way * first > self._friction
            zero[rows], pull[rows] = one.zero, slope[rows] + way * self._friction
        return zero, pull

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and ds/dt [m/s] at times since rest at signed arcs, (n,) each."""
        arc, rate = start.copy(), np.zeros_like(start)
        slope = self._curve.slope(start)
        for way, one in self._ways.items():
            rows = -way * slope > self._friction
            arc[rows], rate[rows] = one.place(start[rows], time[rows], self._gravity)
        return arc, rate

    def _direction(self, start: float) -> int:
        return -1 if float(self._curve.slope(start)) > 0.0 else 1
