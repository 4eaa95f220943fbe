"""What is known exactly of the problems, in 40 digits (mpmath).

The numbers of a problem are taken as the binary fractions they are. `Felt` is the ship at an
instant; `release` and `wheel` go from theta to the weight-driven machine's own (x, p) and back.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from mpmath import mp

from benchmarks.work_precision.equations.sea import turns_at
from benchmarks.work_precision.problems import Numbers, WheelProblem

DIGITS = 40
Real: TypeAlias = Any
"""mpmath's mpf, which has no types."""


@dataclass(frozen=True)
class Felt:
    """Roll and apparent vertical with their rates, [rad] and [rad/s]."""

    roll: Real
    roll_rate: Real
    vertical: Real
    vertical_rate: Real


def felt(numbers: Numbers, time_s: float) -> Felt:
    """Return what the machine feels of the ship at a time (theory/ship.md); zero on land."""
    sea = numbers.sea
    if sea is None:
        return Felt(mp.mpf(0), mp.mpf(0), mp.mpf(0), mp.mpf(0))
    r = [mp.mpf(0)] * 4
    for a, period, phase, turn in zip(
        sea.amplitude, sea.period, sea.phase, turns_at(sea, time_s), strict=True
    ):
        turns = mp.mpf(turn.numerator) / turn.denominator
        angle = 2 * mp.pi * turns + mp.mpf(float(phase))
        omega = 2 * mp.pi / mp.mpf(float(period))
        for k in range(4):
            r[k] += mp.mpf(float(a)) * omega**k * mp.cos(angle + k * mp.pi / 2)
    # the clock at height z0 moves as z0 i e^{i roll}; its acceleration and that one's rate
    turning = mp.expj(r[0])
    height = mp.mpf(sea.height)
    second = height * 1j * turning * (1j * r[2] - r[1] ** 2)
    third = height * 1j * turning * (1j * r[3] - 3 * r[1] * r[2] - 1j * r[1] ** 3)
    force = second + 1j * mp.mpf(numbers.gravity)
    return Felt(r[0], r[1], mp.arg(force) - mp.pi / 2, (third / force).imag)


def release(numbers: Numbers) -> tuple[Real, Real]:
    """Return x [rad] and p = M x' + I beta' [kg m2/s] of the weight-driven machine at release."""
    start = felt(numbers, 0.0)
    x = mp.mpf(numbers.release_angle) + start.roll - start.vertical
    speed = start.roll_rate - start.vertical_rate
    return x, _mass(numbers, x) * speed + mp.mpf(numbers.inertia) * start.vertical_rate


def wheel(numbers: Numbers, time_s: float, x: Real, p: Real) -> tuple[Real, Real]:
    """Return theta [rad] and theta' [rad/s] of the weight-driven machine."""
    now = felt(numbers, time_s)
    speed = (p - mp.mpf(numbers.inertia) * now.vertical_rate) / _mass(numbers, x)
    return x + now.vertical - now.roll, speed + now.vertical_rate - now.roll_rate


def _mass(numbers: Numbers, x: Real) -> Real:
    arm = mp.mpf(numbers.lever_rate) * x
    return mp.mpf(numbers.inertia) + mp.mpf(numbers.mass) * arm * arm


def exact_state(problem: WheelProblem, time_s: float) -> tuple[Real, Real]:
    """Return theta [rad] and theta' [rad/s] of problems a, b and d at a time."""
    numbers = problem.numbers
    with mp.workdps(DIGITS):
        if numbers.mass:
            return _carried(numbers, mp.mpf(time_s))
        return _forced(numbers, time_s)


def _frequency(numbers: Numbers) -> Real:
    pull = mp.mpf(numbers.force) + mp.mpf(numbers.mass) * mp.mpf(numbers.gravity)
    return mp.sqrt(pull * mp.mpf(numbers.lever_rate) / mp.mpf(numbers.inertia))


def _carried(numbers: Numbers, time: Real) -> tuple[Real, Real]:
    """Problem b: with x = A sin u, omega t = E(u | -eps) from the quarter, eps = m b^2 A^2/I.

    u' = omega/sqrt(1 + eps sin^2 u), and E is the incomplete elliptic integral of the second kind.
    """
    amplitude, omega = mp.mpf(numbers.release_angle), _frequency(numbers)
    eps = mp.mpf(numbers.mass) * (mp.mpf(numbers.lever_rate) * amplitude) ** 2
    eps /= mp.mpf(numbers.inertia)
    quarter = mp.ellipe(-eps)
    goal = quarter + mp.fmod(omega * time, 4 * quarter)
    u = mp.findroot(lambda u: mp.ellipe(u, -eps) - goal, goal * mp.pi / (2 * quarter))
    rate = omega / mp.sqrt(1 + eps * mp.sin(u) ** 2)
    return amplitude * mp.sin(u), amplitude * mp.cos(u) * rate


def _forced(numbers: Numbers, time_s: float) -> tuple[Real, Real]:
    """Problems a and d: each cosine of the roll answers with omega^2/(omega^2 - w^2) of itself.

    psi = sum a omega^2/(omega^2 - w^2) cos(w t + eps) + C cos omega t + S sin omega t.
    """
    omega = _frequency(numbers)
    forced0, rate0, roll0, roll_rate0 = _answer(numbers, omega, 0.0)
    forced, rate, roll, roll_rate = _answer(numbers, omega, time_s)
    c = mp.mpf(numbers.release_angle) + roll0 - forced0
    s = (roll_rate0 - rate0) / omega
    angle = omega * mp.mpf(time_s)
    psi = forced + c * mp.cos(angle) + s * mp.sin(angle)
    psi_rate = rate + omega * (s * mp.cos(angle) - c * mp.sin(angle))
    return psi - roll, psi_rate - roll_rate


def _answer(numbers: Numbers, omega: Real, time_s: float) -> tuple[Real, Real, Real, Real]:
    """Return the forced part of psi and its rate, roll and its rate."""
    parts = [mp.mpf(0)] * 4
    sea = numbers.sea
    if sea is None:
        return parts[0], parts[1], parts[2], parts[3]
    for a, period, phase, turn in zip(
        sea.amplitude, sea.period, sea.phase, turns_at(sea, time_s), strict=True
    ):
        w = 2 * mp.pi / mp.mpf(float(period))
        angle = 2 * mp.pi * mp.mpf(turn.numerator) / turn.denominator + mp.mpf(float(phase))
        value, rate = mp.mpf(float(a)) * mp.cos(angle), -mp.mpf(float(a)) * w * mp.sin(angle)
        gain = omega**2 / (omega**2 - w**2)
        parts = [
            parts[0] + gain * value,
            parts[1] + gain * rate,
            parts[2] + value,
            parts[3] + rate,
        ]
    return parts[0], parts[1], parts[2], parts[3]
