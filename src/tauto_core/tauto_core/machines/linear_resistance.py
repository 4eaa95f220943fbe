"""Half swings with a resistance that has a term linear in the speed (Euler 1729, 1 and 35).

Against the motion act κṡ², the linear λṡ that Newton added, and constant friction:

    s̈ = −γg (p(s) ± μ) − λṡ − κṡ|ṡ|,    p = dx/ds.

With the linear term ½ṡ² is no integral along the arc any more. From rest to rest, with τ the part
of the duration T that has passed and U = d²s/dτ²,

    U = −T²γg (p(s) ± μ) − Tλs′ ∓ κs′²,    s′ = ∫ U dτ,    s = S + ∫ s′ dτ,    s′(1) = 0,

which Newton's method solves for T and for U at Chebyshev's nodes. Integrals of series lose no
digits, as derivatives would, and on a curve that is analytic through A the series converge to
rounding. Arcs count from the zero of the force, over the amplitude, so that small swings keep
their digits.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.fluid import DescentCurve
from tauto_core.curves.numerics import chebyshev_nodes
from tauto_core.machines.half_swings import Course, zero_of_force
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import DescentError

# Numbers of nodes tried.
_COUNTS = 16, 24, 36, 54, 80, 120

# Largest size of the last two coefficients of U over the first at which a series is complete.
_TAIL = 1e-14

_NEWTON = 40
# Largest last change of U, relative to its size: convergence is quadratic.
_SETTLED = 1e-14

# Numbers of the Newton matrices held at once.
_NUMBERS = 2**22

# Amplitude below which p(s)/amplitude is its limit [m]: the quotient would underflow.
_ALL_BUT_REST = 1e-290


class _Nodes(NamedTuple):
    """Integrals of a function given at n nodes in τ.

    Attributes:
        once: ∫ from 0 to each node, (n, n).
        twice: ∫∫ the same, (n, n).
        whole: ∫ from 0 to 1, (n,).
        series: values to Chebyshev coefficients in 2τ − 1, (n, n).
        tau: the nodes, (n,).
    """

    once: FloatArray
    twice: FloatArray
    whole: FloatArray
    series: FloatArray
    tau: FloatArray


@lru_cache(maxsize=len(_COUNTS))
def _nodes(count: int) -> _Nodes:
    x = chebyshev_nodes(count)
    series = np.linalg.inv(chebyshev.chebvander(x, count - 1))
    first = chebyshev.chebint(series, lbnd=-1.0, scl=0.5)
    second = chebyshev.chebint(first, lbnd=-1.0, scl=0.5)
    once = chebyshev.chebvander(x, count) @ first
    twice = chebyshev.chebvander(x, count + 1) @ second
    found = once, twice, np.sum(first, axis=0), series, 0.5 * (1.0 + x)
    return _Nodes(*(np.asarray(each, np.float64) for each in found))


class _Swings(NamedTuple):
    """Half swings from rest at m amplitudes.

    Attributes:
        duration: T [s], (m,).
        bend: d²σ/dτ² at the nodes, with σ the arc from the zero of the force over that at the
            start, (m, n).
    """

    duration: FloatArray
    bend: FloatArray


class ResistedWay:
    """The half swings in one direction, as `half_swings.OneWay`, with a linear resistance.

    Args:
        curve: the curve, analytic through A.
        friction: μ, constant friction over the weight in the fluid.
        viscous: λ, linear resistance over the speed and the mass that moves [1/s].
        gravity: g [m/s2].
        falls_to: −1 for half swings towards −s, 1 for those towards +s.
        start: signed arc of the farthest start [m].

    Raises:
        DescentError: a resistance so strong that the body does not swing, or that no series
            describes; or the body would come beyond the end of the curve.
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
            found = self._swings(widest)
            if found is None:
                continue
            series = np.abs(self._at.series @ found.bend[0])
            if np.max(series[-2:]) <= _TAIL * np.max(series):
                break
        else:
            raise DescentError(
                f'start = {start!r} m: half swings take more than {_COUNTS[-1]} Chebyshev '
                'coefficients with this resistance; start nearer to A, or give less viscous '
                'resistance'
            )
        end = self.course(start, gravity).end
        edge = curve.descent_cusp if falls_to > 0 else curve.ascent_cusp
        if not abs(end) <= abs(edge):
            raise DescentError(
                f'start = {start!r} m: the body would come beyond the end of the other branch, at '
                f'the arc {edge!r} m; start nearer to A, or take a longer pendulum'
            )

    def course(self, start: float, gravity: float) -> Course:
        """Return the half swing from rest at a signed arc [m]."""
        del gravity
        amplitude = np.array([start - self.zero])
        duration, bend = self._found(amplitude)
        _, way = self._series(bend[0])
        end = chebyshev.chebval(1.0, way)
        return Course(float(duration[0]), self.zero + float(amplitude[0]) * float(1.0 + end))

    def fall_time(self, start: float, gravity: float) -> float:
        """Return the time from rest at a signed arc [m] to the zero of the force [s]."""
        del gravity
        duration, bend = self._found(np.array([start - self.zero]))
        speed, way = self._series(bend[0])
        tau = 0.5
        for _ in range(_NEWTON):
            x = 2.0 * tau - 1.0
            change = float((1.0 + chebyshev.chebval(x, way)) / chebyshev.chebval(x, speed))
            tau -= change
            # τ is of order 1, and this a few of its roundings
            if abs(change) <= 1e-15:
                break
        return tau * float(duration[0])

    def place(
        self, start: FloatArray, time: FloatArray, gravity: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return signed arc [m] and ds/dt [m/s] at times since rest at signed arcs, (n,) each."""
        del gravity
        arc, rate = np.empty_like(start), np.empty_like(start)
        starts, which = np.unique(start, return_inverse=True)
        rows = max(1, _NUMBERS // len(self._at.tau) ** 2)
        for first in range(0, len(starts), rows):
            amplitude = starts[first : first + rows] - self.zero
            duration, bend = self._found(amplitude)
            speed, way = self._series(bend)
            here = np.flatnonzero((which >= first) & (which < first + rows))
            at = which[here] - first
            x = 2.0 * np.minimum(time[here] / duration[at], 1.0) - 1.0
            sizes = amplitude[at]
            part = chebyshev.chebval(x, way[:, at], tensor=False)
            arc[here] = self.zero + sizes * (1.0 + part)
            turned = chebyshev.chebval(x, speed[:, at], tensor=False)
            rate[here] = sizes * turned / duration[at]
        return arc, rate

    def _series(self, bend: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dσ/dτ and σ − 1 as Chebyshev series in 2τ − 1, a column for each half swing."""
        speed = chebyshev.chebint(self._at.series @ bend.T, lbnd=-1.0, scl=0.5)
        way = chebyshev.chebint(speed, lbnd=-1.0, scl=0.5)
        return np.asarray(speed, np.float64), np.asarray(way, np.float64)

    def _found(self, amplitude: FloatArray) -> _Swings:
        found = self._swings(amplitude)
        if found is None:
            raise DescentError(
                f'half swings from {float(np.max(np.abs(amplitude)))!r} m do not converge with '
                'this resistance; start nearer to A, or give less viscous resistance'
            )
        return found

    def _swings(self, amplitude: FloatArray) -> _Swings | None:
        """Return the half swings from signed arcs, less the zero; None: no convergence."""
        at, count = self._at, len(self._at.tau)
        # the resistance against the motion, in units of the amplitude; of its sign
        kappa = self._curve.kappa * np.abs(amplitude)[:, None]
        viscous, rate = self._viscous, float(self._curve.slope_rate(self.zero))
        slow = self._push * rate - 0.25 * viscous * viscous
        if not slow > 0.0:
            raise DescentError(
                f'viscous = {viscous!r} 1/s: the body creeps back to A and does not swing; give '
                f'less than {2.0 * math.sqrt(self._push * rate)!r} 1/s'
            )
        duration = np.full(amplitude.shape, math.pi / math.sqrt(slow))
        left = np.exp(-0.5 * viscous * duration) / (1.0 + 4.0 / 3.0 * kappa[:, 0])
        waves = 0.5 * math.pi**2 * np.cos(math.pi * at.tau)
        bend = -(1.0 + left)[:, None] * waves
        identity = np.eye(count)
        jacobian = np.empty((len(amplitude), count + 1, count + 1))
        for _ in range(_NEWTON):
            place, speed = 1.0 + bend @ at.twice.T, bend @ at.once.T
            pull, slope = self._pull(amplitude, place)
            t = duration[:, None]
            # σ falls from 1, so that its speed is negative and the quadratic term is positive
            wrong = bend + t * t * pull + t * viscous * speed - kappa * speed * speed
            jacobian[:, :count, :count] = (
                identity
                + (t * t * slope)[..., None] * at.twice
                + (t * viscous - 2.0 * kappa * speed)[..., None] * at.once
            )
            jacobian[:, :count, count] = 2.0 * t * pull + viscous * speed
            jacobian[:, count, :count], jacobian[:, count, count] = at.whole, 0.0
            right = np.concatenate([wrong, bend @ at.whole[:, None]], axis=1)
            change = np.linalg.solve(jacobian, right[..., None])[..., 0]
            bend, duration = bend - change[:, :count], duration - change[:, count]
            size = np.max(np.abs(bend), axis=1)
            if not (np.all(np.isfinite(bend)) and np.all(duration > 0.0)):
                return None
            if np.all(np.max(np.abs(change[:, :count]), axis=1) <= _SETTLED * size):
                swung = bend @ at.once.T
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
