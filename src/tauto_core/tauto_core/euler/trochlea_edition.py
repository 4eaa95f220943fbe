"""Paper A for its page: every paragraph, and its eleven figures constructed from the text.

Where the text leaves a curve open, the figures take the curve that it finds in the end: the
involute of §XIV, the curve of §XXIX. Points of the wheel's frame have y along the thread at rest,
as in `curves.cam`; the drawings have it downwards.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves import Hole, Involute
from tauto_core.curves.cam import Cam
from tauto_core.curves.drawing import outline
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.euler.edition import (
    Control,
    Drawing,
    Edition,
    EulerFigure,
    Paragraph,
    Shown,
    turned,
)
from tauto_core.euler.trochlea_1727 import period
from tauto_core.samples import FloatArray

_TURNS = Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(21)), begin=9)
_UNIT = Involute(1.0)
_CIRCLE = np.linspace(0.0, math.tau, 121)


def _hung(
    points: tuple[ArrayLike, ArrayLike], angle: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return points of the wheel's frame in the drawing, the wheel turned by an angle."""
    x, y = turned(points, -angle)
    return x, -y


def _at(points: tuple[ArrayLike, ArrayLike], angle: float = 0.0) -> tuple[float, float]:
    """Return one point of the wheel's frame in the drawing."""
    x, y = _hung(points, angle)
    return float(x), float(y)


def _weight(drawing: Drawing, hook: tuple[float, float], radius: float) -> tuple[float, float]:
    centre = hook[0], hook[1] - radius
    drawing.circle(centre, radius, 'solid')
    return centre


def _cheeks(drawing: Drawing, cam: Cam, angle: float, reach: float) -> None:
    drawing.curve(*_hung(outline(cam, 60, reach), angle), 'curve')


# -----------------------------------------------------------------------------
# Figures I to IV: the wheel, its balance, Sully's machine, the force.


def _figure_i(turn: float) -> Shown:
    # an arc of a circle through C, tangent to the thread at rest
    bend = 2.2
    along = np.linspace(0.0, 1.65, 60)
    drawing = Drawing(-3.2, 3.7, -4.4, 3.1, 260.0)
    drawing.circle((0.0, 0.0), 2.9, 'faint')
    ends = []
    for side in (-1.0, 1.0):
        cheek = side * bend * (1.0 - np.cos(along)), bend * np.sin(along)
        x, y = _hung(cheek, turn)
        drawing.curve(x, y, 'curve')
        ends.append((float(x[-1]), float(y[-1])))
    for name, end in zip('EF', ends, strict=True):
        drawing.letter(end, name)
    arm = bend * (1.0 - math.cos(turn))
    touch = _at((-bend * (1.0 - math.cos(turn)), bend * math.sin(turn)), turn)
    drawing.line(touch, (touch[0], -3.7), look='thread')
    drawing.letter((0.0, 0.0), 'C', -12.0, 5.0)
    if turn:
        drawing.letter(touch, 'M', 8.0, -4.0)
    drawing.note(_weight(drawing, (touch[0], -3.7), 0.3), 'P', 20.0, -3.0, 'letter')
    return Shown(
        drawing,
        f'The weight pulls at {arm / bend:.3f} of the radius of the arc from C, and turns the '
        'wheel back.' if turn else 'At rest the thread touches neither cheek.',
    )  # fmt: skip


def _figure_ii(turn: float) -> Shown:
    drawing = Drawing(-3.2, 3.2, -3.2, 3.2, 220.0)
    drawing.circle((0.0, 0.0), 2.9, 'ink')
    _cheeks(drawing, _UNIT, turn, 2.0)
    counter = _at((0.0, -2.2), turn)
    drawing.circle(counter, 0.32, 'solid')
    drawing.note(counter, 'counterweight', 0.0, 12.0)
    drawing.letter((0.0, 0.0), 'C', 9.0, 6.0)
    return Shown(drawing, 'The centre of gravity of wheel and cheeks is C: it rests at any turn.')


def _figure_iii(turn: float) -> Shown:
    shape = LeverGeometry(0.02, 0.1, 0.3)
    r, fulcrum = shape.base_radius, (-shape.arm, -shape.depth)
    pose = shape.pose(shape.tau_of(np.array([turn])))
    u, beta, delta, free = (float(part[0]) for part in pose)
    along = np.array([math.sin(delta), -math.cos(delta)])
    touch = r * u * np.array([math.cos(delta), math.sin(delta)]) + r * along
    tied, end = touch + free * along, fulcrum + 0.15 * np.array([math.cos(beta), math.sin(beta)])
    drawing = Drawing(-0.13, 0.1, -0.37, 0.07, 230.0)
    _cheeks(drawing, Involute(r), turn, 2.6)
    drawing.circle((0.0, 0.0), 0.062, 'faint')
    drawing.line(touch, tied, look='thread')
    drawing.line(fulcrum, end, look='heavy')
    drawing.circle(end, 0.011, 'solid')
    drawing.letter((0.0, 0.0), 'C', -12.0, 5.0)
    drawing.letter(fulcrum, 'A', -12.0, 2.0)
    drawing.letter(tied, 'B', -10.0, 9.0)
    drawing.note(end, 'D', 2.0, 15.0, 'letter')
    drawing.note(end, 'P', 2.0, -22.0, 'letter')
    return Shown(
        drawing,
        f'D has risen by {150.0 * math.sin(beta):.1f} mm, and the thread leans by '
        f'{abs(math.degrees(delta)):.2f}°.',
    )


def _figure_iv(turn: float) -> Shown:
    arm, rim = float(_UNIT.lever_arm(turn)), 2.6
    touch = _at(_UNIT.contact(turn), turn) if turn else (0.0, -1.0)
    drawing = Drawing(-3.0, 3.0, -4.3, 2.9, 280.0)
    drawing.circle((0.0, 0.0), rim, 'faint')
    _cheeks(drawing, _UNIT, turn, 2.3)
    drawing.line((0.0, 0.0), (0.0, -rim))
    drawing.line(touch, (arm, -4.2), look='thread')
    drawing.line((0.0, 0.0), (arm, 0.0), look='thin')
    drawing.line((arm, 0.0), touch, look='thin')
    outer = _at((0.0, rim), turn)
    drawing.line((0.0, 0.0), outer)
    drawing.letter((0.0, 0.0), 'C', -10.0, 6.0)
    drawing.letter((0.0, -rim), 'B', -9.0, -8.0)
    drawing.letter((arm, -4.0), 'R', 10.0, 0.0)
    if turn:
        drawing.letter(outer, 'O', 10.0, -4.0)
        drawing.line((0.0, touch[1]), touch)
        drawing.letter((0.0, touch[1]), 'T', -9.0, -2.0)
        drawing.letter(touch, 'M', 10.0, -5.0)
        drawing.letter((arm, 0.0), 'N', 6.0, 7.0)
    return Shown(
        drawing,
        f'TM = {arm:.3f} CT at the angle BCO = {turn:.1f}: the force at O, in units of P, is '
        f'TM/CO = {arm / rim:.4f}.',
    )


# -----------------------------------------------------------------------------
# Figures V to VIII: the curve, its construction, the time of a swing, the larger disc.


def _figure_v(step: float) -> Shown:
    z = 1.5

    def lettered(roll: float) -> tuple[FloatArray, FloatArray]:
        """Return M and T of a roll angle."""
        foot = np.array([math.sin(roll), math.cos(roll)])
        return foot + roll * np.array([-math.cos(roll), math.sin(roll)]), foot

    # the drawing's y is the wheel's, downwards: B below, the curve to its right
    points = [lettered(each) for each in np.linspace(0.0, 2.4, 60)]
    curve = np.array([each[0] for each in points]).T
    (m_point, t_point), (near, near_foot) = lettered(z), lettered(z + step)
    # the normals meet in R
    first, second = m_point - t_point, near - near_foot
    across = np.column_stack([first, -second])
    share = float(np.linalg.solve(across, near_foot - t_point)[0])
    centre = t_point + share * first
    # p lies on the first normal, on the perpendicular Ct of the second
    foot = near_foot / np.linalg.norm(near_foot)
    crossing = t_point + first * float(
        (-t_point[0] * foot[1] + t_point[1] * foot[0]) / (first[0] * foot[1] - first[1] * foot[0])
    )
    drawing = Drawing(-2.15, 1.7, -2.7, 1.15, 330.0)
    down = np.array([1.0, -1.0])
    drawing.circle((0.0, 0.0), 1.0, 'faint')
    drawing.curve(curve[0], -curve[1], 'curve')
    origin = np.zeros(2)
    for end in (m_point, near):
        drawing.line(origin, end * down, look='thin')
    drawing.line(m_point * down, crossing * down)
    drawing.line(near * down, near_foot * down)
    for end in (t_point, near_foot):
        drawing.line(origin, end * down)
    polar = [math.atan2(-each[1], each[0]) for each in (m_point, near)]
    size = float(np.hypot(*m_point))
    drawing.arc((0.0, 0.0), size, polar[0], polar[1], 'other')
    ray = near / np.hypot(*near)
    for place, name, right, up in (
        (origin, 'C', 0.0, 9.0),
        (np.array([0.0, 1.0]), 'B', 8.0, -9.0),
        (m_point, 'M', -10.0, -8.0),
        (near, 'm', -11.0, -4.0),
        (t_point, 'T', 11.0, 2.0),
        (near_foot, 't', 10.0, 8.0),
        (m_point / size, 'S', 9.0, 5.0),
        (ray, 's', -6.0, 9.0),
        (ray * size, 'r', -11.0, 5.0),
        (centre, 'R', 12.0, -8.0),
        (crossing, 'p', 12.0, 12.0),
    ):
        drawing.letter(place * down, name, right, up)
    off = float(np.linalg.norm(centre - t_point))
    return Shown(
        drawing,
        f'R is {off:.3f} from T, for m at {step:.2f} rad from M. As m comes to M, R, p and t run '
        'into T, for CT has no increment.',
    )


STEP = 0.1


def _figure_vi(z: float) -> Shown:
    n_angle, s_angle = math.atan(z), z - math.atan(z)
    drawing = Drawing(-3.3, 3.3, -2.0, 1.3)
    drawing.circle((0.0, 0.0), 1.0, 'ink')

    def ray(angle: float) -> FloatArray:
        """Return the direction at an angle from CB, counterclockwise."""
        return np.array([math.sin(angle), -math.cos(angle)])

    p_point = np.array([-z, -1.0])
    size = math.hypot(1.0, z)
    drawing.line(ray(0.0), p_point)
    drawing.line(np.zeros(2), p_point)
    drawing.line(np.zeros(2), size * ray(s_angle))
    drawing.arc((0.0, 0.0), size, -0.5 * math.pi - n_angle, -0.5 * math.pi + s_angle, 'faint')
    drawing.line(ray(z), size * ray(s_angle), look='thread')
    # the points found up to here, and the involute that the code draws
    for each in np.arange(STEP, z - 0.5 * STEP, STEP):
        drawing.circle(math.hypot(1.0, each) * ray(each - math.atan(each)), 0.03, 'dot')
    rolls = np.linspace(0.0, z, 60)
    x, y = _hung(_UNIT.contact(rolls))
    drawing.curve(np.abs(x), y, 'curve')
    drawing.arc((0.0, 0.0), 1.0, -0.5 * math.pi, -0.5 * math.pi + s_angle, 'heavy')
    for place, name, right, up in (
        (np.zeros(2), 'C', -9.0, 7.0),
        (ray(0.0), 'B', 2.0, -13.0),
        (p_point, 'P', -4.0, -13.0),
        (ray(-n_angle), 'N', -10.0, 6.0),
        (ray(s_angle), 'S', -9.0, 8.0),
        (size * ray(s_angle), 'M', 10.0, -3.0),
        (ray(z), 'T', -4.0, 10.0),
    ):
        drawing.letter(place, name, right, up)
    found = math.hypot(*_at(_UNIT.contact(z)))
    return Shown(
        drawing,
        f'BP = z = {z:.1f}, BN = arctan z = {n_angle:.5f}, BS = BP − BN = {s_angle:.5f}, CM = CP '
        f'= {size:.5f}. The cheek that Tauto cuts is there at {found:.5f} from C, and TM = '
        f'{z:.1f}.',
    )


def _figure_vii(turn: float) -> Shown:
    fall = 0.35
    drawing = Drawing(-1.7, 5.3, -3.4, 1.5)
    drawing.circle((0.0, 0.0), 1.0, 'ink')
    for each, look in ((turn, 'curve'), (turn - fall, 'other')):
        x, y = _hung(_UNIT.contact(np.linspace(0.0, 2.4, 60)), each)
        drawing.curve(x, y, look)
    place, near = np.array([turn, -1.0]), np.array([turn - fall, -1.0])
    # μ: the point of the first position that becomes m
    homologous = np.array(_at(_UNIT.contact(turn - fall), turn))
    end = np.array([turn, -2.6])
    lift = 0.5 * (turn**2 - (turn - fall) ** 2)
    near_end = np.array([turn - fall, -2.6 - lift])
    drawing.line(place, end, look='thread')
    drawing.line(near, near_end, look='thread')
    drawing.line(np.array([0.0, -1.0]), place, look='thin')
    drawing.line(near_end, np.array([turn, near_end[1]]), look='faint')
    drawing.line(end, np.array([turn, near_end[1]]), look='faint')
    drawing.line(end, near_end, look='faint')
    first, second = (np.array(_at((0.0, 1.0), each)) for each in (turn, turn - fall))
    for foot in (first, second):
        drawing.line(np.zeros(2), foot, look='thin')
    for point in (place, near):
        drawing.line(np.zeros(2), point, look='thin')
    for point, name, right, up in (
        (np.zeros(2), 'C', -8.0, 7.0),
        (np.array([0.0, -1.0]), 'B', -9.0, -7.0),
        (first, 'S', 8.0, 7.0),
        (second, 's', 9.0, -1.0),
        (place, 'M', 9.0, -2.0),
        (near, 'm', -2.0, -12.0),
        (homologous, 'μ', 9.0, 5.0),
        (end, 'Q', 10.0, 0.0),
        (near_end, 'q', -9.0, -5.0),
        (np.array([turn, near_end[1]]), 'n', 9.0, -5.0),
    ):
        drawing.letter(point, name, right, up)
    _cycloid(drawing, turn, fall)
    return Shown(
        drawing,
        f'BS = BM = {turn:.1f}, Qn = {lift:.4f} while Ss = {fall}: Qn/Ss is {lift / fall:.4f}, '
        f'the mean of BM/BC and Bm/BC, {turn:.1f} and {turn - fall:.2f}.',
    )


def _cycloid(drawing: Drawing, arc: float, step: float) -> None:
    """Draw the cycloid NA of the pendulum AO beside the wheel, with arcs like the wheel's."""
    length, foot = 3.2, np.array([3.6, -2.6])

    def place(s: float | FloatArray) -> FloatArray:
        # arc s = 4R sin(τ/2) of the circle R = length/4 that rolls by τ
        roll = 2.0 * np.arcsin(np.asarray(s) / length)
        radius = 0.25 * length
        return np.array(
            [foot[0] - radius * (roll + np.sin(roll)), foot[1] + radius * (1.0 - np.cos(roll))]
        )

    x, y = place(np.linspace(-1.9, 2.2, 60))
    drawing.curve(x, y, 'curve')
    begin, end = place(arc), place(arc - step)
    top = foot + np.array([0.0, length])
    drawing.line(foot, top, look='thin')
    drawing.line(begin, np.array([begin[0], end[1]]), look='thread')
    drawing.line(np.array([begin[0], end[1]]), end, look='faint')
    for point, name, right, up in (
        (top, 'O', 9.0, 0.0),
        (foot, 'A', 0.0, -13.0),
        (begin, 'N', -9.0, 5.0),
        (end, 'n', 2.0, 9.0),
        (np.array([begin[0], end[1]]), 't', -9.0, -5.0),
    ):
        drawing.letter(point, name, right, up)


def _figure_viii(ratio: float) -> Shown:
    drawing = Drawing(-5.8, 5.8, -6.6, 5.4, 290.0)
    drawing.circle((0.0, 0.0), ratio, 'ink')
    drawing.circle((0.0, 0.0), 1.0, 'faint')
    _cheeks(drawing, _UNIT, 0.0, 1.2)
    drawing.line((0.0, -1.0), (0.0, -5.7), look='thread')
    drawing.note(_weight(drawing, (0.0, -5.7), 0.35), 'P', 20.0, -3.0, 'letter')
    for point, name, right, up in (
        ((0.0, 0.0), 'C', -9.0, 6.0),
        ((-ratio, 0.0), 'E', -9.0, 6.0),
        ((ratio, 0.0), 'D', 10.0, 6.0),
        ((0.0, -1.0), 'B', 9.0, -7.0),
        ((0.0, 1.0), 'F', 8.0, 7.0),
    ):
        drawing.letter(point, name, right, up)
    # a disc of the same thickness has a⁴ times the inertia
    weight = 100.0 * ratio**2
    loss = (
        period(1.0, weight, 1.0, inertia=_inertia(weight, ratio), carried=1.0 / 9.81)
        / period(1e-3, weight, 1.0, inertia=_inertia(weight, ratio), carried=1.0 / 9.81)
        - 1.0
    )
    return Shown(
        drawing,
        f'CD = a = {ratio:g} BC: the pendulum is a⁴ = {ratio**4:.4g} times as long. The inertia '
        f'of a weight of a hundredth of the small disc costs {86400.0 * loss / (1 + loss):.3g} '
        'seconds a day at 1 rad.',
    )


def _inertia(weight: float, ratio: float) -> float:
    # of a uniform disc; the base radius of the claims is 20 mm
    return 0.5 * weight / 9.81 * (0.02 * ratio) ** 2


# -----------------------------------------------------------------------------
# Figures IX to XI: the thread through a hole.


def _through_hole(cam: Hole, angle: float) -> dict[str, FloatArray]:
    """Return Euler's points of an angle in the wheel's frame, b = 1."""
    a, arm = cam.hole_distance, float(cam.lever_arm(angle))
    psi = angle + math.asin(arm / a)
    normal = np.array([math.cos(psi), math.sin(psi)])
    line = np.array([-normal[1], normal[0]])
    touch = np.array([float(each) for each in cam.contact(angle)])
    return {
        'M': touch,
        'N': arm * normal,
        'P': touch - arm * normal,
        'O': a * np.array([-math.sin(angle), math.cos(angle)]),
        'normal': normal,
        'line': line,
    }


def _figure_ix(ratio: float, angle: float) -> Shown:
    cam = Hole(1.0, ratio)
    at = _through_hole(cam, angle)
    reach = min(2.0, 0.97 * cam.range_rad)
    drawing = Drawing(-2.3, 2.3, -3.2, 1.4, 320.0)
    _cheeks(drawing, cam, angle, reach)
    places = {name: np.array(_at((at[name][0], at[name][1]), angle)) for name in 'MNPO'}
    hole = places['O']
    drawing.line(places['M'], hole, look='thread')
    drawing.line(np.zeros(2), places['P'])
    drawing.line(places['P'], places['M'])
    drawing.line(np.zeros(2), places['M'], look='thin')
    drawing.line(np.zeros(2), hole, look='faint')
    tip: FloatArray = np.array(_at(cam.contact(0.0), angle))
    for place, name, right, up in (
        (np.zeros(2), 'C', -9.0, 7.0),
        (tip, 'B', 8.0, 7.0),
        (places['M'], 'M', 10.0, 4.0),
        (places['P'], 'P', -9.0, -6.0),
    ):
        drawing.letter(place, name, right, up)
    if ratio > 3.0:
        drawing.note((0.0, -3.05), 'A is below', -40.0, 0.0)
    else:
        drawing.letter(hole, 'A', -10.0, 0.0)
    arm = float(cam.lever_arm(angle))
    free = math.sqrt(ratio**2 - arm**2)
    p = float(np.linalg.norm(places['P']))
    return Shown(
        drawing,
        f'a = {ratio:g} b, t = PM = {arm:.3f} b: p = CP = {p:.5f} b in the figure, '
        f'{free / (1.0 + free):.5f} b by the equation.',
    )


def _figure_x(angle: float) -> Shown:
    cam = Hole(1.0, 2.0)
    at = _through_hole(cam, angle)
    places = {name: np.array(_at((at[name][0], at[name][1]), angle)) for name in 'MNPO'}
    drawing = Drawing(-2.3, 2.3, -3.0, 1.7, 320.0)
    _cheeks(drawing, cam, angle, 1.7)
    drawing.line(places['N'], places['M'], look='thin')
    drawing.line(places['M'], places['O'], np.array([0.0, -3.0]), look='thread')
    for side in (-1.0, 1.0):
        drawing.line((0.08 * side, -2.0), (0.6 * side, -2.0), look='heavy')
    drawing.line(np.zeros(2), places['N'])
    drawing.line(np.zeros(2), places['P'], places['M'])
    rest = np.array(_at((0.0, 2.0), angle))
    drawing.line(np.zeros(2), rest, look='faint')
    drawing.line(np.zeros(2), places['O'], look='faint')
    for place, name, right, up in (
        (np.zeros(2), 'C', -9.0, 7.0),
        (places['O'], 'O', -11.0, 6.0),
        (rest, 'B', 9.0, -6.0),
        *(((places['M'], 'M', 10.0, 4.0), (places['N'], 'N', 9.0, 7.0),
           (places['P'], 'P', -9.0, -6.0)) if angle else ()),
    ):  # fmt: skip
        drawing.letter(place, name, right, up)
    arm = float(np.linalg.norm(places['N']))
    return Shown(
        drawing,
        f'CN = MP = {arm:.4f} b at the angle BCO = {angle:.1f}: both are proportional.',
    )


def _figure_xi(step: float) -> Shown:
    cam, angle = Hole(1.0, 2.0), 0.9
    first, second = _through_hole(cam, angle), _through_hole(cam, angle + step)
    meet = np.linalg.solve(
        np.column_stack([first['normal'], -second['normal']]), second['P'] - first['P']
    )
    centre = first['P'] + float(meet[0]) * first['normal']
    # t: on the first normal, on the line Cp
    cross = np.linalg.solve(np.column_stack([first['normal'], -second['line']]), -first['P'])
    element = first['P'] + float(cross[0]) * first['normal']
    foot = second['M'] + second['line'] * float((first['O'] - second['M']) @ second['line'])
    drawing = Drawing(-2.5, 1.7, -2.4, 1.35, 360.0)
    down = np.array([1.0, -1.0])
    drawing.arc((0.0, 0.0), 2.0, -0.5 * math.pi - 1.5, -0.5 * math.pi + 0.15, 'faint')
    x, y = _hung(cam.contact(np.linspace(0.0, 1.75, 60)))
    drawing.curve(x, y, 'curve')
    origin, rest = np.zeros(2), np.array([0.0, 2.0])
    drawing.line(origin, rest * down)
    for at in (first, second):
        drawing.line(at['N'] * down, at['O'] * down, look='thread')
        drawing.line(at['M'] * down, at['P'] * down)
        drawing.line(origin, at['O'] * down, look='thin')
    drawing.line(origin, element * down, look='thin')
    drawing.line(origin, first['P'] * down, look='thin')
    drawing.line(origin, first['N'] * down, look='thin')
    drawing.line(first['O'] * down, foot * down, look='other')
    drawing.line(first['P'] * down, centre * down, look='faint')
    for place, name, right, up in (
        (origin, 'C', 8.0, 7.0),
        (rest, 'B', 9.0, 0.0),
        (first['M'], 'M', -4.0, -13.0),
        (second['M'], 'm', 9.0, 5.0),
        (first['O'], 'O', 4.0, -12.0),
        (second['O'], 'o', -10.0, -3.0),
        (first['P'], 'P', -11.0, -5.0),
        (second['P'], 'p', -9.0, 8.0),
        (element, 't', 9.0, -6.0),
        (first['N'], 'S', 9.0, 3.0),
        (foot, 'n', -2.0, 11.0),
        (centre, 'R', -10.0, 8.0),
    ):
        drawing.letter(place * down, name, right, up)
    turn = step / math.acos(np.clip(float(first['normal'] @ second['normal']), -1.0, 1.0))
    p = float(np.linalg.norm(first['P']))
    return Shown(
        drawing,
        f'OCo : PCt = {turn:.4f}, CP : b = {p:.4f}, for o at {step:.2f} rad from O; they agree as '
        'o comes to O.',
    )


_STEPS = Control('m from M, rad', (0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02), begin=1)
FIGURES = (
    EulerFigure(
        'I',
        'The wheel at *C* with the cheeks *CE* and *CF*, between them the thread with the weight'
        ' *P*; *M* is the contact. The text gives the cheeks no shape: here each is an arc of a '
        'circle.',
        _figure_i,
        (Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(17)), begin=9),),
    ),
    EulerFigure(
        'II',
        'The balanced wheel. The text cites the figure and names no letter of it but *C*; the '
        'counterweight is an example.',
        _figure_ii,
        (_TURNS,),
    ),
    EulerFigure(
        'III',
        "Sully's machine as Euler reports it: the thread is tied at *B* to the lever *AD*, on "
        'which the weight *P* stands at *D*. That the lever is level at rest, with *B* under '
        '*C*, is assumed.',
        _figure_iii,
        (_TURNS,),
    ),
    EulerFigure(
        'IV',
        'The turned wheel: *CB* is vertical, *CO* the line of the wheel that was vertical, *MR* '
        'the thread, *MT* the lever arm, *CN = MT*.',
        _figure_iv,
        (_TURNS,),
    ),
    EulerFigure(
        'V',
        'Two neighbouring points *M* and *m*, their normals *MT* and *mt*, which meet in *R*, '
        'and the perpendiculars *CT* and *Ct*. *S* and *s* lie on the circle *CB*, *r* on the '
        'arc *Mr* about *C*.',
        _figure_v,
        (_STEPS,),
    ),
    EulerFigure(
        'VI',
        'The recipe. Take *BP = z* on the tangent, draw *CP* through the circle at *N*, take the'
        ' arc *BS = BP − BN*, and *CM = CP* on the ray *CS*. Dots: the points found before.',
        _figure_vi,
        (Control('z', tuple(round(STEP * k, 1) for k in range(1, 31)), begin=11),),
    ),
    EulerFigure(
        'VII',
        'The wheel falls from *S* to *s*, the power from *Q* to *q*; *μ* is the point of the '
        'curve that becomes *m*. Beside it the cycloid *NA* of the pendulum *AO*.',
        _figure_vii,
        (Control('BS, rad', tuple(round(0.7 + 0.1 * k, 1) for k in range(10)), begin=5),),
    ),
    EulerFigure(
        'VIII',
        'The disc *ED* larger than the circle *BF* of the cheeks.',
        _figure_viii,
        (Control('a = CD/BC', (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0), begin=4),),
    ),
    EulerFigure(
        'IX',
        'The second cam: *A* is the hole, *AC = a*, *CM = y*, *PM = t* normal to the curve, *CP '
        '= p*. The text gives *b* as the constant at choice: the lever arm is *t = b* times the '
        'turn.',
        _figure_ix,
        (
            Control('a/b', (1.2, 1.5, 1.8, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0), begin=3),
            Control('turn, rad', (0.1, 0.3, 0.5, 0.7, 0.9, 1.0), begin=4),
        ),
    ),
    EulerFigure(
        'X',
        'The machine with its fixed hole *O*, *a = 2b*. *CN* is perpendicular to *OM*, *MP = '
        'CN*. *CB* of the wheel was at *CO*.',
        _figure_x,
        (Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(16)), begin=9),),
    ),
    EulerFigure(
        'XI',
        "The same in the wheel's frame, where the hole moves on a circle about *C* from *O* to "
        '*o*. The perpendiculars *CP* and *Cp*, *S* under *C* on the thread, *On* on *mo*, *R* '
        'where the normals meet.',
        _figure_xi,
        (Control('o from O, rad', (0.4, 0.3, 0.2, 0.1, 0.05, 0.02), begin=0),),
    ),
)  # fmt: skip


# -----------------------------------------------------------------------------
# The paragraphs.

_PARAGRAPHS = (
    Paragraph(
        'I',
        'Sully has described a clock for the sea, in which a wheel swings under a weight, and '
        'found the shape of its cheeks only roughly, by trial. Euler sets out to find the curve '
        'that makes all swings equal, and other ways to the same end.',
        (
            'tauto isochronism clock_cheek_weight --amplitudes 0.5,1,1.5',
            'tauto sail cheek_before_euler',
        ),
        lacks='The text gives the first cheeks no shape. The scenes take an arc of a circle.',
    ),
    Paragraph(
        'II',
        'Two curved plates start from the centre of the wheel, and a loaded thread hangs between '
        'them. When the wheel turns, the thread lies against one of them and the weight turns the '
        'wheel back.',
        (
            'tauto isochronism clock_cheek_weight --amplitudes 0.1,0.5,1 --set '
            'trochlea.cam.root_depth=0',
            'tauto plot cheek_before_euler machine --set trochlea.cam.root_depth=0',
        ),
        ('I',),
        found='An arc of a circle that is rooted in the axle pulls as the square of the angle. '
        'The time of a swing then goes as the inverse root of its size, and the smallest swings '
        'have none.',
    ),
    Paragraph(
        'III',
        'Whether swings of all sizes take the same time depends on the curve of the plates alone. '
        'To keep the calculation short, the wheel is taken to rest in any position, with its '
        'centre of gravity on the axle.',
        (
            'tauto isochronism clock_involute_weight --amplitudes 0.5,1 --set '
            'trochlea.imbalance.moment=1e-5',
        ),
        ('II',),
    ),
    Paragraph(
        'IV',
        'One must ask whether the thread stays vertical, keeps another direction, or neither. One '
        'must also ask whether the power has inertia, like a weight, or none, like a spring; a '
        'weight spends a part of its force on its motion.',
        (
            'tauto scene new --thread hanging --power weight',
            'tauto isochronism clock_involute_weight --amplitudes 1 --set '
            'trochlea.power.massless=true',
        ),
    ),
    Paragraph(
        'V',
        'The power may be constant, or change with its stroke like a spring, a stretched chord or '
        "air. Sully's machine has every difficulty at once: the thread pulls a lever, leans, and "
        'carries the inertia of the weight.',
        (
            'tauto isochronism sully_lever_at_sea --amplitudes 0.5,1,1.5',
            'tauto isochronism clock_own_cam_spring --amplitudes 0.5,1,1.5',
            'tauto sail condensed_air_at_sea',
            'tauto sail stretched_chord_at_sea',
            'tauto sail sully_lever_at_sea',
            "tauto isochronism sully_lever_at_sea --amplitudes 0.5,1,1.5 --set 'trochlea.power={"
            "kind: spring, force: 0.5, stiffness: 5}' --set trochlea.thread.inertia=1e-5",
            'tauto isochronism sully_lever_at_sea --amplitudes 0.5,1,1.5 --set '
            'trochlea.thread.inclination=0.3',
            "tauto isochronism hanging_thread_at_sea --amplitudes 0.5,1 --set 'trochlea.power={"
            "kind: weight_and_spring, mass: 0.322, stiffness: 50}'",
        ),
        ('III',),
        lacks="Air and a stretched chord have no law in the text: Boyle's, and that of a chord "
        'drawn aside, are ours. A thread that swings needs a weight at its end, which a spring '
        'may draw as well: without mass the thread is straight, and its anchor is a hole.',
    ),
    Paragraph(
        'VI',
        'Euler begins with the simplest case, a vertical thread under a constant power without '
        'inertia, and asks for the curve and for the dimensions that give a period. He announces '
        'a second case, which he expects to be of use at sea.',
        ('tauto sail involute_weight_at_sea', 'tauto sail second_cam_at_sea'),
    ),
    Paragraph(
        'VII',
        'From *C* draw the perpendicular to the thread, which touches the plate at *M*. The '
        'power *P* turns the wheel back with the torque *P* times *TM*.',
        ('tauto cam clock_involute_weight',),
        ('IV',),
    ),
    Paragraph(
        'VIII',
        'The same torque is exerted by a force at the rim *O*, at right angles to *CO*. By the '
        'law of the lever it is to *P* as *TM* is to *CO*.',
        ('tauto isochronism ideal --amplitudes 0.1,3',),
    ),
    Paragraph(
        'IX',
        'A pendulum keeps equal times where its acceleration is proportional to the arc that it '
        'has to go. So *TM* must be proportional to the arc *BO*, which is the turn of the '
        'wheel.',
        ('tauto isochronism ideal --amplitudes 0.1,3',),
    ),
    Paragraph(
        'X',
        'Seen from the wheel, *TM* is a normal of the curve and *CT* the perpendicular on it '
        'from *C*. The increments of *TM* and of the angle *TCO* must be in proportion.',
        ('tauto cam clock_involute_weight',),
    ),
    Paragraph(
        'XI',
        'Two neighbouring normals meet in the centre of curvature *R*, and the increment of *TM*'
        ' is *pT*. It is proportional to the angle *TCp* only where *CT* is constant, so *R* and'
        ' *T* coincide.',
        ('tauto cam clock_involute_weight',),
        ('V',),
    ),
    Paragraph(
        'XII',
        'With *CT* as unit, *y* for *CM* and *x* for the arc *BS*, similar triangles give a '
        'differential equation between *x* and *y*. In it the variables are already separated.',
        ('tauto cam clock_involute_weight --csv involute.csv',),
    ),
    Paragraph(
        'XIII',
        'With *z* for the root of *yy − 1* the equation needs only an arc of the circle. So each'
        ' point of the curve is constructed with ruler, compasses and the length of an arc.',
        ('tauto cam clock_involute_weight --svg involute.svg',),
        ('VI',),
    ),
    Paragraph(
        'XIV',
        'The normal *MT* touches the circle in *T*, and *TM* is the radius of curvature. The '
        'curve is the involute of the circle, and is best drawn by a thread that unwinds from '
        'it.',
        ('tauto cam clock_involute_weight --dxf involute.dxf',),
    ),
    Paragraph(
        'XV',
        'The time of a swing must be found too, to give wheel and power their dimensions. The '
        'wheel is taken as a uniform disc of weight *Q*, with the radius *BC* of the circle.',
        ('tauto design --disc-weight 100 --pull 1 --disc-is-base --base-radius 0.02',),
    ),
    Paragraph(
        'XVI',
        'The wheel is drawn in two neighbouring positions, as its curve goes from *S* to *s*. '
        'The contacts *M* and *m* are at the height of *B*, and *μ* is the point of the curve '
        'that becomes *m*.',
        ('tauto cam clock_involute_weight',),
        ('VII',),
    ),
    Paragraph(
        'XVII',
        'Meanwhile the power descends by *Qn*, which equals *Mμ* because the thread keeps its '
        'length. Its work, *P* times *Qn*, passes whole into the wheel, for the power has no '
        'inertia.',
        ('tauto isochronism ideal --amplitudes 0.1,3',),
    ),
    Paragraph(
        'XVIII',
        'The vis viva of the disc is half its weight times the height *v* of fall of its rim. So'
        ' *v* increases along the arc *Ss* in proportion to *BS*, the arc still to go.',
        ('tauto isochronism ideal --amplitudes 0.1,3',),
    ),
    Paragraph(
        'XIX',
        'A pendulum on a cycloid has the same law. Comparing both gives the length of the '
        'isochronous pendulum: the pull is to the weight of the wheel as half the radius is to '
        'that length.',
        ('tauto design --disc-weight 100 --pull 1 --disc-is-base --base-radius 0.02',),
    ),
    Paragraph(
        'XX',
        'A small weight may replace the power, if what it needs for its own motion cannot be '
        'noticed. For a hundredth of the weight of the wheel, and beats of a second, Euler finds '
        'a radius of 63 scruples.',
        (
            'tauto design --pendulum 3166 --length-unit scruple --disc-weight 100 --pull 1 '
            '--disc-is-base',
            'tauto isochronism clock_own_cam_weight --amplitudes 0.5,1',
            'tauto sail hanging_thread_at_sea --set trochlea.thread.damping_ratio=0.2',
        ),
    ),
    Paragraph(
        'XXI',
        'A disc much larger than the circle of the cheeks moves the weight less, so that its '
        'inertia matters less. The pendulum grows as the fourth power of the radius if the '
        'thickness stays.',
        (
            'tauto design --pendulum 3166 --length-unit scruple --disc-weight 900 --pull 1 '
            '--base-radius 10',
        ),
        ('VIII',),
    ),
    Paragraph(
        'XXII',
        'The main difficulty is a thread that does not stay vertical. Led through a fixed hole it '
        'always points to the hole, and Euler states the curve that this needs.',
        ('tauto cam second_cam_at_sea --svg second.svg', 'tauto sail second_cam_at_sea'),
        ('IX',),
    ),
    Paragraph(
        'XXIII',
        'The power without inertia pulls below the hole *O*. The perpendicular *CN* on the line '
        '*OM* measures its action on the wheel.',
        ('tauto isochronism clock_second_cam_force --amplitudes 0.1,1,1.5',),
        ('X',),
    ),
    Paragraph(
        'XXIV',
        'For equal times *CN* must be proportional to the angle *BCO*, which the wheel has yet '
        'to turn. *CN* equals *MP*, the normal of the curve up to the perpendicular from *C*.',
        ('tauto isochronism clock_second_cam_force --amplitudes 0.1,1,1.5',),
    ),
    Paragraph(
        'XXV',
        'In the frame of the wheel the hole moves on a circle, and each point *M* of the curve '
        'has its place *O* there. *MP* must be proportional to the angle *BCO*.',
        ('tauto plot second_cam_at_sea machine',),
        ('XI',),
    ),
    Paragraph(
        'XXVI',
        'A neighbouring point *m* gives the increments *Pt* of the normal and *OCo* of the '
        'angle. Their proportion becomes one of the angles *OCo* and *PCt*, as *CP* to *b*.',
        ('tauto cam second_cam_at_sea',),
    ),
    Paragraph(
        'XXVII',
        'The angle *PCt* is that of the two normals at *R*, and also that of the two tangents. '
        'Similar triangles then give the ratio of both angles as *OM* to *OS*.',
        ('tauto cam second_cam_at_sea',),
    ),
    Paragraph(
        'XXVIII',
        'So *CP* is to *b* as *OM* to *OS*, and no angle is left. Both sides follow from the '
        'right-angled triangle *COS*.',
        ('tauto cam second_cam_at_sea',),
    ),
    Paragraph(
        'XXIX',
        'With *a*, *p* and *t* this is the equation stated before, and it gives *p*. A hole '
        'infinitely far away makes *p* constant, which is the first curve.',
        ('tauto cam second_cam_at_sea --set trochlea.thread.distance=100',),
    ),
    Paragraph(
        'XXX',
        'A weight may serve here too, if it is small and the wheel is heavy. Euler would rather '
        'use the first cam, because the second is laborious to make and the first is easy.',
        (
            'tauto compare clock_involute_weight clock_second_cam_force --duration 5443140',
            'tauto sail clock_involute_weight --duration 5443140 --set suspension=null --set '
            'trochlea.power.kind=force --set trochlea.power.mass=null --set '
            'trochlea.power.force=3.158 --set trochlea.power.material=steel --set '
            'clock.nominal_period=1.00004',
            'tauto sail clock_second_cam_force --duration 5443140 --set suspension=null --set '
            'trochlea.power.kind=weight --set trochlea.power.force=null --set '
            'trochlea.power.material=null --set trochlea.power.mass=0.322 --set '
            'clock.nominal_period=1.004716',
        ),
        found='At sea the power decides and the cam does not. On a passage to Jamaica with '
        "gravity, heat and a winter's weather a weight goes wrong on either cam, and a spring "
        'on both by the heat alone; a compensation mends it on both. So the easier cam is the '
        'better choice, and the weight is not.',
    ),
)
EDITION = Edition(
    'A',
    'trochlea',
    'Dissertatio de novo quodam curvarum tautochronarum genere',
    "The trochlea: Sully's sea clock",
    (
        ('Number', "E6 in Eneström's list (Euler Archive, page E006)"),
        (
            'Printed',
            'Commentarii academiae scientiarum Petropolitanae, tome II, on sheets Q to S: the '
            'first page of sheet R, 129, is in the middle of §IX (signatures in our text)',
        ),
        ('Dated', 'July 1727 (margin of §I)'),
        (
            'Translated',
            'Ian Bruce, with notes and the Latin (17centurymaths.com, "Euler: Some Papers", E006)',
        ),
        (
            'Not verified',
            'The year in which the volume was printed, the first and the last page, and the place '
            'in the Opera Omnia: no source that we could read names them',
        ),
        (
            "Sully's print",
            "Description abrégée d'une Horloge d'une nouvelle invention, Pour la juste mesure du "
            'Temps sur Mer, Paris, Briasson, 1726, 48 pages; the Suite, Bordeaux, Paris and '
            'Amsterdam, 1726, pages 49 to 290, with three plates (description of a copy at '
            'vieillemarine.pagesperso-orange.fr)',
        ),
        (
            'The Academy',
            'Machines et inventions approuvées par l’Académie, tome IV, 1735, No. 244 of 1724, '
            'pages 75 to 79 (digi.ub.uni-heidelberg.de/diglit/machines_inventions1735c)',
        ),
        (
            'Clocks that survive',
            "The Clockmakers' Museum No. 597, at the Science Museum, L2015-3478, dated 1724 "
            'there; Royal Museums Greenwich ZBA2248, c. 1724, an eight-day movement from '
            'Versailles. A sale of 1999 (Antiquorum, Geneva, 23 October, lot 2) called its '
            'clock, an eight-day one from Versailles, one of only two known',
        ),
    ),
    FIGURES,
    _PARAGRAPHS,
)
