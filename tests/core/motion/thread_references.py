"""Sully's lever and the swinging thread by SciPy's DOP853, written from the Lagrangians.

Nothing is shared with the engine but the polynomials of the ship's motion. The lever is found by
Newton's method from |B − A| = AB and moves in θ and its momentum; the weight on the thread is a
mass at a place.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.machines import LeverMachine

HELD = {
    'drag': {'viscous': 1e-5, 'quadratic': 1e-5},
    'escapement': {'kind': 'impulse', 'energy': 1e-4, 'angle': 0.1},
}


class Inputs:
    """The ship's motion in one span."""

    def __init__(self, forcing: Any, k: int, gravity: float) -> None:
        self.forcing, self.k = forcing, k
        self.length = float(forcing.length_s[k])
        self.begin, self.end = float(forcing.begin[k]), float(forcing.end[k])
        self.channels = None
        self.gravity = gravity
        if forcing.neutral is not None:
            self.channels = [
                np.polynomial.Polynomial(c[k])
                for c in (forcing.neutral, forcing.tilt, forcing.gravity)
            ]
            self.slopes = [c.deriv() for c in self.channels]

    @property
    def seconds(self) -> float:
        return (self.end - self.begin) * self.length

    def __call__(self, t: float) -> tuple[float, float, float, float]:
        """β, τ, the rate of the case and g_eff."""
        if self.channels is None:
            return 0.0, 0.0, 0.0, self.gravity
        x = self.begin + t / self.length
        vertical, tilt, gravity = (float(c(x)) for c in self.channels)
        turn = float(self.slopes[0](x) - self.slopes[1](x)) / self.length
        return vertical, tilt, turn, gravity


class LeverReference:
    """State: θ and its momentum p = M θ̇ + (I + J β′) α̇."""

    def __init__(self, machine: Any) -> None:
        self.machine = machine
        self.delta = 0.0

    def geometry(self, theta: float) -> tuple[float, float, float]:
        """β, β′ and β″ of θ."""
        shape = self.machine.geometry
        r, arm, length = shape.base_radius, shape.arm, shape.length
        delta = self.delta
        for _ in range(40):
            u = theta - delta
            free = length - 0.5 * r * u * u
            x = arm + r * u * math.cos(delta) + (r + free) * math.sin(delta)
            y = r + length + r * u * math.sin(delta) - (r + free) * math.cos(delta)
            beta = math.atan2(y, x)
            change = (x * x + y * y - arm * arm) / (2.0 * arm * free * math.cos(beta - delta))
            delta -= change
            if abs(change) < 1e-17 + 1e-16 * abs(delta):
                break
        self.delta = delta
        lean = beta - delta
        first = r * u / (arm * math.cos(lean))
        delta_first = -(r + arm * first * math.sin(lean)) / free
        second = r * (1.0 - delta_first) / (arm * math.cos(lean))
        second += first * math.tan(lean) * (first - delta_first)
        return beta, first, second

    def start(self, outside: Inputs) -> np.ndarray:
        _, _, turn, _ = outside(0.0)
        machine = self.machine
        _, first, _ = self.geometry(machine.release_angle)
        carried = machine.inertia + machine.turned_inertia * first
        return np.array([machine.release_angle, carried * turn])

    def rate(self, y: np.ndarray, turn: float) -> float:
        machine = self.machine
        _, first, _ = self.geometry(float(y[0]))
        inertia, turned = machine.inertia, machine.turned_inertia
        carried = (inertia + turned * first) * turn
        return (float(y[1]) - carried) / (inertia + turned * first * first)

    def slopes(self, t: float, y: np.ndarray, outside: Inputs, signs: Any) -> list[float]:
        machine = self.machine
        _, tilt, turn, gravity = outside(t)
        beta, first, second = self.geometry(float(y[0]))
        rate = self.rate(y, turn)
        pushed = machine.turned_inertia * second * rate * (first * rate + turn)
        pushed -= machine.mass * machine.weight_arm * gravity * math.cos(beta - tilt) * first
        return [rate, pushed - resistance(machine, rate, signs)]

    def angle(self, y: np.ndarray, outside: Inputs, t: float) -> tuple[float, float]:
        return float(y[0]), self.rate(y, outside(t)[2])

    def struck(self, y: np.ndarray, outside: Inputs, t: float, direction: float) -> np.ndarray:
        rate = self.angle(y, outside, t)[1]
        _, first, _ = self.geometry(float(y[0]))
        mass = self.machine.inertia + self.machine.turned_inertia * first**2
        energy = 2.0 * self.machine.escapement.energy / mass
        return y + np.array([0.0, mass * (direction * math.sqrt(rate * rate + energy) - rate)])


class OwnCamReference(LeverReference):
    """The same with the cam that makes the lever isochronous (docs/theory/cams.md).

    Along s = ∫√(I dθ² + J dβ²), W sin β = ½ ω²s². So β(s) is known, I θ_s² = 1 − J β_s², and θ(s)
    is the integral of a series.
    """

    def __init__(self, machine: Any) -> None:
        super().__init__(machine)
        self.torque, self.turned = machine.weight_torque, machine.turned_inertia
        self.stiff, self.s, end = machine.geometry.frequency**2, 0.0, 0.0
        # short of the edges, where W sin β = W and J β_s² = 1
        while self.stiff * end**2 < 1.6 * self.torque and self.wheel(end) ** 2 > 0.2:
            end += 1e-3 * math.sqrt(self.torque / self.stiff)
        series = np.polynomial.Chebyshev.interpolate(
            lambda s: np.array([self.wheel(each) for each in s]), 100, [-end, end]
        )
        self.theta = series.integ(lbnd=0.0) / math.sqrt(machine.inertia)

    def lever(self, s: float) -> tuple[float, float, float]:
        """β, β_s and β_ss of s."""
        sine = 0.5 * self.stiff * s * s / self.torque
        cosine = math.sqrt((1.0 - sine) * (1.0 + sine))
        per = self.stiff / (self.torque * cosine)
        return math.asin(sine), per * s, per + (per * s) ** 2 * sine / cosine

    def wheel(self, s: float) -> float:
        """√I θ_s of s."""
        return math.sqrt(1.0 - self.turned * self.lever(s)[1] ** 2)

    def geometry(self, theta: float) -> tuple[float, float, float]:
        s, root = self.s, math.sqrt(self.machine.inertia)
        for _ in range(40):
            wheel = self.wheel(s) / root
            change = (float(self.theta(s)) - theta) / wheel
            s -= change
            if abs(change) <= 4e-16 * abs(s) + 1e-18:
                break
        self.s = s
        beta, first, second = self.lever(s)
        bend = -self.turned * first * second / (root * self.wheel(s))
        wheel = self.wheel(s) / root
        return beta, first / wheel, (second * wheel - first * bend) / wheel**3


class SignedReference(LeverReference):
    """State: θ and its momentum; the lever's angle counts in the sense of θ, on either side."""

    def __init__(self, machine: Any, side: float, *, arc: bool, moment: float, turned: float):
        super().__init__(machine)
        self.side, self.arc, self.moment, self.turned = side, arc, moment, turned

    def geometry(self, theta: float) -> tuple[float, float, float]:
        if not self.arc:
            rise, first, second = super().geometry(self.side * theta)
            return self.side * rise, first, self.side * second
        shape = self.machine.geometry
        r, rho, depth = shape.base_radius, shape.arm, shape.base_radius + shape.length
        angle, delta = self.side * theta, 0.0
        for _ in range(40):
            # the line at r u from the axle touches the circle about the fulcrum
            wrong = r * (angle - delta) - rho * (1.0 - math.cos(delta)) + depth * math.sin(delta)
            change = wrong / (depth * math.cos(delta) - rho * math.sin(delta) - r)
            delta -= change
            if abs(change) < 1e-17:
                break
        u, free = angle - delta, depth * math.cos(delta) - rho * math.sin(delta) - r
        rise = delta + (0.5 * r * u * u + free - shape.length) / rho
        # β = δ + (½ r u² + l − l₀)/ρ by the length of the thread, with dδ/dθ = −r/l
        lean = -r / free
        wind = 1.0 - lean
        slide = -(depth * math.sin(delta) + rho * math.cos(delta))
        first = lean + (r * u * wind + slide * lean) / rho
        bend = r / free**2 * slide * lean
        turn = -(depth * math.cos(delta) - rho * math.sin(delta))
        second = bend + (r * wind * wind - r * u * bend + turn * lean**2 + slide * bend) / rho
        return self.side * rise, first, self.side * second

    def start(self, outside: Any) -> np.ndarray:
        turn, machine = outside(0.0)[2], self.machine
        first = self.geometry(machine.release_angle)[1]
        return np.array([machine.release_angle, (machine.inertia + self.turned * first) * turn])

    def rate(self, y: np.ndarray, turn: float) -> float:
        first, inertia = self.geometry(float(y[0]))[1], self.machine.inertia
        return (float(y[1]) - (inertia + self.turned * first) * turn) / (
            inertia + self.turned * first * first
        )

    def slopes(self, t: float, y: np.ndarray, outside: Any, signs: Any) -> list[float]:
        _, tilt, turn, gravity = outside(t)
        beta, first, second = self.geometry(float(y[0]))
        rate = self.rate(y, turn)
        pushed = self.turned * second * rate * (first * rate + turn)
        pushed -= self.side * self.moment * gravity * math.cos(beta - tilt) * first
        direction, _ = signs
        drag = self.machine.drag
        if drag is not None:
            pushed -= drag.viscous * rate + direction * drag.quadratic * rate * rate
        return [rate, pushed]

    def struck(self, y: np.ndarray, outside: Any, t: float, direction: float) -> np.ndarray:
        rate = self.angle(y, outside, t)[1]
        mass = self.machine.inertia + self.turned * self.geometry(float(y[0]))[1] ** 2
        energy = 2.0 * self.machine.escapement.energy / mass
        return y + np.array([0.0, mass * (direction * math.sqrt(rate * rate + energy) - rate)])


class HangingReference:
    """State: ψ, δ, ψ̇, δ̇.

    The weight is at x = r u cos δ + (r + l) sin δ, y = r u sin δ − (r + l) cos δ in absolute
    directions, its acceleration against the apparent gravity; both equations are Lagrange's,
    Σ m (ẍ − a)·∂x/∂q = Q, solved as two linear equations.
    """

    def __init__(self, machine: Any) -> None:
        self.machine = machine

    def start(self, outside: Inputs) -> np.ndarray:
        vertical, tilt, turn, _ = outside(0.0)
        step = 1e-6
        rate = (outside(step)[0] - outside(0.0)[0]) / step
        if outside.channels is not None:
            x = outside.begin
            rate = float(outside.slopes[0](x)) / outside.length
        angle = self.machine.release_angle + vertical - tilt
        return np.array([angle, vertical, turn, rate])

    def slopes(self, t: float, y: np.ndarray, outside: Inputs, signs: Any) -> list[float]:
        machine = self.machine
        vertical, _, turn, gravity = outside(t)
        psi, delta, psi_rate, delta_rate = y.tolist()
        r, m = machine.base_radius, machine.mass
        u = psi - delta
        free = machine.length - 0.5 * r * u * u
        # velocity along n = (cos δ, sin δ): r ψ̇ + l δ̇; along (−sin δ, cos δ): r u ψ̇
        normal, along = (r, free), (r * u, 0.0)
        u_rate = psi_rate - delta_rate
        free_rate = -r * u * u_rate
        # what of the acceleration is not in ψ̈, δ̈; the two directions turn with δ̇
        rest_normal = free_rate * delta_rate - r * u * psi_rate * delta_rate
        rest_along = r * u_rate * psi_rate + (r * psi_rate + free * delta_rate) * delta_rate
        # the apparent gravity pulls along (sin β, −cos β)
        down = math.sin(vertical) * gravity, -math.cos(vertical) * gravity
        if machine.stiffness:
            # a spring down along the case, by the height of the weight there above its rest
            case = math.sin(vertical - outside(t)[1]), -math.cos(vertical - outside(t)[1])
            x = r * u * math.cos(delta) + (r + free) * math.sin(delta)
            z = r * u * math.sin(delta) - (r + free) * math.cos(delta)
            drawn = machine.stiffness / m * (r + machine.length - x * case[0] - z * case[1])
            down = down[0] + drawn * case[0], down[1] + drawn * case[1]
        pull_normal = down[0] * math.cos(delta) + down[1] * math.sin(delta)
        pull_along = -down[0] * math.sin(delta) + down[1] * math.cos(delta)
        mass = np.array(
            [[m * (normal[i] * normal[j] + along[i] * along[j]) for j in (0, 1)] for i in (0, 1)]
        )
        mass[0, 0] += machine.inertia
        force = [
            m * normal[i] * (pull_normal - rest_normal) + m * along[i] * (pull_along - rest_along)
            for i in (0, 1)
        ]
        force[0] -= resistance(machine, psi_rate - turn, signs)
        # Rayleigh's function ½ c (δ̇ − α̇)² has no part along ψ
        force[1] -= machine.damping * (delta_rate - turn)
        bends = np.linalg.solve(mass, force)
        return [psi_rate, delta_rate, float(bends[0]), float(bends[1])]

    def angle(self, y: np.ndarray, outside: Inputs, t: float) -> tuple[float, float]:
        vertical, tilt, turn, _ = outside(t)
        return float(y[0]) - (vertical - tilt), float(y[2]) - turn

    def struck(self, y: np.ndarray, outside: Inputs, t: float, direction: float) -> np.ndarray:
        machine, rate = self.machine, self.angle(y, outside, t)[1]
        r, u = machine.base_radius, float(y[0] - y[1])
        mass = machine.inertia + machine.mass * (r * u) ** 2
        kick = direction * math.sqrt(rate**2 + 2.0 * machine.escapement.energy / mass) - rate
        return y + np.array([0.0, 0.0, kick, -r * kick / (machine.length - 0.5 * r * u * u)])


def resistance(machine: Any, rate: float, signs: tuple[float, float]) -> float:
    """Drag and recoil; the signs of θ̇ and of the last impulse."""
    direction, struck = signs
    against = 0.0
    if machine.drag is not None:
        against += machine.drag.viscous * rate + direction * machine.drag.quadratic * rate * rate
    if machine.escapement is not None and machine.escapement.rest is not None:
        against += machine.escapement.rest.recoil * struck
    return against


def reference_of(machine: Any) -> Any:
    """The reference of a lever, with the involute or its own cam, or of a swinging thread."""
    if not isinstance(machine, LeverMachine):
        return HangingReference(machine)
    own = isinstance(machine.geometry, CorrectedLeverGeometry)
    return OwnCamReference(machine) if own else LeverReference(machine)


def swing(reference: Any, forcing: Any) -> np.ndarray:
    """Return θ and θ̇ at the logged ends, (n, 2)."""
    rows = []
    outside = Inputs(forcing, 0, reference.machine.gravity)
    moving = Swinging(reference, outside)
    for k in range(len(forcing.end)):
        outside = Inputs(forcing, k, reference.machine.gravity)
        moving.advance(outside, 0.0, outside.seconds)
        if forcing.logged[k]:
            rows.append(reference.angle(moving.y, outside, outside.seconds))
    return np.array(rows)


class Swinging:
    """The state of a reference, which is stepped from event to event: turning points, impulses."""

    def __init__(self, reference: Any, outside: Any) -> None:
        machine = reference.machine
        self.reference, self.y = reference, reference.start(outside)
        self.struck = math.copysign(1.0, machine.release_angle)
        self.direction = -self.struck
        self.at = math.inf if machine.escapement is None else machine.escapement.angle
        self.given = 0
        self._arm(machine.release_angle)

    def advance(self, outside: Any, t: float, end: float) -> None:
        """Advance from t to `end`, times of `outside` [s]."""
        while t < end:
            times, states, hit = self._solve(outside, t, end, self.y, '')
            t, self.y = float(times[-1]), states[:, -1]
            if hit:
                t, hit = self._reach(outside, times, states, hit)
                self._happen(outside, t, hit)

    def _events(self) -> dict[str, Any]:
        """Return what is positive before an event and negative after it."""
        machine, reference, direction = self.reference.machine, self.reference, self.direction
        found: dict[str, Any] = {}
        if machine.escapement is not None or (machine.drag and machine.drag.quadratic > 0.0):
            found['turning'] = lambda t, y, outside, _: (
                direction * reference.angle(y, outside, t)[1]
            )
        if self.armed:
            found['impulse'] = lambda t, y, outside, _: (
                self.at - direction * reference.angle(y, outside, t)[0]
            )
        for event in found.values():
            event.terminal, event.direction = True, -1.0
        return found

    def _solve(
        self, outside: Any, t: float, end: float, y: np.ndarray, without: str
    ) -> tuple[np.ndarray, np.ndarray, str]:
        """Return times and states of the steps up to the first event, and its kind or ''."""
        events = {kind: event for kind, event in self._events().items() if kind != without}
        found = solve_ivp(
            self.reference.slopes,
            (t, end),
            y,
            'DOP853',
            args=(outside, (self.direction, self.struck)),
            events=list(events.values()),
            rtol=1e-13,
            atol=1e-15,
            max_step=0.05,
        )
        hit = [k for k, at in zip(events, found.t_events or [], strict=False) if len(at)]
        return found.t, found.y, hit[0] if hit else ''

    def _reach(
        self, outside: Any, times: np.ndarray, states: np.ndarray, kind: str
    ) -> tuple[float, str]:
        """Go to the event in the last step; return its time and kind.

        SciPy interpolates there, to seventh order: the last step is taken again, to the event,
        and what else comes before it is found on the way.
        """
        begin, start, earlier = float(times[-2]), states[:, -2], kind
        while earlier:
            kind, t = earlier, float(times[-1])
            times, states, earlier = self._solve(outside, begin, t, start, kind)
        self.y = states[:, -1]
        if kind == 'impulse':
            angle, rate = self.reference.angle(self.y, outside, t)
            late = (self.direction * self.at - angle) / rate
            signs = self.direction, self.struck
            middle = self.y + 0.5 * late * np.array(
                self.reference.slopes(t, self.y, outside, signs)
            )
            self.y = self.y + late * np.array(
                self.reference.slopes(t + 0.5 * late, middle, outside, signs)
            )
            t += late
        return t, kind

    def _happen(self, outside: Any, t: float, kind: str) -> None:
        if kind == 'impulse':
            self.y = self.reference.struck(self.y, outside, t, self.direction)
            self.armed, self.struck, self.given = False, self.direction, self.given + 1
            return
        self.direction = -self.direction
        self._arm(self.reference.angle(self.y, outside, t)[0])

    def _arm(self, angle: float) -> None:
        """Expect an impulse in a swing that begins at `angle` if it comes to that."""
        escapement = self.reference.machine.escapement
        # the pallets alternate; the first impulse is given by either, unless recoil tells which
        first = self.given == 0 and escapement is not None and escapement.recoil == 0.0
        reaches = self.direction * angle < self.at < math.inf
        self.armed = reaches and (first or self.direction != self.struck)
