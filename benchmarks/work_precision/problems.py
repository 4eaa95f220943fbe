"""The problems of the benchmark: two machines, on land and in one sea, and a suspended case.

In a to e every program solves the same equation (docs/theory/machine_at_sea.md), with psi the
wheel's absolute angle, rho the roll, b the lever arm per angle:

    a, d   I psi'' + P b (psi - gamma) = 0,                        gamma = rho
    b, c   (I + m b^2 x^2) x'' + m b^2 x x'^2 + m g_eff b x = -I gamma'',   x = psi - gamma
    e      the same with -c theta' on the right and impulses where theta passes zero

gamma is the apparent vertical beta (b, c, e), theta = psi - rho the wheel's angle in its case,
released at rest there. rho is the exact sum of the sea's components, and beta and g_eff follow
from it (docs/theory/ship.md), so that Tauto's error by sampling the ship counts.

f is the pendulum on its axle at any angles, on land (C in axle.md): a case in its bearing,
released at rest at theta = phi = 0.7 rad, 40 degrees. Both modes swing and the motion is regular:
the distance of two releases 1e-10 rad apart grows like the time (7e-8 rad after 1000 s, 7e-7 rad
after 10,000 s; from releases at 1 rad it grows faster).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from tauto_core.machines.axle_pendulum import modes
from tauto_core.samples import FloatArray
from tauto_core.scene import Scene
from tauto_core.scene.times import DAY_S, STANDARD_GRAVITY
from tauto_core.ship.motions.sea import SeaShip, sea_motion

PASSAGE_S = 81.0 * DAY_S
"""The passage to Jamaica of 1761 [s]."""
TEN_DAYS_S = 10.0 * DAY_S

QUALITY = 200.0
"""Quality factor of problem e: I omega/c."""

_INVOLUTE = {
    'inertia': 4e-4,
    'cam': {'kind': 'involute', 'base_radius': 0.0025},
    'thread': {'kind': 'vertical'},
    'power': {'kind': 'weight', 'mass': 0.644},
    'release_angle': 1.0,
}
_SECOND_CAM = {
    'inertia': 4e-4,
    'cam': {'kind': 'hole', 'lever_rate': 0.01},
    'thread': {'kind': 'hole', 'distance': 0.08},
    'power': {'kind': 'force', 'force': 1.5791367},
    'release_angle': 1.0,
}
_AT_SEA = {
    'kind': 'sea',
    'sea': {
        'spectrum': 'bretschneider',
        'significant_wave_height': 2.5,
        'peak_period': 9.0,
        'components': 32,
    },
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'height': 2.5,
    'rate': 20.0,
}


@dataclass(frozen=True)
class Sea:
    """Roll as an exact sum, rho = sum amplitude cos(omega t + phase), t from the start.

    Attributes:
        amplitude: [rad], shape (n,).
        omega: 2 pi/period, rounded [rad/s], shape (n,).
        phase: [rad], shape (n,).
        height: height of the clock above the roll axis [m].
        period: exact period, from which references compute omega in full [s], shape (n,).
    """

    amplitude: FloatArray
    omega: FloatArray
    phase: FloatArray
    height: float
    period: FloatArray


@dataclass(frozen=True)
class Numbers:
    """The numbers in a problem's equation.

    Attributes:
        inertia: I of the wheel [kg m2].
        lever_rate: b, lever arm per angle [m/rad].
        force: P, pull without inertia [N]; 0 with a weight.
        mass: m of the weight [kg]; 0 with a force.
        gravity: g [m/s2].
        viscous: c of the torque -c theta' [N m s].
        impulse_energy: given to the wheel each time theta passes zero [J]; 0: no impulses.
        release_angle: theta at the start, at rest in the case [rad].
        sea: None on land.
        follows_vertical: whether gamma is the apparent vertical instead of the roll.
    """

    inertia: float
    lever_rate: float
    force: float
    mass: float
    gravity: float
    viscous: float
    impulse_energy: float
    release_angle: float
    sea: Sea | None
    follows_vertical: bool

    @property
    def frequency(self) -> float:
        """Angular frequency of small free swings on land [rad/s]."""
        pull = self.force + self.mass * self.gravity
        return math.sqrt(pull * self.lever_rate / self.inertia)


@dataclass(frozen=True)
class HungCase:
    """The numbers of the case on its axle (C in axle.md).

    Attributes:
        e: radius of the hollow less that of the axle [m].
        c: depth of the centre of gravity below the axle's centre [m].
        k: radius of gyration [m].
        gravity: g [m/s2].
        release_angle: theta = phi at the start, at rest [rad].
    """

    e: float
    c: float
    k: float
    gravity: float
    release_angle: float

    @property
    def frequency(self) -> float:
        """Angular frequency of small swings in the slow mode [rad/s]."""
        return math.sqrt(modes(self.e, self.c, self.k**2).squared_frequencies(self.gravity)[0])


@dataclass(frozen=True)
class WheelProblem:
    """A problem of the benchmark about the wheel: the scene for Tauto, its numbers for the peers.

    `period_s` is that of small free swings on land. An oscillation is counted as this long, and
    an error in rad becomes one in seconds by it. `duration_s` is the full length.
    """

    key: str
    title: str
    scene: Scene
    numbers: Numbers
    period_s: float
    duration_s: float


@dataclass(frozen=True)
class CaseProblem:
    """A problem about the suspended case; no scene lets it go at a large angle.

    `period_s` is that of small swings in the slow mode, else as of a `WheelProblem`.
    """

    key: str
    title: str
    numbers: HungCase
    period_s: float
    duration_s: float


Problem: TypeAlias = WheelProblem | CaseProblem

_HUNG_CASE = HungCase(e=0.015, c=0.1, k=0.05, gravity=STANDARD_GRAVITY, release_angle=0.7)


@cache
def problems() -> tuple[Problem, ...]:
    """Return the problems in order of their keys."""
    return (
        _problem('a', "Euler's second cam with a force, on land", _SECOND_CAM, PASSAGE_S),
        _problem('b', 'weight-driven involute, on land', _INVOLUTE, PASSAGE_S),
        _problem('c', 'weight-driven involute at sea', _INVOLUTE, TEN_DAYS_S, ship=_AT_SEA),
        _problem(
            'd', "Euler's second cam with a force, at sea", _SECOND_CAM, TEN_DAYS_S, ship=_AT_SEA
        ),
        _problem(
            'e',
            'weight, drag and escapement at sea',
            _INVOLUTE,
            TEN_DAYS_S,
            ship=_AT_SEA,
            **_kept_going(),
        ),
        _case_problem('f', 'axle pendulum at large angles, on land', _HUNG_CASE, TEN_DAYS_S),
    )


def _kept_going() -> dict[str, dict[str, object]]:
    """Return drag of the quality Q and impulses that make good for it at 1 rad.

    c = I omega/Q; half a swing of amplitude A loses pi/2 c omega A^2.
    """
    free = _numbers(_scene('free', _INVOLUTE, 1.0))
    omega = free.frequency
    viscous = free.inertia * omega / QUALITY
    return {
        'drag': {'viscous': viscous},
        'escapement': {'kind': 'impulse', 'energy': 0.5 * math.pi * viscous * omega, 'angle': 0.0},
    }


def _problem(
    key: str, title: str, trochlea: dict[str, object], duration_s: float, **sections: object
) -> WheelProblem:
    scene = _scene(title, trochlea, duration_s, **sections)
    numbers = _numbers(scene)
    return WheelProblem(key, title, scene, numbers, math.tau / numbers.frequency, duration_s)


def _case_problem(key: str, title: str, numbers: HungCase, duration_s: float) -> CaseProblem:
    return CaseProblem(key, title, numbers, math.tau / numbers.frequency, duration_s)


def _scene(name: str, trochlea: dict[str, object], duration_s: float, **sections: object) -> Scene:
    return Scene.model_validate(
        {
            'name': name,
            'duration': duration_s,
            'trochlea': trochlea,
            'log': {'interval': min(duration_s, 3600.0), 'motion': False},
            **sections,
        }
    )


def _numbers(scene: Scene) -> Numbers:
    assert scene.trochlea is not None
    machine = scene.trochlea.thread.ideal(
        scene.trochlea.parts(scene.g, scene.drag, scene.escapement)
    )
    return Numbers(
        inertia=machine.inertia,
        lever_rate=float(machine.cam.lever_rate(0.0)),
        force=machine.force,
        mass=machine.carried_mass,
        gravity=machine.gravity,
        viscous=0.0 if scene.drag is None else scene.drag.viscous,
        impulse_energy=0.0 if scene.escapement is None else scene.escapement.energy,
        release_angle=machine.release_angle,
        sea=_sea(scene, scene.ship) if isinstance(scene.ship, SeaShip) else None,
        follows_vertical=machine.follows_apparent_vertical,
    )


def _sea(scene: Scene, ship: SeaShip) -> Sea:
    roll = sea_motion(scene, ship).roll
    return Sea(roll.amplitude, roll.angular_frequency, roll.phase, ship.height, roll.period)
