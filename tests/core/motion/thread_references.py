"""Sully's lever and the swinging thread by SciPy's DOP853, written from the Lagrangians.

Scenes and forcing that several tests share stand here too.

Nothing is shared with the engine but the polynomials of the ship's motion. The lever is found by
Newton's method from |B − A| = AB and moves in θ and its momentum; the weight on the thread is a
mass at a place.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tauto_core.motion import Forcing
from tauto_core.ship import ShipMotion
from tauto_core.ship.buffer import MotionBuffer

SEA = {
    'kind': 'components',
    'components': [
        {'amplitude': 0.15, 'period': 8.2, 'phase': 1.0},
        {'amplitude': 0.04, 'period': 6.3, 'phase': -0.5},
    ],
    'heave': [{'amplitude': 0.6, 'period': 10.2, 'phase': 0.7}],
    'height': 2.5,
}
HELD = {
    'drag': {'viscous': 1e-5, 'quadratic': 1e-5},
    'escapement': {'kind': 'impulse', 'energy': 1e-4, 'angle': 0.1},
}


def on_land(count: int, step_s: float, every: int = 1) -> Forcing:
    """Spans of one length, every so many of them logged."""
    return Forcing(
        length_s=np.full(count, step_s),
        begin=np.zeros(count),
        end=np.ones(count),
        end_ns=np.round(np.arange(1, count + 1) * step_s * 1e9).astype(np.int64),
        logged=np.arange(1, count + 1) % every == 0,
    )


def sampled(scene: Any, stride: int = 2) -> Any:
    """The piecewise polynomials of a scene's ship."""
    ship = ShipMotion(scene)
    buffer = MotionBuffer(
        apparent_vertical=True,
        apparent_gravity=True,
        still=False,
        step_ns=scene.step_ns,
        max_gap_s=1.0,
        stride=stride,
    )
    buffer.add(ship.produce(ship.total), scene.starts_at_ns)
    return buffer.forcing(scene.log_interval_ns, scene.duration_ns, final=True)


class Outside:
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

    def start(self, outside: Outside) -> np.ndarray:
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

    def slopes(self, t: float, y: np.ndarray, outside: Outside, signs: Any) -> list[float]:
        machine = self.machine
        _, tilt, turn, gravity = outside(t)
        beta, first, second = self.geometry(float(y[0]))
        rate = self.rate(y, turn)
        pushed = machine.turned_inertia * second * rate * (first * rate + turn)
        pushed -= machine.mass * machine.weight_arm * gravity * math.cos(beta - tilt) * first
        return [rate, pushed - resistance(machine, rate, signs)]

    def angle(self, y: np.ndarray, outside: Outside, t: float) -> tuple[float, float]:
        return float(y[0]), self.rate(y, outside(t)[2])

    def struck(self, y: np.ndarray, outside: Outside, t: float, direction: float) -> np.ndarray:
        rate = self.angle(y, outside, t)[1]
        _, first, _ = self.geometry(float(y[0]))
        mass = self.machine.inertia + self.machine.turned_inertia * first**2
        energy = 2.0 * self.machine.escapement.energy / mass
        return y + np.array([0.0, mass * (direction * math.sqrt(rate * rate + energy) - rate)])


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

    def start(self, outside: Outside) -> np.ndarray:
        vertical, tilt, turn, _ = outside(0.0)
        step = 1e-6
        rate = (outside(step)[0] - outside(0.0)[0]) / step
        if outside.channels is not None:
            x = outside.begin
            rate = float(outside.slopes[0](x)) / outside.length
        angle = self.machine.release_angle + vertical - tilt
        return np.array([angle, vertical, turn, rate])

    def slopes(self, t: float, y: np.ndarray, outside: Outside, signs: Any) -> list[float]:
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

    def angle(self, y: np.ndarray, outside: Outside, t: float) -> tuple[float, float]:
        vertical, tilt, turn, _ = outside(t)
        return float(y[0]) - (vertical - tilt), float(y[2]) - turn

    def struck(self, y: np.ndarray, outside: Outside, t: float, direction: float) -> np.ndarray:
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


def swing(reference: Any, forcing: Any) -> np.ndarray:
    """Return θ and θ̇ at the logged ends, (n, 2); turning points and impulses are stepped to."""
    machine, rows = reference.machine, []
    outside = Outside(forcing, 0, machine.gravity)
    y = reference.start(outside)
    struck = math.copysign(1.0, machine.release_angle)
    direction = -struck
    angle = math.inf if machine.escapement is None else machine.escapement.angle
    armed = direction * machine.release_angle < angle < math.inf
    for k in range(len(forcing.end)):
        outside = Outside(forcing, k, machine.gravity)
        t = 0.0
        while t < outside.seconds:
            events = watched(reference, outside, direction, angle if armed else math.inf)
            found = solve_ivp(
                reference.slopes,
                (t, outside.seconds),
                y,
                'DOP853',
                args=(outside, (direction, struck)),
                events=events,
                rtol=1e-13,
                atol=1e-15,
                max_step=0.05,
            )
            t, y = float(found.t[-1]), found.y[:, -1]
            hit = [i for i, times in enumerate(found.t_events or []) if len(times)]
            if not hit:
                continue
            if hit[0] == 1:
                y, armed = reference.struck(y, outside, t, direction), False
                struck = direction
            else:
                direction = -direction
                armed = direction * reference.angle(y, outside, t)[0] < angle < math.inf
        if forcing.logged[k]:
            rows.append(reference.angle(y, outside, outside.seconds))
    return np.array(rows)


def watched(reference: Any, outside: Outside, direction: float, angle: float) -> list[Any]:
    """Turning points, and the impulse where one is due, as SciPy's events."""
    machine = reference.machine
    abrupt = machine.drag is not None and machine.drag.quadratic > 0.0
    if machine.escapement is None and not abrupt:
        return []

    def turning(t: float, y: np.ndarray, *_: Any) -> float:
        return direction * reference.angle(y, outside, t)[1]

    def impulse(t: float, y: np.ndarray, *_: Any) -> float:
        return angle - direction * reference.angle(y, outside, t)[0]

    found: list[Any] = [turning] if math.isinf(angle) else [turning, impulse]
    for event in found:
        event.terminal, event.direction = True, -1.0
    return found
