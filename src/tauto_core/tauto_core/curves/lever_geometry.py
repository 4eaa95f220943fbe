"""Sully's lever: the position of thread and lever for each angle of the wheel (Euler 1727, V).

The thread leaves an involute of base radius r on the wheel's axle C, is inclined by δ and tied at
B to a lever AD that turns about A. At rest the lever is at β₀ above the level (0: level), and B
below C. With u = θ − δ, n = (cos δ, sin δ) and d = (sin δ, −cos δ)

    B = r u n + (r + l) d,    l = l₀ − r u²/2,    B = A + AB (cos β, sin β),
    A = (−AB cos β₀, −(r + l₀) − AB sin β₀).

The distance of B from C is a function of u², and by the lever of β. Everything follows without
iteration from τ = ±√tan((β − β₀)/2). τ has the sign of θ, and is smooth up to a dead point and
through rest, since β − β₀ is proportional to θ² there. The forms are free of cancellation.

This is the lever as Euler reports it. Sully built it with an arc about A to which the thread is
tangent (`ArcLeverGeometry`). The fulcrum is to starboard of the thread, or to port
(`MirroredLever`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from tauto_core.curves.numerics import bisect, bracketed_newton, sine_defect
from tauto_core.samples import FloatArray

# -----------------------------------------------------------------------------
# The base of Sully's levers with any cam: parts, edges, and τ of θ.

LEAST_COSINE = 0.1
"""cos(β − δ) or cos β at the edge, six degrees from a dead point (lever in line with the thread)
or from upright.
"""

LEAST_FREE_SHARE = 0.1
"""Part of the thread that is still free at the edge."""

# Number of places on each side in the search for the edge.
_SCAN = 4096


class LeverSetting(NamedTuple):
    """The properties of the machine that determine the cam of a lever.

    Attributes:
        inertia: I of the wheel [kg m2].
        weight_torque: m g AD of the weight about the fulcrum, the lever level [N m].
        turned_inertia: J of weight and lever about the fulcrum [kg m2].
        arm: AB, from the fulcrum to the thread [m].
        length: length of the free thread at rest [m].
        on_arc: whether AB is the radius of an arc to which the thread is tangent.
        inclination: β₀ of the lever above the level at rest [rad].
        varies: whether a force that depends on the draw pulls in place of the weight.
    """

    inertia: float
    weight_torque: float
    turned_inertia: float
    arm: float
    length: float
    on_arc: bool = False
    inclination: float = 0.0
    varies: bool = False


class Pose(NamedTuple):
    """Positions of the parts, arrays of any one shape.

    Attributes:
        u: θ − δ, the direction of the thread's line in the wheel's frame, on an involute the
            angle of wound-up thread [rad].
        beta: β of the lever above the level [rad].
        delta: δ of the thread from the plumb line [rad].
        free: length of the thread from the cam to B [m].
    """

    u: FloatArray
    beta: FloatArray
    delta: FloatArray
    free: FloatArray


class LeverLinkage(ABC):
    """Cam, thread and lever of Sully's machine, as functions of τ.

    Attributes:
        base_radius: r, dt/du at rest [m].
        arm: AB, from the fulcrum to the thread [m].
        length: l₀ of the free thread at rest [m].
        side: 1 with the fulcrum to starboard of the thread, −1 to port.
        inclination: β₀ of the lever above the level at rest [rad].
        widening: the change that widens its range, as the end of a sentence.
    """

    base_radius: float
    arm: float
    length: float
    side: float = 1.0
    inclination: float = 0.0
    widening: str = ', or use a smaller cam, a longer lever or a longer thread'

    @abstractmethod
    def u_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return t/(r τ): the angle that an involute of base radius r would wind up, over τ."""

    @abstractmethod
    def pose(self, tau: FloatArray) -> Pose:
        """Return the position of all parts, NaN beyond the cam or the thread."""

    @abstractmethod
    def theta(self, tau: FloatArray) -> FloatArray:
        """Return θ, the wheel's angle [rad]."""

    @abstractmethod
    def rates(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dθ/dτ, 0 at a dead point, and dβ/dτ."""

    @abstractmethod
    def slopes(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ, the ratio of the two lever arms, and d²β/dθ² [1/rad]."""

    def pull_cosine(self, beta: FloatArray, delta: FloatArray) -> FloatArray:
        """Return the distance of the thread from the fulcrum over AB: cos(β − δ), 1 on an arc."""
        return np.asarray(np.cos(beta - delta))

    @abstractmethod
    def _usable(self, tau: FloatArray) -> np.ndarray:
        """Return whether thread, lever and cam work, which excludes an upright lever."""

    @property
    def depth(self) -> float:
        """Depth of B below C at rest, r + l₀ [m]."""
        return self.base_radius + self.length

    @cached_property
    def edges(self) -> tuple[float, float]:
        """Least and largest τ between which everything is usable, by bisection."""
        # τ of the upright lever
        upright = np.sqrt(np.cos(self.inclination) / (1.0 + np.sin(self.inclination)))
        ends = []
        for side in (-upright, upright):
            # the first unusable point from rest outwards brackets the edge
            grid = side * np.arange(1, _SCAN + 1) / _SCAN
            bad = float(grid[np.argmin(self._usable(grid))])
            good = bad - side / _SCAN
            ends.append(bisect(lambda tau: bool(self._usable(np.array([tau]))[0]), good, bad)[0])
        return -abs(ends[0]), abs(ends[1])

    @property
    def range_rad(self) -> float:
        """Largest |θ| on both sides [rad]."""
        low, high = self.theta(np.array(self.edges)).tolist()
        return float(min(-low, high))

    def tau_of(self, theta: FloatArray) -> FloatArray:
        """Return τ of the wheel's angle, of any shape, within the edges, by Newton's method."""
        theta = np.asarray(theta, np.float64)
        start = np.asarray(theta / self.rates(np.zeros(1))[0][0])
        return bracketed_newton(
            lambda tau: (self.theta(tau) - theta, self.rates(tau)[0]),
            start,
            self.edges,
            relative=2e-16,
        )


def clear(beta: FloatArray, pull_cosine: FloatArray, free: FloatArray) -> np.ndarray:
    """Return whether lever and thread are within the limits.

    `free` is the length of the thread from the cam to B over its length at rest, or NaN.
    """
    cosine = np.minimum(np.cos(beta), pull_cosine)
    return np.asarray((cosine >= LEAST_COSINE) & (free >= LEAST_FREE_SHARE))


@dataclass(frozen=True)
class LeverGeometry(LeverLinkage):
    """A lever machine with an involute of base radius r, and lengths > 0 as in `LeverLinkage`."""

    base_radius: float
    arm: float
    length: float
    inclination: float = 0.0

    def u_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return u/τ, r u² (l₀ + l)/2 = l₀² − l².

        That is 2 AB [(r + l₀)(sin β − sin β₀) − AB (1 − cos(β − β₀))].
        """
        wound, free = self._wound(tau)
        return np.asarray(np.sqrt(2.0 * wound / (self.base_radius * (self.length + free))))

    def pose(self, tau: FloatArray) -> Pose:
        """Return the position of all parts, NaN if the thread is too short."""
        tau = np.asarray(tau, np.float64)
        u, half_angle = tau * self.u_per_tau(tau), np.arctan(tau * tau)
        free, start = self._wound(tau)[1], self.inclination
        beta = start + 2.0 * half_angle
        across = -2.0 * self.arm * np.sin(half_angle) * np.sin(start + half_angle)
        down = self.depth - self.arm * (np.sin(beta) - np.sin(start))
        inner = np.arctan2(self.base_radius * u, self.base_radius + free)
        return Pose(u, beta, np.arctan2(across, down) - inner, free)

    def theta(self, tau: FloatArray) -> FloatArray:
        """Return θ, the wheel's angle [rad]."""
        pose = self.pose(tau)
        return np.asarray(pose.u + pose.delta)

    def rates(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dθ/dτ, 0 at a dead point, and dβ/dτ."""
        pose, square = self.pose(tau), tau * tau
        beta = 4.0 / (1.0 + square * square)
        arm = self.arm * self.pull_cosine(pose.beta, pose.delta)
        return beta * arm / (self.base_radius * self.u_per_tau(tau)), beta * tau

    def slopes(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ, the ratio of the two lever arms, and d²β/dθ² [1/rad]."""
        u, beta, delta, free = self.pose(tau)
        sine, cosine = np.sin(beta - delta), np.cos(beta - delta)
        arm = self.arm * cosine
        ratio = self.base_radius * u / arm
        inclines = -(self.base_radius + self.arm * ratio * sine) / free
        second = self.base_radius * (1.0 - inclines) / arm
        return ratio, second + ratio * sine / cosine * (ratio - inclines)

    def _wound(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return (l₀² − l²)/τ² [m2] and l [m]."""
        square, start = tau * tau, self.inclination
        drop = self.arm + self.depth * np.sin(start)
        wound = 4.0 * self.arm * (self.depth * np.cos(start) - drop * square)
        wound = wound / (1.0 + square * square)
        free_square = self.length * self.length - square * wound
        # beyond the geometry the length does not exist
        free = np.sqrt(np.where((free_square >= 0.0) & (wound > 0.0), free_square, np.nan))
        return np.where(wound > 0.0, wound, np.nan), free

    def _usable(self, tau: FloatArray) -> np.ndarray:
        pose = self.pose(tau)
        return clear(pose.beta, self.pull_cosine(pose.beta, pose.delta), pose.free / self.length)


class ArcLeverGeometry(LeverGeometry):
    """Sully's lever: the thread is tangent to an arc of radius ρ = AB about the fulcrum.

    Its line is at the distance r u from C and ρ from A, and virtual work gives dβ/dθ:

        r u = ρ (1 − cos δ) − (r + l₀) sin δ,    dβ/dθ = r u/ρ,
        l = (r + l₀) cos δ − ρ sin δ − r,
        β − β₀ = r u²/(2ρ) + δ − sin δ − (r + l₀)(1 − cos δ)/ρ.

    l is the thread from the cam to the arc, which is assumed long enough. There is no dead point.
    Source: Académie, Machines et inventions approuvées, IV, 1735, No. 244, p. 77.
    """

    def pull_cosine(self, beta: FloatArray, delta: FloatArray) -> FloatArray:
        """Return 1."""
        return np.ones_like(beta)

    def u_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return u/τ."""
        per_tau = self._lean_per_tau(tau)
        return -per_tau * self._pulled(per_tau * tau) / self.base_radius

    def pose(self, tau: FloatArray) -> Pose:
        """Return the position of all parts, NaN if the thread is too short."""
        tau = np.asarray(tau, np.float64)
        delta = tau * self._lean_per_tau(tau)
        u = -delta * self._pulled(delta) / self.base_radius
        beta = self.inclination + 2.0 * np.arctan(tau * tau)
        return Pose(u, beta, delta, self._free(delta))

    def slopes(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ = r u/ρ and d²β/dθ² = (r + l) r/(l ρ) [1/rad]."""
        pose, ratio = self.pose(tau), self.base_radius / self.arm
        return ratio * pose.u, ratio * (self.base_radius + pose.free) / pose.free

    def _pulled(self, delta: FloatArray) -> FloatArray:
        """Return −r u/δ [m]."""
        # sin δ/δ and (1 − cos δ)/δ by sinc, which is not 0/0 at rest
        sinc = np.sinc(0.5 / np.pi * delta)
        return np.asarray(
            self.depth * np.sinc(delta / np.pi) - 0.5 * self.arm * delta * sinc * sinc
        )

    def _free(self, delta: FloatArray) -> FloatArray:
        return self.depth * np.cos(delta) - self.arm * np.sin(delta) - self.base_radius

    def _lean_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return δ/τ, NaN if the thread ends before the lever is as high.

        (β − β₀)/τ² = 2 arctan(τ²)/τ² is an increasing function of −δ/τ up to l = 0.
        """
        square = tau * tau
        safe = np.where(square > 0.0, square, 1.0)
        wanted = np.where(square > 0.0, 2.0 * np.arctan(square) / safe, 2.0)

        def excess(lean: FloatArray) -> tuple[FloatArray, FloatArray]:
            delta = -lean * tau
            pulled, sinc = self._pulled(delta), np.sinc(0.5 / np.pi * delta)
            safe_delta = np.where(delta == 0.0, 1.0, delta)
            risen = 0.5 * pulled * pulled / (self.base_radius * self.arm)
            risen += sine_defect(delta) / (safe_delta * safe_delta)
            risen -= 0.5 * self.depth / self.arm * sinc * sinc
            rate = lean * pulled * self._free(delta) / (self.arm * self.base_radius)
            return lean * lean * risen - wanted, rate

        # l = 0 at cos(δ + across) = r/√(ρ² + (r + l₀)²)
        across = np.arctan2(self.arm, self.depth)
        reach = np.arccos(self.base_radius / np.hypot(self.arm, self.depth))
        with np.errstate(divide='ignore', invalid='ignore'):
            end = (reach + np.where(tau > 0.0, across, -across)) / np.abs(tau)
            reached = (tau == 0.0) | (excess(np.where(tau == 0.0, 0.0, end))[0] > 0.0)
            start = np.sqrt(4.0 * self.base_radius * self.arm / (self.depth * self.length))
            root = bracketed_newton(
                excess, np.full(np.shape(tau), start), (0.0, end), relative=1e-15
            )
        return np.where(reached, -root, np.nan)


@dataclass(frozen=True)
class MirroredLever(LeverLinkage):
    """The mirror image of a linkage, with the fulcrum to port.

    Attributes:
        linkage: the linkage with the fulcrum to starboard.
    """

    linkage: LeverLinkage

    side = -1.0

    def __post_init__(self) -> None:
        for name in ('base_radius', 'arm', 'length', 'inclination', 'widening'):
            object.__setattr__(self, name, getattr(self.linkage, name))

    def u_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return t/(r τ) at −τ of the linkage."""
        return self.linkage.u_per_tau(-tau)

    def pose(self, tau: FloatArray) -> Pose:
        """Return the position of all parts."""
        u, beta, delta, free = self.linkage.pose(-tau)
        return Pose(-u, beta, -delta, free)

    def theta(self, tau: FloatArray) -> FloatArray:
        """Return θ [rad]."""
        return -self.linkage.theta(-tau)

    def rates(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dθ/dτ and dβ/dτ."""
        theta, beta = self.linkage.rates(-tau)
        return theta, -beta

    def slopes(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ and d²β/dθ² [1/rad]."""
        ratio, second = self.linkage.slopes(-tau)
        return -ratio, second

    def pull_cosine(self, beta: FloatArray, delta: FloatArray) -> FloatArray:
        """Return the distance of the thread from the fulcrum over AB."""
        return self.linkage.pull_cosine(beta, -delta)

    def lever_arm(self, tau: FloatArray) -> FloatArray:
        """Return t of a cam for a lever [m]."""
        return np.asarray(-cast(Any, self.linkage).lever_arm(-tau))

    def radius_of_curvature(self, tau: FloatArray) -> FloatArray:
        """Return R of its cheek [m]."""
        return np.asarray(cast(Any, self.linkage).radius_of_curvature(-tau))

    def contact(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the point at which the thread leaves it, (x, y) in the wheel's frame [m]."""
        x, y = cast(Any, self.linkage).contact(-tau)
        return -x, y

    def _usable(self, tau: FloatArray) -> np.ndarray:
        return self.linkage._usable(-tau)
