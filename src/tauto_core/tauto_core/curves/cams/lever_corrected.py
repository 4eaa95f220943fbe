"""The cam that makes Sully's lever machine isochronous (machine: Euler 1727, V; D in cams.md).

The lever AD turns about A and carries the weight. The thread is tied to it at B and leaves a cam
on the wheel's axle C. At rest the lever is level, and B is below C at the depth D. With
W = m g AD, J = m AD² + J_lever and the lever's angle β: V = W sin β = ½ω²s², and
ds² = I dθ² + J dβ². Along τ = ±√tan(β/2), which has the sign of θ and is smooth through rest,

    dθ/dτ = 2 √(W cos²β − 2Jω² sin β)/(ω √I √(1 + τ⁴)),    dβ/dτ = 4τ/(1 + τ⁴),

which gives θ by one quadrature, and ρ = dβ/dθ. The thread is the line through B at the distance
t = ρ AB cos(β − δ) from C, which gives its inclination δ:

    tan δ = (B − ρ AB (cos β, sin β))_x/(D − AB (1 − ρ) sin β).

With u = θ − δ these lines have the support function t(u) in the wheel's frame, and the cam is
their envelope, p = dt/du. Each side is isochronous by itself. The two differ from the third order
on, since δ has the same sign on both.

On an arc of radius ρ₀ = AB the thread is at the distance t = ρ ρ₀ from C and ρ₀ from A, with
tan ½δ = −ρ ρ₀/(D + √(D² + ρ₀²ρ(2 − ρ))).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from tauto_core.curves.cam import PeriodCam
from tauto_core.curves.lever_geometry import LeverLinkage, LeverSetting, Pose, clear
from tauto_core.curves.numerics import integrate
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import SceneError

# Imaginary part of τ for derivatives without a difference: it may be tiny.
_COMPLEX_STEP = 1e-30


class ThreadLine(NamedTuple):
    """The thread's line and its derivatives by θ, from functions that also take complex τ."""

    ratio: Any  # ρ = dβ/dθ
    bend: Any  # dρ/dθ
    beta: Any
    delta: Any
    turns: Any  # dδ/dθ
    arm: Any  # t
    p: Any
    reach: Any  # distance from the foot of t to B


@dataclass(frozen=True)
class CorrectedLeverGeometry(LeverLinkage):
    """Cam, thread and lever of an isochronous lever machine.

    Attributes:
        frequency: ω of the cam [rad/s], > 0.
        inertia, weight_torque, turned_inertia, arm, length: as in `LeverSetting`.
    """

    inertia: float
    frequency: float
    weight_torque: float
    turned_inertia: float
    arm: float
    length: float
    widening = ', or use a heavier weight or a longer period'

    @property
    def tip_hollow(self) -> float:
        """−R of the hollow cheek at the tip [m], or 0."""
        return 0.0

    @property
    def base_radius(self) -> float:  # type: ignore[override]
        """r = dt/du at rest [m], the base radius of the involute with the same small swings.

        W r (1 + r/l₀)/AB = I ω².
        """
        arm = self.inertia * self.frequency**2 * self.arm / self.weight_torque
        return 2.0 * arm / (1.0 + math.sqrt(1.0 + 4.0 * arm / self.length))

    def u_per_tau(self, tau: FloatArray) -> FloatArray:
        """Return t/(r τ): the angle that an involute of base radius r would wind up, over τ."""
        line = self._line(tau)
        square = tau * tau
        beta_per_tau = 4.0 / (1.0 + square * square)
        arm = self.arm * self.pull_cosine(line.beta, line.delta)
        return np.asarray(beta_per_tau / self._theta_rate(tau) * arm / self.base_radius)

    def pose(self, tau: FloatArray) -> Pose:
        """Return the position of all parts, NaN beyond the cam."""
        tau = np.asarray(tau, np.float64)
        line = self._line(tau)
        return Pose(self.theta(tau) - line.delta, line.beta, line.delta, line.reach - line.p)

    def theta(self, tau: FloatArray) -> FloatArray:
        """Return θ, the wheel's angle [rad], NaN beyond the cam."""
        tau = np.asarray(tau, np.float64)
        flat = tau.ravel()
        fits = np.isfinite(self._theta_rate(flat))
        theta = np.full(flat.shape, np.nan)
        theta[fits] = integrate(self._theta_rate, np.zeros(int(fits.sum())), flat[fits])
        return theta.reshape(tau.shape)

    def rates(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dθ/dτ and dβ/dτ."""
        square = tau * tau
        return self._theta_rate(tau), 4.0 * tau / (1.0 + square * square)

    def slopes(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return dβ/dθ, the ratio of the two lever arms, and d²β/dθ² [1/rad]."""
        line = self._line(tau)
        return line.ratio, line.bend

    def lever_arm(self, tau: FloatArray) -> FloatArray:
        """Return t, the distance of the thread from the axle, with the sign of θ [m]."""
        return np.asarray(self._line(tau).arm)

    def radius_of_curvature(self, tau: FloatArray) -> FloatArray:
        """Return R of the cheek that the thread leaves [m], negative in a hollow.

        R = t + dp/du, on the other cheek its negative. The complex step computes dp to rounding
        (Squire & Trapp, SIAM Review 40, 1998).
        """
        tau = np.asarray(tau, np.float64)
        line = self._line(tau)
        step = self._line(tau + 1j * _COMPLEX_STEP)
        per_tau = np.imag(step.p) / _COMPLEX_STEP
        radius = line.arm + per_tau / (self._theta_rate(tau) * (1.0 - line.turns))
        return np.asarray(np.where(tau < 0.0, -1.0, 1.0) * radius)

    def contact(self, tau: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the point at which the thread leaves the cam, (x, y) in the wheel's frame [m].

        As in `curves.Cam`, +y is along the thread at rest and x < 0 on the cheek for positive
        angles.
        """
        line, u = self._line(tau), self.pose(tau).u
        sine, cosine = np.sin(u), np.cos(u)
        return line.arm * cosine - line.p * sine, line.arm * sine + line.p * cosine

    @staticmethod
    def _angle(tau: Any) -> tuple[Any, Any, Any]:
        """Return τ⁴, sin β and cos β."""
        square = tau * tau
        quartic = square * square
        return quartic, 2.0 * square / (1.0 + quartic), (1.0 - quartic) / (1.0 + quartic)

    def _theta_rate(self, tau: Any) -> Any:
        """Return dθ/dτ, NaN beyond the angle at which the lever takes the whole energy."""
        quartic, sine, cosine = self._angle(tau)
        balance = self.weight_torque * (cosine * cosine)
        balance = balance - 2.0 * self.turned_inertia * self.frequency**2 * sine
        balance = np.where(np.real(balance) > 0.0, balance, np.nan)
        per = self.frequency * math.sqrt(self.inertia)
        return 2.0 / per * np.sqrt(balance / (1.0 + quartic))

    def _raised(self, tau: Any) -> tuple[Any, Any, Any]:
        """Return β, ρ = dβ/dθ and dρ/dθ, for a thread tied or on an arc."""
        quartic, sine, cosine = self._angle(tau)
        beta = 2.0 * np.arctan(tau * tau)
        ratio = 4.0 * tau / (1.0 + quartic) / self._theta_rate(tau)
        torque, stiff = self.weight_torque, self.frequency**2
        balance = torque * (cosine * cosine) - 2.0 * self.turned_inertia * stiff * sine
        bend = self.inertia * stiff * torque * cosine * (1.0 + sine * sine) / (balance * balance)
        return beta, ratio, bend

    @np.errstate(invalid='ignore', divide='ignore')
    def _line(self, tau: Any) -> ThreadLine:
        """Return the thread's line, NaN beyond the cam."""
        quartic, sine, cosine = self._angle(tau)
        beta, ratio, bend = self._raised(tau)
        # B from C, less ρ AB along the lever; 1 − cos β without cancellation
        across = -self.arm * (2.0 * quartic / (1.0 + quartic) + ratio * cosine)
        delta = np.arctan(across / (self.depth - self.arm * (1.0 - ratio) * sine))
        sine_between, cosine_between = np.sin(beta - delta), np.cos(beta - delta)
        b_x = -self.arm * 2.0 * quartic / (1.0 + quartic)
        b_y = self.arm * sine - self.depth
        reach = b_x * np.sin(delta) - b_y * np.cos(delta)
        turns = ratio * (ratio - 1.0) * sine_between - bend * cosine_between
        turns = self.arm * turns / (reach + ratio * self.arm * sine_between)
        arm = ratio * self.arm * cosine_between
        total = bend * cosine_between - ratio * sine_between * (ratio - turns)
        p = self.arm * total / (1.0 - turns)
        return ThreadLine(ratio, bend, beta, delta, turns, arm, p, reach)

    def _usable(self, tau: FloatArray) -> np.ndarray:
        line = self._line(tau)
        pulled = self.pull_cosine(line.beta, line.delta)
        fits = clear(line.beta, pulled, (line.reach - line.p) / self.length)
        return np.asarray(fits & (self.radius_of_curvature(tau) > -self.tip_hollow))


class CorrectedArcLeverGeometry(CorrectedLeverGeometry):
    """Cam, thread and lever with the thread on an arc of the lever.

    A term of the second order in δ makes one cheek hollow next to the tip, with R = −ρ₀r³/D³: for
    Sully's dimensions within a milliradian, by 1e-11 m. The thread bridges it.
    """

    @property
    def tip_hollow(self) -> float:
        """ρ₀r³/D³ and a little more [m]."""
        return 1.01 * self.arm * (self.base_radius / self.depth) ** 3

    def pull_cosine(self, beta: FloatArray, delta: FloatArray) -> FloatArray:
        """Return 1."""
        return np.ones_like(beta)

    @np.errstate(invalid='ignore', divide='ignore')
    def _line(self, tau: Any) -> ThreadLine:
        """Return the thread's line, NaN beyond the cam."""
        beta, ratio, bend = self._raised(tau)
        root = np.sqrt(self.depth**2 + self.arm**2 * ratio * (2.0 - ratio))
        delta = -2.0 * np.arctan(self.arm * ratio / (self.depth + root))
        reach = self.depth * np.cos(delta) - self.arm * np.sin(delta)
        turns = -self.arm * bend / reach
        p = self.arm * bend / (1.0 - turns)
        return ThreadLine(ratio, bend, beta, delta, turns, self.arm * ratio, p, reach)


class LeverCorrectedCam(PeriodCam):
    """The isochronous cam for Sully's lever machine, for one period (D in cams.md)."""

    threads = ('lever',)
    rank = 7

    kind: Literal['lever_corrected'] = 'lever_corrected'

    def on_lever(self, lever: LeverSetting) -> CorrectedLeverGeometry:
        """Return the cam for the wheel, and the lever with its weight.

        Raises:
            SceneError: a lever that is not level at rest, or a pull that is not constant.
        """
        for wrong, key, value, made_for, remedy in (
            (
                lever.inclination != 0.0,
                'trochlea.thread.inclination',
                lever.inclination,
                'a lever that is level at rest',
                'Leave it out, or use cam kind involute.',
            ),
            (
                lever.varies,
                'trochlea.cam.kind',
                self.kind,
                'a weight or a constant force at the end of the lever',
                'Use cam kind involute, or power kind weight or force.',
            ),
        ):
            if wrong:
                raise SceneError(
                    'trochlea',
                    key,
                    value,
                    f'does not go with cam kind {self.kind}, which is made for {made_for}',
                    remedy,
                )
        geometry = CorrectedArcLeverGeometry if lever.on_arc else CorrectedLeverGeometry
        return geometry(
            inertia=lever.inertia,
            frequency=math.tau / self.period,
            weight_torque=lever.weight_torque,
            turned_inertia=lever.turned_inertia,
            arm=lever.arm,
            length=lever.length,
        )


KIND = LeverCorrectedCam
