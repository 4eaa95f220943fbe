"""Half swings over different branches, with constant friction or with linear resistance.

Two integrals give each half swing, or collocation if there is linear resistance. `fluid_pendulum`
has simpler formulas for Euler's curve and for symmetric ones.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.branches import Quarter
from tauto_core.curves.fluid import DescentCurve
from tauto_core.curves.numerics import chebyshev_nodes, root_of
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

# Numbers held in memory at once.
_PLACES_AT_ONCE = 2**19


class Course(NamedTuple):
    """A half swing."""

    duration: float
    """Time from rest to rest [s], inf if friction holds the body."""
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
        # friction is rounded to the slope at `zero`, to make the force there exactly 0: a rest of
        # one rounding gives a square root in r, for which no series converges
        bias = -falls_to * float(curve.slope(zero))

        def fall(arc: FloatArray) -> FloatArray:
            return -falls_to * curve.slope(zero - falls_to * arc) - bias

        def rise(arc: FloatArray) -> FloatArray:
            return falls_to * curve.slope(zero + falls_to * arc) + bias

        joints = curve.joints - zero
        self._fall = Quarter(
            fall, kappa, gamma, falling=True, reach=abs(start - zero), joints=-falls_to * joints
        )
        # the rise, up to the τ of the fall
        root = float(self._fall.roots[-1])
        edge = curve.descent_cusp if falls_to > 0 else curve.ascent_cusp
        room, reach = abs(edge - zero), abs(start - zero)
        while True:
            reach = min(reach, room)
            self._rise = Quarter(
                rise, kappa, gamma, falling=False, reach=reach, joints=falls_to * joints
            )
            end_root = float(self._rise.roots[-1])
            if end_root >= root:
                break
            # a start at the very limit may miss some roundings of τ at the edge
            if reach == room and end_root < root * (1.0 - 1e-12):
                raise DescentError(
                    f'start = {start!r} m: the body would come beyond the end of the other '
                    f'branch, at the arc {edge!r} m and the height '
                    f'{float(curve.height(edge)):.6g} m. Start nearer to A, or take a longer '
                    'pendulum'
                )
            if reach == room:
                break
            # τ grows about as the arc, and half as much again suffices in most cases
            reach *= 1.5 * root / end_root

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
        for begin in range(0, len(start), rows):
            part = slice(begin, begin + rows)
            arc[part], rate[part] = self._place(start[part], time[part], math.sqrt(2.0 * gravity))
        return arc, rate

    def _place(
        self, start: FloatArray, time: FloatArray, pace: float
    ) -> tuple[FloatArray, FloatArray]:
        top = self._fall.root(np.abs(start - self.zero))
        quarter = np.full_like(top, 0.5 * math.pi)
        ahead = self._fall.time(top, quarter) - pace * time
        arc, rate = np.empty_like(start), np.empty_like(start)
        for branch, rows, side in (
            (self._fall, ahead > 0.0, -self._way),
            (self._rise, ahead <= 0.0, self._way),
        ):
            high, away = top[rows], np.abs(ahead[rows])
            away = np.minimum(away, branch.time(high, quarter[rows]))
            angle = branch.angle_at(high, away)
            x = branch.arc(high * np.sin(angle))
            arc[rows] = self.zero + side * x
            rate[rows] = self._way * pace * branch.speed(x, high, angle)
        return arc, rate


def zero_of_force(curve: DescentCurve, pull: float) -> float:
    """Return the signed arc where the slope p equals `pull` [m], nearest to A.

    DescentError: the slope stays below it.
    """
    if float(curve.slope(0.0)) == pull:
        return 0.0
    way = 1.0 if float(curve.slope(0.0)) < pull else -1.0
    edge = curve.descent_cusp if way > 0.0 else curve.ascent_cusp
    # the bracket grows from A, to hold only the nearest zero
    reach = min(abs(edge), 1e-3 * curve.pendulum_length)
    while way * (float(curve.slope(way * reach)) - pull) < 0.0:
        if reach >= abs(edge):
            raise DescentError(
                f'friction of {abs(pull)!r} of the weight: it holds the body everywhere on the '
                'curve. Give less friction'
            )
        reach = min(2.0 * reach, abs(edge))
    # weak friction moves the zero by a tiny arc, which needs its own last digits
    return root_of(lambda s: float(curve.slope(s)) - pull, 0.0, way * reach, 1e-300)


# -----------------------------------------------------------------------------
# Half swings with a resistance that has a term linear in the speed (Euler 1729, 1 and 35).
#
# Against the motion act κṡ², the linear λṡ that Newton added, and constant friction:
#
#     s̈ = −γg (p(s) ± μ) − λṡ − κṡ|ṡ|,    p = dx/ds.
#
# The linear term leaves no integral for ½ṡ² along the arc. From rest to rest, with τ the fraction
# of the duration T and U = d²s/dτ²,
#
#     U = −T²γg (p(s) ± μ) − Tλs′ ∓ κs′²,    s′ = ∫ U dτ,    s = S + ∫ s′ dτ,    s′(1) = 0.
#
# Newton's method solves this for T and for U at Chebyshev's nodes. Integrals of series lose no
# digits, unlike derivatives, and on a curve that is analytic through A the series converge to
# rounding. Arcs count from the zero of the force, over the amplitude: small swings keep their
# digits.

# Numbers of nodes tried.
_COUNTS = 16, 24, 36, 54, 80, 120

# Largest size of the last two coefficients of U over the first at which a series is complete.
_TAIL = 1e-14

_NEWTON = 40
# Largest last change of U, relative to its size: convergence is quadratic.
_SETTLED = 1e-14

# Numbers of the Newton matrices held at once.
_NUMBERS = 2**22

# Amplitude below which p(s)/amplitude is taken at its limit, as the quotient would underflow [m].
_ALL_BUT_REST = 1e-290


class _Nodes(NamedTuple):
    """Integrals of a function given at n nodes in τ.

    Attributes:
        single: ∫ from 0 to each node, (n, n).
        twice: ∫∫ the same, (n, n).
        total: ∫ from 0 to 1, (n,).
        series: values to Chebyshev coefficients in 2τ − 1, (n, n).
        tau: the nodes, (n,).
    """

    single: FloatArray
    twice: FloatArray
    total: FloatArray
    series: FloatArray
    tau: FloatArray


@lru_cache(maxsize=len(_COUNTS))
def _nodes(count: int) -> _Nodes:
    x = chebyshev_nodes(count)
    series = np.linalg.inv(chebyshev.chebvander(x, count - 1))
    integral = chebyshev.chebint(series, lbnd=-1.0, scl=0.5)
    second = chebyshev.chebint(integral, lbnd=-1.0, scl=0.5)
    single = chebyshev.chebvander(x, count) @ integral
    twice = chebyshev.chebvander(x, count + 1) @ second
    matrices = single, twice, np.sum(integral, axis=0), series, 0.5 * (1.0 + x)
    return _Nodes(*(np.asarray(matrix, np.float64) for matrix in matrices))


class _Swings(NamedTuple):
    """Half swings from rest at m amplitudes.

    Attributes:
        duration: T [s], (m,).
        bend: d²σ/dτ² at the nodes, (m, n), with σ the arc from the zero of the force over its
            value at the start.
    """

    duration: FloatArray
    bend: FloatArray


class ResistedWay:
    """The half swings in one direction, like `OneWay`, with a linear resistance.

    Args:
        curve: the curve, analytic through A.
        friction: μ, constant friction over the weight in the fluid.
        viscous: λ, linear resistance over the speed and the mass that moves [1/s].
        gravity: g [m/s2].
        falls_to: −1 for half swings towards −s, 1 for those towards +s.
        start: signed arc of the farthest start [m].

    Raises:
        DescentError: a resistance too strong for a swing or for the series, or an ascent beyond
            the end of the curve.
    """

    def __init__(
        self,
        curve: DescentCurve,
        friction: float,
        viscous: float,
        gravity: float,
        falls_to: int,
        start: float,
    ) -> None:
        self._curve, self._viscous, self._way = curve, viscous, falls_to
        self._push, self._friction = curve.gamma * gravity, friction
        self.zero = zero_of_force(curve, -falls_to * friction)
        widest = np.array([start - self.zero])
        for count in _COUNTS:
            self._at = _nodes(count)
            swings = self._swings(widest)
            if swings is None:
                continue
            series = np.abs(self._at.series @ swings.bend[0])
            if np.max(series[-2:]) <= _TAIL * np.max(series):
                break
        else:
            raise DescentError(
                f'start = {start!r} m: half swings take more than {_COUNTS[-1]} Chebyshev '
                'coefficients with this resistance. Start nearer to A, or give less viscous '
                'resistance'
            )
        end = self.course(start, gravity).end
        edge = curve.descent_cusp if falls_to > 0 else curve.ascent_cusp
        if not abs(end) <= abs(edge):
            raise DescentError(
                f'start = {start!r} m: the body would come beyond the end of the other branch, at '
                f'the arc {edge!r} m. Start nearer to A, or take a longer pendulum'
            )

    def course(self, start: float, gravity: float) -> Course:
        """Return the half swing from rest at a signed arc [m]."""
        amplitude = np.array([start - self.zero])
        duration, bend = self._found(amplitude)
        _, way = self._series(bend[0])
        end = chebyshev.chebval(1.0, way)
        return Course(float(duration[0]), self.zero + float(amplitude[0]) * float(1.0 + end))

    def fall_time(self, start: float, gravity: float) -> float:
        """Return the time from rest at a signed arc [m] to the zero of the force [s]."""
        duration, bend = self._found(np.array([start - self.zero]))
        speed, way = self._series(bend[0])
        tau = 0.5
        for _ in range(_NEWTON):
            x = 2.0 * tau - 1.0
            change = float((1.0 + chebyshev.chebval(x, way)) / chebyshev.chebval(x, speed))
            tau -= change
            # τ is of order 1
            if abs(change) <= 1e-15:
                break
        return tau * float(duration[0])

    def place(
        self, start: FloatArray, time: FloatArray, gravity: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and ds/dt [m/s] at times since rest at signed arcs, (n,) each."""
        arc, rate = np.empty_like(start), np.empty_like(start)
        starts, which = np.unique(start, return_inverse=True)
        rows = max(1, _NUMBERS // len(self._at.tau) ** 2)
        for begin in range(0, len(starts), rows):
            amplitude = starts[begin : begin + rows] - self.zero
            duration, bend = self._found(amplitude)
            speed, way = self._series(bend)
            places = np.flatnonzero((which >= begin) & (which < begin + rows))
            at = which[places] - begin
            x = 2.0 * np.minimum(time[places] / duration[at], 1.0) - 1.0
            sizes = amplitude[at]
            part = chebyshev.chebval(x, way[:, at], tensor=False)
            arc[places] = self.zero + sizes * (1.0 + part)
            turned = chebyshev.chebval(x, speed[:, at], tensor=False)
            rate[places] = sizes * turned / duration[at]
        return arc, rate

    def _series(self, bend: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dσ/dτ and σ − 1 as Chebyshev series in 2τ − 1, a column for each half swing."""
        speed = chebyshev.chebint(self._at.series @ bend.T, lbnd=-1.0, scl=0.5)
        way = chebyshev.chebint(speed, lbnd=-1.0, scl=0.5)
        return np.asarray(speed, np.float64), np.asarray(way, np.float64)

    def _found(self, amplitude: FloatArray) -> _Swings:
        swings = self._swings(amplitude)
        if swings is None:
            raise DescentError(
                f'half swings from {float(np.max(np.abs(amplitude)))!r} m do not converge with '
                'this resistance. Start nearer to A, or give less viscous resistance'
            )
        return swings

    def _swings(self, amplitude: FloatArray) -> _Swings | None:
        """Return the half swings from signed arcs less the zero, if they converge."""
        at, count = self._at, len(self._at.tau)
        # the quadratic resistance against the motion, in units of the signed amplitude
        kappa = self._curve.kappa * np.abs(amplitude)[:, None]
        viscous, rate = self._viscous, float(self._curve.slope_rate(self.zero))
        slow = self._push * rate - 0.25 * viscous * viscous
        if not slow > 0.0:
            raise DescentError(
                f'viscous = {viscous!r} 1/s: the body creeps back to A without a swing. Give '
                f'less than {2.0 * math.sqrt(self._push * rate)!r} 1/s'
            )
        duration = np.full(amplitude.shape, math.pi / math.sqrt(slow))
        decay = np.exp(-0.5 * viscous * duration) / (1.0 + 4.0 / 3.0 * kappa[:, 0])
        waves = 0.5 * math.pi**2 * np.cos(math.pi * at.tau)
        bend = -(1.0 + decay)[:, None] * waves
        identity = np.eye(count)
        jacobian = np.empty((len(amplitude), count + 1, count + 1))
        for _ in range(_NEWTON):
            place, speed = 1.0 + bend @ at.twice.T, bend @ at.single.T
            pull, slope = self._pull(amplitude, place)
            t = duration[:, None]
            # σ falls from 1: the speed is negative and the quadratic term positive
            wrong = bend + t * t * pull + t * viscous * speed - kappa * speed * speed
            jacobian[:, :count, :count] = (
                identity
                + (t * t * slope)[..., None] * at.twice
                + (t * viscous - 2.0 * kappa * speed)[..., None] * at.single
            )
            jacobian[:, :count, count] = 2.0 * t * pull + viscous * speed
            jacobian[:, count, :count], jacobian[:, count, count] = at.total, 0.0
            right = np.concatenate([wrong, bend @ at.total[:, None]], axis=1)
            change = np.linalg.solve(jacobian, right[..., None])[..., 0]
            bend, duration = bend - change[:, :count], duration - change[:, count]
            size = np.max(np.abs(bend), axis=1)
            if not (np.all(np.isfinite(bend)) and np.all(duration > 0.0)):
                return None
            if np.all(np.max(np.abs(change[:, :count]), axis=1) <= _SETTLED * size):
                swung = bend @ at.single.T
                return _Swings(duration, bend) if np.all(swung <= 0.0) else None
        return None

    def _pull(self, amplitude: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return γg (p ± μ) over the amplitude at the zero + amplitude · place, and its slope."""
        curve, size = self._curve, amplitude[:, None]
        arc = np.clip(self.zero + size * place, curve.ascent_cusp, curve.descent_cusp)
        slope = self._push * curve.slope_rate(arc)
        force = curve.slope(arc) + self._way * self._friction
        small = np.abs(size) < _ALL_BUT_REST
        pull = np.where(small, slope * place, self._push * force / np.where(small, 1.0, size))
        return pull, slope


# -----------------------------------------------------------------------------
# Half swings to and fro.


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
        """Return the time from rest at a signed arc [m] to the zero of the force [s]."""
        return self._ways[self._direction(start)].fall_time(start, self._gravity)

    def with_friction(self, start: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the arcs of zero force, and slopes with friction subtracted or added, (n,).

        `start` are the signed arcs at the last rest, `slope` the slopes at the bodies' places.
        Both results are 0 for a body that friction holds.
        """
        zero, pull = np.zeros_like(start), np.zeros_like(slope)
        slopes = self._curve.slope(start)
        for way, path in self._ways.items():
            rows = -way * slopes > self._friction
            zero[rows], pull[rows] = path.zero, slope[rows] + way * self._friction
        return zero, pull

    def place(self, start: FloatArray, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and ds/dt [m/s] at times since rest at signed arcs, (n,) each."""
        arc, rate = start.copy(), np.zeros_like(start)
        slope = self._curve.slope(start)
        for way, path in self._ways.items():
            rows = -way * slope > self._friction
            arc[rows], rate[rows] = path.place(start[rows], time[rows], self._gravity)
        return arc, rate

    def _direction(self, start: float) -> int:
        return -1 if float(self._curve.slope(start)) > 0.0 else 1
