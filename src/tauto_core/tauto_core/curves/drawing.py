"""The cheeks of a cam as polylines, and the plate of arcs and lines that carries both.

The frame is the wheel's: origin at the axle, +y along the thread at rest. Polylines are in metres,
plates in millimetres. Biarcs, pairs of arcs that share a tangent, approximate the cheeks of a
plate. Both curves are convex: the greatest distance between them is the greatest difference of
their support functions, and the tolerance of the outline bounds the error of the lever arm.
"""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.cam import Cam, Setting, too_sharp
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.lever_geometry import MirroredLever
from tauto_core.curves.numerics import bisect
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import Argument, UsageError

ComplexArray: TypeAlias = NDArray[np.complex128]

MM_PER_M = 1000.0

# Number of angles for checks of cheeks.
_PROBES = 2001


class Cheek(NamedTuple):
    """One cheek in the wheel's frame, from the tip on, arrays of shape (n,).

    Attributes:
        angle: angle of the wheel at which the thread leaves the cheek at each point [rad].
        x: x of the cheek [m].
        y: y of the cheek [m].
    """

    angle: FloatArray
    x: FloatArray
    y: FloatArray


def cheek(
    cam: Cam, points: int = 200, reach_rad: float | None = None, thread_thickness: float = 0.0
) -> Cheek:
    """Return the cheek for positive angles, the mirror image of the other one.

    The centre line of a thread of thickness e ≥ 0 follows the cam's curve, and the cheek is the
    parallel curve e/2 inwards. It begins at the radius of curvature e/2, since R = 0 at the tip of
    every cam that is smooth through rest, and the thread bends round this edge. Without
    `reach_rad` it ends with `cam.drawn_rad` or the thread. UsageError: fewer than two points, a
    negative thickness, or a cheek that such a thread cannot follow. CamRangeError: a reach beyond
    the range.
    """
    if points < 2:
        raise UsageError(f'points = {points!r}: a cheek needs at least 2')
    if not 0.0 <= thread_thickness < math.inf:
        raise UsageError(f'thread thickness {thread_thickness!r} m: must be ≥ 0')
    reach = cam.drawn_rad if reach_rad is None else reach_rad
    cam.within(reach)
    # the first interval of angles with R of at least half the thickness
    start, end = 0.0, reach
    for low, high in too_sharp(cam, 0.5 * thread_thickness, reach):
        if low > 0.0 or thread_thickness == 0.0:
            end = low
            break
        start = high
    if end <= start:
        raise UsageError(
            f'the cheek of {cam!r} is nowhere as round as a thread of {thread_thickness!r} m '
            'needs, or hollow from its tip on. Use a thinner thread or another cam'
        )
    if end < reach and reach_rad is not None:
        # the advice, rounded to six digits, must stay below the end
        raise UsageError(
            f'beyond {end:.9g} rad the cheek of {cam!r} has a radius of curvature below half the '
            f"thread's thickness, {0.5 * thread_thickness!r} m, too sharp for the thread. "
            'Draw up to there (',
            Argument('reach_rad', f'{end * (1.0 - 1e-6):.6f}'),
            '), or use a thinner thread',
        )
    # denser at the end: ψ grows like a square root as a thread reaches its hole
    angle = start + (end - start) * np.sin(np.linspace(0.0, 0.5, points) * math.pi)
    x, y = cam.contact(angle)
    if thread_thickness:
        psi, offset = cam.psi(angle), 0.5 * thread_thickness
        x, y = x - offset * np.cos(psi), y - offset * np.sin(psi)
    return Cheek(angle, x, y)


def outline(
    cam: Cam, points: int = 200, reach_rad: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return both cheeks as one polyline (x, y) in the wheel's frame [m], for a thin thread.

    It runs from the end of the cheek at x > 0 over the common tip to the end of the other, with
    2·points − 1 points. Reach and errors as in `cheek`.
    """
    _, x, y = cheek(cam, points, reach_rad)
    return np.concatenate([-x[:0:-1], x]), np.concatenate([y[:0:-1], y])


def cheeks_meet_rad(cam: Cam) -> float:
    """Return the angle at which the two mirror-image cheeks meet again beyond their tip [rad].

    The contact point of the thread is then on the line x = 0. Longer cheeks would cross and could
    not be cut from one plate. For an involute tan ϑ = ϑ, ϑ = 4.493 rad. The result is inf if they
    do not meet up to `cam.drawn_rad`.
    """
    angles = np.linspace(0.0, cam.drawn_rad, _PROBES)
    # at positive angles the thread is on the cheek at x < 0
    is_left = cam.contact(angles)[0] < 0.0
    meets = np.flatnonzero(is_left[:-1] & ~is_left[1:])
    if not len(meets):
        return math.inf
    index = int(meets[0])
    return bisect(
        lambda at: bool(cam.contact(at)[0] < 0.0), float(angles[index]), float(angles[index + 1])
    )[0]


def lever_cheek(
    shape: CorrectedLeverGeometry | MirroredLever,
    end: float,
    points: int,
    thread_thickness: float = 0.0,
) -> Cheek:
    """Return one of the two cheeks of a lever's cam up to τ = end, as `cheek` for other cams.

    UsageError: a cheek that such a thread cannot follow.
    """
    offset, start = 0.5 * thread_thickness, 0.0
    if offset:
        looked = np.linspace(0.0, end, _PROBES - 1)
        radius = shape.radius_of_curvature(looked)
        sharp = np.flatnonzero(radius < offset)
        index = int(sharp[-1]) if len(sharp) else 0
        if index == len(looked) - 1 or not np.array_equal(sharp, np.arange(index + 1)):
            reach = float(shape.theta(looked[-1:])[0])
            raise UsageError(
                f'thread thickness {2.0 * offset!r} m: up to {reach:.6g} rad the cheek is '
                'sharper than half of it beyond its tip. Its greatest '
                f'radius of curvature is {float(np.max(radius)):.6g} m. Use a thinner thread or a '
                'shorter ',
                Argument('reach_rad'),
            )
        sharp_at, round_at = float(looked[index]), float(looked[index + 1])
        start, _ = bisect(
            lambda at: bool(shape.radius_of_curvature(np.array([at]))[0] >= offset),
            round_at,
            sharp_at,
        )
    tau = np.linspace(start, end, points)
    (x, y), angle = shape.contact(tau), shape.theta(tau)
    if offset:
        u, inwards = shape.pose(tau).u, -offset * float(np.sign(end))
        x, y = x + inwards * np.cos(u), y + inwards * np.sin(u)
    return Cheek(angle, x, y)


# -----------------------------------------------------------------------------
# The plate.

WALL_MM = 0.2
"""Least material between a hole and any other edge."""

FINEST_MM, COARSEST_MM = 1e-6, 1.0
"""Limits of the tolerance of an outline: rounding of its numbers, and a coarse saw."""

BORE, PINS, PIN_CIRCLE, SLOT = 0.5, 0.3, 0.65, 0.3
"""Diameter of the bore and of the pin holes, radius of their circle and depth of the slot, over
the distance of the cusp from the axle. All fit within a circle through the cusp, inside the
cheeks."""

TOOL_MM = 1.0
"""Default diameter of the smallest tool."""

PIN_ANGLES = (math.radians(210.0), math.radians(330.0))
"""Directions of the pin holes from the axle, which exclude a plate turned by half a turn."""

_LARGEST_ARC = math.radians(120.0)
_SAMPLES = 33
_MOST_HALVINGS = 20
_SWING_NODES = 20_001


class ArcPath(NamedTuple):
    """A path of arcs and lines in a layer of a drawing, each array of shape (n,).

    Attributes:
        layer: name of the layer.
        x: vertices [mm].
        y: vertices [mm].
        bulge: tan(α/4) of the arc from each vertex to the next, α its angle, positive
            counter-clockwise, at most half a turn, 0 for a line.
        is_closed: whether the last vertex is joined to the first.
    """

    layer: str
    x: FloatArray
    y: FloatArray
    bulge: FloatArray
    is_closed: bool = True

    def svg(self) -> str:
        """Return the data of an SVG path, with y downwards."""
        parts = [f'M{self.x[0]:.6f} {-self.y[0]:.6f}']
        x, y = (np.roll(part, -1) for part in (self.x, self.y))
        sides = list(zip(x, y, np.hypot(x - self.x, y - self.y), self.bulge, strict=True))
        for x, y, chord, bulge in sides if self.is_closed else sides[:-1]:
            if bulge == 0.0:
                parts.append(f'L{x:.6f} {-y:.6f}')
                continue
            radius = 0.25 * chord * (1.0 / abs(bulge) + abs(bulge))
            # with y downwards a left turn is SVG's flag 0
            parts.append(f'A{radius:.6f} {radius:.6f} 0 0 {int(bulge < 0.0)} {x:.6f} {-y:.6f}')
        return ''.join(parts) + 'Z' * self.is_closed

    def polygon(self, sagitta: float) -> tuple[FloatArray, FloatArray]:
        """Return points (x, y) on the path, with chords within a sagitta of it [mm]."""
        points = self.x + 1j * self.y
        parts = []
        for start, end, bulge in zip(points, np.roll(points, -1), self.bulge, strict=True):
            angle = 4.0 * math.atan(bulge)
            if angle == 0.0 or start == end:
                parts.append(np.array([start]))
                continue
            # the centre sees the chord under the angle
            turn = np.exp(1j * angle)
            centre = (end - turn * start) / (1.0 - turn)
            step = 2.0 * math.acos(max(1.0 - sagitta / abs(start - centre), 0.0))
            count = max(math.ceil(abs(angle) / step), 1)
            part = np.exp(1j * angle * np.arange(count) / count)
            parts.append(centre + (start - centre) * part)
        curve = np.concatenate(parts)
        return curve.real, curve.imag


class Circle(NamedTuple):
    """A circle in a layer of a drawing [mm]."""

    layer: str
    x: float
    y: float
    radius: float

    @property
    def path(self) -> ArcPath:
        """The circle as a path of two arcs."""
        x = self.x + self.radius * np.array([-1.0, 1.0])
        return ArcPath(self.layer, x, np.full(2, self.y), np.ones(2))


def polyline(layer: str, x: FloatArray, y: FloatArray) -> ArcPath:
    """Return an open path of lines between points [mm]."""
    return ArcPath(layer, x, y, np.zeros_like(x), is_closed=False)


@dataclass(frozen=True)
class CheekArcs:
    """One cheek, for positive angles, as arcs that share tangents.

    Attributes:
        psi: directions ψ of the normal at the n + 1 vertices [rad], increasing.
        vertex: vertices as x + iy, shape (n + 1,) [mm].
        centre: centres of the arcs, shape (n,) [mm].
        radius: radii of the arcs, shape (n,) [mm].
        thread: thickness of the thread [mm].
    """

    psi: FloatArray
    vertex: ComplexArray
    centre: ComplexArray
    radius: FloatArray
    thread: float

    def lever_arm(self, psi: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t and dt/dψ [mm] of the thread's centre line in a direction ψ ≥ 0.

        Before the first normal the thread bends round the edge at which the cheek begins.
        """
        # the edge is an arc of radius 0
        centre = np.concatenate([self.vertex[:1], self.centre])
        radius = np.concatenate([[0.0], self.radius])
        which = np.minimum(np.searchsorted(self.psi, psi, side='right'), len(self.radius))
        along = centre[which] * np.exp(-1j * psi)
        return along.real + radius[which] + 0.5 * self.thread, along.imag


@dataclass(frozen=True)
class Plate:
    """A plate that carries both cheeks.

    Attributes:
        outline: edge of the plate, counter-clockwise from the edge of the slot on the left.
        holes: bore and pin holes.
        tool: path of the centre of the cutter outside the plate, if any.
        tool_holes: paths of the centre of the cutter inside the holes.
        cheek: cheek on the left, under the thread at positive angles.
        reach_rad: angle of the wheel at which the cheeks end [rad].
        acts_from_rad: least angle of the wheel with the thread on the cheeks [rad].
        slot: width of the slot between the cheeks [mm].
        tolerance: greatest distance between the outline and the cheeks [mm].
        cutter: diameter of the cutter, or width of the kerf [mm].
        rates: its effect on the rate of free swings on land, if computed.
    """

    outline: ArcPath
    holes: tuple[Circle, ...]
    tool: ArcPath | None
    tool_holes: tuple[Circle, ...]
    cheek: CheekArcs
    reach_rad: float
    acts_from_rad: float
    slot: float
    tolerance: float
    cutter: float
    rates: PlateRates | None = None


def cam_plate(
    cam: Cam,
    reach_rad: float,
    *,
    thread_mm: float,
    cutter_mm: float = 0.0,
    tolerance_mm: float = 1e-4,
    bore_mm: float | None = None,
    pins_mm: float | None = None,
    pin_circle_mm: float | None = None,
    slot_mm: float | None = None,
) -> Plate:
    """Return a plate with both cheeks of a cam, closed by an arc about the axle.

    A slot between the cheeks holds the thread, and is as wide as it at their beginning. From the
    end of each cheek the thread leads away from the axle, and from the closing arc.

    Args:
        cam: the cam.
        reach_rad: angle of the wheel at which the cheeks end [rad], > 0, within the range.
        thread_mm: thickness of the thread [mm], > 0: its centre line follows the curve of the cam.
        cutter_mm: diameter of the cutter, or width of the kerf [mm], ≥ 0.
        tolerance_mm: greatest distance between arcs and cheeks [mm], FINEST_MM to COARSEST_MM.
        bore_mm: diameter of the bore for the axle [mm], > 0, by default BORE times the distance of
            the cusp.
        pins_mm: diameter of the two pin holes [mm], > 0, by default PINS times that distance.
        pin_circle_mm: distance of the pin holes from the axle [mm], > 0, by default PIN_CIRCLE.
        slot_mm: depth of the slot below the edges of the cheeks [mm], > 0, by default SLOT.

    Raises:
        UsageError: arguments out of range, cheeks that cross or turn back to the axle, a hole
            without WALL_MM of material about it, or a cutter wider than the slot or a hole.
        CamRangeError: a reach beyond the range of the cam.
    """
    tip = MM_PER_M * float(cam.p(0.0))
    bore, pins, pin_circle, depth, thread = (
        _size(name, value, share * tip)
        for name, value, share in (
            ('bore_mm', bore_mm, BORE),
            ('pins_mm', pins_mm, PINS),
            ('pin_circle_mm', pin_circle_mm, PIN_CIRCLE),
            ('slot_mm', slot_mm, SLOT),
            ('thread_mm', thread_mm, 0.0),
        )
    )
    if not 0.0 <= cutter_mm < math.inf:
        raise UsageError(
            Argument('cutter_mm', cutter_mm, spaced=True),
            ': must be ≥ 0 mm. Give the diameter of the cutter or the width of the kerf, or leave '
            'it out',
        )
    if not FINEST_MM <= tolerance_mm <= COARSEST_MM:
        raise UsageError(
            Argument('tolerance_mm', tolerance_mm, spaced=True),
            f': must be {FINEST_MM:g} to {COARSEST_MM:g} mm. Leave it out for a fine outline',
        )
    meeting = cheeks_meet_rad(cam)
    if reach_rad > meeting:
        raise UsageError(
            Argument('reach_rad', f'{reach_rad:.6g} rad', spaced=True),
            f': the cheeks cross at {meeting:.6g} rad and cannot be cut from one plate beyond it. '
            'Give a smaller one',
        )
    # the first angle of the cheek, or a refusal as in every drawing
    acts_from = float(cheek(cam, 2, reach_rad, thread / MM_PER_M).angle[0])
    looked = np.linspace(acts_from, reach_rad, 1001)
    if np.any(cam.p(looked) <= 0.0):
        turned = float(looked[np.argmax(cam.p(looked) <= 0.0)])
        raise UsageError(
            Argument('reach_rad', f'{reach_rad:.6g} rad', spaced=True),
            f': from {turned:.6g} rad on the thread leads towards the axle, over the edge of '
            'the plate. Give a smaller one',
        )
    arcs = _cheek_arcs(cam, acts_from, reach_rad, thread, tolerance_mm)
    slot = -2.0 * float(arcs.vertex[0].real)
    radius = 0.5 * cutter_mm
    # on an involute the slot is r θ₀³/3 narrower than the thread, 0.2 µm of 0.5 mm
    if radius > 0.5 * max(slot, thread):
        raise UsageError(
            Argument('cutter_mm', f'{cutter_mm:g} mm', spaced=True),
            f": the cutter's radius of {radius:g} mm is larger than the smallest concave radius "
            f'of curvature of the plate, {0.5 * slot:.4g} mm, at the end of the slot between the '
            f'cheeks. Use a cutter of at most {max(slot, thread):.4g} mm, or a thicker thread (',
            Argument('thread_mm'),
            ')',
        )
    outline = _edge('PLATE', arcs, slot, depth, 0.0)
    pin = [pin_circle * complex(math.cos(angle), math.sin(angle)) for angle in PIN_ANGLES]
    holes = (
        Circle('BORE', 0.0, 0.0, 0.5 * bore),
        *(Circle('PIN', at.real, at.imag, 0.5 * pins) for at in pin),
    )
    edge = outline.polygon(1e-3 * tip)
    for hole in holes:
        name, place = (
            ('bore_mm', 'slot_mm') if hole.layer == 'BORE' else ('pins_mm', 'pin_circle_mm')
        )
        others = (
            math.hypot(hole.x - other.x, hole.y - other.y) - other.radius
            for other in holes
            if other is not hole
        )
        room = min(_room(complex(hole.x, hole.y), edge), *others) - WALL_MM
        size = f'{2.0 * hole.radius:.4g} mm'
        thinner = 0.94 * (thread + 2.0 * (room - hole.radius))
        is_thread = name == 'bore_mm' and bore_mm is slot_mm and thinner > 0.0
        if hole.radius > room and is_thread:
            raise UsageError(
                Argument('thread_mm', f'{thread:g} mm', spaced=True),
                f': the slot for it leaves no room for a bore of {size} within a cusp {tip:.4g} '
                f'mm from the axle. Use a thread of at most {thinner:.2g} mm, or give a smaller ',
                *(Argument(name), ' or ', Argument(place)),
            )
        if not hole.radius <= room:
            raise UsageError(
                Argument(name, size, spaced=True),
                f': the hole at ({hole.x:.4g}, {hole.y:.4g}) mm would not leave {WALL_MM:g} mm of '
                f'the plate about it. There is room for {max(2.0 * room, 0.0):.4g} mm. '
                f'Give {"a smaller hole" if room > 0.0 else "another place"}: ',
                *(Argument(name), ', ', Argument(place)),
            )
        if radius >= hole.radius:
            raise UsageError(
                Argument('cutter_mm', f'{cutter_mm:g} mm', spaced=True),
                f': does not cut a hole of {size}. Use a smaller cutter, or a larger ',
                Argument(name),
            )
    tool = tuple(hole._replace(layer='TOOL', radius=hole.radius - radius) for hole in holes)
    return Plate(
        outline,
        holes,
        _edge('TOOL', arcs, slot, depth, radius) if radius else None,
        tool if radius else (),
        arcs,
        reach_rad,
        acts_from,
        slot,
        tolerance_mm,
        cutter_mm,
    )


def too_small(
    tip_mm: float, pull: float, gravity: float, tool_mm: float, given: Container[str] = ()
) -> str:
    """Return a warning about holes of a plate too small for a tool, with the remedy, or ''.

    The default sizes of `cam_plate` are checked, not the given ones. In the same period lever arms
    are inverse to the pull [N]: I ω² = P b.
    """
    shares = {('bore_mm', 'bore'): BORE, ('pins_mm', 'pin holes'): PINS}
    _size('tool_mm', tool_mm, TOOL_MM)  # refuses a negative size
    small = {
        word: share
        for (name, word), share in shares.items()
        if name not in given and share * tip_mm < tool_mm
    }
    if not small:
        return ''
    # two digits of 0.94 of it are less than it
    lower = float(f'{0.94 * pull * tip_mm * min(small.values()) / tool_mm:.2g}')
    named = ', no '.join(f'{word} of {share * tip_mm:.2g} mm' for word, share in small.items())
    return (
        f'the cusp is {tip_mm:.3g} mm from the axle, and a tool of {tool_mm:g} mm makes no {named}'
        f'. A pull of {lower:.2g} N, a weight of {1000.0 * lower / gravity:.3g} g, puts it at '
        f'{tip_mm * pull / lower:.3g} mm in the same period'
    )


def _size(name: str, value: float | None, default: float) -> float:
    """Return a length [mm], by default rounded to two digits. UsageError: it is not > 0."""
    if value is None:
        return float(f'{default:.2g}')
    if not 0.0 < value < math.inf:
        raise UsageError(
            Argument(name, value, spaced=True), ': must be > 0 mm. Leave it out for the default'
        )
    return value


def _room(centre: complex, edge: tuple[FloatArray, FloatArray]) -> float:
    """Return the distance of a point from a polygon [mm], negative outside."""
    start = edge[0] + 1j * edge[1] - centre
    side = np.roll(start, -1) - start
    along = np.clip(-(start * side.conj()).real / np.maximum(np.abs(side) ** 2, 1e-300), 0.0, 1.0)
    distance = float(np.min(np.abs(start + along * side)))
    turns = float(np.sum(np.angle(np.roll(start, -1) / start))) / math.tau
    return distance if round(turns) else -distance


# -----------------------------------------------------------------------------
# The cheek as arcs.


def _cheek_arcs(cam: Cam, start: float, end: float, thread: float, tolerance: float) -> CheekArcs:
    """Return the cheek between two angles of the wheel as biarcs within a tolerance [mm]."""

    def at(angle: FloatArray) -> tuple[FloatArray, ComplexArray]:
        x, y = cam.contact(angle)
        psi = cam.psi(angle)
        normal = np.exp(1j * psi)
        return psi, MM_PER_M * (x + 1j * y) - 0.5 * thread * normal

    def fitted(low: float, high: float, halvings: int) -> list[tuple[float, complex, float]]:
        """Return (ψ at its end, centre, radius) of the arcs from low to high."""
        ends, point = at(np.array([low, high]))
        arcs = _biarc(ends, point)
        if arcs is not None:
            looked, points = at(np.linspace(low, high, _SAMPLES))
            which = (looked > arcs[0][0]).astype(int)
            centre = np.array([arc[1] for arc in arcs])[which]
            radius = np.array([arc[2] for arc in arcs])[which]
            wrong = np.abs(((centre - points) * np.exp(-1j * looked)).real + radius)
            if np.max(wrong) <= tolerance:
                return arcs
        if halvings == 0:
            raise UsageError(
                Argument('tolerance_mm', f'{tolerance:g} mm', spaced=True),
                f': no arcs come so near to the cheek at {low:.6g} rad. Give a larger one',
            )
        middle = 0.5 * (low + high)
        return fitted(low, middle, halvings - 1) + fitted(middle, high, halvings - 1)

    start_psi, _ = at(np.array([start]))
    arcs = fitted(start, end, _MOST_HALVINGS)
    psi = np.array([float(start_psi[0]), *(arc[0] for arc in arcs)])
    centre = np.array([arc[1] for arc in arcs])
    radius = np.array([arc[2] for arc in arcs])
    ends = centre + radius * np.exp(1j * psi[1:])
    begin = centre[0] + radius[0] * np.exp(1j * psi[0])
    return CheekArcs(psi, np.concatenate([[begin], ends]), centre, radius, thread)


def _biarc(psi: FloatArray, point: ComplexArray) -> list[tuple[float, complex, float]] | None:
    """Return (ψ at its end, centre, radius) of two arcs between points with given normals.

    Both arcs have tangents of equal length to the corner of their control polygon. They do not
    exist for a curve that turns back, or by half a turn.
    """
    chord = complex(point[1] - point[0])
    tangents = [complex(1j * np.exp(1j * angle)) for angle in psi]
    # |chord − d (T₀ + T₁)| = 2 d
    across = (chord * (tangents[0] + tangents[1]).conjugate()).real
    turn = 2.0 * (1.0 - math.cos(float(psi[1] - psi[0])))
    if not (across > 0.0 and psi[1] - psi[0] < math.pi):
        return None
    length = abs(chord) ** 2 / (across + math.sqrt(across * across + turn * abs(chord) ** 2))
    joint = 0.5 * (complex(point[0] + point[1]) + length * (tangents[0] - tangents[1]))
    # an arc turns by twice the angle between its first tangent and its chord
    bend = np.angle((joint - complex(point[0])) / tangents[0])
    middle = float(psi[0]) + 2.0 * float(bend)
    if not psi[0] < middle < psi[1]:
        return None
    arcs = []
    for begin, stop, tail, head in (
        (float(psi[0]), middle, complex(point[0]), joint),
        (middle, float(psi[1]), joint, complex(point[1])),
    ):
        radius = abs(head - tail) / (2.0 * math.sin(0.5 * (stop - begin)))
        arcs.append((stop, tail - radius * complex(math.cos(begin), math.sin(begin)), radius))
    return arcs


def _edge(layer: str, cheek: CheekArcs, slot: float, depth: float, offset: float) -> ArcPath:
    """Return the edge of the plate, or its parallel curve outside at an offset [mm].

    Each arc keeps its centre and angle. Convex corners become arcs.
    """
    normal = np.exp(1j * cheek.psi)
    end, away = cheek.vertex[-1], cheek.vertex[-1] / abs(cheek.vertex[-1])
    bottom = complex(-0.5 * slot, cheek.vertex[0].imag - depth)
    vertices, bulges = [bottom + offset], [0.0]
    if offset:
        vertices.append(complex(cheek.vertex[0] + offset))
        bulges.append(math.tan(0.25 * float(cheek.psi[0])))
    vertices += (cheek.vertex + offset * normal).tolist()
    bulges += np.tan(0.25 * np.diff(cheek.psi)).tolist()
    corner = float(np.angle(away / normal[-1]))
    if offset:
        bulges.append(math.tan(0.25 * corner))
        vertices.append(complex(end + offset * away))
    # a cutter as wide as the symmetric slot goes down its middle
    vertices = [complex(min(point.real, 0.0), point.imag) for point in vertices]
    closing = math.tau - 2.0 * float((np.angle(end) - 0.5 * math.pi) % math.tau)
    parts = math.ceil(closing / _LARGEST_ARC)
    turned = np.exp(1j * closing * np.arange(1, parts) / parts)
    points = np.array(
        [*vertices, *((end + offset * away) * turned), *(-np.conj(np.array(vertices[::-1])))]
    )
    bulge = [*bulges, *[math.tan(0.25 * closing / parts)] * parts, *bulges[::-1], -1.0]
    return ArcPath(layer, points.real, points.imag, np.array(bulge))


# -----------------------------------------------------------------------------
# The effect of the plate on the rate.


def lever_arm_as_cut(plate: Plate, cam: Cam, angle: FloatArray) -> FloatArray:
    """Return the lever arm of the thread on the plate [m] at angles of the wheel ≥ 0 [rad]."""
    hole = MM_PER_M * cam.distance
    psi = np.array(cam.psi(angle))
    arm, rate = plate.cheek.lever_arm(psi)
    if math.isinf(hole):
        return arm / MM_PER_M
    # ψ = ϑ + arcsin(t/a) by Newton's method from the ψ of the cam, which is near
    for _ in range(8):
        wrong = psi - angle - np.arcsin(arm / hole)
        psi = psi - wrong / (1.0 - rate / np.sqrt(hole * hole - arm * arm))
        arm, rate = plate.cheek.lever_arm(psi)
    return arm / MM_PER_M


class PlateRates(NamedTuple):
    """Changes of the rate of free swings on land by a plate [s/day], positive for a gain.

    Each array has the shape of the amplitudes.

    Attributes:
        amplitude_rad: amplitudes [rad].
        edge: effect of the edges of the slot, round which the thread bends.
        outline: effect of edge and arcs together, the plate as drawn.
        one_micrometre: effect of both cheeks cut a micrometre too deep.
    """

    amplitude_rad: FloatArray
    edge: FloatArray
    outline: FloatArray
    one_micrometre: FloatArray


def plate_rates(plate: Plate, cam: Cam, setting: Setting, amplitudes: FloatArray) -> PlateRates:
    """Return the rate error of a plate at amplitudes within its reach [rad].

    Thread ideal, swings free: ½ (I + m t²) θ̇² + F₀ h + ½ k h² is constant.
    """
    phase = np.linspace(0.0, 0.5 * math.pi, _SWING_NODES)
    rows = []
    for amplitude in amplitudes.tolist():
        angle = amplitude * np.sin(phase)
        arm, as_cut = cam.lever_arm(angle), lever_arm_as_cut(plate, cam, angle)
        # perfect cheeks that begin at the edges of the slot, the plate, a micrometre too deep
        cuts = np.where(angle < plate.acts_from_rad, as_cut, arm), as_cut, arm - 1e-6
        period, *periods = (_period(t, phase, amplitude, setting) for t in (arm, *cuts))
        rows.append([86400.0 * (period / value - 1.0) for value in periods])
    edge, outline, deep = np.array(rows).T
    return PlateRates(amplitudes, edge, outline, deep)


def _period(arm: FloatArray, phase: FloatArray, amplitude: float, setting: Setting) -> float:
    """Return the period of free swings [s] of lever arms at θ = A sin φ, φ evenly spaced.

    T = 4 ∫ √((I + m t²)/(2 (V(A) − V(θ)))) A cos φ dφ. The trapezoidal rule sums the energies from
    the turning point, near which they are small.
    """
    pull = setting.pull
    # θ₂ − θ₁ = 2 A cos(mean φ) sin(half the step) has no cancellation at the turning point
    middle, half = 0.5 * (phase[1:] + phase[:-1]), 0.5 * np.diff(phase)
    steps = (arm[1:] + arm[:-1]) * amplitude * np.cos(middle) * np.sin(half)
    drop = np.concatenate([np.cumsum(steps[::-1])[::-1], [0.0]])
    force = pull.at_rest(setting.gravity) + 0.5 * pull.stiffness * (2.0 * drop[0] - drop)
    mass = setting.inertia + pull.carried_mass * arm * arm
    integrand = np.empty_like(arm)
    integrand[:-1] = np.sqrt(0.5 * mass[:-1] / (force[:-1] * drop[:-1])) * np.cos(phase[:-1])
    # next to the turning point V(A) − V(θ) = F t (A − θ), and cos² φ = 2 (A − θ)/A
    integrand[-1] = math.sqrt(mass[-1] / (force[-1] * arm[-1] * amplitude))
    integrand[[0, -1]] *= 0.5
    return float(4.0 * amplitude * (phase[1] - phase[0]) * np.sum(integrand))
