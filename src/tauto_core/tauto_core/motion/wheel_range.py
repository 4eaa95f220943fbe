"""Whether a step of the wheel leaves the range of the cam, or the thread goes slack."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tauto_core.curves.levers import LinearLever
from tauto_core.kernels import compiled
from tauto_core.motion.lanes import Lanes, larger, largest, least, load
from tauto_core.motion.lever_arm import lever_arm
from tauto_core.motion.on_arc import on_arc
from tauto_core.motion.system import NOWHERE, Beyond, Mode, first_below
from tauto_core.motion.wells import mass_of, pull_of, resistance, ride, speed_of, term
from tauto_core.motion.wheel_nodes import row_or_zero
from tauto_core.motion.work import Omega, Work

if TYPE_CHECKING:
    from tauto_core.motion.wheel_plane import Wheel

SURELY_WITHIN = 0.97
"""Share of the range within which all nodes must lie if the step surely lies within it."""

ALL_AGAINST = Mode(1.0, 1.0, 1.0)
"""The mode in which, for a positive rate, drag and recoil add up."""


@compiled
def _motion_at_nodes(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> tuple[Lanes, Lanes]:
    """Return ϑ and ϑ̇ at the nodes."""
    line_rate = row_or_zero(wheel.felt.line, work.nodes.line_rate)
    if wheel.shape is None:
        q, w = load(work.x), omega[0] * load(work.y)
        t = lever_arm(wheel.lever, mode.side, q).t
        return q, speed_of(wheel.per_inertia.carried, t, w, line_rate)
    n, _, _, angle = on_arc(wheel.shape, load(work.x))
    return angle, n * (omega[0] * load(work.y) - line_rate * n)


@compiled
def _tension(wheel: Wheel, mode: Mode, q: Lanes, speed: Lanes, work: Work) -> Lanes:
    """Return the thread's tension over I at the nodes, as `_instant` does."""
    per_inertia, felt = wheel.per_inertia, wheel.felt
    mu = per_inertia.carried
    t, t_prime, lift = lever_arm(wheel.lever, mode.side, q)
    rate = speed + row_or_zero(felt.tilt, work.nodes.tilt_rate)
    pull = pull_of(per_inertia, lift, row_or_zero(felt.gravity, work.nodes.gravity))
    against = pull * t + resistance(per_inertia, rate, mode) + ride(mu, t, t_prime, speed)
    line_bend = row_or_zero(felt.line, work.nodes.line_bend)
    acceleration = -(against + line_bend) / mass_of(mu, t)
    # adding 0·q makes lanes of a tension that is one number for all nodes
    return 0.0 * q + (pull + term(mu, t_prime * (speed * speed) + t * acceleration))


@compiled
def _surely_within(wheel: Wheel, omega: Omega, work: Work) -> bool:
    """Return whether rough bounds show that no node is past the edge, and the thread taut.

    On a linear lever arm M · tension = pull + μt′ϑ̇² − μt(γ̈ + resistance), M = 1 + μt²: it is
    positive where pull exceeds the largest μ|t|·(|γ̈| + resistance). |ϑ| is at most the largest
    |x|, and |θ̇| at most that of ωY, γ̇ and τ̇ together, in either coordinate.
    """
    if not isinstance(wheel.lever, LinearLever):
        return False
    per_inertia, felt, x = wheel.per_inertia, wheel.felt, load(work.x)
    zeros = 0.0 * x
    reach = largest(x)
    line_rate = largest(zeros + row_or_zero(felt.line, work.nodes.line_rate))
    line_bend = largest(zeros + row_or_zero(felt.line, work.nodes.line_bend))
    tilt_rate = largest(zeros + row_or_zero(felt.tilt, work.nodes.tilt_rate))
    rate = omega[0] * largest(load(work.y)) + line_rate + tilt_rate
    pull = pull_of(per_inertia, 0.0, row_or_zero(felt.gravity, work.nodes.gravity))
    against = line_bend + resistance(per_inertia, rate, ALL_AGAINST)
    lost = term(per_inertia.carried, wheel.lever.rate * reach * against)
    return reach <= wheel.range and least(zeros + pull) > lost


@compiled
def beyond(wheel: Wheel, mode: Mode, omega: Omega, work: Work) -> Beyond:
    """Return whether the step leaves the range: by rough bounds if they are enough."""
    edge = slack = NOWHERE
    reach = largest(load(work.x))
    within = reach <= SURELY_WITHIN * wheel.range
    if _surely_within(wheel, omega, work):
        return Beyond(edge, slack, within, reach)
    q, speed = _motion_at_nodes(wheel, mode, omega, work)
    if largest(q) > wheel.range:
        edge = first_below(wheel.range - larger(q, q), work)
    if wheel.has_weight:
        slack = first_below(_tension(wheel, mode, q, speed, work), work)
    return Beyond(edge, slack, within, reach)
