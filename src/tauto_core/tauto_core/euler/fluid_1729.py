"""The claims of paper B, *Curva tautochrona in fluido* (1729), in the order of the paper.

Euler's letters: m and n are the densities of body and fluid, a the diameter of the globe or the
height of the cylinder, f and h the pendulum lengths of descent and ascent, e = f/2, b the height
of fall of the speed at A, l the natural logarithm and c its base. Tauto's are κ = 3n/8ma for a
globe, n/2ma for a cylinder, γ = (m − n)/m and β = γκf. Formulas are evaluated as they stand in
the text, for the example of `fluid_checks`; `computed` comes from quadrature and integrated
motion.
"""

from __future__ import annotations

import math

import numpy as np

from tauto_core.curves import FluidTautochrone
from tauto_core.curves.fluid import ActaCurve, abscissa, chained, coordinates
from tauto_core.euler import fluid_checks as check
from tauto_core.euler.edition import Claim, G
from tauto_core.euler.fluid_checks import (
    BETA,
    CLOSE,
    CYLINDER,
    FAIR,
    GAMMA,
    GLOBE,
    NOTHING,
    A,
    B,
    E,
    F,
    H,
    M,
    N,
    S,
)
from tauto_core.machines.fluid_pendulum import descent_time

_QUARTER = 0.5 * math.pi * math.sqrt(F / G)
_CURVE = FluidTautochrone(GLOBE, GAMMA, F)
# 8ma/3n, the inverse of κ [m].
_LONG = 8.0 * M * A / (3.0 * N)
# 3(m − n)nf/8mma, which is β.
_CUSP = 3.0 * (M - N) * N * F / (8.0 * M**2 * A)
# Factors of the exponential and of x in §23.
_CUBE = 64.0 * M**3 * A**2
_HEIGHT = 9.0 * (M - N) * N**2 * F

_SHORT = 0.01
# the remainder after three terms begins with κ³s³/60
_LEFT_OUT = (GLOBE * _SHORT) ** 3 / 50.0

# A κ at which the series of §27–28 converge, and the diameter of a globe that has it [m].
_THIN = 0.01
_WIDE = 3.0 * N / (8.0 * M * _THIN)


def claims() -> list[Claim]:
    """Return the claims of paper B in its order; each is computed."""
    return [
        *_of_the_acta(),
        *_motion(),
        *_cylinder(),
        *_cylinder_by_height(),
        *_globe(),
        *_ascent(),
        *_both(),
        *_globe_by_height(),
        *_series(),
        *_cusp(),
        *_height_of_cusp(),
        *_ascent_cusp(),
        *_by_slope(),
        *_curvature(),
        *_speeds(),
        *_arcs(),
        *_small_arcs(),
        *_friction(),
    ]


def _holds(
    paragraph: str,
    claim: str,
    stands: str,
    value: float,
    computed: float,
    tolerance: float = CLOSE,
    *,
    adds: str = '',
) -> Claim:
    return Claim('B', paragraph, claim, stands, value, computed, tolerance, adds=adds)


def _in_words(
    paragraph: str,
    claim: str,
    adds: str,
    value: float,
    computed: float,
    tolerance: float = CLOSE,
    *,
    euler: bool = True,
) -> Claim:
    """Return a claim that the text makes in words, or (`euler` false) does not make."""
    expected = 'holds' if euler else 'added'
    return Claim(
        'B',
        paragraph,
        claim,
        '',
        value,
        computed,
        tolerance,
        expected=expected,  # type: ignore[arg-type]
        adds=adds,
        euler=euler,
    )


def _corrected(
    paragraph: str,
    claim: str,
    stands: tuple[str, float],
    computed: float,
    must: tuple[str, float],
    because: str,
    tolerance: float = CLOSE,
    *,
    adds: str = '',
) -> Claim:
    """Return a claim that holds only as it must be."""
    return Claim(
        'B', paragraph, claim, *stands, computed, tolerance, *must, because, 'corrected', adds
    )


def _of_the_acta() -> list[Claim]:
    curve = ActaCurve(GLOBE, GAMMA, F, S)
    return [
        _in_words(
            '2-5',
            'on the curve of the Acta of 1726 only the descent from the arc *S* that it is made '
            'for takes *(π/2)√(f/g)*',
            'γf dx/ds = s + κ(S² − s²)',
            _QUARTER,
            descent_time(curve, G, S),
        ),
    ]


def _motion() -> list[Claim]:
    v, p = check.speed_height(S), check.slope(S)
    rate = check.derivative(check.speed_height, S)
    # 4a/3 for a: a globe
    pull = N * v / (M * A * 4.0 / 3.0)
    return [
        _holds(
            '12',
            'speed along the curve; here and in §13 of a globe, with *4a/3* for *a*',
            'dv = nvds : ma − (m − n)dx : m',
            pull - (M - N) / M * p,
            rate,
            FAIR,
        ),
        _corrected(
            '12',
            'the same, arranged to be integrated',
            ('dv  vds/ma − (m − n)dx/m', NOTHING),
            rate,
            ('dv − nvds/ma = −(m − n)dx/m', pull - (M - N) / M * p),
            'signs and *n* are lost; the equation before it has them',
            FAIR,
        ),
        _holds(
            '13',
            'height of fall *v* of the speed',
            'v = c^{ns/ma}(b − t), t = ((m − n)/m)∫c^{−ns/ma}dx',
            math.exp(N * S / (M * A * 4.0 / 3.0)) * (B - check.fallen(S)),
            v,
        ),
    ]


def _time_of_any_fall() -> float:
    """Return ∫ dt/√(bt − t²) from 0 to b, with t = b sin²u, by a sum."""
    u = (np.arange(16) + 0.5) * (0.5 * math.pi / 16)
    t = B * np.sin(u) ** 2
    speed = 2.0 * B * np.sin(u) * np.cos(u)
    return float(np.sum(speed / np.sqrt(B * t - t * t)) * (0.5 * math.pi / 16))


def _cylinder() -> list[Claim]:
    k = CYLINDER
    q = math.exp(-N * S / (2.0 * M * A))
    return [
        _corrected(
            '14',
            'the time does not depend on *b*, the value of *v* at *A*: its element',
            ('dt√e : √(bt − it)', NOTHING),
            math.pi,
            ('dt√e : √(bt − tt)', _time_of_any_fall()),
            '*i* has no meaning: the square of *t* is meant',
            adds='∫dt/√(bt − tt) = π for any b',
        ),
        _holds(
            '14',
            'length of the simple pendulum: a quarter swing takes *(π/2)√(2e/g)*',
            '2e',
            0.5 * math.pi * math.sqrt(2.0 * E / G),
            check.quarter(S),
        ),
        _holds(
            '15',
            'the curve for a cylinder, by *t*',
            '(m²a²/n²)(1 − c^{−ns/2ma})² = et',
            M**2 * A**2 / N**2 * (1.0 - q) ** 2 / E,
            check.fallen(S, k),
        ),
        _corrected(
            '15',
            'its differential',
            ('(na/n)(1 − c^{−ns/2ma})c^{−ns/2ma}ds = edt', A * (1.0 - q) * q / E),
            check.derivative(lambda s: check.fallen(s, k), S),
            (
                '(ma/n)(1 − c^{−ns/2ma})c^{−ns/2ma}ds = edt',
                M * A / N * (1.0 - q) * q / E,
            ),
            'the differential of the square needs *ma/n*; the equation after it has it',
            FAIR,
        ),
    ]


def _cylinder_by_height() -> list[Claim]:
    k = CYLINDER
    x = check.height(S, k)
    grown = math.exp(N * S / (2.0 * M * A))
    arc, factor = M**2 * A * S, (M - N) * N * E
    right = (2.0 * M**3 * A**2 / N * (grown - 1.0) - arc) / factor
    lost = math.log(M**1.5 * N * A * S + 2.0 * M**1.5 * A**2 + factor * x)
    mended = math.log(N * arc + 2.0 * M**3 * A**2 + factor * N * x)
    return [
        _corrected(
            '16',
            'the curve for a cylinder, by *x*',
            ('(2m^{3/2}aa/n)c^{ns/2ma} − mmads − 2m^{3/2}aa/n = (m − n)nex', NOTHING),
            x,
            ('(2m³aa/n)c^{ns/2ma} − mmas − 2m³aa/n = (m − n)nex', right),
            'a differential is left after the integration, and *m^{3/2}* does not match *mm · a*',
        ),
        _corrected(
            '16',
            'its logarithm, solved for *s*',
            (
                'ns/2ma = l(m^{3/2}nas + 2m^{3/2}aa + (m − n)n^{2/2}ex) − l 2m^{3/2}aa',
                (lost - math.log(2.0 * M**1.5 * A**2)) * 2.0 * M * A / N,
            ),
            S,
            (
                'ns/2ma = l(m²nas + 2m³aa + (m − n)n²ex) − l 2m³aa',
                (mended - math.log(2.0 * M**3 * A**2)) * 2.0 * M * A / N,
            ),
            'broken exponents: all three terms have the powers of *m³a² · n⁰*',
        ),
        _holds(
            '16-17',
            'differential equation of the curve for a cylinder',
            'm²asds + (m − n)nexds = 2(m − n)maedx',
            (arc + factor * x) / (2.0 * (M - N) * M * A * E),
            check.slope(S, k),
        ),
    ]


def _drag_of_globe(size: float, density: float) -> float:
    """Return κ of a globe from a drag coefficient of 1/2 on its section [1/m]."""
    mass = M * math.pi / 6.0 * size**3
    return 0.5 * 0.5 * density * 0.25 * math.pi * size**2 / mass


def _globe() -> list[Claim]:
    x, slope = check.height(S), check.slope(S)
    by_e = 4.0 * M**2 * A * S + 3.0 * (M - N) * N * E * x
    by_f = 8.0 * M**2 * A * S + 3.0 * (M - N) * N * F * x
    return [
        _holds(
            '17',
            'a globe is resisted like a cylinder of *4/3* of its diameter',
            '4a/3 for a',
            N / (2.0 * M * (4.0 * A / 3.0)),
            _drag_of_globe(A, N),
            adds='κ = 3n/8ma, a drag coefficient of 1/2 on the section',
        ),
        _holds(
            '17',
            'differential equation of the curve for a globe',
            '4m²asds + 3(m − n)nexds = 8(m − n)maedx',
            by_e / (8.0 * (M - N) * M * A * E),
            slope,
        ),
        _corrected(
            '17, 26',
            'the same, with *e = f/2*',
            ('8m²asds + 3(m − n)nfxdx = 8(m − n)mafdx', NOTHING),
            slope,
            ('8m²asds + 3(m − n)nfxds = 8(m − n)mafdx', by_f / (8.0 * (M - N) * M * A * F)),
            'the equation before it, and §29, have *xds*',
        ),
        _holds(
            '18',
            'without a fluid the curve is the cycloid',
            'ss = 2fx',
            S * S / (2.0 * F),
            GAMMA * check.height(S, kappa=1e-11),
        ),
    ]


def _ascent() -> list[Claim]:
    u, rise = check.height(-S, length=H), -check.slope(-S, length=H)
    forward = check.swing(S)[0] - check.quarter(S)

    def slope(length: float) -> float:
        whole = 8.0 * (M - N) * M * A * length
        return (8.0 * M**2 * A * S - 3.0 * (M - N) * N * length * u) / whole

    return [
        _in_words(
            '19-20',
            'ascents take the same time, whatever their arc',
            '(π/2)√(h/g), here h = f',
            _QUARTER,
            forward,
        ),
        _corrected(
            '20-21',
            'the branch of ascent, *−s* in place of *s*',
            ('8m²asds − 3(m − n)nbxds = 8(m − n)mabdx', slope(B)),
            rise,
            ('8m²asds − 3(m − n)nhxds = 8(m − n)mahdx', slope(H)),
            '*b* is the height of fall at *A*; the pendulum length, *f* of the descent, is *h* '
            'here',
        ),
    ]


def _both() -> list[Claim]:
    q = 0.5
    start = -math.log1p(-q) / GLOBE
    # down a branch of f, up one of h
    time = check.quarter(S) + check.ascent(S, H)
    return [
        _corrected(
            '21',
            'pendulum of the composed oscillation, down *f* and up *h*',
            ('(f + 2√fb + b)/4', 0.25 * (F + 2.0 * math.sqrt(F * B) + B)),
            G * (time / math.pi) ** 2,
            ('(f + 2√fh + h)/4', 0.25 * (F + 2.0 * math.sqrt(F * H) + H)),
            '*b* for *h*, as in §20',
        ),
        _in_words(
            '22',
            '*f = h* gives one continuous curve, on which every half swing, down and up, takes '
            'as long',
            'π√(f/g)',
            2.0 * _QUARTER,
            check.swing(S)[0],
        ),
        Claim(
            'B',
            '22',
            'perhaps swings in the other direction, down the branch of ascent, take as long too '
            f'(*q = 1 − c^(−κs) = {q:g}* at the start)',
            '',
            1.0,
            check.swing(-start)[0] / (2.0 * _QUARTER),
            CLOSE,
            because='*w = (c^{κs} − 1)/κ* obeys *ẅ = −(g/f)(w + κw²)*: *T = 1 + 5q²/12 − 5q³/18 '
            '+ …*, 1.00395 at *q = 0.1*, 1.0984 at 0.5, 1.538 at 0.9, without bound; the'
            ' errors of the two quarters, *±4q/3π*, cancel, so that it fails only at '
            'second order',
            expected='fails',
            adds='T : π√(f/g) = 1',
        ),
    ]


def _globe_by_height() -> list[Claim]:
    x, slope = check.height(S), check.slope(S)
    rest = 24.0 * M**2 * N * A * S
    right = (_CUBE * math.expm1(GLOBE * S) - rest) / _HEIGHT
    weak = 3.0 * N / (4.0 * M * A)
    by_f = 8.0 * M**2 * A * S + 3.0 * (M - N) * N * F * x
    u = check.height(-S, length=H)
    rise = 9.0 * (M - N) * N**2
    falling = (_CUBE * math.expm1(-GLOBE * S) + rest) / (rise * H)
    return [
        _corrected(
            '23, 31',
            'height of the cylinder that is equivalent to a globe, checked by *x* of its curve',
            (
                '2a/3 for a',
                (math.expm1(weak * S) - weak * S) / (GAMMA * weak * weak * F),
            ),
            x,
            ('4a/3 for a', right),
            '§17 has *4/3*, and only *4/3* gives 64, 24, 9 and *3n/8ma*',
        ),
        _holds(
            '23',
            'the curve for a globe',
            '64m³aac^{3ns/8ma} − 64m³aa − 24m²nas = 9(m − n)n²fx',
            right,
            x,
        ),
        _corrected(
            '23',
            'the differential equation with which it agrees',
            ('8m²asds + 3(m − n)nfcds = 8(m − n)mafdx', NOTHING),
            slope,
            ('8m²asds + 3(m − n)nfxds = 8(m − n)mafdx', by_f / (8.0 * (M - N) * M * A * F)),
            '*c* for *x*',
        ),
        _corrected(
            '23, 28',
            'the branch of ascent',
            (
                '64m³aac^{3nt/8ma} − 64m³aa + 24m²nat = 9(m − n)n²bu',
                (_CUBE * math.expm1(GLOBE * S) + rest) / (rise * B),
            ),
            u,
            ('64m³aac^{−3nt/8ma} − 64m³aa + 24m²nat = 9(m − n)n²hu', falling),
            '*s* has become *−t*, also in the exponent; *b* for *h*; §28 has *m* for *n²*',
        ),
    ]


def _series() -> list[Claim]:
    s = _SHORT
    x, u = check.height(s), check.height(-s)
    k = 3.0 * N / (8.0 * M)
    gain = 1.0 - 8.0 * k / 3.0
    first, second, third = s**2 / 2.0, k * s**3 / (6.0 * A), k**2 * s**4 / (24.0 * A**2)
    down, up = (first + side * second + third for side in (1.0, -1.0))
    before = k**2 * first + k**3 * s**2 / (6.0 * A) + k**4 * s**4 / (24.0 * A**2)
    after = first + k**3 * s**2 / (6.0 * A) + k**4 * s**4 / (24.0 * A**2)
    return [
        _holds(
            '24',
            'the curve of descent with *k = 3n/8m*',
            'a²c^{ks/a} − aa − kas = (1 − 8k/3)k²fx',
            (A**2 * math.expm1(k * S / A) - k * A * S) / (gain * k**2 * F),
            check.height(S),
        ),
        _corrected(
            '24',
            'its series',
            (
                'k²ss/1·2 + k³s²/a·1·2·3 + k⁴s⁴/a²·1·2·3·4 − etc = (1 − 8k/3)k²fx',
                before / (gain * k**2 * F),
            ),
            x,
            (
                'k²ss/1·2 + k³s³/a·1·2·3 + k⁴s⁴/a²·1·2·3·4 + etc = (1 − 8k/3)k²fx',
                down / (gain * F),
            ),
            '*s²* for *s³*; all terms of an exponential are positive',
            _LEFT_OUT,
        ),
        _corrected(
            '24',
            'the same, divided by *kk*',
            (
                'ss/1·2 + k³s²/a·1·2·3 + k⁴s⁴/a²·1·2·3·4 − etc = (1 − 8k/3)fx',
                after / (gain * F),
            ),
            x,
            ('ss/1·2 + ks³/a·1·2·3 + k²s⁴/a²·1·2·3·4 + etc = (1 − 8k/3)fx', down / (gain * F)),
            'two terms are not divided',
            _LEFT_OUT,
        ),
        _corrected(
            '24',
            'the series of the ascent',
            (
                'tt/1·2 + kf²/a·1·2·3 + k²t⁴/a²·1·2·3·4 − etc = (1 − 8k/3)hu',
                (first + k * F**2 / (6.0 * A) + third) / (gain * F),
            ),
            u,
            ('tt/1·2 − kt³/a·1·2·3 + k²t⁴/a²·1·2·3·4 − etc = (1 − 8k/3)hu', up / (gain * F)),
            '*f* is no arc, the term is of third order, and its sign changes with that of *t*',
            _LEFT_OUT,
        ),
        _corrected(
            '25',
            'the quantity that vanishes where both branches become cycloids: by it the curve of '
            'twice the globe in twice the fluid is the same',
            ('ka', 4.0),
            _drag_of_globe(2.0 * A, 2.0 * N) / _drag_of_globe(A, N),
            ('k : a', 1.0),
            'the sentence after it has *3n* : *8ma*',
        ),
        _in_words(
            '25',
            'both branches become cycloids as *3n/8ma* tends to 0',
            'x = s²/2γf, γ left as it is',
            S * S / (2.0 * GAMMA * F),
            check.height(S, kappa=1e-11),
        ),
    ]


def _cusp() -> list[Claim]:
    s = check.zero_of(lambda s: check.slope(s) - 1.0, 0.1, 1.5)
    x = check.height(s)
    bent = check.derivative(lambda s: math.asin(check.slope(s)), s - 1e-5, 1e-6)
    return [
        _holds(
            '26',
            'the curve turns back where *ds = dx*',
            '8m²as + 3(m − n)nfx = 8(m − n)maf',
            (8.0 * M**2 * A * s + 3.0 * (M - N) * N * F * x) / (8.0 * (M - N) * M * A * F),
            1.0,
        ),
        _holds(
            '26',
            'arc to that point',
            '64m³aac^{3ns/8ma} − 64m³aa = 24(m − n)mnaf',
            _LONG * math.log1p(24.0 * (M - N) * M * N * A * F / _CUBE),
            s,
        ),
        _corrected(
            '26',
            'the same, solved for *s*',
            (
                's = (8ma + 8m²a + 3(m − n)nf)/8mma − (8ma/3n)(1 + 3(m − n)nf/8mma)',
                NOTHING,
            ),
            s,
            ('s = (8ma/3n) l(1 + 3(m − n)nf/8mma)', _LONG * math.log1p(_CUSP)),
            'the *l* of the logarithm is lost, and two steps run together',
        ),
        _corrected(
            '26',
            'what kind of point it is, by its radius of curvature',
            ('punctum flexus contrarii', NOTHING),
            0.0,
            ('punctum reversionis', 1.0 / bent),
            'at an inflection the radius would be infinite; here it is 0',
            1e-2,
        ),
    ]


def _height_of_cusp() -> list[Claim]:
    s = check.zero_of(lambda s: check.slope(s) - 1.0, 0.1, 1.5)
    x = check.height(s)
    area = _CUBE / _HEIGHT
    end = check.zero_of(lambda s: check.slope(s, _THIN) - 1.0, 0.1, 1.5)
    a = _WIDE
    b = 3.0 * (M - N) * N * F / (8.0 * M**2 * a)
    # exponents of the text: (m − n)n²ff, (m − n)n²f³
    lost = b - 9.0 * (M - N) * N**2 * F**2 / (2.0 * 64.0 * M**4 * a**2)
    lost += 27.0 * (M - N) * N**2 * F**3 / (3.0 * 512.0 * M**6 * a**3) - b**4 / 4.0
    right = b - b**2 / 2.0 + b**3 / 3.0 - b**4 / 4.0
    first, second = (M - N) * F / (2.0 * M), 3.0 * (M - N) ** 2 * N * F**2 / (3.0 * 8.0 * M**3 * a)
    third = 9.0 * (M - N) ** 3 * N**2 * F**3 / (4.0 * 64.0 * M**5 * a**2)
    return [
        _holds(
            '27',
            'its height',
            'x = 8ma/3n − 8m²as/3(m − n)nf',
            _LONG - 8.0 * M**2 * A * s / (3.0 * (M - N) * N * F),
            x,
        ),
        _corrected(
            '27',
            'its arc, put into the height',
            ('s = (8ms/3n)(1 + 3(m − n)nf/8mma)', 8.0 * M * s / (3.0 * N) * (1.0 + _CUSP)),
            s,
            ('s = (8ma/3n) l(1 + 3(m − n)nf/8mma)', _LONG * math.log1p(_CUSP)),
            '*s* for *a*; the *l* of the logarithm is lost',
        ),
        _corrected(
            '27',
            'the height by the logarithm',
            (
                'x = 8ma/3n − (64m³aa/9(m − n)n²f)(1 + 3(m − n)nf/8mma)',
                _LONG - area * (1.0 + _CUSP),
            ),
            x,
            (
                'x = 8ma/3n − (64m³aa/9(m − n)n²f) l(1 + 3(m − n)nf/8mma)',
                _LONG - area * math.log1p(_CUSP),
            ),
            'the *l* of the logarithm is lost',
        ),
        _corrected(
            '27',
            'series of the logarithm (*κ = 0.01*)',
            (
                '3(m − n)nf/8mma − 9(m − n)n²ff/2·64m⁴aa + 27(m − n)n²f³/3·512m⁶a³ − …',
                lost,
            ),
            _THIN * end,
            (
                '3(m − n)nf/8mma − 9(m − n)²n²ff/2·64m⁴aa + 27(m − n)³n³f³/3·512m⁶a³ − …',
                right,
            ),
            'exponents are lost; the fourth term has them',
            b**4 / 4.0,
        ),
        _corrected(
            '27',
            'series of the height (*κ = 0.01*)',
            (
                'x = (m − n)f/2m − 3(m − n)²nff/3·8m³a + 9(m − n)³n²j²/4·64m⁵aa − …',
                NOTHING,
            ),
            check.height(end, _THIN),
            (
                'x = (m − n)f/2m − 3(m − n)²nff/3·8m³a + 9(m − n)³n²f³/4·64m⁵aa − …',
                first - second + third,
            ),
            'there is no *j*; the powers of *f* rise',
            2.0 * _THIN**3,
        ),
    ]


def _ascent_cusp() -> list[Claim]:
    t = check.zero_of(lambda t: check.slope(-t) + 1.0, 0.1, 4.0)
    s = check.zero_of(lambda s: check.slope(s) - 1.0, 0.1, 1.5)
    u = check.height(-t)
    end = check.zero_of(lambda t: check.slope(-t, _THIN) + 1.0, 0.1, 1.5)
    long = 3.0
    spread = GAMMA * GLOBE**2 * F

    def series(first: float, second: float, third: float) -> float:
        found = (M - N) * first / (2.0 * M)
        found += 3.0 * (M - N) ** 2 * N * second / (3.0 * 8.0 * M**3 * _WIDE)
        return found + 9.0 * (M - N) ** 3 * N**2 * third / (4.0 * 64.0 * M**5 * _WIDE**2)

    return [
        _in_words(
            '28',
            'arc to the cusp of the ascent, *h = f*',
            't = −(8ma/3n) l(1 − 3(m − n)nh/8mma)',
            -math.log1p(-BETA) / GLOBE,
            t,
            euler=False,
        ),
        _in_words(
            '28',
            'its height in closed form',
            'u = −1/κ − l(1 − β)/γκ²h',
            -1.0 / GLOBE - math.log1p(-BETA) / spread,
            u,
            euler=False,
        ),
        _corrected(
            '28',
            'series of the height (*κ = 0.01*, *h = f*)',
            (
                'u = (m − n)b/2m + 3(m − n)²nff/3·8m³a + 9(m − n)³n²b²/4·64m⁵aa etc',
                series(B, F**2, B**2),
            ),
            check.height(-end, _THIN),
            (
                'u = (m − n)h/2m + 3(m − n)²nhh/3·8m³a + 9(m − n)³n²h³/4·64m⁵aa etc',
                series(F, F**2, F**3),
            ),
            '*b* and *f* for *h*, and *b²* for its cube',
            2.0 * _THIN**3,
        ),
        _in_words(
            '28',
            'the cusp of the ascent is always higher than that of the descent: by how much',
            'u − x = (l((1 + β)/(1 − β)) − 2β)/γκ²f > 0',
            (math.log((1.0 + BETA) / (1.0 - BETA)) - 2.0 * BETA) / spread,
            u - check.height(s),
        ),
        _corrected(
            '28',
            'a long branch of ascent has no cusp; its slope then only tends to *8mma/3(m − n)nh*'
            ' (*h = 3 m*, *κt = 40*)',
            ('3(m − n)nf ≥ 8mma', 8.0 * M**2 * A / (3.0 * (M - N) * N * F)),
            -check.slope(-40.0 / GLOBE, length=long),
            ('3(m − n)nh ≥ 8mma', 8.0 * M**2 * A / (3.0 * (M - N) * N * long)),
            '*f* for *h*',
        ),
    ]


def _by_slope() -> list[Claim]:
    p = 1.0 / check.slope(S)

    def place(p: float) -> float:
        return check.height(check.zero_of(lambda s: 1.0 / check.slope(s) - p, 0.01, 0.65))

    rate = check.derivative(place, p, 1e-2)
    top = -8.0 * (M - N) * M * A * F
    right = top / (8.0 * M**2 * A * p**3 + 3.0 * (M - N) * N * F * p**2)
    lost = top / (8.0 * M**2 * A * p**2 + 3.0 * (M - N) * N * F * p)
    double = (8.0 * M**2 * A + 3.0 * (M - N) * N * F * check.slope(S)) / -top
    tau = math.asin(math.expm1(GLOBE * S) / BETA)
    w = math.sqrt(1.0 - BETA * BETA)
    turn = math.atan((math.tan(0.5 * tau) + BETA) / w) - math.atan(BETA / w)
    across = (math.cos(tau) - 1.0) / BETA + (tau - 2.0 * w * turn) / BETA**2
    return [
        _corrected(
            '29',
            'the differential equation differentiated once more, *ds* constant',
            ('8mmasds² + 3(m − n)nfdxds = 8(m − n)mafdx', NOTHING),
            check.derivative(check.slope, S),
            ('8mmads² + 3(m − n)nfdxds = 8(m − n)mafddx', double),
            '*s* is differentiated, and the second differential is meant',
            FAIR,
        ),
        _holds(
            '29',
            'the same by *p = ds/dx*',
            '8m²appdx + 3(m − n)nfpdx + 8(m − n)mafdp : p = 0',
            right,
            rate,
            FAIR,
        ),
        _corrected(
            '29',
            'the same, solved for *dx*',
            ('dx = −8(m − n)mafdp/(8m²ap² + 3(m − n)nfp)', lost),
            rate,
            ('dx = −8(m − n)mafdp/(8m²ap³ + 3(m − n)nfp²)', right),
            'the factor *1/p* of "*dp : p*" is lost',
            FAIR,
        ),
        _holds(
            '29',
            'the other coordinate',
            'dy = dx√(pp − 1)',
            GAMMA * F * across,
            float(abscissa(_CURVE, _CURVE.arc_of_height(check.height(S), 'descent'))),
            adds='y by circle and arc tangent, where β < 1',
        ),
    ]


def _curvature() -> list[Claim]:
    level = math.sqrt(1.0 - check.slope(S) ** 2)
    turning = check.derivative(lambda s: math.asin(check.slope(s)), S)
    at_lowest = check.derivative(lambda s: math.asin(check.slope(s, length=H)), 0.0)
    cusps = [chained(_CURVE, end, 1)[1] for end in (_CURVE.ascent_cusp, _CURVE.descent_cusp)]
    width = float(coordinates(_CURVE, _CURVE.descent_cusp)[1])
    width -= float(coordinates(_CURVE, _CURVE.ascent_cusp)[1])
    turned = _CUBE * math.expm1(-GLOBE * S) + 24.0 * M**2 * N * A * S
    return [
        _holds(
            '30',
            'the ascent by the equation of the descent: its height at the arc *S*',
            '−a for +a',
            turned / _HEIGHT,
            check.height(-S),
        ),
        _corrected(
            '30',
            'radius of curvature',
            ('(m − n)fdy/3ns', (M - N) * F * level / (3.0 * N * S)),
            1.0 / turning,
            (
                '(m − n)fdy/mc^{3ns : 8ma}ds',
                (M - N) * F * level / (M * math.exp(3.0 * N * S / (8.0 * M * A))),
            ),
            'the exponential has become the denominator *3ns*',
            FAIR,
        ),
        _corrected(
            '30',
            'radius of curvature at *A* (*f = 0.64* m)',
            ('(m − nf)/m', (M - N * H) / M),
            1.0 / at_lowest,
            ('(m − n)f/m', (M - N) * H / M),
            'a number times a density cannot be subtracted from one; it is *γf*',
            FAIR,
        ),
        _corrected(
            '30',
            'the arcs beyond the cusps are congruent to that between them: their width',
            ('BD, ED', NOTHING),
            width,
            ('BD, CE', cusps[0] - cusps[1]),
            'the arc at the other cusp, *C*, is meant',
        ),
    ]


def _speeds() -> list[Claim]:
    x, v = check.height(S), check.speed_height(S)
    grown = math.exp(GLOBE * S)
    scale = 32.0 * M**2 * A**2 / (9.0 * N**2 * F)
    fallen = check.fallen(S)
    rest = 24.0 * M**2 * N * A * S
    by_x = (rest + 9.0 * (M - N) * N**2 * F * x) / _CUBE
    by_fs = (rest + 9.0 * (M - N) * N * F**2 * S) / (64.0 * M**2 * A**2)
    square = (8.0 * M**2 * A * S + 3.0 * (M - N) * N * F * x) ** 2 / (128.0 * M**4 * A**2 * F)
    lost = (8.0 * M**2 * A * S + 3.0 * (M - N) * N * F**2 * S) ** 2
    lost /= 128.0 * M**4 * A**2 * F
    start = B * math.exp(3.0 * N * S / (4.0 * M * A))
    return [
        _corrected(
            '31',
            'the curve once more',
            (
                '64m³aac^{3ns/8ma} − 64n³aa − 24m²nas = 9(m − n)n²fx',
                (_CUBE * grown - 64.0 * N**3 * A**2 - rest) / _HEIGHT,
            ),
            x,
            (
                '64m³aac^{3ns/8ma} − 64m³aa − 24m²nas = 9(m − n)n²fx',
                (_CUBE * math.expm1(GLOBE * S) - rest) / _HEIGHT,
            ),
            '*n³* for *m³*; §23 has *m³*',
        ),
        _holds(
            '31',
            'its slope',
            '8m²ac^{3ns/8ma}ds − 8m²ads = 3(m − n)nfdx',
            8.0 * M**2 * A * (grown - 1.0) / (3.0 * (M - N) * N * F),
            check.slope(S),
        ),
        _holds(
            '32',
            'the *t* of §13',
            't = (32m²aa/9n²f)(1 − c^{−3ns/8ma})²',
            scale * (1.0 - 1.0 / grown) ** 2,
            fallen,
        ),
        _corrected(
            '32',
            'the same, with the exponential in front',
            (
                't = (32m²aa/9n²f)c^{3ns/8ma}(c^{3ns/8ma} − 1)²',
                scale * grown * (grown - 1.0) ** 2,
            ),
            fallen,
            (
                't = (32m²aa/9n²f)c^{−3ns/4ma}(c^{3ns/8ma} − 1)²',
                scale * (1.0 - 1.0 / grown) ** 2,
            ),
            '*t* must stay below *32m²aa/9n²f*, which is *1/2κ²f*',
        ),
        _corrected(
            '32',
            'the exponential by *s* and *x*',
            ('c^{3ns/8ma} − 1 = (24m²nas + 9(m − n)nf²s)/64m²aa', by_fs),
            math.expm1(GLOBE * S),
            ('c^{3ns/8ma} − 1 = (24m²nas + 9(m − n)n²fx)/64m³aa', by_x),
            '§23 has *n²fx* and *m³*',
        ),
        _corrected(
            '32',
            '*t* by *s* and *x*',
            (
                't = (8m²as + 3(m − n)nf²s)²/128m⁴aafc^{3ns/4ma}',
                lost / grown**2,
            ),
            fallen,
            ('t = (8m²as + 3(m − n)nfx)²/128m⁴aafc^{3ns/4ma}', square / grown**2),
            '*f²s* for *fx*',
        ),
        _holds(
            '32',
            'height of fall *v* of the speed at the arc *s* from *A*',
            'v = bc^{3ns/4ma} − (32m²aa/9n²f)(c^{3ns/8ma} − 1)²',
            start - scale * (grown - 1.0) ** 2,
            v,
        ),
        _corrected(
            '32',
            'the same by *s* and *x*',
            ('v = bc^{3ns/4ma} − (8m²as + 3(m − n)nf²s)²/128m⁴aaf', start - lost),
            v,
            ('v = bc^{3ns/4ma} − (8m²as + 3(m − n)nfx)²/128m⁴aaf', start - square),
            '*f²s* for *fx*',
        ),
    ]


def _arcs() -> list[Claim]:
    grown = math.exp(GLOBE * S)
    part = 9.0 * N**2 * B * F / (32.0 * M**2 * A**2)
    fastest = check.zero_of(
        lambda s: 2.0 * GLOBE * check.speed_height(s) - GAMMA * check.slope(s), 1e-3, 0.3
    )
    loss = 3.0 * N * math.sqrt(0.5 * B * F)
    start = check.zero_of(lambda s: check.fallen(s) - B, 0.1, math.log1p(BETA) / GLOBE)
    end = -check.swing(start)[1]
    return [
        _holds(
            '33',
            'change of *v* along the arc',
            'dv = (3nb/4ma)c^{3ns/4ma}ds − (8ma/3nf)(c^{3ns/8ma} − 1)c^{3ns/8ma}ds',
            3.0 * N * B / (4.0 * M * A) * grown**2 - _LONG / F * (grown - 1.0) * grown,
            check.derivative(check.speed_height, S),
            FAIR,
        ),
        _holds(
            '33',
            'arc before *A* at which the descent is fastest',
            's = (8ma/3n) log 32m²a²/(32m²a² − 9n²bf)',
            _LONG * math.log(32.0 * M**2 * A**2 / (32.0 * M**2 * A**2 - 9.0 * N**2 * B * F)),
            fastest,
        ),
        _corrected(
            '33',
            'the same, divided out',
            ('s = (8ma/3n)(1 − 9n²bf/32m²a²)', _LONG * (1.0 - part)),
            fastest,
            ('s = −(8ma/3n) l(1 − 9n²bf/32m²a²)', -_LONG * math.log1p(-part)),
            'sign and *l* are lost; the formula before it has the logarithm',
        ),
        _holds(
            '33',
            'arc of the descent',
            'c^{3ns/8ma} = 4ma/(4ma − 3n√½bf)',
            _LONG * math.log(4.0 * M * A / (4.0 * M * A - loss)),
            start,
        ),
        _corrected(
            '33',
            'the same, solved for *s*',
            (
                '(8ma/3n) log (1 − 3n√½bf)/4ma',
                _LONG * math.log((1.0 - loss) / (4.0 * M * A)),
            ),
            start,
            (
                '(8ma/3n) l 1/(1 − 3n√½bf/4ma)',
                -_LONG * math.log1p(-loss / (4.0 * M * A)),
            ),
            'two fractions run together; the formula before it has them apart',
        ),
        _corrected(
            '34',
            'arc of the ascent',
            (
                'totus arcus descensus = (8ma/3n) log (1 + 3n√½bf)/4ma',
                _LONG * math.log((1.0 + loss) / (4.0 * M * A)),
            ),
            end,
            (
                'totus arcus ascensus = (8ma/3n) l(1 + 3n√½bf/4ma)',
                _LONG * math.log1p(loss / (4.0 * M * A)),
            ),
            'the + belongs to the ascent, which resistance makes shorter; 1 over *4ma*, as in §33',
        ),
        _in_words(
            '34',
            'the arc from the greatest speed to A equals the loss of arc in the half swing',
            '−l(1 − 2κ²bf)/κ',
            -math.log1p(-2.0 * GLOBE**2 * B * F) / GLOBE,
            start - end,
            euler=False,
        ),
    ]


def _small_arcs() -> list[Claim]:
    small = 1e-4
    arc = check.zero_of(lambda s: check.fallen(s) - small, 1e-3, math.log1p(BETA) / GLOBE)
    other = -check.swing(arc)[1]
    bf = 0.5 * small * F
    terms = [3.0 * N / (2.0 * 2.0 * M * A), 9.0 * N**2 / (3.0 * 8.0 * M**2 * A**2)]
    terms.append(27.0 * N**3 / (4.0 * 32.0 * M**3 * A**3))

    def series(side: float, *powers: float) -> float:
        found = 2.0 * math.sqrt(bf)
        for sign, term, power in zip((side, 1.0, side), terms, powers, strict=True):
            found += sign * term * math.pow(bf, power)
        return found

    # the remainder after the leading terms, by the square of κ√(2bf)
    rough = (2.0 * GLOBE * math.sqrt(bf)) ** 2
    return [
        _corrected(
            '34',
            'series of the arc of descent',
            (
                '2√½bf + 3n(½bf)/2·2ma + 9nn(½bf)²/3·8m²a² + 27n³(½bf)³/4·32m³a³ etc',
                series(1.0, 1.0, 2.0, 3.0),
            ),
            arc,
            (
                '2√½bf + 3n(½bf)/2·2ma + 9nn(½bf)^{3/2}/3·8m²a² + 27n³(½bf)²/4·32m³a³ etc',
                series(1.0, 1.0, 1.5, 2.0),
            ),
            'the powers of *√½bf* rise by one',
            1e-8,
        ),
        _corrected(
            '34',
            'series of the arc of ascent',
            (
                '2√½bf − 3n(½bf)/2·2ma + 9n²(½bf)²/3·8m²a² − 27n³(½bf)³/4·32m³a³ etc',
                series(-1.0, 1.0, 2.0, 3.0),
            ),
            other,
            (
                '2√½bf − 3n(½bf)/2·2ma + 9n²(½bf)^{3/2}/3·8m²a² − 27n³(½bf)²/4·32m³a³ etc',
                series(-1.0, 1.0, 1.5, 2.0),
            ),
            'the powers of *√½bf* rise by one',
            1e-8,
        ),
        _holds(
            '34',
            'difference of both arcs, for a small *b*',
            '3nbf/4ma',
            3.0 * N * small * F / (4.0 * M * A),
            arc - other,
            rough,
        ),
        _holds(
            '34',
            'sum of both arcs, for a small *b*',
            '2√2bf',
            2.0 * math.sqrt(2.0 * small * F),
            arc + other,
            rough,
        ),
    ]


def _friction() -> list[Claim]:
    mu = 0.03

    def with_friction(s: float) -> float:
        return float(FluidTautochrone(GLOBE, GAMMA, F, mu).height(s))

    return [
        _corrected(
            '35',
            'for an additional constant resistance, what stands for *x* (*g* negative on the '
            'descent)',
            ('x + gr', NOTHING),
            check.slope(S) + mu,
            ('x + gs', check.derivative(with_friction, S)),
            'the resistance acts along the arc *s*; there is no *r*',
            FAIR,
        ),
        _in_words(
            '35',
            'with it the time of descent is unchanged',
            '(π/2)√(f/g)',
            _QUARTER,
            check.quarter(S, mu),
        ),
    ]
