"""The wheel in a linear well on a moving ship or with viscous drag, by exact steps of `linear`.

Examples are Euler's second cam driven by a force, a spring's own cam, and any linear lever arm t =
t'ϑ under a constant pull F if the case carries the neutral line. With the case's tilt α_c, the
absolute angle ψ = θ + α_c and viscous drag c₁, (machine_at_sea.1) becomes

    ψ̈ + 2δψ̇ + ω₀²ψ = ω₀²α_c + 2δα̇_c,    2δ = c₁/I,    ω₀² = F t'/I,

or ż = (iω − δ) z + ω₀²u + 2δu̇ with u = α_c, z = ψ̇ + δψ + iωψ and ω² = ω₀² − δ² > 0.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from tauto_core.kernels import compiled, entry, inlined
from tauto_core.machines import Machine
from tauto_core.motion.closed_forms import frequency
from tauto_core.motion.events import first_holds
from tauto_core.motion.forcing import (
    PHASE_DIGITS,
    Forcing,
    Motion,
    Polynomials,
    edge_reached,
    no_motion,
    phase_rate,
    released_beyond,
    since_start,
    within_turn,
)
from tauto_core.motion.lanes import SIZE, lane, larger, largest, row_of, splat
from tauto_core.motion.linear import (
    B_IM,
    B_RE,
    STATE,
    U_BEND,
    U_RATE,
    DrivenSpans,
    LinearLaw,
    Oscillator,
    Path,
    SpanShape,
    U,
    into_frame,
    oscillator,
    propagate,
    responses,
    span_product,
    unique_rows,
)
from tauto_core.samples import FloatArray, IntArray, Stateful

# -----------------------------------------------------------------------------
# Passages of the wheel in a linear well: zero upwards (a turn), zero (a beat), the cam's edge.
#
# The angle in the case is θ = Im z/ω − u, its rate θ̇ = Re z − δ Im z/ω − u̇, with u the tilt of
# the case and z of `linear`. On a calm span the swing |z| outweighs tilt and forcing by the bounds
# below. In the phase plane the direction of (θ, −θ̇/ω₀) then stays within 45° of the swing's own,
# (Im z, −Re z), and over any number of calm spans ωt and the directions at both ends give the
# turns. On other spans passages are counted one by one, in short parts. An angle of exactly zero
# counts as positive.

WHEEL_STATE = [
    *STATE,
    *((name, 'f8') for name in ('angle', 'rate', 'bend')),
    *((name, 'i8') for name in ('turns', 'beats')),
]
"""The running state: Y, θ, θ̇, θ̈, and the numbers of turns and of beats."""

BEYOND_SAMPLES = 1.5
"""Smallest bound of u, and of u̇, between samples, over the largest sample.

A motion with at least n samples in its shortest wave exceeds its largest sample by at most the
factor 1/cos(π/n), which is 1.5 for n = 3.7 (for trigonometric polynomials: H. Ehlich, K. Zeller,
Math. Z. 86 (1964) 41). `_rough` checks the samples for that. A bound for all polynomials over
eight samples, h apart, would be useless: 9 max |u| + 14 h max |u̇|.
"""

BEYOND_ROUGH = 4.0
"""Bound of the rise of u above its samples, over the largest deviation from neighbours' cubics.

A wave of n samples rises by 1.4 of that deviation if n = 3.7, by 1.3 if n = 2.5, by 3.7 if n =
2.1.
"""

CALM_FORCING = 0.5
"""Largest |b| on a calm span, as a share of |Y|. It turns Y by 30° at most."""

CALM_TILT = 0.7
"""Largest bound of (u, u̇/ω₀) on a calm span, as a share of the swing: sin 45°, rounded down."""

CALM_DAMPING = 0.1
"""Largest δ/ω₀ of calm spans. With more, a swing may decay within a span."""

CALM_GROWTH = 1.5
"""Bound of the swing within a calm span, as a multiple of the larger swing at its ends."""

ANGLE_ROUNDING = 2.0**-44
"""Rounding of θ, as a share of the tilt and of the swing from the vertical."""

TOUCHING = 1e-300
"""|θ| that stands for a touch of zero.

A wheel that reaches zero and rest together, to rounding, does not pass. It gets the sign of θ̈.
This happens if the roll's period is a multiple of the wheel's and the release is at 0.
"""

BETWEEN = 1e-6
"""Error of θ within a part (`_within`), over |θ̈| at its ends times its length squared.

A smaller excursion beyond zero does not count as a passage.
"""

NEARLY_EDGE = 1.0 - 1e-12
"""Share of the edge above which an amplitude may reach it, to rounding."""

HALF_TURNS_PER_RADIAN = 1.0 / math.pi
EDGE_TRIALS = 64
"""Points of a part at which the first one beyond the edge is sought."""

PART_HALVINGS = 40
"""Halvings of an interval within a part, down to 1e-12 of it."""


class LinearWell(NamedTuple):
    """The well of the wheel.

    Attributes:
        of: the oscillator of z.
        omega0: ω₀ = √(ω² + δ²), the frequency without damping [rad/s].
        edge: largest |θ| on the cam [rad], or infinity.
    """

    of: Oscillator
    omega0: float
    edge: float


class Angle(NamedTuple):
    """The wheel at an instant.

    Attributes:
        angle: θ [rad], ±`TOUCHING` if it touches zero.
        rate: θ̇ [rad/s].
        bend: θ̈ [rad/s2].
        rounding: error bound of θ [rad].
    """

    angle: float
    rate: float
    bend: float
    rounding: float

    def direction(self, omega0: float) -> float:
        """Return the angle of (θ, −θ̇/ω₀) in [−½, 3/2) half turns, as `forcing.polar` does."""
        turns = math.atan2(0.0 - self.rate, omega0 * self.angle) * HALF_TURNS_PER_RADIAN
        return turns + 2.0 if turns < 0.0 and self.angle < 0.0 else turns


@entry
def count_passages(
    well: LinearWell,
    spans: DrivenSpans,
    step_s: float,
    path: Path,
    logged: NDArray[np.bool_],
    wheel: Any,
    counts: IntArray,
) -> tuple[bool, int, float]:
    """Count passages over propagated spans, and update θ, θ̇, θ̈ and the counters.

    `step_s` is the interval between the samples of a window, `wheel` a record of `WHEEL_STATE`.
    `counts` gets turns and beats at the logged ends, and the sign of θ if it touches zero there,
    else 0, (logged, 3). Returns whether the edge is reached, in which span, and at which fraction
    of it.
    """
    y, n, written = path.y, len(logged), 0
    rough = _rough(well.omega0, spans.u, step_s)
    bound = _bound_of_all(well.omega0, spans.u, rough)
    # Over a run of calm spans Y turns by at most 45°, and by 30° more in the last one. The tilt
    # adds 45° at both ends. The sum is below half a turn, hence the count is unique.
    begun, at_begin = 0, Angle(wheel.angle, wheel.rate, wheel.bend, 0.0)
    for k in range(n):
        calm = _is_calm(well, spans, path, k, bound, rough)
        if not calm and begun < k:
            at_end = _at_end(well, path, k - 1)
            _count_run(well, spans, begun, k - 1, at_begin, at_end, wheel)
            begun, at_begin = k, at_end
        along = y[0, begun] * y[0, k + 1] + y[1, begun] * y[1, k + 1]
        is_far = not 2.0 * along * along >= _square(y, begun) * _square(y, k + 1)
        if not calm or is_far or along < 0.0 or logged[k] or k + 1 == n:
            at_end = _at_end(well, path, k)
            if calm:
                _count_run(well, spans, begun, k, at_begin, at_end, wheel)
            else:
                at = _count_in_parts(well, spans, path, k, at_begin, at_end, wheel)
                if at <= 1.0:
                    return True, k, at
            begun, at_begin = k + 1, at_end
        if logged[k]:
            counts[written, 0], counts[written, 1] = wheel.turns, wheel.beats
            touches = abs(at_begin.angle) == TOUCHING
            counts[written, 2] = (-1 if at_begin.angle < 0.0 else 1) if touches else 0
            written += 1
    wheel.angle, wheel.rate, wheel.bend = at_begin.angle, at_begin.rate, at_begin.bend
    return False, 0, 0.0


@compiled
def _square(y: FloatArray, k: int) -> float:
    """Return |Y|² at the beginning of span k."""
    return y[0, k] * y[0, k] + y[1, k] * y[1, k]


@compiled
def _angle_of(
    well: LinearWell,
    y: tuple[float, float],
    frame: tuple[float, float],
    tilt: tuple[float, float, float],
) -> Angle:
    """Return the wheel at an instant. A touch of zero gets the side on which it stays.

    `y` is (Re Y, Im Y), `frame` (cos ωt, sin ωt), and `tilt` (u, u̇, ü).
    """
    of = well.of
    psi = (frame[0] * y[1] + frame[1] * y[0]) / of.omega
    rate = frame[0] * y[0] - frame[1] * y[1] - of.delta * psi - tilt[1]
    angle = psi - tilt[0]
    bend = -tilt[2] - 2.0 * of.delta * rate - well.omega0 * well.omega0 * angle
    rounding = ANGLE_ROUNDING * (math.hypot(y[0], y[1]) / of.omega + abs(tilt[0]))
    if abs(angle) <= rounding and rate * rate <= 2.0 * rounding * abs(bend):
        angle = math.copysign(TOUCHING, bend)
    return Angle(angle, rate, bend, rounding)


@compiled
def _at_end(well: LinearWell, path: Path, k: int) -> Angle:
    """Return the wheel at the end of span k."""
    y, frame, span = path.y, path.frame, path.span
    ends = (y[0, k + 1], y[1, k + 1]), (frame[0, k + 1], frame[1, k + 1])
    return _angle_of(well, ends[0], ends[1], (span[k, U], span[k, U_RATE], span[k, U_BEND]))


@compiled
def _is_calm(
    well: LinearWell, spans: DrivenSpans, path: Path, k: int, bound: float, rough: float
) -> bool:
    """Return whether the swing outweighs tilt and forcing over a span, away from the edge.

    `bound` bounds (u, u̇/ω₀) over all spans that samples determine.
    """
    re, im, square = path.span[k, B_RE], path.span[k, B_IM], _square(path.y, k)
    if well.of.delta > CALM_DAMPING * well.omega0:
        return False
    if not re * re + im * im < CALM_FORCING**2 * square:
        return False
    # this span's own bound costs more, and is needed if another span has a large tilt
    sampled = spans.u is not None and spans.u.sample[k] >= 0
    if sampled and _outweighs(well, square, _square(path.y, k + 1), bound):
        return True
    bound = _bound_of_span(well.omega0, spans, k, rough)
    return _outweighs(well, square, _square(path.y, k + 1), bound)


@inlined
def _outweighs(well: LinearWell, square_begin: float, square_end: float, bound: float) -> bool:
    """Return whether a swing outweighs a tilt, and both together stay off the edge.

    `square_begin` and `square_end` are |Y|² at the ends of a span, `bound` bounds (u, u̇/ω₀).
    """
    squared, room = well.of.omega * well.of.omega, well.edge - bound
    if not bound * bound * squared <= CALM_TILT**2 * min(square_begin, square_end):
        return False
    return room > 0.0 and CALM_GROWTH**2 * max(square_begin, square_end) < room * room * squared


@compiled
def _rough(omega0: float, u: Polynomials | None, step_s: float) -> float:
    """Return a bound of the rise of (u, u̇/ω₀) above its samples.

    Each sample is compared with the cubic through its two neighbours at a distance h. A wave that
    passes between the samples has at most the frequency π/h.
    """
    if u is None:
        return 0.0
    values, rates, roughness = u.values, u.rates, 0.0
    for i in range(1, len(values) - 1):
        # Hermite's cubic at the middle of 2h, and h times its slope
        value = 0.5 * (values[i - 1] + values[i + 1]) + 0.25 * step_s * (
            rates[i - 1] - rates[i + 1]
        )
        slope = 0.75 * (values[i + 1] - values[i - 1]) - 0.25 * step_s * (
            rates[i - 1] + rates[i + 1]
        )
        off = max(abs(values[i] - value), abs(step_s * rates[i] - slope) / math.pi)
        roughness = max(roughness, off)
    return BEYOND_ROUGH * roughness * math.hypot(1.0, math.pi / (step_s * omega0))


@compiled
def _bound_of_all(omega0: float, u: Polynomials | None, rough: float) -> float:
    """Return a bound of |(u, u̇/ω₀)| over all spans that samples determine."""
    if u is None:
        return 0.0
    values, rates = u.values, u.rates
    value, rate, blocks = splat(0.0), splat(0.0), len(values) // SIZE
    for i in range(blocks):
        value, rate = larger(value, row_of(values, i)), larger(rate, row_of(rates, i))
    value_bound, fastest = largest(value), largest(rate)
    for i in range(blocks * SIZE, len(values)):
        value_bound, fastest = max(value_bound, abs(values[i])), max(fastest, abs(rates[i]))
    size = math.hypot(value_bound, fastest / omega0)
    return max(BEYOND_SAMPLES * size, size + rough)


@compiled
def _bound_of_span(omega0: float, spans: DrivenSpans, k: int, rough: float) -> float:
    """Return a bound of |(u, u̇/ω₀)| over a span."""
    if spans.u is None:
        return 0.0
    values, rates, sample, fitted = spans.u
    per_slope, begin = spans.responses.per_slope[spans.shape[k]] / omega0, sample[k]
    if begin < 0:
        value = slope = 0.0
        for j in range(fitted.shape[1]):
            number = abs(fitted[-1 - begin, j])
            value += number
            slope += j * number
        return math.hypot(value, per_slope * slope)
    largest = 0.0
    for i in range(begin, begin + spans.responses.rows.shape[1] // 2):
        value, slope = values[i], per_slope * rates[i]
        largest = max(largest, value * value + slope * slope)
    size = math.sqrt(largest)
    return max(BEYOND_SAMPLES * size, size + rough)


@compiled
def _count_run(
    well: LinearWell,
    spans: DrivenSpans,
    first_span: int,
    last_span: int,
    begin: Angle,
    end: Angle,
    wheel: Any,
) -> None:
    """Count the passages of a run of calm spans.

    (θ, −θ̇/ω₀) turns by ωt to within half a turn, and its directions at both ends give the whole
    turns. It passes θ = 0 upwards only if θ̇ > 0, hence once per turn.
    """
    begin_ns = spans.end_ns[first_span - 1] if first_span > 0 else spans.begin_ns
    turned = well.of.omega * HALF_TURNS_PER_RADIAN * 1e-9 * (spans.end_ns[last_span] - begin_ns)
    ahead = end.direction(well.omega0) - begin.direction(well.omega0)
    turns = round(0.5 * (turned - ahead))
    wheel.turns += turns
    wheel.beats += 2 * turns + (1 if end.angle < 0.0 else 0) - (1 if begin.angle < 0.0 else 0)


@compiled
def _count_in_parts(
    well: LinearWell,
    spans: DrivenSpans,
    path: Path,
    k: int,
    at_begin: Angle,
    at_end: Angle,
    wheel: Any,
) -> float:
    """Count the passages of span k part by part. Return its fraction at the cam's edge, or 2."""
    of, shape, (y, frame, _) = well.of, spans.shape[k], path
    parts, first_part = spans.responses.parts[shape], spans.responses.first_part[shape]
    step = spans.responses.time_s[shape] / parts
    decay, now = math.exp(-of.delta * step), at_begin
    re, im, c, s = y[0, k], y[1, k], frame[0, k], frame[1, k]
    for j in range(parts):
        then = now
        if j + 1 < parts:
            part = span_product(spans, first_part + j, k)
            add = into_frame(c, s, lane(part, B_RE), lane(part, B_IM))
            re, im = decay * (re + add[0]), decay * (im + add[1])
            turned = of.omega * (j + 1) * step
            cosine, sine = math.cos(turned), math.sin(turned)
            c = frame[0, k] * cosine - frame[1, k] * sine
            s = frame[1, k] * cosine + frame[0, k] * sine
            tilt = lane(part, U), lane(part, U_RATE), lane(part, U_BEND)
            now = _angle_of(well, (re, im), (c, s), tilt)
        else:
            now = at_end
        if math.hypot(now.angle, now.rate / well.omega0) > well.edge * NEARLY_EDGE:
            at = first_holds(WatchEdge(well, step, then, now), EDGE_TRIALS)
            if at <= 1.0:
                return (j + at) / parts
        _count_part(well, step, then, now, wheel)
    return 2.0


@compiled
def _count_part(well: LinearWell, step: float, then: Angle, now: Angle, wheel: Any) -> None:
    """Count the passages of θ in a part [s]. Leaving zero from rest does not count."""
    below, below_now = then.angle < 0.0, now.angle < 0.0
    if below != below_now:
        wheel.turns += 1 if below else 0
        wheel.beats += 0 if then.angle == 0.0 and then.rate == 0.0 else 1
        return
    may_return = (then.rate < 0.0) != below and (now.rate < 0.0) == below
    if may_return and _returns(well, step, then, now):
        wheel.turns += 1
        wheel.beats += 2


@compiled
def _returns(well: LinearWell, step: float, then: Angle, now: Angle) -> bool:
    """Return whether θ passes zero and comes back within a part.

    θ has the same sign at both ends. It moves towards zero at the first and away at the second.
    Bisection of the sign of θ̇ finds the turning point.
    """
    a, b, below = 0.0, 1.0, then.angle < 0.0
    unsure = now.rounding + BETWEEN * (abs(then.bend) + abs(now.bend)) * step * step
    for _ in range(PART_HALVINGS):
        middle = 0.5 * (a + b)
        place = _within(well, step, then, now, middle)
        if (place.angle < 0.0) != below and abs(place.angle) > unsure:
            return True
        a, b = (middle, b) if (place.rate < 0.0) != below else (a, middle)
    return False


class WatchEdge(NamedTuple):
    """The condition |θ| > edge within a part."""

    well: LinearWell
    step: float
    then: Angle
    now: Angle

    def holds(self, xi: float) -> bool:
        """Return whether it holds at a fraction of the part."""
        return abs(_within(self.well, self.step, self.then, self.now, xi).angle) > self.well.edge


@compiled
def _within(well: LinearWell, step: float, then: Angle, now: Angle, x: float) -> Angle:
    """Return the wheel at the fraction x of a part.

    θ is a free swing plus the response to the case's acceleration. The response is taken as the
    quintic with the right value and first two derivatives at both ends. Over a part of 0.35 rad
    the error is at most 4e-8 (1 + Ω²/ω₀² + Ω⁴/ω₀⁴) |α̈|/ω₀² for an acceleration α̈ of frequency Ω
    (remainder of Hermite interpolation, (ω₀h)⁶/46080).
    """
    end, free = _free_swing(well, step, then), _free_swing(well, x * step, then)
    begin = _free_swing(well, 0.0, then)
    add, add_rate = now.angle - end.angle, (now.rate - end.rate) * step
    bend_0, bend_1 = ((then.bend - begin.bend) * step * step, (now.bend - end.bend) * step * step)
    # x² (c₂ + c₃ x + c₄ x² + c₅ x³)
    c2 = 0.5 * bend_0
    value, slope, bend = add - c2, add_rate - bend_0, bend_1 - bend_0
    c3 = 10.0 * value - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * value + 7.0 * slope - bend
    c5 = 6.0 * value - 3.0 * slope + 0.5 * bend
    added = x * x * (c2 + x * (c3 + x * (c4 + x * c5)))
    rate = x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5)))
    return Angle(free.angle + added, free.rate + rate / step, free.bend, 0.0)


@compiled
def _free_swing(well: LinearWell, s: float, then: Angle) -> Angle:
    """Return the wheel after s seconds in a uniformly turning case: θ̈ = −2δθ̇ − ω₀²θ."""
    omega, delta, angle, rate = well.of.omega, well.of.delta, then.angle, then.rate
    square = well.omega0 * well.omega0
    cosine, sine, decay = math.cos(omega * s), math.sin(omega * s), math.exp(-delta * s)
    new_angle = decay * (angle * cosine + (rate + delta * angle) / omega * sine)
    turned = decay * (rate * cosine - (delta * rate + square * angle) / omega * sine)
    return Angle(new_angle, turned, -2.0 * delta * turned - square * new_angle, 0.0)


class ForcedHarmonic(Stateful):
    """Propagator of an underdamped linear well whose neutral line moves with the case."""

    name = 'forced_harmonic'
    state_names = ('wheel', 'time_ns', 'start_angle')

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        delta = 0.5 * (machine.drag.viscous if machine.drag else 0.0) / machine.inertia
        with localcontext() as context:
            context.prec = PHASE_DIGITS
            exact = (frequency(machine) ** 2 - Decimal(delta) ** 2).sqrt()
        of, omega0 = oscillator(exact, delta), machine.frequency
        self._well = LinearWell(of, omega0, machine.cam.range_rad)
        self._law = LinearLaw(of.omega, delta, omega0 * omega0, 2.0 * delta)
        self._wheel = np.zeros((), WHEEL_STATE)
        self._time_ns = 0
        self._start_angle = 0.0

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises a PropagationError for a release beyond the cam.
        """
        machine, of = self._machine, self._well.of
        angle = machine.release_angle
        if not abs(angle) <= machine.cam.range_rad:
            raise released_beyond(machine, angle)
        # the window of a run's first piece is one-sided: coefficients determine it
        u = _polynomials(forcing)
        line = Polynomial([0.0] if u is None else u.fitted[0])
        x, per_s = forcing.begin[0], 1.0 / forcing.length_s[0]
        tilt, rate, acceleration = (line.deriv(n)(x) * per_s**n for n in range(3))
        psi = angle + tilt
        self._wheel = np.zeros((), WHEEL_STATE)
        self._wheel['re'], self._wheel['im'] = rate + of.delta * psi, of.omega * psi
        at = self._with_acceleration(*(np.array([value]) for value in (angle, 0.0, acceleration)))
        self._wheel['angle'], self._wheel['bend'], self._time_ns = angle, at[2][0], 0
        self._start_angle = float(within_turn(machine, *at)[0])
        return self._motion(*at, np.zeros((1, 3), np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and return the motion at their logged ends.

        Raises a PropagationError at the edge of the cam.
        """
        of, window, neutral = self._well.of, forcing.window, forcing.neutral
        nodes: tuple[float, ...] = ()
        width, sampled = 0, np.zeros(len(forcing.end), np.bool_)
        # interval between the samples of a window, unused if there is none
        step_s = 1.0
        if window is not None:
            nodes, width, sampled = (window.nodes, 2 * len(window.nodes), window.line.sample >= 0)
            if sampled.any():
                step_s = (nodes[1] - nodes[0]) * float(forcing.length_s[np.argmax(sampled)])
        elif neutral is not None:
            width = neutral.shape[1]
        shape, kinds = unique_rows(forcing.length_s, forcing.begin, forcing.end, sampled)
        shapes = [SpanShape(long, begin, end, bool(by)) for long, begin, end, by in kinds]
        tables = responses(self._law, shapes, nodes, width)
        spans = DrivenSpans(self._time_ns, forcing.end_ns, shape, tables, _polynomials(forcing))
        path = propagate(of, spans, self._wheel)
        counts = np.empty((np.count_nonzero(forcing.logged), 3), np.int64)
        at_edge, k, at = count_passages(
            self._well, spans, step_s, path, forcing.logged, self._wheel, counts
        )
        if at_edge:
            remaining_s = (1.0 - at) * (forcing.end[k] - forcing.begin[k]) * forcing.length_s[k]
            raise edge_reached(self._machine, float(forcing.end_ns[k] * 1e-9 - remaining_s))
        self._time_ns = int(forcing.end_ns[-1])
        if not len(counts):
            return no_motion()
        which = np.flatnonzero(forcing.logged)
        (re, im), ends = path.z(which), path.span[which]
        tilt, tilt_rate, tilt_acceleration = ends[:, U : U_BEND + 1].T
        psi = im / of.omega
        rate = re - of.delta * psi - tilt_rate
        return self._motion(*self._with_acceleration(psi - tilt, rate, tilt_acceleration), counts)

    def _with_acceleration(
        self, angle: FloatArray, rate: FloatArray, tilt_acceleration: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return θ, θ̇ and θ̈ = −α̈_c − 2δθ̇ − ω₀²θ."""
        drag = 2.0 * self._well.of.delta * rate
        return angle, rate, -tilt_acceleration - drag - self._law.per_value * angle

    def _motion(
        self, angle: FloatArray, rate: FloatArray, acceleration: FloatArray, counts: IntArray
    ) -> Motion:
        """Return the motion from θ, θ̇, θ̈ and the counts of `count_passages`."""
        machine, touches = self._machine, counts[:, 2]
        # for a wheel that almost rests in the middle, rounding decides the direction
        counted = np.where(touches == 0, angle, TOUCHING * touches)
        turn_angle = within_turn(machine, counted, np.where(touches == 0, rate, 0.0), acceleration)
        half_turns, fraction = since_start(counts[:, 0], turn_angle, self._start_angle)
        return Motion(
            angle=angle,
            rate=rate,
            torque=-machine.inertia * self._law.per_value * angle,
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=counts[:, 1].copy(),
        )


def _polynomials(forcing: Forcing) -> Polynomials | None:
    """Return α_c over each span, or `None` if it does not move."""
    window, neutral = forcing.window, forcing.neutral
    if window is not None:
        return window.line
    if neutral is None:
        return None
    return Polynomials(np.empty(0), np.empty(0), -1 - np.arange(len(neutral)), neutral)
