"""Machines with a thread that may go slack by SciPy's DOP853, from the equations of threads.md.

Wheel and weight always have coordinates of their own, and the tension of a taut thread keeps its
constraint. The engine shares only the polynomials of the ship's motion and, for ideal threads, the
cam.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from thread_references import Inputs, LeverReference

RTOL, ATOL = 1e-13, 1e-15


class Ship(Inputs):  # type: ignore[misc]
    """The ship's motion in one span, with the specific force."""

    def force(self, t: float) -> tuple[float, float]:
        """Specific force to port and up in the case, from g_eff and τ.

        Near weightlessness these belong to a force with z̃ in place of z (threads.md).
        """
        _, tilt, g = self.channels(t)
        slope, z = math.tan(tilt[0]), g * math.cos(tilt[0])

        def upward(z: float) -> float:
            return z if z >= 1.0 else 0.5 * (1.0 + math.exp(2.0 * z - 2.0))

        if z < 1.0:
            n = math.hypot(1.0, slope)
            z = brentq(
                lambda z: (z + upward(z) * slope * slope) / n - g,
                -1e3,
                1.0,
                xtol=1e-15,
                rtol=1e-15,
            )
        return -upward(z) * slope, z

    def falls(self, t: float) -> np.ndarray:
        """Acceleration of a weight that falls, to port and up."""
        line, tilt, _ = self.channels(t)
        (y, z), alpha = self.force(t), line[0] - tilt[0]
        sine, cosine = math.sin(alpha), math.cos(alpha)
        return -np.array([y * cosine - z * sine, y * sine + z * cosine])


class TrueShip(Ship):
    """The force at the clock (ship.1) of the falling ship of test_motion_slack, without z̃."""

    amplitude = 2.5

    def __init__(self, forcing: Any, k: int, gravity: float) -> None:
        super().__init__(forcing, k, gravity)
        self.end_s = 1e-9 * float(forcing.end_ns[k])

    def force(self, t: float) -> tuple[float, float]:
        now = self.end_s - self.seconds + t
        heave, omega = math.tau / 3.1, math.tau / 7.0
        roll, rate = 0.05 * math.cos(omega * now), -0.05 * omega * math.sin(omega * now)
        upward = self.gravity - self.amplitude * heave * heave * math.cos(heave * now + 1.6)
        # f′ of ship.md: in axes that turn with the roll, 3 m above it
        y = upward * math.sin(roll) + 3.0 * omega * omega * roll
        return y, upward * math.cos(roll) - 3.0 * rate * rate


class Reference:
    """A wheel (its angle and ψ̇ come first in the state) and the load of its thread."""

    ship: type[Ship] = Ship

    def __init__(self, machine: Any) -> None:
        self.machine, drag = machine, machine.drag
        self.viscous = drag.viscous / machine.inertia if drag else 0.0
        self.quadratic = drag.quadratic / machine.inertia if drag else 0.0
        escapement = machine.escapement
        self.energy = 2.0 * escapement.energy / machine.inertia if escapement else 0.0
        self.angle = escapement.angle if escapement else math.inf
        self.taut = True
        self.slacks: list[float] = []
        self.lost: list[float] = []
        self.gone_s = 0.0
        self.direction, self.pallet, self.armed, self.given = 1.0, 1.0, False, 0

    def braking(self, rate: float) -> float:
        return rate * (self.viscous + self.quadratic * self.direction * rate)

    def due(self, theta: float) -> bool:
        other = self.direction != self.pallet or self.given == 0
        return self.direction * theta < self.angle < math.inf and other

    def slopes(self, t: float, y: np.ndarray, ship: Ship) -> np.ndarray:
        tension = self.tension(t, y, ship) if self.taut else 0.0
        return self.moved(t, y, ship, tension)

    def run(self, forcing: Any) -> np.ndarray:
        """θ, θ̇ at the logged ends."""
        ship = self.ship(forcing, 0, self.machine.gravity)
        y, rows = self.start(ship), []
        self.pallet = -1.0 if self.machine.release_angle < 0.0 else 1.0
        self.taut = self.tension(0.0, y, ship) > 0.0
        soon = y + 1e-7 * self.slopes(0.0, y, ship)
        self.direction = -1.0 if self.wheel(1e-7, soon, ship)[1] < 0.0 else 1.0
        self.armed = self.due(self.wheel(0.0, y, ship)[0])
        for k in range(len(forcing.length_s)):
            ship, t = self.ship(forcing, k, self.machine.gravity), 0.0
            if self.taut:
                # the momentum is continuous, even if γ̇ of two polynomials differs
                y = self.shared(0.0, y, ship)
            while t < ship.seconds:
                t, y = self.piece(t, y, ship)
            self.gone_s += ship.seconds
            if forcing.logged[k]:
                rows.append(self.wheel(ship.seconds, y, ship))
        return np.array(rows)

    def piece(self, t: float, y: np.ndarray, ship: Ship) -> tuple[float, np.ndarray]:
        """Integrate to the next event or the end of the span, and apply the event."""

        def thread(t: float, y: np.ndarray) -> float:
            return (self.tension if self.taut else self.gap)(t, y, ship) + 1e-14

        def turning(t: float, y: np.ndarray) -> float:
            return self.direction * self.wheel(t, y, ship)[1]

        def impulse(t: float, y: np.ndarray) -> float:
            return self.angle - self.direction * self.wheel(t, y, ship)[0]

        events = [thread, turning] + ([impulse] if self.armed else [])
        for event in events:
            event.terminal, event.direction = True, -1.0
        found = solve_ivp(
            lambda t, y: self.slopes(t, y, ship),
            (t, ship.seconds),
            y,
            method='DOP853',
            rtol=RTOL,
            atol=ATOL,
            events=events,
            max_step=0.02,
        )
        t, y = float(found.t[-1]), found.y[:, -1]
        happened = [i for i, times in enumerate(found.t_events) if len(times)]
        if 0 in happened:
            if not self.taut:
                before = self.kinetic(t, y, ship)
                y = self.shared(t, y, ship)
                self.slacks.append(self.gone_s + t)
                self.lost.append(before - self.kinetic(t, y, ship))
                rate = self.wheel(t, y, ship)[1]
                if self.direction * rate < 0.0:
                    self.direction = -self.direction
                    self.armed = self.due(self.wheel(t, y, ship)[0])
            # the thread may go slack again at once
            self.taut = not self.taut and self.tension(t, y, ship) > 0.0
        elif 1 in happened:
            self.direction = -self.direction
            self.armed = self.due(self.wheel(t, y, ship)[0])
        elif 2 in happened:
            y = self.struck(t, y, ship)
            self.armed, self.pallet, self.given = False, self.direction, self.given + 1
        return t, y

    def struck(self, t: float, y: np.ndarray, ship: Ship) -> np.ndarray:
        """Return the state after an impulse, which a taut thread passes on to its load."""
        rate, (carried, along) = self.wheel(t, y, ship)[1], self.carried(y)
        mass = 1.0 + carried if self.taut else 1.0
        kick = self.direction * math.sqrt(rate * rate + self.energy / mass) - rate
        wheel = np.zeros_like(y)
        wheel[1] = kick
        return y + wheel + kick * along if self.taut else y + wheel


class Ideal(Reference):
    """A vertical thread, or one through a hole: ϑ, ψ̇, η, η̇."""

    def arm(self, q: float) -> tuple[float, float, float]:
        cam = self.machine.cam
        return float(cam.lever_arm(q)), float(cam.lever_rate(q)), float(cam.lift(q))

    def pull(self, height: float, g: float) -> float:
        machine = self.machine
        return g + machine.stiffness * height / machine.carried_mass

    def wheel(self, t: float, y: np.ndarray, ship: Ship) -> tuple[float, float]:
        line, tilt, _ = ship.channels(t)
        return y[0] + tilt[0], y[1] - line[1] + tilt[1]

    def start(self, ship: Ship) -> np.ndarray:
        line, tilt, _ = ship.channels(0.0)
        q, speed = self.machine.release_angle - tilt[0], -tilt[1]
        arm, _, lift = self.arm(q)
        return np.array([q, speed + line[1], lift, arm * speed])

    def tension(self, t: float, y: np.ndarray, ship: Ship) -> float:
        """T/m from d²(η − h)/dt² = 0."""
        line, _, g = ship.channels(t)
        arm, slope, _ = self.arm(y[0])
        speed, mu = y[1] - line[1], self.machine.carried_mass / self.machine.inertia
        free = -self.braking(self.wheel(t, y, ship)[1]) - line[2]
        pulled = self.pull(y[2], g) + slope * speed * speed + arm * free
        return pulled / (1.0 + mu * arm * arm)

    def gap(self, t: float, y: np.ndarray, ship: Ship) -> float:
        return y[2] - self.arm(y[0])[2]

    def moved(self, t: float, y: np.ndarray, ship: Ship, tension: float) -> np.ndarray:
        line, _, g = ship.channels(t)
        mu = self.machine.carried_mass / self.machine.inertia
        bend = -self.braking(self.wheel(t, y, ship)[1]) - mu * self.arm(y[0])[0] * tension
        return np.array([y[1] - line[1], bend, y[3], tension - self.pull(y[2], g)])

    def shared(self, t: float, y: np.ndarray, ship: Ship) -> np.ndarray:
        """(threads.4): ψ̇⁺ = (J ψ̇⁻ + m ρ (v + ρ γ̇))/(J + m ρ²), v⁺ = ρ (ψ̇⁺ − γ̇)."""
        line, _, _ = ship.channels(t)
        inertia, mass = self.machine.inertia, self.machine.carried_mass
        rho, _, lift = self.arm(y[0])
        psi = inertia * y[1] + mass * rho * (y[3] + rho * line[1])
        psi /= inertia + mass * rho * rho
        return np.array([y[0], psi, lift, rho * (psi - line[1])])

    def kinetic(self, t: float, y: np.ndarray, ship: Ship) -> float:
        """Energy of wheel and weight relative to the line, with ϑ̇ as in (threads.4)."""
        speed = y[1] - ship.channels(t)[0][1]
        return float(
            0.5 * self.machine.inertia * speed**2 + 0.5 * self.machine.carried_mass * y[3] ** 2
        )

    def carried(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        """What the thread adds to the wheel's inertia, over it, and how the load moves along."""
        arm = self.arm(y[0])[0]
        mu = self.machine.carried_mass / self.machine.inertia
        return mu * arm * arm, np.array([0.0, 0.0, 0.0, arm])


class Swinging(Reference):
    """A thread that swings: ψ, ψ̇, and position and velocity of the weight from the axle."""

    def lean(self, y: np.ndarray) -> float:
        r, delta = self.machine.base_radius, math.atan2(y[2], -y[3])
        for _ in range(50):
            sine, cosine = math.sin(delta), math.cos(delta)
            wrong = y[2] * cosine + y[3] * sine - r * (y[0] - delta)
            delta += wrong / (y[2] * sine - y[3] * cosine - r)
        return delta

    def wheel(self, t: float, y: np.ndarray, ship: Ship) -> tuple[float, float]:
        line, tilt, _ = ship.channels(t)
        return y[0] - (line[0] - tilt[0]), y[1] - (line[1] - tilt[1])

    def start(self, ship: Ship) -> np.ndarray:
        line, tilt, _ = ship.channels(0.0)
        machine, delta, delta_rate = self.machine, line[0], line[1]
        psi, psi_rate = machine.release_angle + line[0] - tilt[0], line[1] - tilt[1]
        r, u = machine.base_radius, psi - delta
        free = machine.length - 0.5 * r * u * u
        n = np.array([math.cos(delta), math.sin(delta)])
        d = np.array([math.sin(delta), -math.cos(delta)])
        place = r * u * n + (r + free) * d
        velocity = (r * psi_rate + free * delta_rate) * n - r * u * psi_rate * d
        return np.array([psi, psi_rate, *place, *velocity])

    def along(self, y: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, float]:
        delta = self.lean(y)
        n = np.array([math.cos(delta), math.sin(delta)])
        d = np.array([math.sin(delta), -math.cos(delta)])
        return y[0] - delta, n, d, float(y[2:4] @ d) - self.machine.base_radius

    def tension(self, t: float, y: np.ndarray, ship: Ship) -> float:
        """T/m from d/dt (r u ψ̇ + Ẇ·d) = 0."""
        machine, (u, n, d, reach) = self.machine, self.along(y)
        r, mu = machine.base_radius, machine.mass / machine.inertia
        delta_rate = (float(y[4:6] @ n) - r * y[1]) / reach
        down = ship.falls(t)
        free = -self.braking(self.wheel(t, y, ship)[1])
        pulled = float(down @ d) + r * (y[1] - delta_rate) * y[1] + r * u * free
        pulled += float(y[4:6] @ n) * delta_rate
        return pulled / (1.0 + mu * (r * u) ** 2)

    def gap(self, t: float, y: np.ndarray, ship: Ship) -> float:
        u, _, _, reach = self.along(y)
        return self.machine.length - 0.5 * self.machine.base_radius * u * u - reach

    def moved(self, t: float, y: np.ndarray, ship: Ship, tension: float) -> np.ndarray:
        machine, (u, _, d, _) = self.machine, self.along(y)
        mu = machine.mass / machine.inertia
        down = ship.falls(t) - tension * d
        bend = -self.braking(self.wheel(t, y, ship)[1]) - mu * machine.base_radius * u * tension
        return np.array([y[1], bend, y[4], y[5], *down])

    def shared(self, t: float, y: np.ndarray, ship: Ship) -> np.ndarray:
        machine, (u, n, d, _) = self.machine, self.along(y)
        rho, v = machine.base_radius * u, -float(y[4:6] @ d)
        psi = machine.inertia * y[1] + machine.mass * rho * v
        psi /= machine.inertia + machine.mass * rho * rho
        velocity = float(y[4:6] @ n) * n - rho * psi * d
        return np.array([y[0], psi, y[2], y[3], *velocity])

    def kinetic(self, t: float, y: np.ndarray, ship: Ship) -> float:
        wheel = 0.5 * self.machine.inertia * y[1] ** 2
        return float(wheel + 0.5 * self.machine.mass * (y[4] ** 2 + y[5] ** 2))

    def carried(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        machine, (u, _, d, _) = self.machine, self.along(y)
        rho = machine.base_radius * u
        return machine.mass / machine.inertia * rho**2, np.array([0.0] * 4 + [*(-rho * d)])


class Lever(Reference):
    """Sully's lever, its fulcrum to starboard: θ, ψ̇, β in the case, and β̇ + the case's rate."""

    def __init__(self, machine: Any) -> None:
        super().__init__(machine)
        (tail, exits), arm = machine.tail, machine.weight_arm
        about = machine.mass * arm * arm + tail * exits * exits + machine.lever_inertia
        self.j = about / machine.inertia
        self.shape = LeverReference(machine)
        self.weight = (machine.mass * arm - tail * exits) / about

    def held(self, theta: float) -> tuple[float, float, float]:
        """β, dβ/dθ and d²β/dθ², by Newton's method from |B − A| = AB."""
        return self.shape.geometry(theta)

    def wheel(self, t: float, y: np.ndarray, ship: Ship) -> tuple[float, float]:
        line, tilt, _ = ship.channels(t)
        return y[0], y[1] - (line[1] - tilt[1])

    def start(self, ship: Ship) -> np.ndarray:
        line, tilt, _ = ship.channels(0.0)
        turn = line[1] - tilt[1]
        beta, _, _ = self.held(self.machine.release_angle)
        return np.array([self.machine.release_angle, turn, beta, turn])

    def falling(self, t: float, y: np.ndarray, ship: Ship) -> float:
        """β̈ + the case's, without a thread."""
        across, up = ship.force(t)
        return -self.weight * (up * math.cos(y[2]) - across * math.sin(y[2]))

    def tension(self, t: float, y: np.ndarray, ship: Ship) -> float:
        """Torque of the thread on the lever over J, from β̈ = b θ̈ + b′ θ̇²."""
        line, tilt, _ = ship.channels(t)
        _, b, slope = self.held(y[0])
        turn, rate = line[2] - tilt[2], self.wheel(t, y, ship)[1]
        wanted = b * (-self.braking(rate) - turn) + slope * rate * rate
        wanted -= self.falling(t, y, ship) - turn
        return wanted / (1.0 + self.j * b * b)

    def gap(self, t: float, y: np.ndarray, ship: Ship) -> float:
        return y[2] - self.held(y[0])[0]

    def moved(self, t: float, y: np.ndarray, ship: Ship, tension: float) -> np.ndarray:
        line, tilt, _ = ship.channels(t)
        turn, rate = line[1] - tilt[1], self.wheel(t, y, ship)[1]
        bend = -self.braking(rate) - self.j * self.held(y[0])[1] * tension
        falls = self.falling(t, y, ship) + tension
        return np.array([rate, bend, y[3] - turn, falls])

    def shared(self, t: float, y: np.ndarray, ship: Ship) -> np.ndarray:
        line, tilt, _ = ship.channels(t)
        turn, (beta, b, _) = line[1] - tilt[1], self.held(y[0])
        rate = (y[1] - turn + self.j * b * (y[3] - turn)) / (1.0 + self.j * b * b)
        return np.array([y[0], rate + turn, beta, b * rate + turn])

    def kinetic(self, t: float, y: np.ndarray, ship: Ship) -> float:
        line, tilt, _ = ship.channels(t)
        turn = line[1] - tilt[1]
        speeds = (y[1] - turn) ** 2 + self.j * (y[3] - turn) ** 2
        return float(0.5 * self.machine.inertia * speeds)

    def carried(self, y: np.ndarray) -> tuple[float, np.ndarray]:
        b = self.held(y[0])[1]
        return self.j * b * b, np.array([0.0, 0.0, 0.0, b])
