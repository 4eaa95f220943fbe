"""Paper C for its page: every paragraph, and its six figures constructed from the text.

The body of the examples is that of the claims: e = 0.1 m, c = 0.3 m, k = 0.15 m. The formulas are
for small swings; the figures show them larger.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.euler.edition import Control, Drawing, Edition, EulerFigure, G, Paragraph, Shown
from tauto_core.euler.figures import AXLE, C, E, K
from tauto_core.machines.axle_pendulum import modes

Place = tuple[float, float]


def _below(start: Place, length: float, tilt: float) -> Place:
    """Return the point at a distance from another, downwards and tilted from the vertical."""
    return start[0] + length * math.sin(tilt), start[1] - length * math.cos(tilt)


def _body(drawing: Drawing, axle: Place, low: Place, k: float, radius: float = AXLE) -> None:
    """Draw the axle, the line to the centre of gravity, and the circle of gyration about it."""
    drawing.circle(axle, radius, 'curve')
    drawing.line(axle, low, look='curve')
    drawing.circle(low, k, 'faint')


def _letters(drawing: Drawing, *places: tuple[Place, str, float, float]) -> None:
    for place, name, right, up in places:
        drawing.letter(place, name, right, up)


def _swings(e: float, c: float, k: float) -> str:
    """Return the lengths of both modes, and how long a swing takes or how fast the body falls."""
    found = modes(e, c, k * k)
    said = []
    for name, length in (('b', found.b), ('b′', found.b_prime)):
        if math.isinf(length):
            said.append(f'{name} is infinite, the axle drifts')
        elif length < 0.0:
            grown = math.sqrt(-length / G)
            said.append(f'{name} = {length:.5f} m, the body falls, e-fold in {grown:.4f} s')
        else:
            swing = math.pi * math.sqrt(length / G)
            said.append(f'{name} = {length:.5f} m, a swing takes {swing:.5f} s')
    return '; '.join(said) + '.'


# -----------------------------------------------------------------------------
# Table IV: the body from the front, at rest, displaced, and on a plane.


def _figure_3(c: float) -> Shown:
    drawing = Drawing(-0.6, 0.6, -0.68, 0.12)
    drawing.line((-0.5, -AXLE), (0.5, -AXLE), (0.5, AXLE), (-0.5, AXLE), closed=True)
    for side in (-1.0, 1.0):
        # the supports at both ends
        drawing.line((0.5 * side, -AXLE), (0.38 * side, -AXLE), look='heavy')
        drawing.line((0.44 * side, -AXLE), (0.44 * side, -0.14), look='heavy')
    turn = np.linspace(0.0, math.tau, 61)
    drawing.curve(0.16 * np.sin(turn), -c - 0.17 * np.cos(turn), 'curve')
    drawing.line((0.0, -AXLE), (0.0, 0.17 - c), look='curve')
    drawing.line((0.0, 0.0), (0.0, -c), look='thread')
    drawing.line((-0.3, -c), (0.3, -c), look='faint')
    _letters(
        drawing,
        ((-0.5, -AXLE), 'A', -10.0, -6.0),
        ((0.5, -AXLE), 'A', 10.0, -6.0),
        ((-0.5, AXLE), 'B', -10.0, 6.0),
        ((0.5, AXLE), 'B', 10.0, 6.0),
        ((0.0, 0.0), 'C', 10.0, 3.0),
        ((0.0, -c), 'G', 9.0, -8.0),
        ((-0.16, -c), 'E', -10.0, 8.0),
        ((0.16, -c), 'F', 10.0, 8.0),
        ((0.0, -c - 0.17), 'D', 0.0, -11.0),
        ((-0.3, -c), 'I', -9.0, 0.0),
        ((0.3, -c), 'K', 9.0, 0.0),
    )
    own = K * K + c * c
    return Shown(
        drawing,
        f'GC = c = {c:g} m. With k = {K:g} m about IK the moment of inertia about the axis of the '
        f'axle would be M times {own:.4f} m².',
    )


def _figure_4(e: float, c: float, k: float) -> Shown:
    a = e + AXLE
    drawing = Drawing(-0.45, 0.45, -0.95, 0.06, 280.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 1.1, -0.5 * math.pi + 1.1, 'ink')
    axle, low = (0.0, -e), (0.0, -e - c)
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.0), (0.0, -0.93), look='faint')
    side = a * math.sin(1.1)
    _letters(
        drawing,
        ((0.0, 0.0), 'O', -10.0, 4.0),
        (axle, 'C', 9.0, 3.0),
        ((0.0, -a), 'A', -9.0, -7.0),
        ((0.0, AXLE - e), 'B', 10.0, 4.0),
        (low, 'G', 9.0, -4.0),
        ((-side, -a * math.cos(1.1)), 'M', -10.0, 2.0),
        ((side, -a * math.cos(1.1)), 'N', 10.0, 2.0),
    )
    return Shown(drawing, f'a = {a:g} m, e = a − b = {e:g} m. {_swings(e, c, k)}')


_MOTIONS = ('slow mode', 'fast mode', 'push n at G')
PUSH = 0.8
"""Velocity n of the centre of gravity after the push [m/s], with which nothing is turned."""
_TIMES = tuple(round(0.04 * k, 2) for k in range(1, 36))


def _angles(motion: int, seconds: float) -> tuple[float, float]:
    """Return θ and Φ of a motion from equilibrium at a time [rad]."""
    own = modes(E, C, K * K)
    slow, fast = (math.sqrt(G / length) for length in (own.b, own.b_prime))
    if motion == 0:
        rates = 0.35 * slow / C, 0.0
    elif motion == 1:
        rates = 0.0, 0.6 * fast / C
    else:
        # dΦ/dt = 0 and e dθ/dt = n
        first = PUSH / (E * C * (1.0 - own.B / own.B_prime))
        rates = first, -first * own.B / own.B_prime
    z = rates[0] / slow * math.sin(slow * seconds), rates[1] / fast * math.sin(fast * seconds)
    return C * (z[0] + z[1]), own.B * z[0] + own.B_prime * z[1]


def _figure_5(motion: float, seconds: float) -> Shown:
    theta, phi = _angles(int(motion), seconds)
    a = E + AXLE
    drawing = Drawing(-0.38, 0.38, -0.62, 0.16, 300.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 1.3, -0.5 * math.pi + 1.3, 'ink')
    axle, touch = _below((0.0, 0.0), E, theta), _below((0.0, 0.0), a, theta)
    low = _below(axle, C, phi)
    _body(drawing, axle, low, K)
    drawing.line((0.0, 0.15), (0.0, -0.6), look='faint')
    drawing.line((0.0, 0.0), touch, look='thin')
    drawing.line((0.0, low[1]), low, look='thin')
    drawing.line((0.0, axle[1]), axle, look='thin')
    _letters(
        drawing,
        ((0.0, 0.0), 'O', -10.0, 4.0),
        ((0.0, -a), 'A', -9.0, -8.0),
        ((0.0, -E), 'C', -10.0, 7.0),
        ((0.0, low[1]), 'p', -9.0, -4.0),
        ((0.0, axle[1]), 'q', -9.0, -3.0),
        (axle, 'c', 10.0, 3.0),
        (touch, 'a', 8.0, -9.0),
        (low, 'g', 10.0, -5.0),
    )
    if abs(phi) > 0.02:
        # where gc, produced backwards, meets the vertical
        above = axle[1] + axle[0] / math.tan(phi)
        if -0.55 < above < 0.12:
            drawing.line(axle, (0.0, above), look='faint')
            drawing.letter((0.0, above), 'h', 9.0, 5.0)
    return Shown(
        drawing,
        f'{_MOTIONS[int(motion)]}, {seconds:.2f} s from equilibrium: θ = AOa = {theta:.5f}, Φ = '
        f'Ahg = {phi:.5f}, x = Op = {-low[1]:.4f} m, y = pg = {low[0]:.4f} m.',
    )


def _figure_6(phi: float, c: float, k: float) -> Shown:
    drawing = Drawing(-0.45, 0.45, -0.65, 0.12, 320.0)
    drawing.line((-0.42, -AXLE), (0.42, -AXLE), look='heavy')
    axle = -c * math.sin(phi), 0.0
    low = _below(axle, c, phi)
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.1), (0.0, -0.63), look='faint')
    _letters(
        drawing,
        ((0.0, -AXLE), 'A', 8.0, -9.0),
        ((-0.42, -AXLE), 'M', -1.0, -11.0),
        ((0.42, -AXLE), 'N', 1.0, -11.0),
        (low, 'g', 10.0, 0.0),
        (axle, 'c', -9.0, 7.0),
        ((axle[0], -AXLE), 'a', -9.0, -8.0),
    )
    b = k * k / c
    return Shown(
        drawing,
        f'The axle is at {axle[0]:.4f} m = −c sin Φ, g in its vertical. A swing takes '
        f'{math.pi * math.sqrt(b / G):.5f} s, as of a pendulum kk/c = {b:.5f} m.',
    )


# -----------------------------------------------------------------------------
# Table V: the convex support and the cradle.


def _figure_v_1(i: float, c: float, k: float) -> Shown:
    found = modes(-i, c, k * k)
    radius = i - AXLE
    theta = 0.45
    drawing = Drawing(-0.5, 0.5, -0.55, 0.36, 320.0)
    # O is at the origin, the axle above it
    drawing.arc((0.0, 0.0), radius, 0.1, math.pi - 0.1, 'ink')
    rest = (0.0, i)
    axle = i * math.sin(theta), i * math.cos(theta)
    touch = radius * math.sin(theta), radius * math.cos(theta)
    tilt = theta * found.B_prime / c
    low = _below(axle, c, tilt)
    drawing.circle(rest, AXLE, 'faint')
    _body(drawing, axle, low, k)
    drawing.line((0.0, 0.35), (0.0, -0.52), look='faint')
    drawing.line((0.0, 0.0), axle, look='thin')
    _letters(
        drawing,
        ((0.0, 0.0), 'O', -10.0, -4.0),
        (rest, 'C', -10.0, 6.0),
        ((0.0, radius), 'A', -9.0, -8.0),
        ((-radius * math.cos(0.1), radius * math.sin(0.1)), 'M', -10.0, 3.0),
        ((radius * math.cos(0.1), radius * math.sin(0.1)), 'N', 11.0, 3.0),
        (axle, 'c', 9.0, 7.0),
        (touch, 'a', -7.0, -9.0),
        (low, 'g', 10.0, -4.0),
    )
    return Shown(drawing, f'OC = i = {i:g} m. {_swings(-i, c, k)}')


ROCKER = 0.5
"""Radius of the rockers of the cradle [m]."""


def _figure_v_2(e: float, c: float, k: float) -> Shown:
    found = modes(e, c, k * k)
    ratio = (found.B if found.b > 0.0 else found.B_prime) / c
    theta = min(0.22, 0.5 / abs(ratio))
    a = e + ROCKER
    drawing = Drawing(-1.0, 1.0, -1.75, 0.12, 320.0)
    drawing.arc((0.0, 0.0), a, -0.5 * math.pi - 0.6, -0.5 * math.pi + 0.6, 'ink')
    axle, touch = _below((0.0, 0.0), e, theta), _below((0.0, 0.0), a, theta)
    tilt = theta * ratio
    low = _below(axle, c, tilt)
    # the rockers, as far up as the cradle's edge
    drawing.arc(axle, ROCKER, -0.5 * math.pi + tilt - 1.2, -0.5 * math.pi + tilt + 1.2, 'curve')
    drawing.line(*(_below(axle, ROCKER, tilt + side) for side in (-1.2, 1.2)), look='curve')
    drawing.circle(low, k, 'faint')
    drawing.line(axle, low, look='curve')
    drawing.line((0.0, 0.05), (0.0, -1.7), look='faint')
    drawing.line((0.0, 0.0), touch, look='thin')
    _letters(
        drawing,
        ((0.0, 0.0), 'O', -10.0, -2.0),
        ((0.0, -e), 'C', -10.0, 4.0),
        ((0.0, -a), 'A', -9.0, -9.0),
        (_below((0.0, 0.0), a, -0.6), 'M', -10.0, 3.0),
        (_below((0.0, 0.0), a, 0.6), 'N', 10.0, 3.0),
        (axle, 'c', 10.0, 6.0),
        (low, 'g', 10.0, -3.0),
        (touch, 'a', 9.0, -9.0),
    )
    return Shown(drawing, f'OC = e = {e:g} m. {_swings(e, c, k)}')


_C = Control('c, m', (0.1, 0.2, 0.3, 0.4), begin=2)
_K = Control('k, m', (0.05, 0.1, 0.15, 0.2), begin=2)
FIGURES = (
    EulerFigure(
        'Tab. IV, 3',
        'The body from the front: the axle *AABB* on its two supports, the mass *EDF*, the '
        'centre of gravity *G* at the distance *c* from the axis, and *IK* through *G*.',
        _figure_3,
        (_C,),
    ),
    EulerFigure(
        'Tab. IV, 4',
        'At rest, seen along the axle: the hollow support *MAN* about *O* with the radius *a*, '
        'the axle *AB* of the radius *b = 50* mm about *C*. Dashed: the circle of gyration about'
        ' *G*.',
        _figure_4,
        (Control('e, m', (0.01, 0.03, 0.1, 0.2, 0.3), begin=2), _C, _K),
    ),
    EulerFigure(
        'Tab. IV, 5',
        'In motion: *c* is the centre of the axle, *a* the contact, *g* the centre of gravity; '
        '*gc* meets the vertical in *h*. *e = 0.1* m, *c = 0.3* m, *k = 0.15* m.',
        _figure_5,
        (
            Control('motion', (0.0, 1.0, 2.0), begin=0, names=_MOTIONS),
            Control('time, s', _TIMES, begin=7),
        ),
    ),
    EulerFigure(
        'Tab. IV, 6',
        'On a plane without friction: the axle is aside by *ac*, *g* stays in the vertical of '
        '*A*.',
        _figure_6,
        (
            Control('Φ, rad', tuple(round(0.15 * each, 2) for each in range(-4, 5)), begin=6),
            Control('c, m', (0.2, 0.3, 0.4), begin=1),
            Control('k, m', (0.05, 0.1, 0.15), begin=2),
        ),
    ),
    EulerFigure(
        'Tab. V, 1',
        'The convex support *MAN* about *O*, below the axle: *OC = i*. The axle is drawn where '
        'it falls from the support, in the mode *b′*.',
        _figure_v_1,
        (Control('i, m', (0.15, 0.2, 0.25), begin=1), _C, _K),
    ),
    EulerFigure(
        'Tab. V, 2',
        'The cradle on a hollow floor *MAN* about *O*; *C* is the centre of its rockers, here of'
        ' the radius 0.5 m. A negative *c* has the centre of gravity above *C*.',
        _figure_v_2,
        (
            Control('e, m', (0.4, 0.7, 1.0), begin=1),
            Control('c, m', (-0.1, 0.1, 0.2, 0.3), begin=2),
            Control('k, m', (0.2, 0.3, 0.4), begin=1),
        ),
    ),
)


# -----------------------------------------------------------------------------
# The paragraphs.

_BODY = '--depth 0.3 --gyration-radius 0.15 --axle-radius 0.05'
_HOLLOW = f'tauto axle --support concave --support-radius 0.15 {_BODY}'
_OWN = f'{_HOLLOW} --release-tilt 0.1'
_PUSHED = f'{_HOLLOW} --push-speed 0.01 --push-spin 0.02 --duration 0.5'
_LARGE = f'{_HOLLOW} --release-tilt 0.4 --release-arc 0.05'
_PLANE = f'tauto axle {_BODY} --release-tilt 0.3'
_CONVEX = (
    f'tauto axle --support convex --support-radius 0.15 {_BODY} --push-speed 0.01 --duration 0.3'
)
_ROCKERS = '--axle-radius 0.5 --depth 0.2 --gyration-radius 0.3 --release-tilt 0.1'
_CRADLE = f'tauto axle --support cradle --support-radius 1.2 {_ROCKERS}'
_TIPS = (
    'tauto axle --support cradle --axle-radius 0.5 --depth -0.1 --gyration-radius 0.3 '
    '--release-tilt 0.01'
)
_SAIL = 'tauto sail axle_at_sea'
_PARAGRAPHS = (
    Paragraph(
        '1',
        'A pendulum is made of a cylindrical axle and a body of any shape fixed to its middle. '
        'What matters are the distance *c* of the centre of gravity from the axis, the mass *M*,'
        ' and the moment of inertia *Mkk* about the line *IK* through that centre.',
        (_OWN,),
        ('Tab. IV, 3',),
    ),
    Paragraph(
        '2',
        'Both ends of the axle lie on equal supports, so that it stays level and presses on both '
        'alike. Only very small swings are to be found, for larger ones need too much '
        'calculation.',
        (_OWN, _LARGE),
    ),
    Paragraph(
        '3',
        'At rest the axle, of the radius *b*, lies at the lowest point *A* of a hollow support '
        'with the centre *O* and the radius *a*. The centre of gravity then lies below *O*, *C* '
        'and *A*.',
        (_OWN,),
        ('Tab. IV, 4',),
    ),
    Paragraph(
        '4',
        'A push gives the centre of gravity a small velocity *n* and the body a small angular '
        'velocity *ν*. The motion that follows is sought.',
        (_PUSHED,),
    ),
    Paragraph(
        '5',
        'After a time *t* the contact is at *a*, seen from *O* at the angle *θ*, and the body is'
        ' tilted by *Φ*. Four equations join these angles with the coordinates *x* and *y* of '
        'the centre of gravity.',
        (_LARGE,),
        ('Tab. IV, 5',),
    ),
    Paragraph(
        '6',
        'Gravity acts at the centre of gravity, downwards. The support presses on the axle along'
        ' the line from *a* through *c* to *O*, because there is no friction.',
        (_OWN,),
    ),
    Paragraph(
        '7',
        'That pressure, carried over to the centre of gravity, has a vertical and a horizontal '
        'part. What is left is a torque that turns the body.',
        (_OWN,),
    ),
    Paragraph(
        '8',
        'The accelerations of the centre of gravity follow in both directions. Eliminating the '
        'unknown pressure leaves one equation.',
        (_LARGE,),
    ),
    Paragraph(
        '9',
        'The torque of the pressure about the centre of gravity gives the angular acceleration. '
        'Here too the pressure is eliminated.',
        (_LARGE,),
    ),
    Paragraph(
        '10',
        'Two differential equations and two conditions determine *x*, *y*, *θ* and *Φ*. In '
        'general they are too difficult, but for small angles they become simple.',
        (_LARGE,),
    ),
    Paragraph(
        '11',
        'With *e* for *a − b* everything can be expressed by the two angles. So *x* and *y* are '
        'sums of the projections of *e* and *c*.',
        (_LARGE,),
    ),
    Paragraph(
        '12',
        'For small angles *x* is constant and the pressure is the weight. Two linear equations '
        'for *θ* and *Φ* are left.',
        (_OWN,),
    ),
    Paragraph(
        '13',
        'Each of the two equations contains both angles. They must be combined so that one '
        'unknown remains.',
        (_OWN,),
    ),
    Paragraph(
        '14',
        'The first equation times *A* and the second times *B* are added. *A* and *B* are chosen'
        ' so that both sides contain the same combination *z* of the angles.',
        (_OWN,),
    ),
    Paragraph(
        '15',
        'Comparing the two expressions of *θ* gives a quadratic equation for *A* to *B*. Its two'
        ' roots are equally good.',
        (_OWN,),
    ),
    Paragraph(
        '16',
        'Each root has its own coefficient *D*. So there are two solutions.',
        (_OWN,),
    ),
    Paragraph(
        '17',
        'The first solution joins *θ* and *Φ* with *z*, and *z* obeys the equation of a '
        'pendulum. Its coefficient contains the root with one sign.',
        (_OWN,),
    ),
    Paragraph(
        '18',
        'The second solution has another variable *z′*. It differs by the sign of the root.',
        (_OWN,),
    ),
    Paragraph(
        '19',
        'From *z* and *z′* both angles follow by sum and difference. Each angle is a combination'
        ' of both.',
        (_OWN,),
    ),
    Paragraph(
        '20',
        'The equation for *z* is integrated: *z* is a sine of the time. Its length of pendulum '
        'is called *b*.',
        (_OWN,),
    ),
    Paragraph(
        '21',
        'In the same way *z′* is a sine with the length *b′*. The coefficients of both must be '
        'small, because the angles must be.',
        (_OWN,),
    ),
    Paragraph(
        '22',
        'A second, neater solution begins with *θ* and *Φ* as sums of multiples of *z* and *z′*.'
        ' Each of them is to swing like a simple pendulum.',
        (_OWN,),
    ),
    Paragraph(
        '23',
        'Put into the two equations this must hold for all times. The letters *A*, *B*, *A′*, '
        '*B′*, *b* and *b′* are free for it.',
        (_OWN,),
    ),
    Paragraph(
        '24',
        'Since *z* and *z′* do not depend on each other, their coefficients vanish one by one. '
        'Four equations result.',
        (_OWN,),
    ),
    Paragraph(
        '25',
        'Dividing them in pairs eliminates the lengths. The ratios of *A* to *B* and of *A′* to '
        '*B′* remain.',
        (_OWN,),
    ),
    Paragraph(
        '26',
        'The equation for *A* to *B* is quadratic. With *A = c* it gives *B*.',
        (_OWN,),
    ),
    Paragraph(
        '27',
        'The equation for the other pair is the same. So one pair takes one root and the other '
        'pair the other.',
        (_OWN,),
    ),
    Paragraph(
        '28',
        'Both lengths follow, and reduce to a sum of *e*, *f* and the root. They differ only by '
        'the sign of the root.',
        (_OWN,),
    ),
    Paragraph(
        '29',
        'Now both angles are known at any time. Two amplitudes and two phases are still free.',
        (_OWN,),
    ),
    Paragraph(
        '30',
        'The body starts in equilibrium, where both angles vanish. So both phases are zero.',
        (_PUSHED,),
    ),
    Paragraph(
        '31',
        'The velocity *n* of the centre of gravity gives one equation between the amplitudes. It'
        ' becomes short, because *e* and *B* add up to *b*.',
        (_PUSHED,),
    ),
    Paragraph(
        '32',
        'The angular velocity *ν* gives another. Both amplitudes follow, and with them the whole'
        ' motion.',
        (_PUSHED,),
    ),
    Paragraph(
        '33',
        'The motion is in general a mixture of two simple ones. It is simple and regular where '
        'one of the amplitudes is zero.',
        (_OWN,),
    ),
    Paragraph(
        '34',
        'If the second amplitude is zero, both angles go with one sine. The two angular '
        'velocities do too.',
        (_OWN,),
    ),
    Paragraph(
        '35',
        'Both velocities then vanish at the same moments, at the ends of each swing. A swing '
        'takes as long as that of a pendulum of the length *b*.',
        (_OWN,),
    ),
    Paragraph(
        '36',
        'Without extent and on a knife-edge the body is the simple pendulum. A mass without '
        'extent on a real axle swings as if it hung from *O*.',
        (
            'tauto axle --support concave --support-radius 0.01 --depth 0.3 --gyration-radius '
            '0.02 --release-tilt 0.1',
            'tauto axle --support concave --support-radius 0.15 --axle-radius 0.05 --depth 0.3 '
            '--gyration-radius 0.001 --release-tilt 0.1',
        ),
    ),
    Paragraph(
        '37',
        'The shape of the support matters much. On a level plane *e* is infinite and so is *b*: '
        'the body can be moved aside and does not come back.',
        (f'tauto axle {_BODY} --push-speed 0.2',),
    ),
    Paragraph(
        '38',
        'The other root still gives a swing on the plane, with the length *kk/c*. In it the '
        'centre of gravity keeps to its vertical, and the axle goes to and fro.',
        (_PLANE,),
        ('Tab. IV, 6',),
    ),
    Paragraph(
        '39',
        'The case of a vanishing first amplitude is the other regular motion. It has the length '
        '*b′*.',
        (_OWN,),
    ),
    Paragraph(
        '40',
        'On a plane experience shows something else: the body swings about an axle at rest. That '
        'is due to friction, which is left out here, so that nothing pushes the centre of gravity '
        'sideways.',
        (f'{_PLANE} --contact rolling', f'{_PLANE} --contact coulomb --friction 0.1'),
        found='With friction an axle that rolls has one way to swing, and a thin axle then '
        'stays nearly at rest, as experience has it. This paper leaves friction out; '
        'its title promises another.',
    ),
    Paragraph(
        '41',
        'Where both amplitudes are there the motion is very irregular. It is composed of two '
        'swings of the lengths *b* and *b′*, in endless variety.',
        (_LARGE, _SAIL),
    ),
    Paragraph(
        '42',
        'Both lengths are written out with *c*, *e* and *k* alone. They differ by the sign of '
        'one root.',
        (_OWN,),
    ),
    Paragraph(
        '43',
        'Since *B* is *b − e*, both angles follow from the two lengths. With their velocities '
        'the motion is determined completely.',
        (_PUSHED, 'tauto sail suspended_weight_at_sea'),
    ),
    Paragraph(
        '44',
        'For a distant *O*, or one below the axle, the arc *s* of the axle is better than *θ*. '
        'All formulas are written with *s*.',
        (_PUSHED,),
    ),
    Paragraph(
        '45',
        'On a convex support *O* lies below the axle, at the distance *i*. The formulas hold '
        'with *−i* for *e*.',
        (_CONVEX,),
        ('Tab. V, 1',),
    ),
    Paragraph(
        '46',
        'The motions on such a support are written out. They have the same form.',
        (_CONVEX,),
    ),
    Paragraph(
        '47',
        'The formulas hold only where *b* and *b′* are positive. Where one is not, the body '
        'cannot swing and slides off the support, which is to be feared for *b′* here.',
        (_CONVEX,),
        found='It is certain. One of the two lengths is negative for every body on a convex '
        'support, so that without friction it always falls.',
    ),
    Paragraph(
        '48',
        'An appendix is on the rocking of cradles, on which Euler had written before for a level '
        'floor. It is the same problem with the body above the support.',
        (f'tauto axle --support cradle {_ROCKERS}',),
    ),
    Paragraph(
        '49',
        'The axle becomes the body of the cradle, and *C* is the centre of its rockers. Its '
        'centre of gravity must be below *C*, or it would not rock.',
        (_CRADLE, _TIPS),
        ('Tab. V, 2',),
    ),
    Paragraph(
        '50',
        'The displaced cradle touches the floor on the line from *O* through *c*. Only the base '
        'need be round, for the swings are small.',
        (_CRADLE,),
    ),
    Paragraph(
        '51',
        'A cradle has infinitely more motions than the regular ones found before. *And* the '
        'floor may be curved.',
        (_CRADLE,),
    ),
    Paragraph(
        '52',
        'Three numbers describe a cradle. They are the distance *e* of both centres, the depth '
        '*c* of the centre of gravity, and the square of *k*.',
        (_CRADLE,),
    ),
    Paragraph(
        '53',
        'From them both lengths follow, and the path and tilt at any time. On a convex floor '
        '*−i* replaces *e*, as before.',
        (_CRADLE, _CONVEX),
    ),
)
EDITION = Edition(
    'C',
    'axle',
    'De motu penduli circa axem cylindricum, fulcro datae figurae incumbentem, mobilis. Remota '
    'frictione. Dissertatio prior',
    'The axle: a pendulum on a round axle',
    (
        (
            'Printed',
            'Acta academiae scientiarum imperialis Petropolitanae, tome IV, part II, for 1780, '
            'from page 133: the text begins on the third leaf of sheet R, and §36 is on the first '
            'page of sheet V, 153 (signatures in our text)',
        ),
        ('Plates', 'IV, figures 3 to 6, and V, figures 1 and 2 (margins)'),
        (
            'After it',
            'The title calls this the first dissertation, without friction. The second is not in '
            'our text',
        ),
        (
            'Not verified',
            "Eneström's number, the year in which the volume was printed, when the paper was "
            'presented, the place in the Opera Omnia, and a translation: no source that we could '
            'read names them',
        ),
    ),
    FIGURES,
    _PARAGRAPHS,
)
