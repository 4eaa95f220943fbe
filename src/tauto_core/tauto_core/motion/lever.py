"""Sully's lever machine in one rotating plane, with the arc for its coordinate."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from tauto_core.curves.numerics import chebyshev_coefficients, chebyshev_nodes, complete_series
from tauto_core.kernels import compiled, inlined
from tauto_core.machines import LeverMachine
from tauto_core.motion.gauss_step import Mode, Omega, Work, rows_of_eight, sine_versine
from tauto_core.motion.lanes import (
    Lanes,
    Numeric,
    filled,
    fma,
    lane,
    largest,
    lowest,
    row_of,
    splat,
    store,
)
from tauto_core.motion.stepping import CLEAR
from tauto_core.motion.system import (
    APPARENT_GRAVITY,
    DRIVE_BEND,
    DRIVE_RATE,
    TILT,
    TILT_BEND,
    TILT_RATE,
    Exits,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    Plane,
    RunningState,
    StepPlace,
    column_at,
    difference,
    fill_hot,
    heated_at_nodes,
    heated_now,
    keep,
    nodes_of,
)
from tauto_core.motion.threads import (
    OnWheel,
    ThreadSystem,
    case_bounds,
    drag_on_wheel,
    exits_by,
    thermal_on_wheel,
    transverse,
    transverse_at_nodes,
)
from tauto_core.motion.wells import REACH_PER_RELEASE
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError

if TYPE_CHECKING:
    from tauto_core.motion.free_step import FreeHalfSwing

# -----------------------------------------------------------------------------
# Sully's lever machine along its arc: the functions that steps need, as Chebyshev series.
#
# θ is the angle of the wheel, β the angle of the lever (β_l in machine_at_sea.3), I and J their
# moments of inertia, M = I + J (dβ/dθ)². Along the arc s = ∫√(M/I) dθ the inertia is one. With j =
# J/I the pair n = dθ/ds, w = √j dβ/ds is a unit vector (cos χ, sin χ). Steps need n, w, χ' =
# dχ/ds, cos β, sin β and θ. Functions of θ are singular at a dead point. Functions of s are smooth
# there and beyond.

ARC_FUNCTIONS = 0, 1, 2, 3, 4, 5
"""Columns: n, w, χ', cos β, sin β, θ. A force law F multiplies cos β by F(H)/F(0)."""

AT_NODES = 0, 1, 2, 3, 4
"""Columns that the nodes of a step need: all except θ."""

FEWEST_SHAPE_TERMS, MOST_SHAPE_TERMS = 16, 128
"""Fewest and most terms of the functions of s."""

MOST_TERMS_OF_ARC = 1024
"""Most terms of s as a function of τ, which is evaluated only to make the series."""

SHAPE_TAIL = 2.0**-48
"""A series is complete if its last four coefficients are below this share of the largest."""

TAIL_OF_LAW = 2.0**-40
"""The same for a force through points: the joints of its spline keep the tail above rounding."""

MOST_GROWN = 64.0
"""Largest sum of a power series' coefficients over the largest Chebyshev coefficient.

This bounds the rounding that cancellation amplifies.
"""

# Most Newton iterations for τ(s). A few suffice.
_NEWTON = 60


class Series(NamedTuple):
    """The six functions of s on an interval, as Chebyshev series.

    Attributes:
        middle: middle of the interval.
        half_width: half its length.
        per_half: 1/half_width.
        terms: coefficients of T_k(x), x = (s − middle)/half_width, one row per k with six
            functions and two zeros, (n, 8).
    """

    middle: float
    half_width: float
    per_half: float
    terms: FloatArray


class Powers(Series):
    """The functions of `Series` as sums of terms · x^k, at half the operations."""


class ArcSeries(NamedTuple):
    """The functions on two intervals.

    Attributes:
        near_rest: about rest, over the usual range of motion or less.
        full: over the whole geometry, or over the usual range (`wells.REACH_PER_RELEASE`) if the
            geometry needs too many terms.
    """

    near_rest: Series | Powers
    full: Series


def arc_series(
    machine: LeverMachine, allowed: float = 0.0, per_release: float = REACH_PER_RELEASE
) -> ArcSeries:
    """Return the series of a machine.

    Args:
        machine: the machine.
        allowed: error relative to the largest coefficient. Below rounding it has no effect.
        per_release: reach of `near_rest` over the release angle, plus 0.1 rad.

    Raises a PropagationError if the inertia changes too abruptly for `MOST_SHAPE_TERMS` or
    `MOST_TERMS_OF_ARC`.
    """
    low, high = machine.edges
    root = math.sqrt(machine.inertia)
    arc_slope = _complete(
        lambda tau: machine.arc_slope(tau)[None] / root, low, high, MOST_TERMS_OF_ARC
    )
    if arc_slope is None:
        raise PropagationError(
            f'the arc of the lever takes more than {MOST_TERMS_OF_ARC} Chebyshev coefficients. '
            'Use a heavier wheel or a lighter weight',
            0.0,
        )
    # s(τ), 0 at rest, τ the parameter of the geometry
    arc = chebyshev.Chebyshev(arc_slope[0], domain=[low, high]).integ()
    arc = arc - float(arc(0.0))

    def within(per_release: float) -> Series | None:
        # 0.1 rad serves a wheel that is released at rest and moved by the ship only
        reach = per_release * abs(machine.release_angle) + 0.1
        edges = np.clip(np.array([-reach, reach]), *machine.sides)
        inner = machine.geometry.tau_of(edges)
        return _series(machine, arc, float(inner[0]), float(inner[1]))

    short = usual = within(REACH_PER_RELEASE)
    if per_release != REACH_PER_RELEASE:
        short = within(per_release)
    if short is None or usual is None:
        raise PropagationError(
            'the inertia of weight and lever, or the force that pulls it, changes too abruptly '
            f'for {MOST_SHAPE_TERMS} Chebyshev coefficients. Use a heavier wheel, a lighter '
            'weight, a smoother force or a smaller release angle',
            0.0,
        )
    full = _series(machine, arc, low, high) or usual
    return ArcSeries(_in_powers(_shortened(short, allowed)), _shortened(full, allowed))


def _shortened(series: Series, allowed: float) -> Series:
    """Drop the last terms, as long as their sum stays below the error allowed."""
    size = np.abs(series.terms[:, list(ARC_FUNCTIONS)])
    tails = np.cumsum(size[::-1], axis=0)[::-1] / np.max(size, axis=0)
    needed = max(2, int(np.count_nonzero(np.max(tails, axis=1) > allowed)))
    return series._replace(terms=_in_rows(series.terms[:needed]))


def _in_rows(terms: FloatArray) -> FloatArray:
    """Return coefficients in rows of eight."""
    rows = rows_of_eight(len(terms))
    rows[:, : terms.shape[1]] = terms
    return rows


def _in_powers(series: Series) -> Series | Powers:
    """Return a series in powers, unless cancellation would cost digits."""
    terms = np.zeros_like(series.terms)
    for i in ARC_FUNCTIONS:
        powers = chebyshev.cheb2poly(series.terms[:, i])
        terms[: len(powers), i] = powers
        grown = np.sum(np.abs(terms[:, i])) / np.max(np.abs(series.terms[:, i]))
        if grown > MOST_GROWN:
            return series
    return Powers(series.middle, series.half_width, series.per_half, _in_rows(terms))


def _series(
    machine: LeverMachine, arc: chebyshev.Chebyshev, low: float, high: float
) -> Series | None:
    """Return the functions between two values of τ, or `None` if they take too many terms."""
    begin, end = float(arc(low)), float(arc(high))
    slope = arc.deriv()

    def functions(s: FloatArray) -> FloatArray:
        tau = np.clip(low + (s - begin) / (end - begin) * (high - low), low, high)
        for _ in range(_NEWTON):
            change = (arc(tau) - s) / slope(tau)
            tau = np.clip(tau - change, low, high)
            if np.max(np.abs(change)) <= 1e-12 * (high - low):
                # convergence is quadratic: the next change would be rounding
                break
        shape = machine.geometry
        ratio, ratio_slope = shape.slopes(tau)
        # with the fulcrum to port the lever turns by −β, counted in the sense of θ
        root_j = shape.side * math.sqrt(machine.turned_inertia / machine.inertia)
        # with b = dβ/dθ: n = 1/√(1 + jb²), w = √j bn and χ′ = √j n³ db/dθ
        n = 1.0 / np.hypot(1.0, root_j * ratio)
        w, beta = root_j * ratio * n, shape.pose(tau).beta
        chi_slope = root_j * ratio_slope * n**3
        sine = shape.side * np.sin(beta)
        # a pull that depends on the draw acts as a constant pull on a lever of another length
        cosine = np.cos(beta) if machine.law is None else np.cos(beta) * machine.strength(tau)
        return np.stack([n, w, chi_slope, cosine, sine, shape.theta(tau)])

    tail = SHAPE_TAIL if machine.law is None else TAIL_OF_LAW
    terms = _complete(functions, begin, end, MOST_SHAPE_TERMS, tail)
    if terms is None:
        return None
    half_width = 0.5 * (end - begin)
    return Series(0.5 * (begin + end), half_width, 1.0 / half_width, _in_rows(terms.T))


def _complete(
    functions: Callable[[FloatArray], FloatArray],
    low: float,
    high: float,
    most_terms: int,
    tail: float = SHAPE_TAIL,
) -> FloatArray | None:
    """Return complete Chebyshev coefficients on an interval, (m, n), or `None` if too many."""

    def series(terms: int) -> FloatArray:
        places = 0.5 * (low + high) + 0.5 * (high - low) * chebyshev_nodes(terms)
        return chebyshev_coefficients(functions(places))

    counts, terms = [], FEWEST_SHAPE_TERMS
    while terms <= most_terms:
        counts.append(terms)
        terms += terms // 4
    return complete_series(series, counts, tail)


# -----------------------------------------------------------------------------
# Sully's lever machine in one rotating plane, with the arc as coordinate.
#
# s, n, w, χ', β and j are as in `arc_series`, κ = (m AD − m′AE)/√(IJ) and A = n + √j w. The case's
# tilt is α = β_v − τ, with β_v the direction of the apparent vertical and τ its tilt in the case.
# (machine_at_sea.3) becomes
#
#     L/I = ½ṡ² + Aα̇ṡ + ½(1 + j)α̇² − √j κ g_eff sin(β − τ),    p = ṡ + Aα̇,
#     (methods.3)   ṡ = p − Aα̇,    ṗ = ṡα̇ dA/ds − κ w g_eff cos(β − τ) − n · drag,
#
# with dA/ds = χ'(√j n − w), without second derivatives of the ship's motion. X is s, ωY is p.
# g_eff and β_v are taken at the fulcrum. With the fulcrum to port the lever turns by −β, and sin
# β, w, χ' and κ change sign.

LEVER_NODES = 'alpha_rate', 'alpha_bend', 'g_up', 'g_across'
"""Rows of the nodes: α̇, α̈ and the apparent gravity along and across the case.

The latter are g_eff cos τ and g_eff sin τ, plus the transverse part near weightlessness.
"""


class LeverOnArc(NamedTuple):
    """The functions of the arc at one s, or at lanes of s: n, w, χ', cos β and sin β."""

    n: Numeric
    w: Numeric
    chi_slope: Numeric
    cosine: Numeric
    sine: Numeric


class _LeverNumbers(NamedTuple):
    """The constants of the equations.

    Attributes:
        shape: functions of the arc.
        root_j: √j.
        kappa: κ [1/m], negative with the fulcrum to port.
        on_wheel: terms on the wheel other than the thread.
        mirrored: True with the fulcrum to port, else `None`.
    """

    shape: ArcSeries
    root_j: float
    kappa: float
    on_wheel: OnWheel
    mirrored: bool | None = None


class SullyLever(_LeverNumbers, ThreadSystem):
    """Sully's lever machine as `system.System`."""

    @inlined
    def heated(self, hot: HeatTerms) -> SullyLever:
        """Return the lever with parameters as heat changes them."""
        on_wheel = thermal_on_wheel(self.on_wheel, hot)
        return SullyLever(self.shape, self.root_j, hot.weight, on_wheel, self.mirrored)

    def at_nodes(self, place: StepPlace, work: Work) -> None:
        """Fill α̇, α̈ and the apparent gravity along and across the case."""
        x, nodes = nodes_of(place, work), work.nodes
        store(nodes.alpha_rate, 0, difference(DRIVE_RATE, TILT_RATE, place.terms, x, work))
        store(nodes.alpha_bend, 0, difference(DRIVE_BEND, TILT_BEND, place.terms, x, work))
        store(nodes.g_up, 0, column_at(APPARENT_GRAVITY, place.terms, x, work))
        store(nodes.g_across, 0, column_at(TILT, place.terms, x, work))
        self.complete_case(work)
        if self.on_wheel.heat is not None:
            fill_hot(x, work)

    @inlined
    def keep_case(
        self, swing: FreeHalfSwing, k: int, at: Lanes, times: Lanes, initial: bool, work: Work
    ) -> None:
        """Keep the rows of `at_nodes` at the nodes of an event-to-event step, from x of span k.

        Until `complete_case` the gravity rows hold g_eff and τ.
        """
        nodes = work.nodes
        rate = bend = tilt = gravity = filled(work.fractions, 0.0)
        for j in range(swing.powers - 1, -1, -1):
            bend = fma(bend, at, rate)
            rate = fma(
                rate, at, swing.coefficient(DRIVE_RATE, k, j) - swing.coefficient(TILT_RATE, k, j)
            )
            tilt = fma(tilt, at, swing.coefficient(TILT, k, j))
            gravity = fma(gravity, at, swing.coefficient(APPARENT_GRAVITY, k, j))
        keep(nodes.alpha_rate, times, initial, rate)
        keep(nodes.alpha_bend, times, initial, bend * (1.0 / swing.pieces.length_s[k]))
        keep(nodes.g_up, times, initial, gravity)
        keep(nodes.g_across, times, initial, tilt)

    @inlined
    def complete_case(self, work: Work) -> None:
        """Turn g_eff and tilt at the nodes into the apparent gravity along and across the case."""
        nodes = work.nodes
        g_eff, tilt = row_of(nodes.g_up), row_of(nodes.g_across)
        sine, versine = sine_versine(tilt)
        aside = transverse_at_nodes(g_eff, tilt, work)
        store(nodes.g_up, 0, g_eff - g_eff * versine - aside * sine)
        store(nodes.g_across, 0, g_eff * sine + aside * (1.0 - versine))

    def disturb(self, mode: Mode, omega: Omega, work: Work) -> None:
        """Fill the terms of (methods.3) beyond the rotation of the plane."""
        s, p = row_of(work.x), omega[0] * row_of(work.y)
        nodes = work.nodes
        hot, at = heated_at_nodes(self, work), _near_nodes(self.shape, s)
        alpha_rate = row_of(nodes.alpha_rate)
        carried = alpha_rate * fma(self.root_j, at.w, at.n)
        speed = p - carried
        gravity = row_of(nodes.g_up) * at.cosine + row_of(nodes.g_across) * at.sine
        # ṗ + ω²s: with ω²s first, the two large terms cancel before the rest is added
        pushed = (omega[0] * omega[0]) * s - (hot.kappa * at.w) * gravity
        extra = pushed + _turned(self, at, speed, alpha_rate)
        extra = extra - at.n * drag_on_wheel(hot.on_wheel, mode, at.n * speed)
        if hot.on_wheel.growth is not None:
            extra = extra - hot.on_wheel.growth * p
        store(work.d1, 0, -carried)
        store(work.d2, 0, extra * (1.0 / omega[0]))

    def exits(self, mode: Mode, omega: Omega, work: Work) -> Exits:
        """Return whether the step leaves the geometry, or the thread goes slack."""
        s, p = row_of(work.x), omega[0] * row_of(work.y)
        nodes = work.nodes
        at = _near_nodes(self.shape, s)
        a = fma(self.root_j, at.w, at.n)
        speed = p - row_of(nodes.alpha_rate) * a
        gravity = row_of(nodes.g_up) * at.cosine + row_of(nodes.g_across) * at.sine
        hot = heated_at_nodes(self, work)
        _, tension, _ = _pushed(hot, mode, at, a, speed, row_of(nodes.alpha_bend), gravity)
        full = self.shape.full
        x = (s - full.middle) * full.per_half
        return exits_by(tension, 1.0 - x * x, s, work)

    def clear_square(
        self, omega: Omega, pieces: ForcingPieces, k: int, besides: float = 0.0
    ) -> float:
        """Return the y² above which ṡ has the sign of y: (Aα̇/ω)², with |A| ≤ √(1 + j).

        θ and s vanish together, hence the tilt does not matter. With an angle `besides`, the swing
        is also clear of θ = ± that angle, at |s| ≈ angle/n.
        """
        carried = case_bounds(pieces, k)[1] / omega[0]
        square = (1.0 + self.root_j * self.root_j) * (carried * carried)
        if besides > 0.0:
            reach = besides / lever_on_arc(self.shape, 0.0)[0].n
            square += reach * reach
        return CLEAR * square

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return whether s² + y² exceeds the bound at all nodes."""
        x, y = row_of(work.x), row_of(work.y)
        return lowest(x * x + y * y) > square

    def instant(self, mode: Mode, omega: Omega, planes: tuple[Plane, ...], at: Inputs) -> Instant:
        """Return the lever at an instant."""
        line, tilt, shape, s = at.drive, at.tilt, self.shape, planes[0].x
        hot, (arc, angle) = heated_now(self, at), lever_on_arc(shape, s)
        a = arc.n + self.root_j * arc.w
        alpha_bend = line.bend - tilt.bend
        speed = omega[0] * planes[0].y - a * (line.rate - tilt.rate)
        sine, cosine = math.sin(tilt.value), math.cos(tilt.value)
        aside = transverse(at.gravity, tilt.value)
        gravity = at.gravity * (arc.cosine * cosine + arc.sine * sine)
        gravity += aside * (arc.sine * cosine - arc.cosine * sine)
        # İψ̇ is left out of s̈, as in `Wheel.instant`
        acceleration, tension, drag = _pushed(hot, mode, arc, a, speed, alpha_bend, gravity)
        bend = arc.n * acceleration - arc.w * arc.chi_slope * speed * speed
        x = (s - shape.full.middle) / shape.full.half_width
        torque, share = bend + alpha_bend + drag, hot.on_wheel.share
        # ṗ = s̈ + Aα̈ + ṡα̇ dA/ds
        pushed = acceleration + a * alpha_bend
        if hot.on_wheel.growth is not None:
            pushed = pushed - hot.on_wheel.growth * (speed + a * (line.rate - tilt.rate))
        pushed = pushed + _turned(self, arc, speed, line.rate - tilt.rate)
        return Instant(
            angle=angle,
            rate=arc.n * speed,
            bend=bend,
            tension=tension,
            margin=1.0 - x * x,
            torque=torque if share is None else torque / share,
            coordinate=s,
            speed=speed,
            acceleration=acceleration,
            drift=(Plane(speed, pushed),),
        )

    def wheel_angle(self, planes: tuple[Plane, ...], at: Inputs) -> float:
        """Return θ."""
        return lever_on_arc(self.shape, planes[0].x)[1]

    def strike(
        self, mode: Mode, omega: Omega, at: Inputs, now: Instant, state: RunningState
    ) -> None:
        """Let an impulse change the momentum: ½Mθ̇² = ½Iṡ² grows by its energy."""
        speed, plane = now.speed, state.planes[0]
        energy = heated_now(self, at).on_wheel.energy
        struck = mode.direction * math.sqrt(speed * speed + energy)
        plane.y += (struck - speed) / omega[0]
        plane.y_rest = 0.0


@inlined
def _pushed(
    lever: SullyLever,
    mode: Mode,
    arc: LeverOnArc,
    a: Numeric,
    speed: Numeric,
    alpha_bend: Numeric,
    gravity: Numeric,
) -> tuple[Numeric, Numeric, Numeric]:
    """Return s̈, a number with the tension's sign, and the drag, from ṡ and α̈.

    By (methods.3) s̈ = −κ w g_eff cos(β − τ) − n · drag − Aα̈. `a` is A, `gravity` g_eff cos(β −
    τ). Serves the nodes of a step and single instants.
    """
    n, w = arc.n, arc.w
    drag = drag_on_wheel(lever.on_wheel, mode, n * speed)
    acceleration = -(lever.kappa * w * gravity + n * drag + a * alpha_bend)
    lifted = w * acceleration + n * arc.chi_slope * speed * speed + lever.root_j * alpha_bend
    tension = lifted + lever.kappa * gravity
    return acceleration, tension if lever.mirrored is None else -tension, drag


@inlined
def _turned(lever: SullyLever, arc: LeverOnArc, speed: Numeric, alpha_rate: Numeric) -> Numeric:
    """Return ṡα̇ dA/ds, with dA/ds = χ′(√j n − w)."""
    return speed * alpha_rate * arc.chi_slope * (lever.root_j * arc.n - arc.w)


@inlined
def _clenshaw(terms: FloatArray, x: Lanes) -> LeverOnArc:
    """Return Σ terms_k T_k(x) of each function by Clenshaw's recurrence, in parallel."""
    twice, zero = 2.0 * x, filled(x, 0.0)
    sums = older = zero, zero, zero, zero, zero
    for j in range(terms.shape[0] - 1, 0, -1):
        next_sums: tuple[Lanes, ...] = ()
        for i in AT_NODES:
            next_sums = (*next_sums, fma(twice, sums[i], terms[j, i] - older[i]))
        sums, older = next_sums, sums
    values: tuple[Lanes, ...] = ()
    for i in AT_NODES:
        values = (*values, fma(x, sums[i], terms[0, i] - older[i]))
    return LeverOnArc(values[0], values[1], values[2], values[3], values[4])


@inlined
def _horner(terms: FloatArray, x: Lanes) -> LeverOnArc:
    """Return Σ terms_k x^k of each function by Horner's scheme, in parallel."""
    zero = filled(x, 0.0)
    sums = zero, zero, zero, zero, zero
    for j in range(terms.shape[0] - 1, -1, -1):
        next_sums: tuple[Lanes, ...] = ()
        for i in AT_NODES:
            next_sums = (*next_sums, fma(sums[i], x, terms[j, i]))
        sums = next_sums
    return LeverOnArc(sums[0], sums[1], sums[2], sums[3], sums[4])


@compiled
def _near_nodes(shape: ArcSeries, s: Lanes) -> LeverOnArc:
    """Return the functions of the arc at lanes of s."""
    near_rest, full = shape.near_rest, shape.full
    away = s - near_rest.middle
    if largest(away) <= near_rest.half_width:
        if isinstance(near_rest, Powers):
            return _horner(near_rest.terms, away * near_rest.per_half)
        return _clenshaw(near_rest.terms, away * near_rest.per_half)
    return _clenshaw(full.terms, (s - full.middle) * full.per_half)


@inlined
def _powers_at(terms: FloatArray, x: float) -> Lanes:
    """Return Σ terms_k x^k of all functions."""
    sums = splat(0.0)
    for j in range(terms.shape[0] - 1, -1, -1):
        sums = fma(sums, x, row_of(terms, j))
    return sums


@inlined
def _series_at(terms: FloatArray, x: float) -> Lanes:
    """Return Σ terms_k T_k(x) of all functions by Clenshaw's recurrence."""
    twice, sums, older = 2.0 * x, splat(0.0), splat(0.0)
    for j in range(terms.shape[0] - 1, 0, -1):
        sums, older = fma(sums, twice, row_of(terms, j) - older), sums
    return fma(sums, x, row_of(terms) - older)


@compiled
def lever_on_arc(shape: ArcSeries, s: float) -> tuple[LeverOnArc, float]:
    """Return the functions of the arc and θ at s."""
    near_rest, full = shape.near_rest, shape.full
    away = s - near_rest.middle
    if abs(away) > near_rest.half_width:
        values = _series_at(full.terms, (s - full.middle) * full.per_half)
    elif isinstance(near_rest, Powers):
        values = _powers_at(near_rest.terms, away * near_rest.per_half)
    else:
        values = _series_at(near_rest.terms, away * near_rest.per_half)
    arc = LeverOnArc(
        lane(values, 0), lane(values, 1), lane(values, 2), lane(values, 3), lane(values, 4)
    )
    return arc, lane(values, 5)
