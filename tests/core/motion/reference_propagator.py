"""The reference propagator: DOP853 of SciPy at a relative tolerance of 1e-13.

It shares only the forcing's polynomials with the compiled engine. Lever arms come from the cam,
and the variables are ϑ and ϑ̇, which need γ̈ (docs/theory/machine_at_sea.md, as printed):

    (I + m t²) ϑ̈ + m t t' ϑ̇² + F t = −I γ̈ − (c₁ θ̇ + d c₂ θ̇² + d c₀ + s R),    θ = ϑ + τ,

d = sgn θ̇ and s, sgn θ̇ at the last impulse, are constant between events. Static friction is an
error. For an unbalanced wheel (machine_at_sea.4) is added.

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, II.5.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from motion_cases import moved, spans_to
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly
from thread_references import Swinging, reference_of, solve

from tauto_core.curves.cams.corrected import WeightCorrected
from tauto_core.machines import AnyMachine, FluidPendulum, HangingMachine, Machine, compile_machine
from tauto_core.motion.forcing import (
    Forcing,
    Motion,
    edge_reached,
    phase_rate,
    released_beyond,
    thread_slack,
    within_turn,
)
from tauto_core.samples import FloatArray, State
from tauto_core.scene import Scene
from tauto_core.scene.errors import PropagationError
from tauto_core.ship.motions import ComponentsShip
from tauto_core.ship.motions.sea import SeaShip, sea_motion

RTOL = 1e-13
ATOL = 1e-15
"""Absolute tolerance over the release angle, or over 1 rad for a release at 0."""

STEPS_A_SWING = 16
"""At least so many, since events are looked for between steps."""

TURNING, KINK, IMPULSE, EDGE, SLACK = 'turning', 'kink', 'impulse', 'edge', 'slack'


class _Instant(NamedTuple):
    felt: float  # ϑ
    felt_rate: float
    felt_bend: float
    angle: float  # θ
    rate: float
    bend: float
    mass: float
    torque: float
    tension: float


@dataclass
class _Now:
    """The running state, with the momentum ϑ̇ M/I + γ̇."""

    felt: float = 0.0
    momentum: float = 0.0
    start_angle: float = 0.0
    direction: float = 1.0
    pallet: float = 1.0
    side: float = 1.0
    armed: bool = False
    turns: int = 0
    beats: int = 0
    given: int = 0


class Reference:
    """Propagator of any machine with one degree of freedom, as good as DOP853 at 1e-13."""

    name = 'reference'

    def __init__(self, machine: Machine) -> None:
        self._machine, self._now = machine, _Now()
        self._latest: tuple[tuple[object, ...], _Instant] | None = None
        self._range_rad = machine.cam.range_rad
        size = abs(machine.release_angle) or 1.0
        self._atol = ATOL * size * np.array([1.0, machine.frequency])

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises:
            PropagationError: a release beyond the cam, or one that friction holds.
        """
        machine = self._machine
        self._forcing, self._k, self._now = forcing, 0, _Now()
        self._now.pallet = -1.0 if machine.release_angle < 0.0 else 1.0
        tilt = self._channel(forcing.tilt, 0.0)
        felt, rate = machine.release_angle - tilt[0], -tilt[1]
        if not abs(felt) <= machine.cam.range_rad:
            raise released_beyond(machine, felt)
        self._set_off(0.0, np.array([felt, rate]), 0.0)
        row = self._row(0.0, np.array([felt, rate]))
        self._now.start_angle = float(within_turn(machine, *np.array(row[2:5])))
        return self._motion([row])

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and return the motion at their logged ends.

        Raises:
            PropagationError: slack thread, edge of the cam, friction that holds the wheel, or a
                step below rounding.
        """
        self._forcing, rows = forcing, []
        lengths = (forcing.end - forcing.begin) * forcing.length_s
        for self._k, length in enumerate(lengths.tolist()):
            row = self._row(length, self._span(length))
            if forcing.logged[self._k]:
                rows.append(row)
        return self._motion(rows)

    def state(self) -> State:
        """Return the running state."""
        return asdict(self._now)

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._now = _Now(**state)

    def _channel(self, rows: FloatArray | None, t: float) -> tuple[float, float, float]:
        """Return a channel and its first two derivatives at t [s] from the span's beginning."""
        if rows is None:
            return 0.0, 0.0, 0.0
        length = float(self._forcing.length_s[self._k])
        x = float(self._forcing.begin[self._k]) + t / length
        value = first = half_second = 0.0
        for c in reversed(rows[self._k].tolist()):
            half_second = half_second * x + first
            first = first * x + value
            value = value * x + c
        return value, first / length, 2.0 * half_second / length**2

    def _lever(self, felt: float) -> tuple[float, float, float]:
        """Return t, t' and h, along the tangent beyond the edge, which only trial steps reach.

        Without a spring h is 0, which saves a third of the time.
        """
        cam = self._machine.cam
        if cam.linear_rate is not None:
            return cam.linear_rate * felt, cam.linear_rate, 0.5 * cam.linear_rate * felt * felt
        inside = min(max(felt, -self._range_rad), self._range_rad)
        exits = felt - inside
        if isinstance(cam, WeightCorrected):
            mean = 2.0 * cam.rate / cam.gyration * inside
            if abs(mean) < 1.2:
                tangent = _tangent(mean)
                steep = cam.rate * (1.0 + tangent * tangent) ** 2
                return cam.gyration * tangent + steep * exits, steep, 0.0
        arm, slope = cam.lever_arm(inside), cam.lever_rate(inside)
        lift = cam.lift(inside) + arm * exits if self._machine.stiffness else 0.0
        return float(arm + slope * exits), float(slope), float(lift)

    def _instant(self, t: float, y: FloatArray, d: float) -> _Instant:
        """Return all of an instant, once for the slopes and every event that ask for the same."""
        asked = t, y.tobytes(), d, self._now.pallet, self._k, id(self._forcing)
        if self._latest is None or self._latest[0] != asked:
            self._latest = asked, self._evaluated(t, y, d)
        return self._latest[1]

    def _warmth(self, t: float) -> tuple[float, float, float, float]:
        """Return T − T₀ [K], Ṫ [K/s], and factors of the pull and of the viscous drag."""
        return 0.0, 0.0, 1.0, 1.0

    def _evaluated(self, t: float, y: FloatArray, d: float) -> _Instant:
        machine, forcing, drag, heat = (
            self._machine,
            self._forcing,
            self._machine.drag,
            self._machine.heat,
        )
        (delta, per_s, kept, thin), line = self._warmth(t), self._channel(forcing.neutral, t)
        tilt, still = self._channel(forcing.tilt, t), forcing.gravity is None
        gravity = machine.gravity if still else self._channel(forcing.gravity, t)[0]
        grown, grown_cam = 1.0 + heat.wheel * delta, 1.0 + heat.cam * delta
        (felt, felt_rate), carried = y.tolist(), machine.carried_mass
        arm, slope, lift = (grown_cam * each for each in self._lever(felt))
        inertia = machine.inertia * grown * grown
        spring = (1.0 + heat.force * delta) * (machine.force + machine.stiffness * lift)
        pull = kept * (spring + machine.pulling_mass * gravity)
        widening = 2.0 * heat.cam * per_s / grown_cam * arm * felt_rate
        ride, rate = carried * (slope * felt_rate * felt_rate + widening), felt_rate + tilt[1]
        against = inertia * line[2] + (pull + ride) * arm
        against += 2.0 * machine.inertia * grown * heat.wheel * per_s * (felt_rate + line[1])
        if drag is not None:
            against += thin * drag.viscous * rate
            against += d * (drag.quadratic * rate * rate + drag.coulomb)
        if machine.escapement is not None:
            against += self._now.pallet * machine.escapement.recoil
        if machine.imbalance is not None:
            moment, direction = machine.imbalance
            against += moment * grown * gravity * math.sin(felt + self._aside(t) + direction)
        mass = inertia + carried * arm * arm
        bend = -against / mass
        tension = pull + ride + carried * arm * bend
        of_case = felt + tilt[0], rate, bend + tilt[2]
        return _Instant(felt, felt_rate, bend, *of_case, mass, -tension * arm, tension)

    def _aside(self, t: float) -> float:
        """Return the neutral line's angle from the apparent vertical, ψ − β at ϑ = 0 [rad]."""
        assert self._machine.follows_apparent_vertical or self._forcing.gravity is None
        return 0.0

    def _events(self, t: float, y: FloatArray) -> dict[str, tuple[float, float]]:
        """Return value (positive before the event, negative after it) and slope of each event."""
        machine, drag, escapement = self._machine, self._machine.drag, self._machine.escapement
        d, side, at = self._now.direction, self._now.side, self._instant(t, y, self._now.direction)
        found = {EDGE: (self._range_rad - abs(at.felt), 0.0)}
        if machine.pulling_mass > 0.0:
            found[SLACK] = at.tension, 0.0
        if machine.cam.kinked and not (self._now.armed and self._struck_at_kink):
            found[KINK] = side * at.felt, side * at.felt_rate
        if escapement is not None or (drag is not None and (drag.quadratic or drag.coulomb)):
            found[TURNING] = d * at.rate, d * at.bend
        if escapement is not None and self._now.armed:
            found[IMPULSE] = escapement.angle - d * at.angle, -d * at.rate
        return found

    @property
    def _struck_at_kink(self) -> bool:
        """Whether an impulse and the passage over the kink are one event: ϑ is θ, and α = 0."""
        machine = self._machine
        struck = machine.escapement is not None and machine.escapement.angle == 0.0
        return machine.cam.kinked and struck and self._forcing.tilt is None

    def _slopes(self, t: float, y: FloatArray) -> FloatArray:
        return np.array([y[1], self._instant(t, y, self._now.direction).felt_bend])

    def _solve(
        self, t: float, end: float, y: FloatArray, without: str
    ) -> tuple[FloatArray, FloatArray, str]:
        """Return times and states of the steps up to the first event, and its kind or ''."""
        kinds = [kind for kind in self._events(t, y) if kind != without]
        events = {
            kind: partial(lambda kind, t, y: self._events(t, y)[kind][0], kind) for kind in kinds
        }
        step_s = self._machine.small_period / STEPS_A_SWING
        return solve(self._slopes, (t, end), y, events, atol=self._atol, max_step=step_s)

    def _span(self, length: float) -> FloatArray:
        """Advance over a span and return ϑ and ϑ̇ at its end."""
        t, y = 0.0, np.array([self._now.felt, 0.0])
        # the momentum is continuous at a jump of γ̇ between two pieces
        y[1] = self._now.momentum - self._channel(self._forcing.neutral, 0.0)[1]
        y[1] *= self._machine.inertia / self._instant(0.0, y, 0.0).mass
        while t < length:
            times, states, kind = self._solve(t, length, y, '')
            t, y = length, states[:, -1]
            if kind:
                t, y, kind = self._reach(kind, times, states)
            self._count(np.append(times[:-1], t), np.column_stack([states[:, :-1], y]))
            y = self._happen(kind, t, y)
        return y

    def _reach(
        self, kind: str, times: FloatArray, states: FloatArray
    ) -> tuple[float, FloatArray, str]:
        """Return time, state and kind of the event in the last step.

        SciPy interpolates there, to seventh order: the last step is taken again, to the event,
        and what else comes before it is found on the way.
        """
        begin, start, earlier = float(times[-2]), states[:, -2], kind
        while earlier:
            kind, t = earlier, float(times[-1])
            times, states, earlier = self._solve(begin, t, start, kind)
        y: FloatArray = states[:, -1]
        value, slope = self._events(t, y)[kind]
        late = -value / slope if slope < 0.0 else 0.0
        middle = y + 0.5 * late * self._slopes(t, y)
        return t + late, y + late * self._slopes(t + 0.5 * late, middle), kind

    def _happen(self, kind: str, t: float, y: FloatArray) -> FloatArray:
        """Change the discrete state and return the state after an event."""
        d, escapement = self._now.direction, self._machine.escapement
        if kind == EDGE:
            raise edge_reached(self._machine, self._time(t))
        if kind == SLACK:
            raise thread_slack(self._time(t))
        if kind == KINK or (kind == IMPULSE and self._struck_at_kink):
            self._now.side = -self._now.side
        if kind == TURNING:
            self._set_off(t, y, -d)
        if kind == IMPULSE and escapement is not None:
            self._now.armed, at = False, self._instant(t, y, d)
            self._now.pallet = d
            ebb = escapement.ebb
            strength = 1.0 if ebb is None else ebb.strength(self._now.given)
            self._now.given += 1
            energy = strength * escapement.energy
            rate = d * math.sqrt(at.rate * at.rate + 2.0 * energy / at.mass)
            struck: FloatArray = y + np.array([0.0, rate - at.rate])
            return struck
        return y

    def _set_off(self, t: float, y: FloatArray, direction: float) -> None:
        """Leave θ̇ = 0 in a direction, or, if friction acts or it is 0, as pushed."""
        free, now = self._instant(t, y, 0.0), self._now
        drag, escapement = self._machine.drag, self._machine.escapement
        if drag is not None and drag.coulomb > 0.0:
            direction, pushed = 0.0, abs(free.bend * free.mass) - drag.coulomb
            if not pushed > 0.0:
                words = 'friction of %.6g N m holds the wheel; use `collocation`, or stop earlier'
                raise PropagationError(words % drag.coulomb, self._time(t))
        now.direction = direction or math.copysign(1.0, free.bend)
        now.side = math.copysign(1.0, free.felt or now.direction)
        # The pallets alternate. Either gives the first impulse, unless recoil decides.
        other = now.direction != now.pallet or (
            now.given == 0 and (escapement is None or escapement.recoil == 0.0)
        )
        reaches = escapement is not None and now.direction * free.angle < escapement.angle
        now.armed = reaches and other

    def _count(self, times: FloatArray, states: FloatArray) -> None:
        """Count upward passages of ϑ and passages of θ through zero over steps between events."""
        at = [
            self._instant(t, y, self._now.direction)
            for t, y in zip(times.tolist(), states.T, strict=True)
        ]
        felt = np.array([(each.felt, each.felt_rate, each.felt_bend) for each in at])
        angle = np.array([(each.angle, each.rate, each.bend) for each in at])
        self._now.turns += _passages(times, felt)[0]
        self._now.beats += sum(_passages(times, angle))

    def _time(self, t: float) -> float:
        """Return the time from the start of the run [s]."""
        forcing, k = self._forcing, self._k
        span = (forcing.end[k] - forcing.begin[k]) * forcing.length_s[k]
        return float(forcing.end_ns[k] * 1e-9 - (span - t))

    def _row(self, t: float, y: FloatArray) -> tuple[float, ...]:
        """Keep the state; return what `_motion` needs of it."""
        at, now = self._instant(t, y, self._now.direction), self._now
        line_rate = self._channel(self._forcing.neutral, t)[1]
        now.felt = at.felt
        now.momentum = at.felt_rate * at.mass / self._machine.inertia + line_rate
        angle, rate, _ = self._channel(self._forcing.tilt, t)
        return at.felt + angle, at.felt_rate + rate, *at[:3], at.torque, now.turns, now.beats

    def _motion(self, rows: list[tuple[float, ...]]) -> Motion:
        angle, rate, felt, felt_rate, bend, torque, turns, beats = np.array(rows).reshape(-1, 8).T
        within = within_turn(self._machine, felt, felt_rate, bend)
        half = (within - self._now.start_angle) / math.pi
        half_turns = (2 * turns + np.floor(half)).astype(np.int64)
        speed = phase_rate(self._machine, felt, felt_rate, bend)
        fraction = half - np.floor(half)
        return Motion(angle, rate, torque, half_turns, fraction, speed, beats.astype(np.int64))


@contextmanager
def by_reference() -> Iterator[None]:
    """Let clocks move by the reference instead of the engine."""
    made = 'tauto_core.clockwork.trochlea.make_propagator'
    with patch(made, lambda machine, **_: Reference(machine)):
        yield


def _tangent(mean: float) -> float:
    """Return tan χ of χ + sin χ cos χ = `mean` = 2rϑ/λ (cams.3), by Newton's method.

    The cam solves this for arrays, which takes ten times as long. Near its edge, π/2, the equation
    is flat, and the cam's solution is taken.
    """
    chi = 0.5 * mean
    for _ in range(30):
        cosine = math.cos(chi)
        step = (chi + math.sin(chi) * cosine - mean) / (2.0 * cosine * cosine)
        chi -= step
        if abs(step) <= 1e-16:
            break
    return math.tan(chi)


class HotReference(Reference):
    """DOP853 of I ψ̈ + İ ψ̇ + t (F + m d²h/dt²) = −drag, with t, I, F and c₁ of the instant."""

    def _warmth(self, t: float) -> tuple[float, float, float, float]:
        felt, forcing, heat = self._forcing.temperatures, self._forcing, self._machine.heat
        assert felt is not None
        row = int(felt.interval[self._k])
        span_s = (forcing.end[self._k] - forcing.begin[self._k]) * forcing.length_s[self._k]
        since_s = float(forcing.end_ns[self._k]) * 1e-9 - float(span_s) + t
        u = (since_s - felt.begin_s[row]) / felt.interval_s
        first, last = felt.celsius[row].tolist()
        delta = first + u * (last - first) - heat.at_celsius
        middle = heat.at_celsius - heat.middle
        lost_s = heat.leaves * ((delta + middle) ** 2 - middle**2) - heat.takes * delta
        thin = -heat.oil.rate * delta / (1.0 + heat.oil.per_kelvin * delta)
        thin = math.exp(thin + heat.thickening * since_s)
        return delta, (last - first) / felt.interval_s, (1.0 + lost_s / 86400.0) ** 2, thin


def _passages(times: FloatArray, values: FloatArray) -> tuple[int, int]:
    """Return how often a value passes zero upwards and downwards.

    Args:
        times: of the ends of steps, (n,).
        values: the value and two derivatives there, (n, 3).
    """
    # a wheel at rest in the middle leaves it, and does not pass it
    first = 1 if values[0, 0] == 0.0 and values[0, 1] == 0.0 else 0
    below, falls = values[first:, 0] < 0.0, values[first:, 1] < 0.0
    up = int(np.count_nonzero(below[:-1] & ~below[1:]))
    down = int(np.count_nonzero(~below[:-1] & below[1:]))
    back = (below[:-1] == below[1:]) & (falls[:-1] != below[:-1]) & (falls[1:] == below[1:])
    for k in (np.flatnonzero(back) + first).tolist():
        # steps are a sixteenth of a swing: the quintic through both ends errs by 1e-7 of it
        between = BPoly.from_derivatives(times[k : k + 2], values[k : k + 2])
        inside = between(np.linspace(times[k], times[k + 1], 257))
        if np.any((inside < 0.0) != (values[k, 0] < 0.0)):
            up, down = up + 1, down + 1
    return up, down


# -----------------------------------------------------------------------------
# The clock's reading at sea by DOP853 on the exact motion of the ship, without sampling.
#
# Roll and heave are sums of cosines with exact derivatives. The reference propagator integrates a
# wheel, the Lagrangians of thread_references.py a lever or a swinging thread, and linear equations
# a suspended case (docs/theory/suspension.md). Only the machine's geometry and the definition of
# the phase (docs/theory/reading.md) are shared with the engine.

STEPS_OF_CASE = 16
"""Least steps in a swing of the case's fast mode. The dense output is of the eighth order."""


class Felt(NamedTuple):
    """The motion of the clock's case: each angle with its first two derivatives."""

    vertical: tuple[float, float, float]
    tilt: tuple[float, float, float]  # tilt of the case
    gravity: float


class ShipAt:
    """The exact motion of a ship of harmonics, at the clock or its case's bearing (ship.md)."""

    def __init__(self, scene: Scene) -> None:
        ship = scene.ship
        if isinstance(ship, ComponentsShip):
            roll = [(c.amplitude, c.period, c.phase) for c in ship.components]
            heave = [(c.amplitude, c.period, c.phase) for c in ship.heave or ()]
        else:
            assert isinstance(ship, SeaShip)
            sea = sea_motion(scene, ship)
            roll, heave = (
                []
                if sum_ is None
                else list(zip(sum_.amplitude, sum_.period, sum_.phase, strict=True))
                for sum_ in (sea.roll, sea.heave)
            )
        self._roll, self._heave = _terms(roll, range(5)), _terms(heave, range(2, 5))
        self._height, self._gravity = ship.height, scene.g

    def force(self, t: float) -> tuple[FloatArray, complex, complex, complex]:
        """Return the roll's derivatives up to the fourth, and ÿ + i(g + z̈) with two of its own."""
        roll = self._roll(t)
        heave = self._heave(t)
        _, first, second, third, fourth = roll.tolist()
        bend = 1j * second - first**2
        bend_1 = 1j * third - 2.0 * first * second
        bend_2 = 1j * fourth - 2.0 * second**2 - 2.0 * first * third
        up = 1j * self._height * cmath.exp(1j * roll[0])
        turn = 1j * first
        return (
            roll,
            up * bend + 1j * (self._gravity + heave[0]),
            up * (turn * bend + bend_1) + 1j * heave[1],
            up * ((turn * turn + 1j * second) * bend + 2.0 * turn * bend_1 + bend_2)
            + 1j * heave[2],
        )

    def __call__(self, t: float) -> Felt:
        """Return the motion of a clock fixed to the ship."""
        roll, force, first, second = self.force(t)
        rate = first / force
        bend = second / force - rate * rate
        return Felt(
            (cmath.phase(force / 1j), rate.imag, bend.imag),
            (float(roll[0]), float(roll[1]), float(roll[2])),
            abs(force),
        )


def _terms(
    harmonics: list[tuple[float, float, float]], orders: range
) -> Callable[[float], FloatArray]:
    """Return a function of t: the sum's derivatives of some orders."""
    a, period, phase = np.array(harmonics).reshape(-1, 3).T
    w = math.tau / period
    factors = np.array([a * w**n for n in orders])
    turned = np.array([math.tau * n / 4.0 for n in orders])[:, None]
    return lambda t: np.asarray(np.sum(factors * np.cos(w * t + phase + turned), axis=1))


class CaseAt:
    """The exact motion felt in a suspended case: linear equations (suspension.md) by DOP853.

    e θ̈ + c φ̈ + g θ = −ÿ, k² φ̈ + g c (φ − θ) = 0. The specific force along θ is the contact force
    over the mass.
    """

    def __init__(self, scene: Scene, end_s: float) -> None:
        assert scene.suspension is not None
        hung = scene.suspension
        if hung.large_angles:
            raise ValueError('only the small angles of a case are known here')
        self._ship, self._gravity = ShipAt(scene), scene.g
        self._e, self._c = hung.link, hung.depth
        self._k2 = hung.gyration_radius**2
        tilt = -self._ship.force(0.0)[1].real / self._gravity
        fast = hung.frequencies(scene.g)[1]
        dense = solve_ivp(
            lambda t, y: self._slopes(t, y)[0],
            (0.0, end_s),
            [tilt, tilt, 0.0, 0.0],
            'DOP853',
            dense_output=True,
            rtol=RTOL,
            atol=1e-16,
            max_step=math.tau / fast / STEPS_OF_CASE,
        ).sol
        assert dense is not None
        self._dense = dense

    def _slopes(self, t: float, y: FloatArray) -> tuple[list[float], complex]:
        theta, phi, theta_rate, phi_rate = y.tolist()
        force = self._ship.force(t)[1]
        phi_bend = -self._gravity * self._c * (phi - theta) / self._k2
        theta_bend = -(force.real + self._gravity * theta + self._c * phi_bend) / self._e
        return [theta_rate, phi_rate, theta_bend, phi_bend], force

    def __call__(self, t: float) -> Felt:
        """Return the motion of a clock in the case."""
        y = self._dense(t)
        (theta_rate, phi_rate, theta_bend, phi_bend), force = self._slopes(t, y)
        theta, phi = float(y[0]), float(y[1])
        pressed = force.imag * math.cos(theta) - force.real * math.sin(theta)
        pressed += self._e * theta_rate**2 + self._c * phi_rate**2 * math.cos(phi - theta)
        contact = pressed / (1.0 + self._c**2 / self._k2 * math.sin(phi - theta) ** 2)
        return Felt((theta, theta_rate, theta_bend), (phi, phi_rate, phi_bend), contact)


def exact_phase(scene: Scene) -> FloatArray:
    """Return the phase since the start at the logged instants after it, within a turn [rad]."""
    machine = compile_machine(scene)
    assert not isinstance(machine, FluidPendulum)
    end_s = scene.duration
    felt = lru_cache(maxsize=4)(
        ShipAt(scene) if scene.suspension is None else CaseAt(scene, end_s)
    )
    times = np.arange(1, scene.log_count) * (scene.log_interval_ns * 1e-9)
    if isinstance(machine, Machine):
        return _of_one_degree(machine, felt, times)
    return _of_thread(machine, felt, times)


class _ExactReference(Reference):
    """DOP853 on the exact motion instead of polynomials."""

    def __init__(self, machine: Machine, felt: Callable[[float], Felt]) -> None:
        super().__init__(machine)
        self._felt = felt

    def _now_felt(self, t: float) -> Felt:
        span = float(self._forcing.length_s[self._k])
        return self._felt(float(self._forcing.end_ns[self._k]) * 1e-9 - span + t)

    def _aside(self, t: float) -> float:
        felt = self._now_felt(t)
        follows = self._machine.follows_apparent_vertical
        return 0.0 if follows else felt.tilt[0] - felt.vertical[0]

    def _channel(self, rows: FloatArray | None, t: float) -> tuple[float, float, float]:
        forcing, felt = self._forcing, self._now_felt(t)
        follows = self._machine.follows_apparent_vertical
        if rows is not None and rows is forcing.gravity:
            return felt.gravity, math.nan, math.nan
        if rows is not None and rows is forcing.neutral:
            return felt.vertical if follows else felt.tilt
        if rows is None or not follows:
            return 0.0, 0.0, 0.0
        vertical, tilt = felt.vertical, felt.tilt
        return vertical[0] - tilt[0], vertical[1] - tilt[1], vertical[2] - tilt[2]


def _of_one_degree(
    machine: Machine, felt: Callable[[float], Felt], times: FloatArray
) -> FloatArray:
    names = ['neutral'] + ['tilt'] * machine.follows_apparent_vertical
    names += ['gravity'] * machine.feels_gravity
    channels: dict[str, Any] = {name: np.zeros((len(times), 1)) for name in names}
    forcing = replace(spans_to(np.round(times * 1e9)), **channels)
    motion = moved(_ExactReference(machine, felt), forcing)
    return math.pi * (motion.half_turns % 2 + motion.fraction)


class _Outside:
    """The functions that the references of threads need, t from the start."""

    channels, begin, length = True, 0.0, 1.0

    def __init__(self, felt: Callable[[float], Felt]) -> None:
        self._felt = felt
        self.slopes = (lambda x: felt(x).vertical[1],)

    def __call__(self, t: float) -> tuple[float, float, float, float]:
        """Return β, β − α, α̇ and g_eff."""
        felt = self._felt(t)
        return felt.vertical[0], felt.vertical[0] - felt.tilt[0], felt.tilt[1], felt.gravity


def _of_thread(
    machine: AnyMachine, felt: Callable[[float], Felt], times: FloatArray
) -> FloatArray:
    reference, outside, begin, rows = reference_of(machine), _Outside(felt), 0.0, []
    moving = Swinging(reference, outside)
    for end in [0.0, *times.tolist()]:
        moving.advance(outside, begin, end)
        begin, y = end, moving.y
        if isinstance(machine, HangingMachine):
            rows.append((y[0] - y[1], y[2] - y[3]))
            continue
        angle, rate = np.array([reference.angle(y, outside, end)]).T
        rows.append(
            (float(machine.arc(angle)[0]), float((np.sqrt(machine.mass_at(angle)) * rate)[0]))
        )
    x, speed = np.array(rows).T
    phase = np.arctan2(0.0 - speed / machine.frequency, x)
    return np.asarray((phase[1:] - phase[0]) % math.tau)
