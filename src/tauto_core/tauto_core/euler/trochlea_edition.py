"""Paper A for its page: its eleven figures, constructed from the text.

If the text leaves a curve open, the figure shows the final solution: the involute of §XIV, or the
curve of §XXIX. The wheel's frame has y along the thread at rest, as in `curves.cam`, and the
drawings have it downwards.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves import Hole, Involute
from tauto_core.curves.cam import Cam
from tauto_core.curves.drawing import outline
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.euler.edition import Control, Drawing, G, Point, View, read_edition, turned
from tauto_core.euler.trochlea_1727 import BASE_RADIUS, inertia_of_rings, period
from tauto_core.samples import FloatArray

_TURNS = Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(21)), begin=9)
_UNIT = Involute(1.0)
_CIRCLE = np.linspace(0.0, math.tau, 121)


def _hung(
    points: tuple[ArrayLike, ArrayLike], angle: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Return points of the wheel's frame in the drawing, with the wheel turned by an angle."""
    x, y = turned(points, -angle)
    return x, -y


def _at(points: tuple[ArrayLike, ArrayLike], angle: float = 0.0) -> tuple[float, float]:
    x, y = _hung(points, angle)
    return float(x), float(y)


def _weight(drawing: Drawing, hook: tuple[float, float], radius: float) -> tuple[float, float]:
    centre = hook[0], hook[1] - radius
    drawing.circle(centre, radius, 'solid')
    return centre


def _cheeks(
    drawing: Drawing, cam: Cam, angle: float, reach: float, end: Point, lean: float = 0.0
) -> None:
    """Draw both cheeks, and the thread: from their tip along a cheek, then straight to its end.

    A thread that leans by δ has the contact of a vertical one at the turn less δ.
    """
    drawing.curve(*_hung(outline(cam, 60, reach), angle), 'curve')
    _thread(drawing, _hung(cam.contact(np.linspace(0.0, angle - lean, 40)), angle), end)


def _thread(drawing: Drawing, along: tuple[FloatArray, FloatArray], end: Point) -> None:
    drawing.curve(np.append(along[0], end[0]), np.append(along[1], end[1]), 'thread')


# -----------------------------------------------------------------------------
# Figures I to IV: the wheel, its balance, Sully's machine, the force.


def _figure_i(turn: float) -> View:
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
    drawing.letters((ends[0], 'E', -10.0, 6.0), (ends[1], 'F', 10.0, 6.0))
    arm, bent = bend * (1.0 - math.cos(turn)), np.linspace(0.0, turn, 40)
    wound = _hung((-bend * (1.0 - np.cos(bent)), bend * np.sin(bent)), turn)
    touch = float(wound[0][-1]), float(wound[1][-1])
    _thread(drawing, wound, (touch[0], -3.7))
    drawing.letter((0.0, 0.0), 'C', -12.0, 5.0)
    if turn:
        drawing.letter(touch, 'M', 8.0, -4.0)
    drawing.note(_weight(drawing, (touch[0], -3.7), 0.3), 'P', 20.0, -3.0, 'letter')
    return View(
        drawing,
        f'The weight pulls at {arm / bend:.3f} of the radius of the arc from *C*, and turns the '
        'wheel back.' if turn else 'At rest the thread touches neither cheek.',
    )  # fmt: skip


def _figure_ii(turn: float) -> View:
    drawing = Drawing(-3.2, 3.2, -3.2, 3.2, 220.0)
    drawing.circle((0.0, 0.0), 2.9, 'ink')
    _cheeks(drawing, _UNIT, turn, 2.0, (turn, -3.2))
    counter = _at((0.0, -2.2), turn)
    drawing.circle(counter, 0.32, 'solid')
    drawing.note(counter, 'counterweight', 0.0, -22.0)
    drawing.letter((0.0, 0.0), 'C', 9.0, 6.0)
    return View(drawing, 'The centre of gravity of wheel and cheeks is *C*: it rests at any turn.')


def _figure_iii(turn: float) -> View:
    shape = LeverGeometry(0.02, 0.1, 0.3)
    r, fulcrum = shape.base_radius, (-shape.arm, -shape.depth)
    pose = shape.pose(shape.tau_of(np.array([turn])))
    u, beta, delta, free = (float(part[0]) for part in pose)
    along = np.array([math.sin(delta), -math.cos(delta)])
    touch = r * u * np.array([math.cos(delta), math.sin(delta)]) + r * along
    tied, end = touch + free * along, fulcrum + 0.15 * np.array([math.cos(beta), math.sin(beta)])
    drawing = Drawing(-0.13, 0.1, -0.37, 0.07, 230.0)
    _cheeks(drawing, Involute(r), turn, 2.6, tied, delta)
    drawing.circle((0.0, 0.0), 0.062, 'faint')
    drawing.line(fulcrum, end, look='heavy')
    # the weight is on the lever
    size = 0.011
    weight = end + size * np.array([-math.sin(beta), math.cos(beta)])
    drawing.circle(weight, size, 'solid')
    drawing.letters(
        ((0.0, 0.0), 'C', -12.0, 5.0),
        (fulcrum, 'A', -12.0, 2.0),
        (tied, 'B', -10.0, 9.0),
        (end, 'D', 2.0, -14.0),
    )
    drawing.note(weight, 'P', 20.0, 0.0, 'letter')
    return View(
        drawing,
        f'*D* has risen by {150.0 * math.sin(beta):.1f} mm, and the thread leans by '
        f'{abs(math.degrees(delta)):.2f}°.',
    )


def _figure_iv(turn: float) -> View:
    arm, rim = float(_UNIT.lever_arm(turn)), 2.6
    touch = _at(_UNIT.contact(turn), turn) if turn else (0.0, -1.0)
    drawing = Drawing(-3.0, 3.0, -4.3, 2.9, 280.0)
    drawing.circle((0.0, 0.0), rim, 'faint')
    _cheeks(drawing, _UNIT, turn, 2.3, (arm, -4.2))
    outer = _at((0.0, rim), turn)
    drawing.line((0.0, 0.0), (arm, 0.0), touch, look='thin')
    drawing.line((0.0, -rim), (0.0, 0.0), outer)
    drawing.letters(
        ((0.0, 0.0), 'C', -10.0, 6.0),
        ((0.0, -rim), 'B', -9.0, -8.0),
        ((arm, -4.0), 'R', 10.0, 0.0),
    )
    if turn:
        drawing.line((0.0, touch[1]), touch)
        drawing.letters(
            (outer, 'O', 10.0, -4.0),
            ((0.0, touch[1]), 'T', -9.0, -2.0),
            (touch, 'M', 10.0, -5.0),
            ((arm, 0.0), 'N', 6.0, 7.0),
        )
    return View(
        drawing,
        f'*TM* = {arm:.3f} *CT* at the angle *BCO* = {turn:.1f}: the force at *O*, in units of '
        f'*P*, is *TM/CO* = {arm / rim:.4f}.',
    )


# -----------------------------------------------------------------------------
# Figures V to VIII: the curve, its construction, the time of a swing, the larger disc.


def _figure_v(step: float) -> View:
    z = 1.5

    def lettered(roll: float) -> tuple[FloatArray, FloatArray]:
        """Return M and T of a roll angle."""
        foot = np.array([math.sin(roll), math.cos(roll)])
        return foot + roll * np.array([-math.cos(roll), math.sin(roll)]), foot

    # the drawing has the wheel's y downwards: B is below, the curve to its right
    points = [lettered(angle) for angle in np.linspace(0.0, 2.2, 60)]
    curve = np.array([point[0] for point in points]).T
    (m_point, t_point), (m_next, near_foot) = lettered(z), lettered(z + step)
    # the normals meet in R
    chord, second = m_point - t_point, m_next - near_foot
    across = np.column_stack([chord, -second])
    share = float(np.linalg.solve(across, near_foot - t_point)[0])
    centre = t_point + share * chord
    # p is the intersection of the first normal with the perpendicular Ct of the second
    foot = near_foot / np.linalg.norm(near_foot)
    crossing = t_point + chord * float(
        (-t_point[0] * foot[1] + t_point[1] * foot[0]) / (chord[0] * foot[1] - chord[1] * foot[0])
    )
    drawing = Drawing(-1.25, 2.25, -1.95, 1.2, 330.0)
    down = np.array([1.0, -1.0])
    drawing.circle((0.0, 0.0), 1.0, 'faint')
    drawing.curve(curve[0], -curve[1], 'curve')
    origin = np.zeros(2)
    drawing.line(m_point * down, origin, m_next * down, look='thin')
    drawing.lines(
        'ink',
        (m_point * down, crossing * down),
        (m_next * down, near_foot * down, origin, t_point * down),
    )
    polar = [math.atan2(-point[1], point[0]) for point in (m_point, m_next)]
    size = float(np.hypot(*m_point))
    drawing.arc((0.0, 0.0), size, polar[0], polar[1], 'other')
    ray = m_next / np.hypot(*m_next)
    drawing.letters(
        (origin * down, 'C', 0.0, 9.0),
        (np.array([0.0, 1.0]) * down, 'B', -9.0, -7.0),
        (m_point * down, 'M', -10.0, -8.0),
        (m_next * down, 'm', 5.0, -13.0),
        (t_point * down, 'T', -8.0, -10.0),
        (near_foot * down, 't', -8.0, 9.0),
        (m_point / size * down, 'S', 10.0, -3.0),
        (ray * down, 's', 10.0, 5.0),
        (ray * size * down, 'r', -12.0, 4.0),
        (centre * down, 'R', 12.0, 1.0),
        (crossing * down, 'p', 9.0, 9.0),
    )
    off = float(np.linalg.norm(centre - t_point))
    return View(
        drawing,
        f'*R* is {off:.3f} from *T*, for *m* at {step:.2f} rad from *M*. As *m* comes to *M*, '
        '*R*, *p* and *t* run into *T*, for *CT* has no increment.',
    )


STEP = 0.1


def _figure_vi(z: float) -> View:
    n_angle, s_angle = math.atan(z), z - math.atan(z)
    drawing = Drawing(-3.3, 3.3, -2.0, 1.3)
    drawing.circle((0.0, 0.0), 1.0, 'ink')

    def ray(angle: float) -> FloatArray:
        """Return the direction at an angle from CB, counterclockwise."""
        return np.array([math.sin(angle), -math.cos(angle)])

    p_point = np.array([-z, -1.0])
    size = math.hypot(1.0, z)
    drawing.line(ray(0.0), p_point, np.zeros(2), size * ray(s_angle))
    drawing.arc((0.0, 0.0), size, -0.5 * math.pi - n_angle, -0.5 * math.pi + s_angle, 'faint')
    drawing.line(ray(z), size * ray(s_angle), look='thread')
    # the points constructed so far, and the involute of `curves`
    for arc in np.arange(STEP, z - 0.5 * STEP, STEP):
        drawing.circle(math.hypot(1.0, arc) * ray(arc - math.atan(arc)), 0.03, 'dot')
    rolls = np.linspace(0.0, z, 60)
    x, y = _hung(_UNIT.contact(rolls))
    drawing.curve(np.abs(x), y, 'curve')
    drawing.arc((0.0, 0.0), 1.0, -0.5 * math.pi, -0.5 * math.pi + s_angle, 'heavy')
    drawing.letters(
        (np.zeros(2), 'C', -9.0, 7.0),
        (ray(0.0), 'B', 2.0, -13.0),
        (p_point, 'P', -4.0, -13.0),
        (ray(-n_angle), 'N', -10.0, 6.0),
        (ray(s_angle), 'S', -9.0, 8.0),
        (size * ray(s_angle), 'M', 10.0, -3.0),
        (ray(z), 'T', -4.0, 10.0),
    )
    reach = math.hypot(*_at(_UNIT.contact(z)))
    return View(
        drawing,
        f'*BP = z* = {z:.1f}, *BN = arctan z* = {n_angle:.5f}, *BS = BP − BN* = {s_angle:.5f}, '
        f'*CM = CP* = {size:.5f}. The cheek that Tauto cuts is there at {reach:.5f} from *C*, and '
        f'*TM* = {z:.1f}.',
    )


def _figure_vii(turn: float) -> View:
    fall = 0.35
    drawing = Drawing(-1.7, 5.3, -3.4, 1.5)
    drawing.circle((0.0, 0.0), 1.0, 'ink')
    for angle, look in ((turn, 'curve'), (turn - fall, 'other')):
        x, y = _hung(_UNIT.contact(np.linspace(0.0, 2.4, 60)), angle)
        drawing.curve(x, y, look)
    place, m_next = np.array([turn, -1.0]), np.array([turn - fall, -1.0])
    # μ: the point at the first position that becomes m
    homologous = np.array(_at(_UNIT.contact(turn - fall), turn))
    end = np.array([turn, -2.6])
    lift = 0.5 * (turn**2 - (turn - fall) ** 2)
    near_end = np.array([turn - fall, -2.6 - lift])
    drawing.lines('thread', (place, end), (m_next, near_end))
    drawing.line(near_end, (turn, near_end[1]), end, look='faint', closed=True)
    mark, second = (np.array(_at((0.0, 1.0), angle)) for angle in (turn, turn - fall))
    drawing.lines('thin', ((0.0, -1.0), place, (0.0, 0.0), m_next), (mark, (0.0, 0.0), second))
    drawing.letters(
        (np.zeros(2), 'C', -8.0, 7.0),
        (np.array([0.0, -1.0]), 'B', -9.0, -7.0),
        (mark, 'S', 8.0, 7.0),
        (second, 's', 9.0, -1.0),
        (place, 'M', 9.0, -2.0),
        (m_next, 'm', -2.0, -12.0),
        (homologous, 'μ', 9.0, 5.0),
        (end, 'Q', 10.0, 0.0),
        (near_end, 'q', -9.0, -5.0),
        (np.array([turn, near_end[1]]), 'n', 9.0, -5.0),
    )
    _cycloid(drawing, turn, fall)
    return View(
        drawing,
        f'*BS = BM* = {turn:.1f}, *Qn* = {lift:.4f} while *Ss* = {fall}: *Qn/Ss* is '
        f'{lift / fall:.4f}, the mean of *BM/BC* and *Bm/BC*, {turn:.1f} and {turn - fall:.2f}.',
    )


def _cycloid(drawing: Drawing, arc: float, step: float) -> None:
    """Draw the cycloid NA of the pendulum AO, with the wheel's arcs."""
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
    # nt is vertical
    level = np.array([end[0], begin[1]])
    drawing.line(level, end, look='thread')
    drawing.line(begin, level, look='faint')
    drawing.letters(
        (top, 'O', 9.0, 0.0),
        (foot, 'A', 0.0, -13.0),
        (begin, 'N', -9.0, 5.0),
        (end, 'n', -8.0, -8.0),
        (level, 't', 9.0, 5.0),
    )


def _figure_viii(ratio: float) -> View:
    drawing = Drawing(-5.8, 5.8, -6.6, 5.4, 290.0)
    drawing.circle((0.0, 0.0), ratio, 'ink')
    drawing.circle((0.0, 0.0), 1.0, 'faint')
    _cheeks(drawing, _UNIT, 0.0, 1.2, (0.0, -5.7))
    drawing.note(_weight(drawing, (0.0, -5.7), 0.35), 'P', 20.0, -3.0, 'letter')
    drawing.letters(
        ((0.0, 0.0), 'C', -9.0, 6.0),
        ((-ratio, 0.0), 'E', -9.0, 6.0),
        ((ratio, 0.0), 'D', 10.0, 6.0),
        ((0.0, -1.0), 'B', 9.0, -7.0),
        ((0.0, 1.0), 'F', 8.0, 7.0),
    )
    # a disc of the same thickness has a⁴ times the inertia
    disc = inertia_of_rings(100.0 * ratio**2, BASE_RADIUS * ratio)
    large, small = (period(size, inertia=disc, carried=1.0 / G) for size in (1.0, 1e-3))
    return View(
        drawing,
        f'*CD = a* = {ratio:g} *BC*: the pendulum is *a⁴* = {ratio**4:.4g} times as long. The '
        f'inertia of a weight of a hundredth of the small disc costs '
        f'{86400.0 * (1.0 - small / large):.3g} seconds a day at 1 rad.',
    )


# -----------------------------------------------------------------------------
# Figures IX to XI: the thread through a hole.


def _through_hole(cam: Hole, angle: float) -> dict[str, FloatArray]:
    """Return Euler's points of an angle in the wheel's frame, b = 1."""
    a, arm = cam.distance, float(cam.lever_arm(angle))
    psi = angle + math.asin(arm / a)
    normal = np.array([math.cos(psi), math.sin(psi)])
    line = np.array([-normal[1], normal[0]])
    touch = np.array([float(value) for value in cam.contact(angle)])
    return {
        'M': touch,
        'N': arm * normal,
        'P': touch - arm * normal,
        'O': a * np.array([-math.sin(angle), math.cos(angle)]),
        'normal': normal,
        'line': line,
    }


def _figure_ix(ratio: float, angle: float) -> View:
    cam = Hole(1.0, ratio)
    at = _through_hole(cam, angle)
    reach = min(2.0, 0.97 * cam.range_rad)
    drawing = Drawing(-2.3, 2.3, -3.2, 1.4, 320.0)
    places = {name: np.array(_at((at[name][0], at[name][1]), angle)) for name in 'MNPO'}
    hole = places['O']
    _cheeks(drawing, cam, angle, reach, hole)
    drawing.line(np.zeros(2), places['P'], places['M'])
    drawing.line(np.zeros(2), places['M'], look='thin')
    drawing.line(np.zeros(2), hole, look='faint')
    tip: FloatArray = np.array(_at(cam.contact(0.0), angle))
    drawing.letters(
        (np.zeros(2), 'C', -9.0, 7.0),
        (tip, 'B', 8.0, 7.0),
        (places['M'], 'M', 10.0, 4.0),
        (places['P'], 'P', -9.0, -6.0),
    )
    if ratio > 3.0:
        drawing.note((0.0, -3.05), 'A is below', -40.0, 0.0)
    else:
        drawing.letter(hole, 'A', -10.0, 0.0)
    arm = float(cam.lever_arm(angle))
    free = math.sqrt(ratio**2 - arm**2)
    p = float(np.linalg.norm(places['P']))
    return View(
        drawing,
        f'*a* = {ratio:g} *b*, *t = PM* = {arm:.3f} *b*: *p = CP* = {p:.5f} *b* in the figure, '
        f'{free / (1.0 + free):.5f} *b* by the equation.',
    )


def _figure_x(angle: float) -> View:
    cam = Hole(1.0, 2.0)
    at = _through_hole(cam, angle)
    places = {name: np.array(_at((at[name][0], at[name][1]), angle)) for name in 'MNPO'}
    drawing = Drawing(-2.3, 2.3, -3.0, 1.7, 320.0)
    _cheeks(drawing, cam, angle, 1.7, places['O'])
    drawing.line(places['N'], places['M'], look='thin')
    drawing.line(places['O'], (0.0, -3.0), look='thread')
    top = np.array(_at((0.0, 2.0), angle))
    drawing.lines('heavy', ((-0.6, -2.0), (-0.08, -2.0)), ((0.08, -2.0), (0.6, -2.0)))
    drawing.line(places['N'], np.zeros(2), places['P'], places['M'])
    drawing.line(top, np.zeros(2), places['O'], look='faint')
    drawing.letters(
        (np.zeros(2), 'C', -9.0, 7.0),
        (places['O'], 'O', -11.0, 6.0),
        (top, 'B', 9.0, -6.0),
        *(
            (
                (places['M'], 'M', 10.0, 4.0),
                (places['N'], 'N', 9.0, 7.0),
                (places['P'], 'P', -9.0, -6.0),
            )
            if angle
            else ()
        ),
    )
    arm = float(np.linalg.norm(places['N']))
    return View(
        drawing,
        f'*CN = MP* = {arm:.4f} *b* at the angle *BCO* = {angle:.1f}: both are proportional.',
    )


def _figure_xi(step: float) -> View:
    cam, angle = Hole(1.0, 2.0), 0.9
    pose, second = _through_hole(cam, angle), _through_hole(cam, angle + step)
    meet = np.linalg.solve(
        np.column_stack([pose['normal'], -second['normal']]), second['P'] - pose['P']
    )
    centre = pose['P'] + float(meet[0]) * pose['normal']
    # t: on the first normal, on the line Cp
    cross = np.linalg.solve(np.column_stack([pose['normal'], -second['line']]), -pose['P'])
    element = pose['P'] + float(cross[0]) * pose['normal']
    foot = second['M'] + second['line'] * float((pose['O'] - second['M']) @ second['line'])
    drawing = Drawing(-2.25, 0.5, -2.2, 0.6, 360.0)
    down = np.array([1.0, -1.0])
    drawing.arc((0.0, 0.0), 2.0, -0.5 * math.pi - 1.5, -0.5 * math.pi + 0.15, 'faint')
    x, y = _hung(cam.contact(np.linspace(0.0, 1.75, 60)))
    drawing.curve(x, y, 'curve')
    origin, top = np.zeros(2), np.array([0.0, 2.0])
    drawing.line(origin, top * down)
    for at in (pose, second):
        drawing.line(at['N'] * down, at['O'] * down, look='thread')
        drawing.line(at['M'] * down, at['P'] * down)
    ends = pose['O'], second['O'], element, pose['P'], pose['N']
    drawing.lines('thin', *((origin, end * down) for end in ends))
    drawing.line(pose['O'] * down, foot * down, look='other')
    drawing.line(pose['P'] * down, centre * down, look='faint')
    drawing.letters(
        (origin * down, 'C', 8.0, 7.0),
        (top * down, 'B', 9.0, 0.0),
        (pose['M'] * down, 'M', -4.0, -13.0),
        (second['M'] * down, 'm', 9.0, 5.0),
        (pose['O'] * down, 'O', 4.0, -12.0),
        (second['O'] * down, 'o', -10.0, -3.0),
        (pose['P'] * down, 'P', 10.0, -10.0),
        (second['P'] * down, 'p', 9.0, 9.0),
        (element * down, 't', -9.0, 5.0),
        (pose['N'] * down, 'S', 9.0, 3.0),
        (foot * down, 'n', -2.0, 11.0),
        (centre * down, 'R', -10.0, 8.0),
    )
    turn = step / math.acos(np.clip(float(pose['normal'] @ second['normal']), -1.0, 1.0))
    p = float(np.linalg.norm(pose['P']))
    return View(
        drawing,
        f'*OCo : PCt* = {turn:.4f}, *CP : b* = {p:.4f}, for *o* at {step:.2f} rad from *O*. They '
        'agree as *o* comes to *O*.',
    )


_STEPS = Control('m from M, rad', (0.5, 0.4, 0.3, 0.2, 0.1, 0.05, 0.02), begin=1)
EDITION = read_edition(
    'A',
    'trochlea',
    {
        'I': (
            _figure_i,
            Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(17)), begin=9),
        ),
        'II': (_figure_ii, _TURNS),
        'III': (_figure_iii, _TURNS),
        'IV': (_figure_iv, _TURNS),
        'V': (_figure_v, _STEPS),
        'VI': (
            _figure_vi,
            Control('z', tuple(round(STEP * k, 1) for k in range(1, 31)), begin=11),
        ),
        'VII': (
            _figure_vii,
            Control('BS, rad', tuple(round(0.7 + 0.1 * k, 1) for k in range(10)), begin=5),
        ),
        'VIII': (
            _figure_viii,
            Control('a = CD/BC', (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0), begin=4),
        ),
        'IX': (
            _figure_ix,
            Control('a/b', (1.2, 1.5, 1.8, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0), begin=3),
            Control('turn, rad', (0.1, 0.3, 0.5, 0.7, 0.9, 1.0), begin=4),
        ),
        'X': (
            _figure_x,
            Control('turn, rad', tuple(round(0.1 * k, 1) for k in range(16)), begin=9),
        ),
        'XI': (_figure_xi, Control('o from O, rad', (0.4, 0.3, 0.2, 0.1, 0.05, 0.02), begin=0)),
    },
)
