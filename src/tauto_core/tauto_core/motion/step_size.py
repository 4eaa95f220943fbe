"""The reference frequency of the rotating frame and the longest step that meets a tolerance."""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np

from tauto_core.kernels import inlined
from tauto_core.machines import Machine, SlackThreadError
from tauto_core.motion.arc_length import ArcShape, angles_of, arc_of
from tauto_core.motion.gauss import Gauss, gauss
from tauto_core.motion.lanes import SIZE, WIDE_SIZE
from tauto_core.motion.stages import SETTLED
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError

LONGEST_ANGLE = {SIZE: 3.05, WIDE_SIZE: 6.1}
"""Longest step by its number of stages, as the angle ωh [rad].

`layout.SPARE` may make it longer by a twentieth: with eight stages it then spans half a swing and
`layout.BEYOND`, with sixteen it stays within `rotation.MAX_ANGLE`.
"""

MIN_ANGLE = 0.005
"""Longest step that is laid out whatever the error, as the angle ωh [rad]."""

TOLERANCE = 2e-12
"""Error allowed in a step, relative to the state, if the scene does not state one."""

MARGIN = 0.3
"""Share of the tolerance for which steps are laid out; the rest is for the sea."""

ITERATION_SHARE = 1e-5
"""Share of the tolerance that the iteration of the stage equations may use."""

ERROR_OF_LAST, ERROR_OF_LAST_STRONG = 0.03, 1.0
"""Error of a smooth step over the square of the last Legendre coefficient of its slopes.

The step is of twice the order of its polynomial, whence the square. The factor is measured
(benchmarks/stress.json): 0.002 to 0.03 where the disturbance is weak, up to 0.8 for a weight or a
spring that makes the well strongly anharmonic.
"""

WIDE_ERROR_OF_LAST, WIDE_ERROR_OF_GROWTH = 0.003, 0.05
"""The same for sixteen stages, and its increase with the growth of the inertia, k²ϑ²."""

MOST_DISTURBED = 1.0
"""Growth of the inertia k²ϑ², or damping c₁/(Iω), up to which sixteen stages are worth it."""

_PHASES = 12
"""Phases of the swing at which steps are tried."""


def reference_frequency(machine: Machine) -> float:
    """Return the frequency of the rotating frame [rad/s]: that of the released swing, if any.

    Any frequency would do; with this one the disturbance has no mean, and is smallest.
    """
    try:
        return math.tau / machine.period(machine.release_angle)
    except (CamRangeError, SlackThreadError):
        return machine.frequency


def stages_of(machine: Machine, shape: ArcShape | None) -> int:
    """Return how many stages a step has: sixteen where little disturbs the swing, else eight.

    Steps end at a kink and at the joints of a spline, and are short where the well is strongly
    anharmonic or damped: longer ones would be of no use there.
    """
    drag = machine.drag
    abrupt = drag is not None and (drag.quadratic > 0.0 or drag.coulomb > 0.0)
    cam = machine.cam
    if abrupt or cam.kinked or cam.joints.size:
        return SIZE
    damped = drag.viscous / (machine.inertia * machine.frequency) if drag is not None else 0.0
    smooth = shape is not None or machine.is_linear
    disturbed = max(_inertia_growth(machine, shape), damped)
    return WIDE_SIZE if smooth and disturbed <= MOST_DISTURBED else SIZE


def _inertia_growth(machine: Machine, shape: ArcShape | None) -> float:
    """Return the relative growth of the inertia from ϑ = 0 to the release, k²ϑ² (`arc_length`)."""
    return 0.0 if shape is None else (shape.k * machine.release_angle) ** 2


def error_factor(machine: Machine, shape: ArcShape | None) -> float:
    """Return the error of a step over the square of its last coefficient.

    0 for a cam with joints, where derivatives of the law jump: there the square does not hold, and
    the error is the coefficient itself.
    """
    if machine.cam.joints.size:
        return 0.0
    if stages_of(machine, shape) == WIDE_SIZE:
        return WIDE_ERROR_OF_LAST + WIDE_ERROR_OF_GROWTH * _inertia_growth(machine, shape)
    weak = shape is not None or machine.is_linear
    weak = weak or (machine.carried_mass == 0.0 and machine.stiffness == 0.0)
    return ERROR_OF_LAST if weak else ERROR_OF_LAST_STRONG


def settled_at(tolerance: float) -> float:
    """Return the accuracy of the stage equations, relative to the state."""
    return max(SETTLED, ITERATION_SHARE * tolerance)


def carried_within(tolerance: float) -> float:
    """Return the distance within which the midpoint rule carries a state to an event [rad].

    Its error, a 24th of the cube of the angle, is then as much as the iteration may have.
    """
    return float(np.cbrt(24.0 * ITERATION_SHARE * tolerance))


@inlined
def step_error(factor: float, last: float, newton: bool) -> float:
    """Return the error of a step relative to the state, from what `collocate` returned.

    Where Newton's method is needed the order falls to that of the polynomial.

    Args:
        factor: as `error_factor` returns.
    """
    return last if newton or factor == 0.0 else factor * last * last


def longest_step(
    machine: Machine, shape: ArcShape | None, omega: float, *, factor: float, tolerance: float
) -> float:
    """Return the longest step [s] whose error on land is within the tolerance, at any phase.

    The disturbance is taken along the undisturbed motion at the release amplitude.
    """
    amplitude = machine.release_angle
    if shape is not None:
        amplitude = arc_of(amplitude, shape.k)
    stages = stages_of(machine, shape)
    # an impulse may come every half swing
    most = LONGEST_ANGLE[stages if machine.escapement is None else SIZE]
    constants, angles = gauss(stages), [most]
    while angles[-1] > MIN_ANGLE:
        angles.append(0.97 * angles[-1])

    def is_within(angle: float) -> bool:
        last = _last_coefficient(machine, shape, constants, omega, amplitude, angle)
        return step_error(factor, last, False) <= MARGIN * tolerance

    # the coefficient falls with the length of the step; the shortest is taken whatever its error
    return angles[bisect_left(angles, True, hi=len(angles) - 1, key=is_within)] / omega


def _last_coefficient(
    machine: Machine,
    shape: ArcShape | None,
    constants: Gauss,
    omega: float,
    amplitude: float,
    angle: float,
) -> float:
    """Return the largest last Legendre coefficient of steps of ωh = angle, relative to the state.

    Steps at all phases are tried, but for those over a kink.
    """
    if amplitude == 0.0:
        return 0.0
    phase = (np.arange(_PHASES) * (math.tau / _PHASES))[:, None]
    turned = constants.nodes * angle
    x, y = amplitude * np.cos(phase + turned), -amplitude * np.sin(phase + turned)
    if machine.cam.kinked:
        within = np.min(x, axis=1) * np.max(x, axis=1) >= 0.0
        x, y = x[within], y[within]
    d1, d2 = _disturbance(machine, shape, omega, x, y)
    slopes = np.cos(turned) * d1 - np.sin(turned) * d2, np.sin(turned) * d1 + np.cos(turned) * d2
    tails = [np.max(np.abs(slope @ constants.projection[-1]), initial=0.0) for slope in slopes]
    return angle / omega * float(max(tails)) / abs(amplitude)


def _disturbance(
    machine: Machine, shape: ArcShape | None, omega: float, x: FloatArray, y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return d₁ and d₂ of the equations of `stages`, on land."""
    q = angles_of(x, shape.k) if shape is not None else x
    edge = machine.cam.range_rad
    q = np.clip(q, -edge, edge)
    t, t_prime = machine.cam.lever_arm(q), machine.cam.lever_rate(q)
    mass = machine.mass(q) / machine.inertia
    force = machine.pull(machine.cam.lift(q)) * t / machine.inertia
    if shape is not None:
        return np.zeros(x.shape), omega * x - force / np.sqrt(mass) / omega
    w = omega * y
    ride = machine.carried_mass / machine.inertia * t * t_prime * (w / mass) ** 2
    viscous = machine.drag.viscous / machine.inertia if machine.drag else 0.0
    return w / mass - w, omega * x + (ride - force - viscous * w) / omega
