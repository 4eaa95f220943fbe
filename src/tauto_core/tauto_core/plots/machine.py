"""The machine of a scene as outlines: wheel, axle, cheeks, thread, weight, case [mm]."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, cast

import numpy as np

from tauto_core.curves import Cam, Cheek, DescentCurve, cheek
from tauto_core.curves.cam import Pull
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.drawing import cheeks_meet_rad, lever_cheek
from tauto_core.curves.fluid import coordinates, fluid_outline
from tauto_core.curves.lever_geometry import MirroredLever
from tauto_core.machines import (
    AxleClock,
    FluidPendulum,
    HangingMachine,
    LeverMachine,
    NoSteadySwing,
    compile_machine,
    compile_trochlea,
    steady_swing,
)
from tauto_core.machines.axle_pendulum import AxleRegulator
from tauto_core.machines.sections import FluidTautochroneRegulator
from tauto_core.machines.threads import HoleThread
from tauto_core.machines.threads.hanging import HangingThread
from tauto_core.machines.threads.lever import LeverThread
from tauto_core.plots.chart import Colour, Line
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.errors import UsageError
from tauto_core.ship.suspensions import AxleSuspension, SuspensionKind

# -----------------------------------------------------------------------------
# The default extent of a cheek in drawings and files.

# Extent over swing. A ship's motion and an escapement may increase the swing.
_MARGIN = 1.5


def cam_extent(scene: Scene) -> float:
    """Return the largest angle of the wheel for which a scene's cheeks are drawn [rad].

    It is one and a half times the swing of the wheel, rounded to two digits, within the range of
    the cam and the angle at which the two cheeks would meet. The swing is the angle of release, or
    the steady amplitude on land with an escapement if that is larger.

    Raises:
        SceneError: a machine that cannot be built.
    """
    machine = compile_trochlea(scene)
    assert scene.trochlea is not None
    ends = [machine.range_rad, math.tau]
    if scene.trochlea.cam.kind != 'lever_corrected':
        curve = scene.trochlea.made_cam(scene.g)
        ends += [curve.drawn_rad, cheeks_meet_rad(curve)]
    swing = abs(machine.release_angle)
    if not isinstance(machine, HangingMachine) and machine.escapement is not None:
        steady = steady_swing(machine)
        swing = swing if isinstance(steady, NoSteadySwing) else max(swing, steady.amplitude)
    if swing > 0.0:
        ends.append(float(f'{_MARGIN * swing:.2g}'))
    return min(ends)


LeverShape: TypeAlias = CorrectedLeverGeometry | MirroredLever


def cam_shape(scene: Scene) -> tuple[Cam | LeverShape, float]:
    """Return a scene's cam, or the lever whose cam is made for it, and its range [rad]."""
    assert scene.trochlea is not None
    if scene.trochlea.cam.kind != 'lever_corrected':
        cam = scene.trochlea.made_cam(scene.g)
        return cam, cam.range_rad
    machine = compile_machine(scene)
    assert isinstance(machine, LeverMachine)
    return cast(LeverShape, machine.geometry), machine.range_rad


def both_cheeks(
    shape: Cam | LeverShape, reach_rad: float, points: int, thread: float = 0.0
) -> tuple[Cheek, Cheek]:
    """Return the cheeks under the thread at negative angles, on the right, and at positive ones.

    Reach, thread and errors as in `curves.cheek`.
    """
    if isinstance(shape, Cam):
        left = cheek(shape, points, reach_rad, thread)
        return Cheek(-left.angle, -left.x, left.y), left
    ends = shape.tau_of(np.array([-1.0, 1.0]) * reach_rad).tolist()
    right, left = (lever_cheek(shape, end, points, thread) for end in ends)
    return right, left


# -----------------------------------------------------------------------------
# The machine of a scene as outlines, to scale [mm]: its parts, and how they move.
#
# The origin is the axle of the wheel, or the lowest point of a curve in a fluid. y points upwards,
# and all is at rest. A scene gives inertias and masses, not shapes: the rim is drawn as a brass
# ring with the inertia of the wheel, the weight as a lead cylinder with its mass. A note names the
# other assumptions.

MM = 1000.0
BRASS_KG_M3, LEAD_KG_M3 = 8500.0, 11340.0
RIM_SIDE = 0.1
"""Side of the rim's square section over its mean radius."""
WEIGHT_HEIGHT = 1.5
"""Height of the weight over its width."""
MOST_RADII = 6.0
"""Longest thread that is drawn whole, over the radius of the rim."""
BROKEN_RADII = 3.0
"""Length at which a longer thread is drawn, with a break, over the radius of the rim."""
_CIRCLE = np.linspace(0.0, math.tau, 121)

Carrier = Literal['ship', 'case', 'wheel', 'weight', 'spring', 'lever', 'body']


@dataclass(frozen=True)
class Outline(Line):
    """An outline, and the part that carries it. The weight moves along its thread."""

    moves_with: Carrier = 'case'


@dataclass(frozen=True)
class MachineDrawing:
    """The outlines of a machine.

    Attributes:
        parts: outlines from the back to the front.
        note: the materials, and the assumed dimensions.
        is_broken: whether a thread is drawn too short. Heights below the break are not to scale.
    """

    parts: list[Outline]
    note: str
    is_broken: bool = False


def rim_mm(inertia: float) -> tuple[float, float, float]:
    """Return the inner and outer radius [mm] and the mass [kg] of the rim.

    A ring of mean radius R and square section of side a = R/10 has the inertia 2πρ a² R³ (1 +
    a²/4R²) [kg m2] about its axis and the mass 2πρ a² R.
    """
    per_r5 = math.tau * BRASS_KG_M3 * RIM_SIDE**2
    radius = (inertia / (per_r5 * (1.0 + 0.25 * RIM_SIDE**2))) ** 0.2
    half_side = 0.5 * RIM_SIDE
    return MM * radius * (1.0 - half_side), MM * radius * (1.0 + half_side), per_r5 * radius**3


def weight_mm(mass: float) -> tuple[float, float]:
    """Return width and height of a lead cylinder [mm] of a mass [kg]: π/4 w² h = m/ρ."""
    width = MM * (4.0 * mass / (LEAD_KG_M3 * math.pi * WEIGHT_HEIGHT)) ** (1.0 / 3.0)
    return width, WEIGHT_HEIGHT * width


def cam_lines(scene: Scene) -> list[Outline]:
    """Return both cheeks, the thread at rest and the axle. Raise UsageError without a trochlea."""
    left, right, tip = _cheeks(scene)
    return [
        _area('cheeks', left, 'blue'),
        _area('', right, 'blue'),
        _path('thread at rest', [(0.0, tip), (0.0, 3.0 * tip)], 'grey'),
        _area('axle', _circle(0.0, 0.0, 0.04 * abs(tip)), 'grey'),
    ]


def draw_machine(scene: Scene) -> MachineDrawing:
    """Return the drawing of a scene's machine: wheel, cheeks, thread, power, case and suspension.

    A regulator in a fluid has its curve and body, one on an axle its support and body.

    Raises:
        SceneError: a machine that cannot be built.
    """
    machine = compile_machine(scene)
    if isinstance(machine, AxleClock):
        return _on_axle(machine, cast(AxleRegulator, scene.regulator).support)
    if isinstance(machine, FluidPendulum):
        return _in_fluid(cast(FluidTautochroneRegulator, scene.regulator), machine.curve)
    assert scene.trochlea is not None
    thread, pull = scene.trochlea.thread, scene.trochlea.power.pull
    left, right, tip = _cheeks(scene)
    inner, outer, mass = rim_mm(scene.trochlea.inertia)
    across, high = weight_mm(pull.pulling_mass) if pull.pulling_mass else (0.0, 0.0)
    notes = [
        f'The rim is a brass ring that has the inertia of the wheel ({MM * mass:.3g} g, with a '
        'square section a tenth of its radius wide)',
        *[f'the weight is a lead cylinder of {pull.pulling_mass:.3g} kg'] * bool(high),
    ]
    length = _below_axle(scene, tip)
    assumed = ['axle of the wheel', 'case', *['length of the thread'] * (length is None)]
    # a length that is not given is as long as the weight needs, and never broken
    depth = 1.6 * outer + 0.5 * high if length is None else length
    is_broken = length is not None and depth > MOST_RADII * outer
    if is_broken:
        depth = BROKEN_RADII * outer
        notes.append(f'the thread is broken, it ends {length:.4g} mm below the axle')
    # a ring as one closed line, with a seam at the right and the inside backwards
    edges = _circle(0.0, 0.0, outer), _circle(0.0, 0.0, inner)[:, ::-1]
    parts = [
        _area('wheel', np.concatenate(edges, axis=1), 'grey', 'wheel'),
        _path('', [(-inner, 0.0), (inner, 0.0)], 'grey', 'wheel'),
        _path('', [(0.0, inner), (0.0, -inner)], 'grey', 'wheel'),
        _area('cheeks', left, 'blue', 'wheel'),
        _area('', right, 'blue', 'wheel'),
        _path('thread', [(0.0, tip), (0.0, -depth)], 'orange'),
        _area('axle', _circle(0.0, 0.0, 0.04 * outer), 'grey', 'wheel'),
    ]
    if is_broken:
        carrier: Carrier = 'weight' if isinstance(thread, HangingThread) else 'case'
        middle, slant = -0.5 * (depth + outer), 0.06 * outer
        parts += [
            _path(name, [(-slant, at - slant), (slant, at + slant)], 'orange', carrier)
            for name, at in (('break', middle), ('', middle - slant))
        ]
    low, half_width = -depth, outer
    if isinstance(thread, LeverThread):
        lever = _lever(thread, low, 0.04 * outer, _box(0.0, 0.0, across, high))
        half_width = max(outer, *(float(np.abs(part.x).max()) for part in lever)) + 0.5 * across
        parts += lever
        assumed += ['length of the arc'] * (thread.arc is not None) + ['thickness of the lever']
        end = np.add(fulcrum_mm(thread), _along_lever(thread, thread.weight_arm))
        parts += [] if high else _power(pull, low + end[1], outer, float(end[0]))
    else:
        if isinstance(thread, HoleThread):
            width, anchor = 0.06 * outer, low - 0.4 * outer - 0.5 * high
            parts += [
                _path('hole', [(-0.5 * outer, low), (-width, low)], 'green'),
                _path('', [(width, low), (0.5 * outer, low)], 'green'),
                _path('', [(0.0, low), (0.0, anchor)], 'orange', 'weight'),
            ]
            low = anchor
            assumed.append('width of the hole')
        parts += _power(pull, low, outer)
    assumed += ['spring'] * bool(pull.stiffness)
    low, margin = min(float(part.y.min()) for part in parts), 0.15 * outer
    top, hung = 1.15 * outer, scene.suspension
    if hung is not None:
        axle = hung.axle_radius if isinstance(hung, AxleSuspension) else 0.0
        top = min(top, max(MM * (hung.depth - axle), 0.0))
        parts += _suspension(hung, top, outer)
        assumed.append('outside of the bearing' if hung.link else 'radius of the pivots')
    box = _box(0.0, 0.5 * (top + low - margin), 2.0 * (half_width + margin), top - low + margin)
    note = f'To scale. {"; ".join(notes)}. Assumed: {", ".join(assumed)}.'
    return MachineDrawing([_path('case', box.T, 'grey'), *parts], note, is_broken)


def fulcrum_mm(thread: LeverThread) -> tuple[float, float]:
    """Return the place of the fulcrum from the thread's end on the lever, at rest [mm]."""
    side = 1.0 if thread.fulcrum == 'starboard' else -1.0
    if thread.arc is not None:
        return -side * MM * thread.arc, 0.0
    across, up = _along_lever(thread, thread.pulled_at)
    return -across, -up


def _along_lever(thread: LeverThread, distance: float) -> tuple[float, float]:
    """Return the offset along the lever at rest [mm] for a distance [m] from the fulcrum."""
    side, start = 1.0 if thread.fulcrum == 'starboard' else -1.0, thread.inclination
    return side * MM * distance * math.cos(start), MM * distance * math.sin(start)


def _lever(thread: LeverThread, y: float, radius: float, weight: FloatArray) -> list[Outline]:
    """Return the lever at rest with its weights.

    `weight` is an outline about its middle, y the height of the thread's end.
    """
    side = 1.0 if thread.fulcrum == 'starboard' else -1.0
    fulcrum = np.add((0.0, y), fulcrum_mm(thread))

    def place(distance: float) -> FloatArray:
        return fulcrum + _along_lever(thread, distance)

    tail = 0.0 if thread.tail is None else -thread.tail.distance
    ends = place(tail), place(max(thread.weight_arm, thread.pulled_at))
    parts = [
        _path('lever', ends, 'green', 'lever'),
        _area('fulcrum', _circle(float(fulcrum[0]), float(fulcrum[1]), radius), 'green'),
    ]
    if np.ptp(weight[0]):
        hung = weight + place(thread.weight_arm)[:, None]
        parts.append(_area('weight', hung, 'orange', 'lever'))
    if thread.tail is not None:
        across, up = place(tail).tolist()
        small = _box(across, up, *weight_mm(thread.tail.mass))
        parts.append(_area('tail weight', small, 'orange', 'lever'))
    if thread.arc is not None:
        turned, arm = np.linspace(-0.5, 0.1, 31), MM * thread.arc
        arc = side * arm * (np.cos(turned) - 1.0), y + arm * np.sin(turned)
        parts.append(_path('arc', np.column_stack(arc), 'green', 'lever'))
    return parts


def _power(pull: Pull, end: float, outer: float, at: float = 0.0) -> list[Outline]:
    """Return the power at the end of a thread: a weight, a spring, or the arrow of a force.

    On a lever, `at` is its distance from the axle.
    """
    if not (pull.pulling_mass or pull.stiffness):
        tail, head = end - 0.6 * outer, 0.08 * outer
        arrow = [(0.0, end), (0.0, tail), (-head, tail + head), (0.0, tail), (head, tail + head)]
        arrow = [(at + x, y) for x, y in arrow]
        return [_path('pull', arrow, 'orange', 'weight')]
    parts = []
    if pull.pulling_mass:
        across, high = weight_mm(pull.pulling_mass)
        parts.append(_area('weight', _box(0.0, end, across, high), 'orange', 'weight'))
        end -= 0.5 * high
    if pull.stiffness:
        turns, half, height = 8, 0.12 * outer, 0.7 * outer
        coil = [(half if k % 2 else -half, end - height * (k + 0.5) / turns) for k in range(turns)]
        coil = [(at + x, y) for x, y in [(0.0, end), *coil, (0.0, end - height)]]
        parts.append(_path('spring', coil, 'green', 'spring'))
    return parts


def _in_fluid(regulator: FluidTautochroneRegulator, curve: DescentCurve) -> MachineDrawing:
    """Return the curve, and the body at the lowest point and at the release."""
    level, height = (MM * line for line in fluid_outline(curve))
    up, across = (MM * float(size) for size in coordinates(curve, regulator.release_arc))
    size = MM * regulator.diameter
    if regulator.body == 'globe':
        body, assumed = _circle(0.0, 0.0, 0.5 * size), ''
        released = _circle(across, up, 0.5 * size)
    else:
        body, assumed = _box(0.0, 0.0, size, size), ' Assumed: the cylinder is as wide as high.'
        sine = float(curve.slope(regulator.release_arc))
        cosine = math.sqrt(max(1.0 - sine * sine, 0.0))
        released = np.array([[cosine, -sine], [sine, cosine]]) @ body
        released += np.array([[across], [up]])
    if regulator.of is None:
        curves = [Outline('curve', level, height, 'blue', moves_with='ship')]
    else:
        mine = f'{regulator.of.kind}, the given branch', 'blue'
        names = [('its companion', 'green'), mine]
        if regulator.given == 'ascent':
            names.reverse()
        lowest = len(level) // 2
        curves = [
            Outline(name, level[branch], height[branch], cast(Colour, colour), moves_with='ship')
            for (name, colour), branch in zip(
                names, (slice(0, lowest + 1), slice(lowest, None)), strict=True
            )
        ]
    return MachineDrawing(
        [
            *curves,
            _path('at the release', released.T, 'grey', 'ship'),
            _area(f'{regulator.body} at rest', body, 'orange', 'body'),
        ],
        f'To scale. The centre of the {regulator.body} moves on the curve.{assumed}',
    )


def _on_axle(machine: AxleClock, support: str) -> MachineDrawing:
    """Return the support, the axle or rockers on it, and the body at rest and at the start."""
    depth, bent, k = machine.body.depth, machine.body.curvature, machine.body.gyration_radius
    axle = machine.radius or 0.04 * (depth + k)
    half_width = 1.3 * (k + axle)
    if bent == 0.0:
        across = np.linspace(-half_width, half_width, 121)
        level = np.full_like(across, -axle)
    else:
        # an arc about O of radius 1/bent plus the axle's radius
        radius = 1.0 / bent + axle
        across = np.linspace(-1.0, 1.0, 121) * min(half_width, 0.95 * abs(radius))
        root = math.copysign(1.0, radius) * np.sqrt(radius * radius - across**2)
        level = -axle + across**2 / (radius + root)
    turned = bent * machine.arc
    chord = machine.arc * float(np.sinc(0.5 * turned / np.pi))
    place = chord * math.cos(0.5 * turned), chord * math.sin(0.5 * turned)

    def body(x: float, y: float, tilt: float) -> tuple[FloatArray, FloatArray]:
        """Return the ring about the centre of gravity, and the line to it."""
        centre = x + depth * math.sin(tilt), y - depth * math.cos(tilt)
        stem = np.array([[x, centre[0]], [y, centre[1]]])
        return MM * _circle(centre[0], centre[1], k), MM * stem

    (upright, stem), (start, leant) = body(0.0, 0.0, 0.0), body(*place, machine.tilt)
    return MachineDrawing(
        [
            Outline('support', MM * across, MM * level, 'green', moves_with='ship'),
            Outline('at the start', start[0], start[1], 'grey', moves_with='ship'),
            Outline('', leant[0], leant[1], 'grey', moves_with='ship'),
            _area(
                'rockers' if support == 'cradle' else 'axle', MM * _circle(0.0, 0.0, axle), 'blue'
            ),
            _path('', stem.T.tolist(), 'orange', 'wheel'),
            Outline('body at rest', upright[0], upright[1], 'orange', moves_with='wheel'),
        ],
        'To scale. The body is drawn as a ring of its radius of gyration about its centre of '
        'gravity.' + (' Assumed: radius of the axle.' if machine.radius == 0.0 else ''),
    )


def _below_axle(scene: Scene, tip: float) -> float | None:
    """Return the depth of the thread's end below the axle [mm], if the scene gives it."""
    assert scene.trochlea is not None
    thread = scene.trochlea.thread
    if isinstance(thread, HoleThread):
        return MM * float(thread.distance)
    if isinstance(thread, HangingThread | LeverThread):
        return MM * float(thread.length) - tip
    return None


def _suspension(hung: SuspensionKind, top: float, outer: float) -> list[Outline]:
    """Return the axle of the case, its link to the case, and the hollow bearing in the ship."""
    if not isinstance(hung, AxleSuspension):
        pivots = _circle(0.0, MM * hung.depth, 0.05 * outer)
        stem = _path('', [(0.0, top), (0.0, MM * hung.depth)], 'grey')
        return [stem, _area('pivots of the case', pivots, 'blue')]
    radius, axle = MM * hung.support_radius, MM * hung.axle_radius
    bottom = MM * hung.depth - axle
    edge = min(0.85 * radius, 6.0 * axle)
    x = np.linspace(-edge, edge, 41)
    y = bottom + x * x / (radius + np.sqrt(radius * radius - x * x))
    under = bottom - axle
    outline = np.array([[*x, edge, -edge, -edge], [*y, under, under, float(y[0])]])
    return [
        _area('bearing', outline, 'green', 'ship'),
        _path('', [(0.0, top), (0.0, bottom + axle)], 'grey'),
        _area('axle of the case', _circle(0.0, bottom + axle, axle), 'blue'),
    ]


def _cheeks(scene: Scene) -> tuple[FloatArray, FloatArray, float]:
    """Return the closed outlines of both cheeks, (2, n) [mm], and the height of their tip."""
    if scene.trochlea is None:
        raise UsageError(f'cam: {scene.name} has no trochlea, and so no cam. Draw machine')
    cheeks = both_cheeks(cam_shape(scene)[0], cam_extent(scene), 200)
    right, left = (MM * np.array([side.x, -side.y]) for side in cheeks)
    tip = float(right[1, 0])
    closed = [np.column_stack((side, [[0.0], [0.0]], side[:, :1])) for side in (left, right)]
    return closed[0], closed[1], tip


def _circle(x: float, y: float, radius: float) -> FloatArray:
    return np.array([x + radius * np.cos(_CIRCLE), y + radius * np.sin(_CIRCLE)])


def _box(x: float, y: float, width: float, height: float) -> FloatArray:
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5)]).T
    outline: FloatArray = np.array([[x], [y]]) + corners * np.array([[width], [height]])
    return outline


def _area(name: str, outline: FloatArray, colour: str, carrier: Carrier = 'case') -> Outline:
    return Outline(name, outline[0], outline[1], colour, 'area', moves_with=carrier)  # type: ignore[arg-type]


def _path(name: str, points: object, colour: str, carrier: Carrier = 'case') -> Outline:
    x, y = np.asarray(points, float).T
    return Outline(name, x, y, colour, moves_with=carrier)  # type: ignore[arg-type]
