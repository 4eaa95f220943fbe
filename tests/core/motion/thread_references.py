"""Sully's lever and the swinging thread by SciPy's DOP853, written from the Lagrangians.

They share only the polynomials of the ship's motion with the engine. The lever moves in θ and its
momentum, the weight on the thread is a point mass.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.machines import HangingMachine, LeverMachine

HELD = {
    'drag': {'viscous': 1e-5, 'quadratic': 1e-5},
    'escapement': {'kind': 'impulse', 'energy': 1e-4, 'angle': 0.1},
}


def hanging_energy(
    m: HangingMachine, psi: float, delta: float, psi_rate: float, delta_rate: float
) -> float:
    """Kinetic plus potential energy of wheel and swinging thread, 0 at rest in equilibrium [J]."""
    radius, u = m.base_radius, psi - delta
    free = m.length - 0.5 * radius * u * u
    along, across = radius * psi_rate + free * delta_rate, radius * u * psi_rate
    lift = radius * u * math.sin(delta) + 2.0 * (radius + m.length) * math.sin(0.5 * delta) ** 2
    lift += 0.5 * radius * u * u * math.cos(delta)
    kinetic = m.inertia * psi_rate**2 + m.mass * (along**2 + across**2)
    return 0.5 * kinetic + (m.mass * m.gravity + 0.5 * m.stiffness * lift) * lift


class Inputs:
    """The ship's motion in one span."""

    def __init__(self, forcing: Any, k: int, gravity: float) -> None:
        self.forcing, self.k, self.gravity = forcing, k, gravity
        self.begin, self.length = float(forcing.begin[k]), float(forcing.length_s[k])
        self.seconds = (float(forcing.end[k]) - self.begin) * self.length

        def channel(rows: Any) -> list[Any]:
            one = np.polynomial.Polynomial([0.0] if rows is None else rows[k])
            return [one, one.deriv(), one.deriv(2)]

        self.line, self.tilt = channel(forcing.neutral), channel(forcing.tilt)
        self.slopes = (self.line[1],)
        self.pull = None if forcing.gravity is None else channel(forcing.gravity)[0]

    def channels(self, t: float) -> tuple[tuple[float, ...], tuple[float, ...], float]:
        """γ or β, and τ, with two derivatives each, and g_eff."""
        x, per_s = self.begin + t / self.length, 1.0 / self.length
        line = tuple(float(c(x)) * per_s**n for n, c in enumerate(self.line))
        tilt = tuple(float(c(x)) * per_s**n for n, c in enumerate(self.tilt))
        return line, tilt, self.gravity if self.pull is None else float(self.pull(x))

    def __call__(self, t: float) -> tuple[float, float, float, float]:
        """β, τ, the rate of the case and g_eff."""
        line, tilt, gravity = self.channels(t)
        return line[0], tilt[0], line[1] - tilt[1], gravity


class LeverReference:
    """State: θ and its momentum p = M θ̇ + (I + J β′) α̇. β counts in the sense of θ.

    Args:
        machine: the lever.
        side: −1 with the fulcrum to port.
        arc: whether the thread winds on an arc of the lever.
        given: m AD − m′AE and J, if they differ from a lever with a weight only.
        inclination: the lever's angle at rest.
    """

    def __init__(
        self,
        machine: Any,
        side: float = 1.0,
        *,
        arc: bool = False,
        given: tuple[float, float] | None = None,
        inclination: float = 0.0,
    ) -> None:
        self.machine, self.side, self.arc, self.given = machine, side, arc, given
        self.inclination, self.delta = inclination, 0.0

    def masses(self) -> tuple[float, float]:
        """Moment of weight and tail, and J."""
        machine = self.machine
        return self.given or (machine.mass * machine.weight_arm, machine.turned_inertia)

    def geometry(self, theta: float) -> tuple[float, float, float]:
        """β, β′ and β″ of θ."""
        rise, first, second = (self._on_arc if self.arc else self._tied)(self.side * theta)
        return self.side * rise, first, self.side * second

    def _tied(self, angle: float) -> tuple[float, float, float]:
        """By Newton's method from |B − A| = AB."""
        shape, start = self.machine.geometry, self.inclination
        r, arm, length = shape.base_radius, shape.arm, shape.length
        delta = self.delta
        for _ in range(60):
            u = angle - delta
            free = length - 0.5 * r * u * u
            x = arm * math.cos(start) + r * u * math.cos(delta) + (r + free) * math.sin(delta)
            y = arm * math.sin(start) + r + length
            y += r * u * math.sin(delta) - (r + free) * math.cos(delta)
            beta = math.atan2(y, x)
            change = (x * x + y * y - arm * arm) / (2.0 * arm * free * math.cos(beta - delta))
            delta -= change
            if abs(change) < 1e-17 + 1e-16 * abs(delta):
                break
        self.delta, lean = delta, beta - delta
        first = r * u / (arm * math.cos(lean))
        delta_first = -(r + arm * first * math.sin(lean)) / free
        second = r * (1.0 - delta_first) / (arm * math.cos(lean))
        second += first * math.tan(lean) * (first - delta_first)
        return beta, first, second

    def _on_arc(self, angle: float) -> tuple[float, float, float]:
        """β = β₀ + δ + (½ r u² + l − l₀)/ρ by the length of the thread, with dδ/dθ = −r/l."""
        shape = self.machine.geometry
        r, rho, depth = shape.base_radius, shape.arm, shape.base_radius + shape.length
        delta = 0.0
        for _ in range(40):
            # the line at r u from the axle touches the circle about the fulcrum
            wrong = r * (angle - delta) - rho * (1.0 - math.cos(delta)) + depth * math.sin(delta)
            change = wrong / (depth * math.cos(delta) - rho * math.sin(delta) - r)
            delta -= change
            if abs(change) < 1e-17:
                break
        u, free = angle - delta, depth * math.cos(delta) - rho * math.sin(delta) - r
        rise = self.inclination + delta + (0.5 * r * u * u + free - shape.length) / rho
        lean = -r / free
        wind = 1.0 - lean
        slide = -(depth * math.sin(delta) + rho * math.cos(delta))
        first = lean + (r * u * wind + slide * lean) / rho
        bend = r / free**2 * slide * lean
        turn = -(depth * math.cos(delta) - rho * math.sin(delta))
        second = bend + (r * wind * wind - r * u * bend + turn * lean**2 + slide * bend) / rho
        return rise, first, second

    def start(self, outside: Any) -> np.ndarray:
        turn, machine = outside(0.0)[2], self.machine
        first = self.geometry(machine.release_angle)[1]
        return np.array(
            [machine.release_angle, (machine.inertia + self.masses()[1] * first) * turn]
        )

    def rate(self, y: np.ndarray, turn: float) -> float:
        first, inertia = self.geometry(float(y[0]))[1], self.machine.inertia
        turned = self.masses()[1]
        carried = (inertia + turned * first) * turn
        return (float(y[1]) - carried) / (inertia + turned * first * first)

    def slopes(self, t: float, y: np.ndarray, outside: Any, signs: Any) -> list[float]:
        _, tilt, turn, gravity = outside(t)
        beta, first, second = self.geometry(float(y[0]))
        rate, (moment, turned) = self.rate(y, turn), self.masses()
        pushed = turned * second * rate * (first * rate + turn)
        pushed -= self.side * moment * gravity * math.cos(beta - tilt) * first
        return [rate, pushed - resistance(self.machine, rate, signs)]

    def angle(self, y: np.ndarray, outside: Any, t: float) -> tuple[float, float]:
        return float(y[0]), self.rate(y, outside(t)[2])

    def struck(self, y: np.ndarray, outside: Any, t: float, direction: float) -> np.ndarray:
        rate = self.angle(y, outside, t)[1]
        mass = self.machine.inertia + self.masses()[1] * self.geometry(float(y[0]))[1] ** 2
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
        # short of the edges, W sin β = W and J β_s² = 1
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


class HangingReference:
    """State: ψ, δ, ψ̇, δ̇.

    The weight is at x = r u cos δ + (r + l) sin δ, y = r u sin δ − (r + l) cos δ in absolute
    directions. Lagrange's equations, Σ m (ẍ − a)·∂x/∂q = Q, are solved as two linear equations.
    """

    def __init__(self, machine: Any) -> None:
        self.machine = machine

    def start(self, outside: Inputs) -> np.ndarray:
        vertical, tilt, turn, _ = outside(0.0)
        angle = self.machine.release_angle + vertical - tilt
        rate = float(outside.slopes[0](outside.begin)) / outside.length
        return np.array([angle, vertical, turn, rate])

    def growth(self) -> tuple[float, float]:
        """ṙ and İ."""
        return 0.0, 0.0

    def slopes(self, t: float, y: np.ndarray, outside: Any, signs: Any) -> list[float]:
        """By the velocity (r ψ̇ + l δ̇ + ṙ u) n + (r u ψ̇ − ṙ (1 − u²/2)) e, e = (−sin δ, cos δ)."""
        machine = self.machine
        vertical, tilt, turn, gravity = outside(t)
        psi, delta, psi_rate, delta_rate = y.tolist()
        r, m, (widen, inertia_rate) = machine.base_radius, machine.mass, self.growth()
        u, u_rate = psi - delta, psi_rate - delta_rate
        free = machine.length - 0.5 * r * u * u
        free_rate = -r * u * u_rate - 0.5 * widen * u * u
        along_n = r * psi_rate + free * delta_rate + widen * u
        along_e = r * u * psi_rate - widen * (1.0 - 0.5 * u * u)
        # the acceleration without ψ̈ and δ̈, as n turns towards e, and e away from n, with δ̇
        rest_n = widen * psi_rate + free_rate * delta_rate + widen * u_rate - delta_rate * along_e
        rest_e = (widen * u + r * u_rate) * psi_rate + widen * u * u_rate + delta_rate * along_n
        n, e = (
            np.array([math.cos(delta), math.sin(delta)]),
            np.array([-math.sin(delta), math.cos(delta)]),
        )
        # the apparent gravity pulls along (sin β, −cos β)
        down = gravity * np.array([math.sin(vertical), -math.cos(vertical)])
        if machine.stiffness:
            # a spring down along the case, by the height of the weight there above its rest
            case = np.array([math.sin(vertical - tilt), -math.cos(vertical - tilt)])
            place = r * u * n - (r + free) * e
            down += machine.stiffness / m * (r + machine.length - place @ case) * case
        normal, along = np.array([r, free]), np.array([r * u, 0.0])
        mass = m * (np.outer(normal, normal) + np.outer(along, along))
        mass[0, 0] += machine.inertia
        force = m * (normal * (down @ n - rest_n) + along * (down @ e - rest_e))
        force[0] -= resistance(machine, psi_rate - turn, signs) + inertia_rate * psi_rate
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
    """Drag and recoil, by the signs of θ̇ and of the last impulse."""
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


def solve(
    slopes: Any, span: tuple[float, float], y: np.ndarray, events: dict[str, Any], **options: Any
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return times and states of DOP853's steps up to the first event, and its kind or ''.

    Events are functions that are positive before an event and negative after it.
    """
    for event in events.values():
        event.terminal, event.direction = True, -1.0
    found = solve_ivp(
        slopes, span, y, 'DOP853', events=list(events.values()), rtol=1e-13, **options
    )
    assert found.status >= 0, found.message
    hit = [kind for kind, at in zip(events, found.t_events or [], strict=True) if len(at)]
    return found.t, found.y, hit[0] if hit else ''


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
        """Return functions that are positive before an event and negative after it."""
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
        return found

    def _solve(
        self, outside: Any, t: float, end: float, y: np.ndarray, without: str
    ) -> tuple[np.ndarray, np.ndarray, str]:
        """Return times and states of the steps up to the first event, and its kind or ''."""
        events = {kind: event for kind, event in self._events().items() if kind != without}
        args = outside, (self.direction, self.struck)
        return solve(
            self.reference.slopes, (t, end), y, events, atol=1e-15, max_step=0.05, args=args
        )

    def _reach(
        self, outside: Any, times: np.ndarray, states: np.ndarray, kind: str
    ) -> tuple[float, str]:
        """Go to the event in the last step and return its time and kind.

        SciPy interpolates to seventh order there. The last step is taken again, to the event, or
        to an earlier event on the way.
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
        # the pallets alternate. Either gives the first impulse, unless recoil determines which
        first = self.given == 0 and escapement is not None and escapement.recoil == 0.0
        reaches = self.direction * angle < self.at < math.inf
        self.armed = reaches and (first or self.direction != self.struck)
