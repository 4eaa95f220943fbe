"""Paper B for its page: every paragraph, and its five figures constructed from the text.

The examples are those of `figures`: κ = 3n/8ma of a globe, γ = (m − n)/m = 0.9, lengths in metres.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves.fluid import FluidTautochrone, abscissa, chained, coordinates
from tauto_core.euler.edition import Control, Drawing, Edition, EulerFigure, G, Paragraph, Shown
from tauto_core.euler.figures import GAMMA
from tauto_core.machines.fluid_pendulum import (
    composed_length,
    descent_time,
    height_at_lowest,
    velocity_height,
)
from tauto_core.samples import FloatArray

_KAPPAS = Control('κ, 1/m', (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9), begin=5)
_ALONG = np.sin(np.linspace(0.0, 0.5 * math.pi, 41))
_START = 0.55
"""Arc of the release in the first figure [m]."""


def _branch(curve: FluidTautochrone, end: float) -> tuple[FloatArray, FloatArray]:
    """Return the curve from A to an arc: horizontal places and heights [m]."""
    height, level = coordinates(curve, end * _ALONG)
    return level, height


def _figure_1(kappa: float, part: float) -> Shown:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    arc = part * _START
    b = height_at_lowest(curve, _START)
    drawing = Drawing(-0.12, 0.62, -0.07, 0.42)
    x, y = _branch(curve, 0.65)
    drawing.curve(x, y, 'curve')
    drawing.line((0.0, 0.0), (0.0, 0.4))
    (height, near_height), (level, near_level) = coordinates(curve, np.array([arc, 1.12 * arc]))
    (top,), (start,) = coordinates(curve, np.array([_START]))
    drawing.line((0.0, height), (level, height))
    drawing.line((0.0, near_height), (near_level, near_height), look='thin')
    for place, name, right, up in (
        ((0.0, 0.0), 'A', -4.0, -12.0),
        ((0.0, height), 'P', -10.0, -2.0),
        ((0.0, near_height), 'p', -10.0, 3.0),
        ((level, height), 'M', 10.0, -5.0),
        ((near_level, near_height), 'm', 2.0, 11.0),
        ((start, top), 'E', -2.0, 12.0),
        ((float(x[-1]), float(y[-1])), 'C', 10.0, 2.0),
    ):
        drawing.letter(place, name, right, up)
    v = float(velocity_height(curve, arc, b))
    seconds = descent_time(curve, G, arc)
    return Shown(
        drawing,
        f'AM = s = {arc:.3f} m, AP = x = {height:.4f} m. From E the globe passes M with v = '
        f'{1e3 * v:.2f} mm and A with b = {1e3 * b:.2f} mm. From rest at M it needs '
        f'{seconds:.6f} s to A.',
    )


def _figure_2(descent: float, ascent: float) -> Shown:
    down, up = (FluidTautochrone(0.75, GAMMA, each) for each in (descent, ascent))
    drawing = Drawing(-0.82, 0.82, -0.08, 0.78)
    # both branches to their cusps, at most as long as the sheet is wide
    right, high = _branch(down, min(down.descent_cusp, 0.8))
    left, steep = _branch(up, max(up.ascent_cusp, -0.8))
    drawing.line((0.0, 0.0), (0.0, 0.7), look='thin')
    drawing.curve(right, high, 'curve')
    drawing.curve(left, steep, 'other')
    arc = 0.6 * down.descent_cusp
    # the arc of the ascent from b at A (§34)
    lowest = height_at_lowest(down, arc)
    far = math.log1p(up.kappa * math.sqrt(2.0 * lowest * ascent)) / up.kappa
    (x,), (y,) = coordinates(down, np.array([arc]))
    (u,), (w,) = coordinates(up, np.array([-far]))
    drawing.line((0.0, x), (y, x))
    drawing.line((0.0, u), (w, u))
    for place, name, aside, above in (
        ((0.0, 0.0), 'A', -2.0, -12.0),
        ((0.0, x), 'P', -9.0, 3.0),
        ((y, x), 'M', 10.0, -5.0),
        ((0.0, u), 'Q', 9.0, 3.0),
        ((w, u), 'N', -10.0, -5.0),
    ):
        drawing.letter(place, name, aside, above)
    length = composed_length(descent, ascent)
    return Shown(
        drawing,
        f'f = {descent:g} m, h = {ascent:g} m: a half swing takes as long as one of a pendulum of '
        f'{length:.5f} m, {math.pi * math.sqrt(length / G):.5f} s, from any start. From AM = '
        f'{arc:.4f} m the globe gets to AN = {far:.5f} m.',
    )


def _figure_3(kappa: float) -> Shown:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    drawing = Drawing(-0.12, 1.25, -0.07, 0.86)
    arc = np.linspace(0.0, 1.2, 60)
    height = curve.height(arc)
    seen = height <= 0.8
    drawing.line((0.0, 0.0), (0.0, 0.8))
    drawing.curve(arc[seen], height[seen], 'curve')
    cusp = curve.descent_cusp
    top = float(curve.height(cusp))
    drawing.line((cusp - 0.12, top - 0.12), (cusp + 0.1, top + 0.1), look='other')
    middle = 0.6 * cusp
    low = float(curve.height(middle))
    drawing.line((0.0, low), (middle, low))
    for place, name, right, up in (
        ((0.0, 0.0), 'A', -4.0, -11.0),
        ((0.0, low), 'P', -10.0, 2.0),
        ((middle, low), 'M', 10.0, -5.0),
        ((float(arc[seen][-1]), float(height[seen][-1])), 'B', 11.0, 2.0),
    ):
        drawing.letter(place, name, right, up)
    drawing.note((cusp, top), 'ds = dx', 28.0, -8.0)
    return Shown(
        drawing,
        f'ds = dx at s = {cusp:.5f} m, x = {top:.5f} m: there the tautochrone stands upright, and '
        'turns back.',
    )


def _figure_4(ascent: float) -> Shown:
    curve, down = (FluidTautochrone(0.75, GAMMA, each) for each in (ascent, 1.0))
    drawing = Drawing(-0.12, 1.9, -0.1, 1.25)
    for each, sign, look in ((down, 1.0, 'faint'), (curve, -1.0, 'curve')):
        arc = np.linspace(0.0, 1.85, 90)
        height = each.height(sign * arc)
        seen = height <= 1.2
        drawing.curve(arc[seen], height[seen], look)
    drawing.line((0.0, 0.0), (0.0, 1.2))
    arc_n = 0.5
    low = float(curve.height(-arc_n))
    drawing.line((0.0, low), (arc_n, low))
    for place, name, right, up in (
        ((0.0, 0.0), 'A', -4.0, -11.0),
        ((0.0, low), 'Q', -10.0, 2.0),
        ((arc_n, low), 'N', 10.0, -5.0),
    ):
        drawing.letter(place, name, right, up)
    drawing.note((0.95, 1.1), 'descent', -22.0, 0.0)
    cusp = -curve.ascent_cusp
    if math.isinf(cusp):
        return Shown(
            drawing,
            f'h = {ascent:g} m: 3(m − n)nh is at least 8mma, β = {curve.beta:.4f}. The curve '
            'never gets as steep as dt = du, so the ascent has no point of return.',
        )
    top, other = float(curve.height(-cusp)), float(curve.height(curve.descent_cusp))
    if top < 1.2:
        drawing.line((cusp - 0.15, top - 0.15), (cusp + 0.12, top + 0.12), look='other')
        drawing.note((cusp, top), 'dt = du', 30.0, -8.0)
    return Shown(
        drawing,
        f'h = {ascent:g} m, β = γκh = {curve.beta:.4f}: dt = du at t = {cusp:.5f} m, u = '
        f'{top:.5f} m; on the descent of f = h it is at x = {other:.5f} m.',
    )


def _figure_5(kappa: float) -> Shown:
    curve = FluidTautochrone(kappa, GAMMA, 1.0)
    ends = curve.ascent_cusp, curve.descent_cusp
    share = np.sin(np.linspace(-0.5, 0.5, 61) * np.pi)
    arc = np.where(share < 0.0, -ends[0], ends[1]) * share
    beyond = np.array([chained(curve, float(s), 1) for s in arc]).T
    x, y = coordinates(curve, arc)
    width = 2.0 * abs(beyond[1][0] - beyond[1][-1])
    drawing = Drawing(-4.0, 3.0, -0.25, 1.75)
    for shift in (0.0, -width):
        drawing.curve(beyond[1] + shift, beyond[0], 'faint')
    drawing.curve(y, x, 'curve')
    for place, name, right, up in (
        ((0.0, 0.0), 'A', 0.0, -12.0),
        ((float(y[-1]), float(x[-1])), 'B', 0.0, 11.0),
        ((float(y[0]), float(x[0])), 'C', 0.0, 11.0),
        ((float(beyond[1][0]), float(beyond[0][0])), 'D', -4.0, 11.0),
        ((float(beyond[1][-1]) - width, float(beyond[0][-1])), 'E', 4.0, 11.0),
    ):
        drawing.letter(place, name, right, up)
    across = float(abscissa(curve, ends[1]) - abscissa(curve, ends[0]))
    return Shown(
        drawing,
        f'B is {float(x[-1]):.4f} m and C {float(x[0]):.4f} m high; BD and CE are as wide as BC, '
        f'{across:.4f} m.',
    )


_LENGTHS = (0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)
FIGURES = (
    EulerFigure(
        '1',
        'The curve *CMA* with its vertical axis *AP*, and the release *E*; *P* and *M*, *p* and '
        '*m* are neighbours. Here *f = 1* m, *γ = 0.9* and *AE = 0.55* m.',
        _figure_1,
        (_KAPPAS, Control('AM : AE', (0.2, 0.35, 0.5, 0.65, 0.8, 0.95), begin=3)),
    ),
    EulerFigure(
        '2',
        'The branch *AM* for the descent, of a pendulum *f*, and *AN* for the ascent, of a '
        'pendulum *h*. A body released at *M* gets to *N*.',
        _figure_2,
        (Control('f, m', _LENGTHS, begin=6), Control('h, m', _LENGTHS, begin=3)),
    ),
    EulerFigure(
        '3',
        'The auxiliary curve *AMB*: above *AP = x* the distance *PM* is the arc *s* of the '
        'tautochrone.',
        _figure_3,
        (_KAPPAS,),
    ),
    EulerFigure(
        '4',
        'The same for the ascent: *AQ = u*, *QN = t*.',
        _figure_4,
        (
            Control(
                'h, m', (0.2, 0.4, 0.6, 0.8, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 2.0), begin=4
            ),
        ),
    ),
    EulerFigure(
        '5',
        'The whole curve: *BA* for the descent, *AC* for the ascent, and its continuation in '
        '*BD* and *CE*, dashed.',
        _figure_5,
        (Control('κ, 1/m', (0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9), begin=5),),
    ),
)  # fmt: skip


# -----------------------------------------------------------------------------
# The paragraphs.

_LAND = 'tauto isochronism globe_in_oil --amplitudes 0.1,0.3,0.5'
_TWO = 'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.ascent_length=0.7'
_CAM = 'tauto cam globe_in_oil --svg globe_in_oil.svg'
_PARAGRAPHS = (
    Paragraph(
        '1',
        'The cycloid is the tautochrone in a vacuum, and Newton showed that it stays one where '
        'the resistance is proportional to the speed. For any other resistance nobody has found '
        'one.',
        (
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.fluid_density=0 '
            '--set regulator.curve=cycloid --set regulator.viscous=0.3',
        ),
    ),
    Paragraph(
        '2',
        'On a suitable curve a body descends in a resisting medium just as on a cycloid in a '
        'vacuum. Euler had published such curves in 1726 and called them tautochrones.',
        (_LAND,),
    ),
    Paragraph(
        '3',
        'Each of those curves fits one start only. From another start the descent is another, so '
        'that the times differ.',
        (_LAND,),
    ),
    Paragraph(
        '4',
        'The equations of 1726 contain a quantity that looks constant and depends on the start. '
        'Hermann found the same, and showed that the times are not equal.',
        (_LAND,),
    ),
    Paragraph(
        '5',
        'So those equations give a family of curves, each with its own proper start. After many '
        'attempts Euler has found the tautochrone for a resistance that grows with the square of '
        'the speed.',
        (_LAND,),
        lacks='The curves of 1726 are checked by a claim, and no scene sails them. They are '
        'tautochrones for no clock.',
    ),
    Paragraph(
        '6',
        'A new method needs the speed at every point of any curve. It can be expressed only in a '
        'vacuum, and in a medium that resists with the square of the speed, as fluids are thought '
        'to do.',
        (_LAND,),
    ),
    Paragraph(
        '7',
        'Euler first asked for the curve that completes a given one, so that the swings over both '
        'are equal. He could not find it, because equal speeds do not occur at the same points in '
        'every swing, and he asks for the descent alone.',
        (
            'tauto isochronism companion_in_oil --amplitudes 0.1,0.3',
            'tauto sail companion_in_oil',
            'tauto cam companion_in_oil --svg companion_in_oil.svg',
        ),
        found='The question has an answer. Up to a height, a given branch for the descent has a '
        'companion for the ascent that makes all half swings equal; both can be cut and sailed.',
    ),
    Paragraph(
        '8',
        'Let the body descend from *E* to *A*, and let *b* be the height of fall of its speed at'
        ' *A*. Seen backwards this is an ascent in which the resistance drives.',
        ('tauto plot globe_in_oil machine',),
        ('1',),
    ),
    Paragraph(
        '9',
        'The body is a cylinder of the height *a* that moves along its axis, and *m* is to *n* '
        'as its density to that of the fluid. At *M*, with the arc *s* and the height *x*, its '
        'speed is that of a fall from the height *v*.',
        ('tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.body=cylinder',),
    ),
    Paragraph(
        '10',
        'Only the excess of its weight over that of the displaced fluid drives the body. This is'
        ' *m − n* parts of *m*, and changes *v* in this proportion to the height.',
        ('tauto isochronism globe_in_oil --amplitudes 0.1 --set regulator.fluid_density=1500',),
    ),
    Paragraph(
        '11',
        'The resistance is taken as the weight of a column of the fluid with the base of the '
        'cylinder and the height *v*. So it is to the weight of the body as *nv* to *ma*.',
        ('tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.body=cylinder',),
    ),
    Paragraph(
        '12',
        'Both together give a differential equation for *v*, which is linear. An exponential of '
        'the arc as factor makes it integrable.',
        (_LAND,),
    ),
    Paragraph(
        '13',
        'With *t* for an integral that the curve decides, *v* is the exponential times *b − t*. '
        'The speed vanishes where *t* equals *b*.',
        ('tauto euler --page claims',),
    ),
    Paragraph(
        '14',
        'The time is an integral over *t*, and must not depend on *b*. That is so where its '
        'element has no dimension, which decides *s* as a function of *t*.',
        (_LAND,),
    ),
    Paragraph(
        '15',
        'Integrating gives the root of *t* as an exponential of the arc. With the meaning of *t*'
        ' this becomes a differential equation between the arc and the height.',
        (_CAM,),
    ),
    Paragraph(
        '16',
        'It can be integrated once more. Without the exponential it becomes an equation of the '
        'first order between *s* and *x*.',
        (_CAM,),
    ),
    Paragraph(
        '17',
        'A cylinder of the height a descends on this curve in equal times from anywhere. A globe'
        ' of the diameter a needs the same curve with four thirds of *a* for *a*.',
        (
            _LAND,
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.body=cylinder',
        ),
    ),
    Paragraph(
        '18',
        'Where the fluid has no density the curve is the cycloid. Only in a fluid do size, shape '
        'and density of the body matter.',
        ('tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.fluid_density=0',),
    ),
    Paragraph(
        '19',
        'An ascent meets gravity and resistance together. Its equation is that of the descent '
        'with another sign of the resistance.',
        (_TWO,),
    ),
    Paragraph(
        '20',
        'The same follows where the arc *s* becomes negative. So the tautochrone of the ascent '
        'is that of the descent with *−s* for *s*, and may have another length of pendulum.',
        (_TWO,),
    ),
    Paragraph(
        '21',
        'Joined at their lowest points, the two branches make whole swings equal. Such a swing '
        'takes half the time of a pendulum *f* and half that of a pendulum *h*.',
        (_TWO, 'tauto sail globe_in_oil --set regulator.ascent_length=0.7'),
        ('2',),
    ),
    Paragraph(
        '22',
        'Where both lengths are equal the branches are one continuous curve. The descents must be '
        'on one side of it and the ascents on the other, unless swings the other way should be '
        'equal too.',
        (_LAND, 'tauto sail globe_in_oil'),
    ),
    Paragraph(
        '23',
        'The equations with exponentials for globes follow, of the descent and of the ascent. '
        'They suffice to construct both curves.',
        (_CAM,),
    ),
    Paragraph(
        '24',
        'The exponential becomes a series, and with *k* for *3n/8m* so do both curves. Their '
        'first term is that of the cycloid.',
        (_CAM,),
    ),
    Paragraph(
        '25',
        'Both branches approach cycloids where the fluid is thin or the globe is large. So one '
        'sees how far a cycloid is from a tautochrone in a given fluid.',
        (
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.diameter=1',
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.curve=cycloid',
        ),
    ),
    Paragraph(
        '26',
        'An auxiliary curve has the arcs *s* as distances from its axis. It bends one way for '
        'ever, like a parabola, and the tautochrone turns back where its element equals that of '
        'the axis.',
        (_CAM,),
        ('3',),
    ),
    Paragraph(
        '27',
        'The height of that point follows, with a logarithm, and as a series. The thinner the '
        'fluid or the larger the globe, the higher it is.',
        (_CAM,),
    ),
    Paragraph(
        '28',
        'For the ascent the auxiliary curve is like a hyperbola and leaves its axis much faster. '
        'The point of return is always higher than on the descent, and does not exist where the '
        'pendulum is long.',
        (_CAM,),
        ('4',),
    ),
    Paragraph(
        '29',
        'With *p* for *ds/dx* both coordinates become integrals over *p*. So the curve can be '
        'constructed by quadratures.',
        ('tauto cam globe_in_oil --csv globe_in_oil.csv',),
    ),
    Paragraph(
        '30',
        'The ascent needs only the opposite sign of *a*, and the radius of curvature at *A* is '
        'the length of a pendulum in this fluid. Beyond its two points of return the curve '
        'continues in equal arcs.',
        (_CAM, 'tauto plot globe_in_oil machine'),
        ('5',),
    ),
    Paragraph(
        '31',
        'How does a globe move on the curve, if its speed at *A* is that of a fall from *b*? The'
        ' formula for *v* is joined with the equation of the curve.',
        ('tauto euler --page claims',),
    ),
    Paragraph(
        '32',
        'The integral *t* becomes a square, and *v* is found by the arc alone. With *s* and *x* '
        'the exponential disappears.',
        ('tauto euler --page claims',),
    ),
    Paragraph(
        '33',
        'The globe is fastest before it gets to *A*, and the arc between grows with *bf*. The '
        'whole arc of the descent follows where *v* vanishes.',
        ('tauto euler --page claims',),
    ),
    Paragraph(
        '34',
        'The arc of the ascent has the same formula with the other sign, and is shorter. For '
        'small swings the difference of both arcs is as the square of their sum.',
        (_LAND,),
    ),
    Paragraph(
        '35',
        'For other powers of the speed the method fails, because the speed cannot be expressed. '
        'A resistance that is constant, as Newton has it for the tenacity of fluids, only adds a'
        ' multiple of the arc to *x*.',
        (
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.friction=0.02',
            'tauto sail globe_in_oil --set regulator.friction=0.02',
            'tauto isochronism globe_in_oil --amplitudes 0.1,0.3 --set regulator.viscous=0.3',
        ),
        lacks='A term linear in the speed beside the square leaves the half swings forward equal'
        ' on the same curve: *z* is then a damped harmonic swing. Other powers have no '
        'tautochrone here, for the reason that Euler gives.',
    ),
)
EDITION = Edition(
    'B',
    'fluid',
    'Curva tautochrona in fluido resistentiam faciente secundum quadrata celeritatum',
    'The fluid: a tautochrone against resistance',
    (
        ('Number', "E13 in Eneström's list (17centurymaths.com, contents of Euler's papers)"),
        (
            'Printed',
            'Commentarii academiae scientiarum Petropolitanae, tome IV, from page 67: the text '
            'begins on the second leaf of sheet I, and §26 is on the first page of sheet L, 81 '
            '(signatures in our text)',
        ),
        ('Dated', 'October 1729, plate VII (margin of §1)'),
        (
            'Translated',
            'Ian Bruce, with notes and the Latin (17centurymaths.com, "Euler: Some Papers", E013)',
        ),
        (
            'Before it',
            'The construction of isochronous curves in media with different forms of resistance, '
            'Acta Eruditorum, August 1726, pages 361 to 363, to which §2 refers (title and pages '
            "in Ian Bruce's translation)",
        ),
        (
            'After it',
            'E21, Quomodo data quacunque curva inveniri oporteat aliam quae cum data quodammodo '
            'iuncta ad tautochronismum producendum sit idonea, presented on 7 March 1732, has the '
            'question of §7 for its title (Euler Archive, page E021; its text was not read); '
            'Mechanica, volume II, propositions 88 and 89, return to it '
            "(Ian Bruce's translation, at superphysics.org)",
        ),
        (
            'Not verified',
            'The year in which the volume was printed, the last page, and the place in the Opera '
            'Omnia: no source that we could read names them',
        ),
    ),
    FIGURES,
    _PARAGRAPHS,
)
