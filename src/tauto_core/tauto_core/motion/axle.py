"""A body on an axle, by Gauss–Legendre collocation. The axle slides, rolls, or both in turn.

The state is s, φ, ṡ and φ̇ of `axle_pendulum`. Compiled code iterates a step of 16 stages to
rounding. A step is at most a radian of the fast mode, and is halved if the iteration does not
settle. Its stage polynomials give the motion at any instant within it. Steps end at the ends of
spans, hence splitting spans into calls does not change the result. With limited friction a step
also ends when the axle starts or stops slipping.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial.polynomial import polyval

from tauto_core.curves.numerics import root_of
from tauto_core.kernels import compiled, entry
from tauto_core.machines.axle_pendulum import (
    SMOOTH,
    STILL,
    AxleClock,
    AxleContact,
    AxlePendulum,
    AxleState,
    SupportMotion,
    small_motion,
)
from tauto_core.motion.forcing import Forcing, Motion, no_motion, polar, polar_rate, since_start
from tauto_core.motion.gauss_step import gauss_constants
from tauto_core.samples import FloatArray, State
from tauto_core.scene.errors import PropagationError

# Order 32: over a radian of a small swing the error is below 1e-54 of it.
_STAGES = 16
# Longest step, as a phase of the fast mode [rad].
_LONGEST = 1.0
# A step that does not settle in 60 sweeps is halved.
MOST_SWEEPS, SETTLED = 60, 2e-16
MOST_HALVINGS = 24
# |φ − θ| or |θ − ρ| at which the body counts as turned over [rad].
_TIPPING_ANGLE = 3.0
MOST_EVENTS = 1000
"""Most changes between rolling and sliding in one call of `advance`."""

_GAUSS = gauss_constants(_STAGES)
# a_ij, from values at the nodes to integrals up to them.
_INNER = np.ascontiguousarray(_GAUSS.columns.T)
# The nodes, and the end of a step.
_ENDS = np.append(_GAUSS.nodes, 1.0)
_POWERS = _GAUSS.integral


# -----------------------------------------------------------------------------
# A step in compiled code.

ARC_BEND, TILT_BEND, ARC, TILT, ARC_RATE, TILT_RATE, PRESSED, ALONG = range(8)
"""Rows of a step: s̈, φ̈, s, φ, ṡ, φ̇, N/M and F/M at its nodes."""

TURN, TURN_RATE, TURN_BEND, DOWN, LATERAL = range(5)
"""Rows of the support's motion: ρ, ρ̇, ρ̈, and the acceleration of its axis."""


class AxleLaw(NamedTuple):
    """The body and its contact with the support, as in `AxlePendulum` and `AxleContact`.

    Attributes:
        curvature: 1/e [1/m].
        depth: c [m].
        gyration_radius: k [m].
        gravity: g [m/s2].
        radius: b of the axle [m].
        friction: force along the support over the contact force, signed, of a sliding axle.
        rolls: whether the axle rolls.
    """

    curvature: float
    depth: float
    gyration_radius: float
    gravity: float
    radius: float
    friction: float
    rolls: bool


class AxleForces(NamedTuple):
    """Accelerations of the body and forces on it, floats or arrays of one shape.

    Attributes:
        arc_acceleration: d²s/dt² in the support's frame [m/s2].
        tilt_acceleration: d²φ/dt² [rad/s2].
        contact: contact force over mass, N/M [m/s2]. At 0 the axle lifts off.
        along: force along the support over mass, F/M [m/s2], 0 without friction.
    """

    arc_acceleration: Any
    tilt_acceleration: Any
    contact: Any
    along: Any


@compiled
def pushed(law: AxleLaw, at: Any, support: Any) -> AxleForces:
    """Return contact force and accelerations at any angles (§8–10; C in axle.md, moving support).

    `at` is an `AxleState` and `support` a `SupportMotion`, of floats.

    With δ = φ − θ, D = b − c cos δ, and A, A⊥ the acceleration of the support's point at C, along
    the normal and across it,

        N/M = P + c φ̈ sin δ,   P = g cos θ − A + 2ρ̇ṡ + ṡ²/e + c φ̇² cos δ,
        k² φ̈ = −(N/M) c sin δ + (F/M) D,
        s̈ = −g sin θ − A⊥ + F/M − c φ̈ cos δ + c φ̇² sin δ.

    F = 0 without friction and F = fN if the axle slides. If it rolls, s̈ = −b(φ̈ − ρ̈) gives F.
    """
    sigma = law.curvature * at.arc
    theta, half_angle = support.turn + sigma, 0.5 * sigma
    # the axle's centre in fixed axes, from its place at s = 0. The chord of the arc serves a plane
    # (curvature 0) too
    chord = at.arc * (math.sin(half_angle) / half_angle if half_angle != 0.0 else 1.0)
    x, y = -chord * math.sin(half_angle), chord * math.cos(half_angle)
    sine_rho, cosine_rho = math.sin(support.turn), math.cos(support.turn)
    down, lateral = x * cosine_rho - y * sine_rho, x * sine_rho + y * cosine_rho
    square = support.turn_rate * support.turn_rate
    # the acceleration of that point of the turning support
    a = support.down - support.turn_acceleration * lateral - square * down
    b = support.lateral + support.turn_acceleration * down - square * lateral
    sine_theta, cosine_theta = math.sin(theta), math.cos(theta)
    c, k = law.depth, law.gyration_radius
    sine, cosine = math.sin(at.tilt - theta), math.cos(at.tilt - theta)
    swung = at.tilt_rate * at.tilt_rate
    pressing = law.gravity * cosine_theta - (a * cosine_theta + b * sine_theta)
    pressing = pressing + 2.0 * support.turn_rate * at.arc_rate
    pressing = pressing + law.curvature * at.arc_rate * at.arc_rate + c * cosine * swung
    pull = law.gravity * sine_theta + b * cosine_theta - a * sine_theta
    lever = law.radius - c * cosine
    if law.rolls:
        # no slip, s̈ = −b(φ̈ − ρ̈), and F eliminated from (axle.5)
        spun = c * sine * swung - pull
        inertia = k * k + (c * sine) * (c * sine) + lever * lever
        turned = lever * (law.radius * support.turn_acceleration - spun) - c * sine * pressing
        bend = turned / inertia
        slip = -law.radius * (bend - support.turn_acceleration)
        return AxleForces(slip, bend, pressing + c * sine * bend, slip - spun + c * cosine * bend)
    # sliding: F = ±μN enters φ̈ and, through c φ̈ sin δ, the contact force
    across, rubbing = c * sine / k, law.friction * lever / k
    contact = pressing / (1.0 + across * (across - rubbing))
    bend = contact * (rubbing - across) / k
    rubbed = law.friction * contact
    return AxleForces(c * (sine * swung - cosine * bend) - pull + rubbed, bend, contact, rubbed)


def law_of(body: AxlePendulum, touch: AxleContact) -> AxleLaw:
    """Return the body and its contact as plain numbers."""
    constants = body.curvature, body.depth, body.gyration_radius, body.gravity
    return AxleLaw(*constants, touch.radius, touch.friction, touch.rolls)


def forces(
    body: AxlePendulum,
    state: AxleState,
    support: SupportMotion = STILL,
    touch: AxleContact = SMOOTH,
) -> AxleForces:
    """Return `pushed` for a state and a support that may be arrays."""
    law, numbers = law_of(body, touch), np.broadcast_arrays(*state, *support)
    instants = zip(*(values.ravel().tolist() for values in numbers), strict=True)
    rows = np.array([pushed(law, AxleState(*x[:4]), SupportMotion(*x[4:])) for x in instants])
    return AxleForces(*rows.T.reshape(-1, *numbers[0].shape))


@entry
def collocate_axle(
    law: AxleLaw,
    begin: FloatArray,
    size: float,
    support: FloatArray,
    inner: FloatArray,
    settled: float,
    most_sweeps: int,
    rows: FloatArray,
) -> int:
    """Fill the rows of a step and return the number of sweeps, or 0 if it does not settle.

    The support turns about the point of the axle's centre at s = 0 and ρ = 0.

    Args:
        law: the body and its contact.
        begin: s, φ, ṡ, φ̇ at the beginning, (4,).
        size: length of the step [s].
        support: motion of the support at the nodes, rows TURN to LATERAL, (5, n + 1).
        inner: a_ij, from values at the nodes to integrals up to them, (n, n).
        settled: largest last change, over the largest acceleration, of a settled step.
        most_sweeps: most sweeps.
        rows: rows ARC_BEND to ALONG, (8, n), filled.
    """
    n = inner.shape[0]
    last_change = math.inf
    for sweep in range(1, most_sweeps + 1):
        # avoids 0/0 for a body at rest
        arc_size = tilt_size = 1e-300
        arc_moved = tilt_moved = 0.0
        for i in range(n):
            if sweep == 1:
                rows[ARC_RATE, i], rows[TILT_RATE, i] = begin[2], begin[3]
            else:
                arc = tilt = 0.0
                for j in range(n):
                    arc += inner[i, j] * rows[ARC_BEND, j]
                    tilt += inner[i, j] * rows[TILT_BEND, j]
                rows[ARC_RATE, i] = begin[2] + size * arc
                rows[TILT_RATE, i] = begin[3] + size * tilt
        for i in range(n):
            arc = tilt = 0.0
            for j in range(n):
                arc += inner[i, j] * rows[ARC_RATE, j]
                tilt += inner[i, j] * rows[TILT_RATE, j]
            rows[ARC, i] = begin[0] + size * arc
            rows[TILT, i] = begin[1] + size * tilt
        for i in range(n):
            push = pushed(
                law,
                AxleState(rows[ARC, i], rows[TILT, i], rows[ARC_RATE, i], rows[TILT_RATE, i]),
                SupportMotion(
                    support[TURN, i],
                    support[TURN_RATE, i],
                    support[TURN_BEND, i],
                    support[DOWN, i],
                    support[LATERAL, i],
                ),
            )
            bend, tilt_bend = push.arc_acceleration, push.tilt_acceleration
            if not math.isfinite(bend + tilt_bend):
                return 0
            arc_moved = max(arc_moved, abs(bend - rows[ARC_BEND, i]))
            tilt_moved = max(tilt_moved, abs(tilt_bend - rows[TILT_BEND, i]))
            arc_size, tilt_size = max(arc_size, abs(bend)), max(tilt_size, abs(tilt_bend))
            rows[ARC_BEND, i], rows[TILT_BEND, i] = bend, tilt_bend
            rows[PRESSED, i], rows[ALONG, i] = push.contact, push.along
        change = max(arc_moved / arc_size, tilt_moved / tilt_size)
        # or rounding stops the changes from falling further
        if sweep > 1 and (change <= settled or (change < 1e-13 and change >= last_change)):
            return sweep
        last_change = change
    return 0


# -----------------------------------------------------------------------------
# The motion.


@dataclass
class _Now:
    """State of the body."""

    arc: float
    tilt: float
    arc_rate: float
    tilt_rate: float
    slips: int = 0
    """Sign of the slip of a sliding axle, 0 if it rolls or has no friction."""
    turns: int = 0
    beats: int = 0
    is_up: bool = True
    """Whether φ ≥ 0."""
    is_right: bool = True
    """Whether φ ≥ ρ."""

    @property
    def state(self) -> AxleState:
        return AxleState(self.arc, self.tilt, self.arc_rate, self.tilt_rate)


class AxleStep(NamedTuple):
    """A computed step.

    Attributes:
        rows: ARC_BEND to ALONG at the nodes, (8, stages).
        times: times of the nodes and of the end [s], (stages + 1,).
        support: motion of the support at these times.
        turn: ρ at these times [rad].
    """

    rows: FloatArray
    times: FloatArray
    support: SupportMotion
    turn: FloatArray


Support: TypeAlias = Callable[[Any], SupportMotion]
"""The support's motion at times from the beginning of a span [s], a float or an array."""

Visit: TypeAlias = Callable[[FloatArray, FloatArray, SupportMotion], None]


class AxleMotion:
    """A body on an axle with a support that may move, advanced without `Forcing`.

    Args:
        clock: the machine.
        now: its state, which `advance` changes.
    """

    def __init__(self, clock: AxleClock, now: _Now) -> None:
        self.clock, self.now = clock, now

    def advance(
        self, length_s: float, support: Support, begin_s: float, visit: Visit | None = None
    ) -> None:
        """Move over a length of time. `support` gives its motion at times from `begin_s` on [s].

        After each step `visit` gets the times of its nodes and end [s], the states there, (4, n),
        and the support's motion. Raises a PropagationError if the axle lifts off, the body turns
        over, or the steps become too short.
        """
        at, remaining, events = begin_s, length_s, 0
        longest = _LONGEST / self.clock.fastest
        while remaining > 0.0:
            # a rounding above a whole number of steps adds no step
            size = remaining / max(1, math.ceil(remaining / longest - 1e-9))
            took = self._step(at, size, support, visit)
            events += took < size
            if events > MOST_EVENTS:
                raise PropagationError(
                    'the axle keeps changing between rolling and sliding. Use another '
                    'friction, or contact rolling',
                    at,
                )
            at += took
            remaining = 0.0 if took == remaining else remaining - took

    def law(self, *, rolls: bool = False) -> AxleLaw:
        """Return the body and its present contact, or rolling contact."""
        clock = self.clock
        touch = clock.touch
        if clock.contact == 'coulomb' and self.now.slips and not rolls:
            touch = AxleContact(clock.radius, friction=-self.now.slips * clock.friction)
        return law_of(clock.body, touch)

    def pushed(self, support: SupportMotion, *, rolls: bool = False) -> AxleForces:
        """Return accelerations and forces now, or as if the axle rolled."""
        return pushed(self.law(rolls=rolls), self.now.state, support)

    def _step(self, at: float, size: float, support: Support, visit: Visit | None) -> float:
        """Take a step of at most `size` [s] and return its length."""
        for _ in range(MOST_HALVINGS):
            step = self._collocate(at, size, support)
            if step is not None:
                break
            size *= 0.5
        else:
            raise PropagationError(
                f'no step of the body on its axle settles ({size:.3g} s). Release it nearer to '
                'rest',
                at,
            )
        shorter = self._event(at, size, step, support)
        if shorter is not None:
            # the step again, up to the event
            size = shorter
            retry = self._collocate(at, size, support)
            step = step if retry is None else retry
        self._check(step)
        begin, states = np.array(self.now.state), step.rows[ARC : TILT_RATE + 1]
        rates = begin[2:] + size * (step.rows[:ARC] @ _GAUSS.weights)
        places = begin[:2] + size * (states[2:] @ _GAUSS.weights)
        end = np.concatenate([places, rates])
        if visit is not None:
            visit(step.times, np.column_stack([states, end]), step.support)
        now = self.now
        now.arc, now.tilt, now.arc_rate, now.tilt_rate = end.tolist()
        if shorter is not None:
            self._change(support(at + size))
        return size

    def _collocate(self, at: float, size: float, support: Support) -> AxleStep | None:
        """Return the step, or `None` if its iteration does not settle."""
        times = at + size * _ENDS
        support_motion = support(times)
        motion, rows = np.empty((5, _STAGES + 1)), np.zeros((8, _STAGES))
        for row, values in zip(motion, support_motion, strict=True):
            row[:] = values
        law, begin = self.law(), np.array(self.now.state)
        if not collocate_axle(law, begin, size, motion, _INNER, SETTLED, MOST_SWEEPS, rows):
            return None
        # the last two Legendre coefficients must be rounding: in a step that is even or odd about
        # its middle every second one is zero
        terms = np.abs(rows[:2] @ _GAUSS.projection.T)
        scale = np.maximum(np.max(terms, axis=1), 1e-300)
        if not np.all(terms[:, -2:] <= 1e-10 * scale[:, None]):
            return None
        return AxleStep(rows, times, support_motion, motion[TURN])

    def _check(self, step: AxleStep) -> None:
        """Raise a PropagationError if the axle lifts off, or the body turns over."""
        lifts = np.flatnonzero(~(step.rows[PRESSED] > 0.0))
        if len(lifts):
            raise PropagationError(
                'the axle lifted off its support (the contact force fell to 0 N). Release the '
                'body nearer to rest, push it less, or choose a calmer sea',
                float(step.times[lifts[0]]),
            )
        sigma = self.clock.body.curvature * step.rows[ARC]
        relative_tilt = np.abs(step.rows[TILT] - step.turn[:-1] - sigma)
        tip_nodes = np.flatnonzero(np.maximum(relative_tilt, np.abs(sigma)) > _TIPPING_ANGLE)
        if len(tip_nodes):
            raise PropagationError(
                f'the body turned over (more than {_TIPPING_ANGLE:g} rad from its support). '
                'Release it nearer to rest, or push it less',
                float(step.times[tip_nodes[0]]),
            )

    def _slip(self, arc_rate: float, tilt_rate: float, support: SupportMotion) -> float:
        """Return ṡ + b(φ̇ − ρ̇), the speed at which the axle slides over its support [m/s]."""
        return float(arc_rate + self.clock.radius * (tilt_rate - support.turn_rate))

    def _event(self, at: float, size: float, step: AxleStep, support: Support) -> float | None:
        """Return the length after which the axle starts or stops slipping, or `None`."""
        if self.clock.contact != 'coulomb':
            return None
        slips, mu, law = self.now.slips, self.clock.friction, self.law()

        def margin(share: float) -> float:
            """Return a margin that is positive while the contact stays as it is."""
            powers = (2.0 * share - 1.0) ** np.arange(_STAGES)
            gained = share * size * ((step.rows[:ARC] @ _POWERS.T) @ powers)
            shift = share * size * ((step.rows[ARC_RATE : TILT_RATE + 1] @ _POWERS.T) @ powers)
            state = np.array(self.now.state) + np.concatenate([shift, gained])
            support_motion = support(at + size * share)
            if slips:
                return slips * self._slip(state[2], state[3], support_motion)
            push = pushed(law, AxleState(*state), support_motion)
            return float(mu * push.contact - abs(push.along))

        if slips:
            turning = np.broadcast_to(step.support.turn_rate, step.times.shape)[:-1]
            rates = step.rows[ARC_RATE] + self.clock.radius * (step.rows[TILT_RATE] - turning)
            margins = slips * rates
        else:
            margins = mu * step.rows[PRESSED] - np.abs(step.rows[ALONG])
        share_before = 0.0
        for share, value in zip(_ENDS.tolist(), [*margins.tolist(), margin(1.0)], strict=True):
            if value < 0.0:
                # just after a change the margin is 0: evaluate it a little later
                low = share_before if share_before > 0.0 else 1e-9
                if margin(low) <= 0.0:
                    return size * low
                return size * root_of(margin, low, share, 1e-15)
            share_before = share
        return None

    def _change(self, support: SupportMotion) -> None:
        """Change the contact: a sliding axle rolls or reverses, a rolling one slides."""
        now, rolling = self.now, self.pushed(support, rolls=True)
        slid = now.slips != 0
        if slid:
            # remove the slip, since its rounding would start a new one
            now.arc_rate -= self._slip(now.arc_rate, now.tilt_rate, support)
        if slid and self._holds(rolling):
            now.slips = 0
        else:
            # the axle slides against the force that rolling would need
            now.slips = -1 if rolling.along > 0.0 else 1

    def _holds(self, rolling: AxleForces) -> bool:
        """Return whether friction can supply the force that rolling needs."""
        return bool(abs(rolling.along) <= self.clock.friction * rolling.contact)

    def settle(self, support: SupportMotion) -> None:
        """Choose rolling or sliding at the start, by slip and friction."""
        if self.clock.contact != 'coulomb':
            return
        slip = self._slip(self.now.arc_rate, self.now.tilt_rate, support)
        # a slip of a picometre per second is rounding of a rolling contact
        if abs(slip) > 1e-12:
            self.now.slips = 1 if slip > 0.0 else -1
            return
        self.now.slips = 0
        if not self._holds(self.pushed(support)):
            self._change(support)


# -----------------------------------------------------------------------------
# The motion on a support at rest, at given instants.


@dataclass(frozen=True, eq=False)
class AxleTable:
    """Motion of a body on an axle at n instants, on a support at rest, all (n,).

    Attributes:
        time_s: time since the start [s].
        theta_rad: θ, tilt of the normal at the contact, s/e [rad], 0 on a plane.
        phi_rad: φ, tilt of the body [rad].
        arc_m: s of the axle's centre [m].
        contact: contact force over the weight, N/Mg.
        slip_m_s: speed at which the axle slides over its support [m/s].
        small_phi_rad: φ by the equations of small angles (§29), smooth or rolling [rad].
        ends_s: time at which the axle lifts off or the body turns over [s], or `None`.
        ends_why: the reason, as a sentence, or ''.
    """

    time_s: FloatArray
    theta_rad: FloatArray
    phi_rad: FloatArray
    arc_m: FloatArray
    contact: FloatArray
    slip_m_s: FloatArray
    small_phi_rad: FloatArray
    ends_s: float | None
    ends_why: str


def axle_table(clock: AxleClock, duration_s: float, every_s: float) -> AxleTable:
    """Return the motion at equal intervals up to a duration, or until it ends."""
    now = _Now(clock.arc, clock.tilt, clock.arc_rate, clock.tilt_rate)
    motion = AxleMotion(clock, now)
    motion.settle(STILL)
    rows: list[tuple[float, ...]] = []
    ends_s, why = None, ''
    # rounding must not drop the last row of a whole number of intervals
    count = math.floor(duration_s / every_s * (1.0 + 1e-12))
    for k in range(count + 1):
        slip = now.arc_rate + clock.radius * now.tilt_rate
        pressed = motion.pushed(STILL).contact / clock.body.gravity
        rows.append((k * every_s, now.tilt, now.arc, pressed, slip))
        if k == count:
            break
        try:
            motion.advance(every_s, lambda _: STILL, k * every_s)
        except PropagationError as error:
            ends_s, why = error.time_s, error.what
            break
    time, tilt, arc, contact, slips = np.array(rows).T
    return AxleTable(
        time,
        clock.body.curvature * arc,
        tilt,
        arc,
        contact,
        slips,
        _small_tilt(clock, time),
        ends_s,
        why,
    )


def _small_tilt(clock: AxleClock, time: FloatArray) -> FloatArray:
    """Return φ by the equations of small angles."""
    if clock.contact == 'smooth':
        start = AxleState(clock.arc, clock.tilt, clock.arc_rate, clock.tilt_rate)
        return np.asarray(small_motion(clock.body, start, time).tilt)
    length = clock.lengths[0]
    omega = math.sqrt(abs(clock.body.gravity / length))
    if length > 0.0:
        return clock.tilt * np.cos(omega * time) + clock.tilt_rate / omega * np.sin(omega * time)
    return clock.tilt * np.cosh(omega * time) + clock.tilt_rate / omega * np.sinh(omega * time)


# -----------------------------------------------------------------------------
# The propagator, on land and at sea. The support moves with the ship. The clock's place is the
# axle's centre at rest. The forcing's β and g_eff are the apparent gravity there, and its tilt τ
# gives the roll, ρ = β − τ.


class AxleSwings:
    """Propagator of a body on an axle."""

    name = 'axle'

    def __init__(self, clock: AxleClock) -> None:
        self._clock = clock
        self._now: _Now | None = None
        self._start = 0.0

    def release(self, forcing: Forcing) -> Motion:
        """Release the body at the beginning of the first span and return that instant."""
        clock, support = self._clock, _support(forcing, 0, self._clock.body.gravity)
        at_start = support(float(forcing.begin[0] * forcing.length_s[0]))
        tilt, rate = float(at_start.turn) + clock.tilt, float(at_start.turn_rate) + clock.tilt_rate
        self._now = _Now(clock.arc, tilt, clock.arc_rate, rate)
        # a start at 0 counts as on the side that it comes from, hence not as a passage
        self._now.is_up = tilt > 0.0 or (tilt == 0.0 and rate >= 0.0)
        self._now.is_right = clock.tilt > 0.0 or (clock.tilt == 0.0 and clock.tilt_rate >= 0.0)
        AxleMotion(clock, self._now).settle(at_start)
        row = self._logged(at_start)
        angle, speed, bend = np.array(row[:3])[:, None]
        self._start = float(polar(angle, speed, bend, clock.frequency)[0])
        return self._motion([row])

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and return the motion at the logged ends."""
        assert self._now is not None
        body, rows = AxleMotion(self._clock, self._now), []
        for k in range(len(forcing.length_s)):
            support = _support(forcing, k, self._clock.body.gravity)
            length_s = float(forcing.length_s[k])
            begin, end = (length_s * float(cut[k]) for cut in (forcing.begin, forcing.end))
            try:
                body.advance(end - begin, support, begin, self._count)
            except PropagationError as error:
                late = float(forcing.end_ns[k]) * 1e-9 - end
                raise PropagationError(error.what, late + error.time_s) from None
            if forcing.logged[k]:
                rows.append(self._logged(support(end)))
        return self._motion(rows) if rows else no_motion()

    def _count(self, times: FloatArray, states: FloatArray, support: SupportMotion) -> None:
        """Count turns (upward passages of φ = 0) and beats (passages of φ = ρ)."""
        del times
        now = self._now
        assert now is not None
        up = np.concatenate([[now.is_up], states[1] >= 0.0])
        right = np.concatenate([[now.is_right], states[1] >= support.turn])
        now.turns += int(np.count_nonzero(up[1:] & ~up[:-1]))
        now.beats += int(np.count_nonzero(right[1:] != right[:-1]))
        now.is_up, now.is_right = bool(up[-1]), bool(right[-1])

    def state(self) -> State:
        """Return everything that later motion depends on."""
        return {'start': self._start, 'now': None if self._now is None else asdict(self._now)}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._start = state['start']
        self._now = None if state['now'] is None else _Now(**state['now'])

    def _logged(self, support: SupportMotion) -> tuple[float, ...]:
        """Return the row of an instant."""
        now = self._now
        assert now is not None
        bend = AxleMotion(self._clock, now).pushed(support).tilt_acceleration
        rho, turning = float(support.turn), float(support.turn_rate)
        return (now.tilt, now.tilt_rate, bend, rho, turning, float(now.turns), float(now.beats))

    def _motion(self, rows: list[tuple[float, ...]]) -> Motion:
        tilt, rate, bend, rho, turning, turns, beats = np.array(rows).T
        clock, omega = self._clock, self._clock.frequency
        angle = polar(tilt, rate, bend, omega)
        half_turns, fraction = since_start(turns.astype(np.int64), angle, self._start)
        return Motion(
            angle=tilt - rho,
            rate=rate - turning,
            torque=clock.mass * clock.body.gyration_radius**2 * bend,
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=polar_rate(tilt, rate, bend, omega),
            beats=beats.astype(np.int64),
        )


def _support(forcing: Forcing, k: int, gravity: float) -> Support:
    """Return the motion of the support over a span's piece, at times from its beginning."""
    neutral, gravities, tilt = forcing.neutral, forcing.gravity, forcing.tilt
    if neutral is None or gravities is None:
        return lambda _: STILL
    length_s = float(forcing.length_s[k])
    # at least ρ̈ has a coefficient
    size = max(3, neutral.shape[1], 0 if tilt is None else tilt.shape[1])
    roll = np.zeros(size)
    roll[: neutral.shape[1]] = neutral[k]
    if tilt is not None:
        roll[: tilt.shape[1]] -= tilt[k]
    powers = np.arange(size)
    rate = (roll * powers)[1:] / length_s
    bend = (rate * powers[: size - 1])[1:] / length_s

    def support(times: Any) -> SupportMotion:
        x = times / length_s
        beta, pull = polyval(x, neutral[k]), polyval(x, gravities[k])
        return SupportMotion(
            turn=polyval(x, roll),
            turn_rate=polyval(x, rate),
            turn_acceleration=polyval(x, bend),
            down=gravity - pull * np.cos(beta),
            lateral=-pull * np.sin(beta),
        )

    return support
