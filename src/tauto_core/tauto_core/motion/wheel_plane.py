"""What disturbs the plane of the wheel: the trochlea in one turning plane, as `turning` takes it.

Along the angle, or along the arc where the lever arm is linear and a weight rides along.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from tauto_core.kernels import inlined, overload
from tauto_core.motion import turning
from tauto_core.motion.lanes import fma, load, store
from tauto_core.motion.outside import (
    D1_ROW,
    D2_ROW,
    GRAVITY,
    LINE_RATE,
    OUTSIDE_ROW,
    TILT_RATE,
    X_ROW,
    Y_ROW,
    node_row,
)
from tauto_core.motion.wells import (
    excess,
    lever_arm,
    pull_of,
    rate_of,
    resistance,
    ride,
    shape_at,
)


class Trochlea(NamedTuple):
    """What disturbs the plane of the wheel: machine, lever and shape as in wells, what is felt.

    `felt` tells by its types which rows of outside there are: γ, τ, g or None.
    """

    machine: Any
    lever: Any
    shape: Any
    felt: Any


@overload(turning.disturb)
def _disturb(system: Any, mode: Any, omega: Any, work: Any) -> Any:
    if getattr(system, 'instance_class', None) is not Trochlea:
        return None
    if system[2] is not None:
        return _along_the_arc
    return _along_the_angle


@inlined
def _along_the_angle(system: Any, mode: Any, omega: Any, work: Any) -> None:
    machine, lever, _, felt = system
    q, w = load(work, X_ROW), omega[0] * load(work, Y_ROW)
    line_rate = node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE)
    t, t1, lift = lever_arm(lever, mode[0], q)
    rate = rate_of(machine[0], t, w, line_rate)
    v = rate + node_row(felt[1], work, OUTSIDE_ROW + TILT_RATE)
    pull = pull_of(machine, lift, node_row(felt[2], work, OUTSIDE_ROW + GRAVITY))
    per_omega = 1.0 / omega[0]
    more = excess(lever, q, t, pull, omega[0] * omega[0])
    more = more + ride(machine[0], t, t1, rate) - resistance(machine, v, mode)
    store(work, D1_ROW, rate - w)
    store(work, D2_ROW, more * per_omega)


@inlined
def _along_the_arc(system: Any, mode: Any, omega: Any, work: Any) -> None:
    machine, lever, shape, felt = system
    s, p = load(work, X_ROW), omega[0] * load(work, Y_ROW)
    n, slope, less, _ = shape_at(shape, lever.rate, s)
    line_rate = node_row(felt[0], work, OUTSIDE_ROW + LINE_RATE)
    rate = fma(-line_rate, n, p)
    v = fma(n, rate, node_row(felt[1], work, OUTSIDE_ROW + TILT_RATE))
    pull = pull_of(machine, 0.0, node_row(felt[2], work, OUTSIDE_ROW + GRAVITY))
    per_omega = 1.0 / omega[0]
    square = fma(pull, less, omega[0] * omega[0] - lever.rate * pull)
    more = s * fma(rate, line_rate * slope, square)
    more = fma(-n, resistance(machine, v, mode), more)
    store(work, D1_ROW, -(line_rate * n))
    store(work, D2_ROW, more * per_omega)
