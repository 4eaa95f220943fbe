"""The steady swing: the escapement gives the energy that drag takes (escapement.md).

A swing has four arcs, each between a turning point A and an impulse. An arc that ends at its
turning point is followed backward in time. With δ the energy above a free swing's, 0 at the
turning point, and R the recoil,

    dδ/dθ = ∓(c₁θ̇ + c₂θ̇² + c₀),   ½ M θ̇² = h sin²W + δ + R |A − θ|,   V = h cos²W,   h = V(A).

In the steady swing the four arcs lose as much as the escapement gives: two impulses, and 4 R α of
the recoil. In an even well that is exact for any drag. For the lever and an unbalanced wheel V +
R |θ| is assumed equal at both turning points, with an error of the square of the loss. V counts
from the place of rest. All on land.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tauto_core.curves.numerics import QuadratureError, panel_nodes, root_of, running, unresolved
from tauto_core.machines.drags import Drag
from tauto_core.machines.parts import DragKind, EscapementKind
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import TautoError

# Relative change of the energy lost on an arc at which the iteration ends.
_SETTLED = 1e-14

_ITERATIONS = 200
_HALVINGS = 6
# Share by which swings end before the edge, near which arms and slopes may diverge.
_SHORT_OF_EDGE = 1e-6

# Share by which the amplitude is changed for the slope of the loss, with an error of its square.
_NUDGE = 1e-4

_ROUNDING = 4.0 * np.finfo(float).eps
# Relative error of the energy for deciding whether a clock starts itself.
_START_ERROR = 1e-9


@dataclass(frozen=True)
class SteadySwing:
    """The swing that repeats, on land.

    Attributes:
        amplitude: A [rad], the turning point on the positive side for the lever and an unbalanced
            wheel.
        period: period of the swing with drag and impulses [s].
        free_period: period of a free swing of the same amplitude [s].
        time_constant: time in which a small departure of the energy from the steady one falls
            e-fold, to first order in the loss [s], inf without drive and drag.
    """

    amplitude: float
    period: float
    free_period: float
    time_constant: float


@dataclass(frozen=True)
class NoSteadySwing:
    """The reason why no swing repeats."""

    why: str


_GROWS = (
    'the swing grows for ever, or to the end of its range: there is an escapement and no drag '
    'against it'
)


class Torques(NamedTuple):
    """Drag and recoil, the torques on the wheel apart from the thread's [N m]."""

    drag: DragKind
    recoil: float


class SwingPart(NamedTuple):
    """An arc from turning point to impulse: energy lost to drag [J], time [s] (inf: it stops)."""

    lost: float
    time: float


def steady_swing(machine: Machine | LeverMachine) -> SteadySwing | NoSteadySwing:
    """Return the swing in which a clock settles on land after its release.

    Without drag and impulses it is the released swing itself.
    """
    escapement = machine.escapement
    drag = None if machine.drag is None or machine.drag.is_zero else machine.drag
    try:
        if escapement is None:
            if drag is None:
                return _free(machine)
            return NoSteadySwing(
                'the swing dies away: there is drag, and no escapement to make good for it'
            )
        if drag is None and not escapement.recoil:
            if abs(machine.release_angle) <= abs(escapement.angle):
                return _free(machine)
            return NoSteadySwing(_GROWS)
        return _driven(machine, drag, escapement)
    except TautoError as error:
        return NoSteadySwing(str(error))


def _free(machine: Machine | LeverMachine) -> SteadySwing:
    """Return the swing after the release, without drive or drag."""
    period = machine.period(machine.release_angle)
    return SteadySwing(abs(machine.release_angle), period, period, math.inf)


def _driven(
    machine: Machine | LeverMachine, drag: DragKind | None, escapement: EscapementKind
) -> SteadySwing | NoSteadySwing:
    """Return the swing in which drag takes as much energy as the escapement gives."""
    if isinstance(machine, Machine) and not machine.has_small_swings:
        raise QuadratureError(
            'the cheeks are rooted in the axle: the wheel lingers in the middle, where the '
            'quadrature of a steady swing does not settle'
        )
    (low, edge), start = _reach(machine, escapement.angle), machine.release_angle
    work, torques = escapement.work, Torques(drag or Drag(), escapement.recoil)
    hindered, impulses = '', 2.0 * escapement.energy
    if abs(start) <= low and not _starts_itself(machine, torques, escapement.angle):
        hindered = (
            f'the clock stops: released at {abs(start):.6g} rad it does not swing beyond the '
            f'{low:.6g} rad of the impulse'
        )
    elif work <= 0.0:
        hindered = (
            f'the clock stops: the impulses give {impulses:.6g} J in a swing, and recoil that '
            f'begins before the middle takes {impulses - work:.6g} J'
        )
    if hindered or drag is None:
        return NoSteadySwing(hindered or _GROWS)
    # the loss of a swing of 0 rad has no logarithm
    low = max(low, 1e-9 * abs(start))

    def loss(amplitude: float) -> float:
        return sum(leg.lost for leg in _legs(machine, torques, escapement.angle, amplitude))

    if loss(low) >= work:
        return NoSteadySwing(
            f'the clock stops: the escapement gives {work:.6g} J in a swing, less than the '
            f'{loss(low):.6g} J that the drag takes from the smallest swing that reaches it, '
            f'of {low:.6g} rad'
        )
    top = edge
    # near its unstable equilibrium an unbalanced wheel has an infinite period
    if math.isinf(edge) or _is_uneven(machine):
        top = min(max(abs(start), low), edge)
        for _ in range(200):
            if loss(top) > work or top == edge:
                break
            top = min(2.0 * top, edge)
    if loss(top) < work:
        return NoSteadySwing(
            f'the swing grows to the end of its range: at {top:.6g} rad the drag takes '
            f'{loss(top):.6g} J in a swing, the escapement gives {work:.6g} J'
        )

    def missing(log_amplitude: float) -> float:
        return math.log(work / loss(math.exp(log_amplitude)))

    # the loss is roughly a power of the amplitude: solved in logarithms
    amplitude = math.exp(root_of(missing, math.log(low), math.log(top), _ROUNDING))
    legs = _legs(machine, torques, escapement.angle, amplitude)
    if abs(start) > low:
        legs.append(
            _leg(machine, torques, start, -math.copysign(1.0, start) * escapement.angle, -1.0)
        )
    period = sum(leg.time for leg in legs[:4])
    if not all(math.isfinite(leg.time) for leg in legs):
        return NoSteadySwing(
            f'the clock stops: with {work:.6g} J in a swing from the escapement the drag brings '
            'the wheel to rest before it comes to the next impulse'
        )
    below, above = amplitude * (1.0 - _NUDGE), min(amplitude * (1.0 + _NUDGE), edge)
    rise = float(machine.potential(above) - machine.potential(below))
    rise += torques.recoil * (above - below)
    settling = period * rise / (loss(above) - loss(below))
    return SteadySwing(amplitude, period, machine.period(amplitude), settling)


def _is_uneven(machine: Machine | LeverMachine) -> bool:
    """Return whether the wheel is unbalanced."""
    return isinstance(machine, Machine) and machine.imbalance is not None


def _reach(machine: Machine | LeverMachine, angle: float) -> tuple[float, float]:
    """Return the least amplitude that reaches ±angle on both sides, and the largest possible."""
    if isinstance(machine, Machine):
        edge = machine.range_rad * (1.0 - _SHORT_OF_EDGE)
        if machine.imbalance is None:
            return abs(angle), edge
        amplitude = abs(angle)
        # up to the higher of the two sides
        if machine.potential(-amplitude) > machine.potential(amplitude):
            amplitude = machine.angle_of_potential(float(machine.potential(-amplitude)))
        # as long as V rises on both sides
        ways = np.linspace(0.0, min(edge - abs(machine.rest_angle), 2.0 * math.tau), 2000)[1:]
        sides = [machine.raised(machine.rest_angle + side * ways) for side in (-1.0, 1.0)]
        heights = [side[: np.argmax(np.append(np.diff(side) <= 0.0, True)) + 1] for side in sides]
        lowest = min(float(side[-1]) for side in heights)
        at = np.searchsorted(heights[1], lowest, side='right') - 1
        return amplitude, float(machine.rest_angle + ways[at])
    geometry, (low, high) = machine.geometry, machine.edges
    taus = geometry.tau_of(np.array([abs(angle), -abs(angle)]))
    ends = np.array([np.max(np.abs(taus)), min(-low, high) * (1.0 - _SHORT_OF_EDGE)])
    amplitude, edge = geometry.theta(ends).tolist()
    return amplitude, edge


def _starts_itself(machine: Machine | LeverMachine, torques: Torques, angle: float) -> bool:
    """Return whether recoil drives a wheel released short of the first impulse to it."""
    if torques.recoil * angle <= 0.0:
        return False
    from scipy.integrate import solve_ivp  # slow to import

    start = machine.release_angle
    end = -math.copysign(angle, start)
    mass = machine.mass if isinstance(machine, Machine) else machine.mass_at

    def kinetic(way: float, energy: FloatArray) -> float:
        return float(energy[0] - machine.potential(start + math.copysign(way, end)))

    def gained(way: float, energy: FloatArray) -> FloatArray:
        place = np.array([start + math.copysign(way, end)])
        rate = np.sqrt(max(2.0 * kinetic(way, energy), 0.0) / mass(place))
        return torques.recoil - torques.drag.torque(rate)

    kinetic.terminal, kinetic.direction = True, -1.0  # type: ignore[attr-defined]
    begin, length = np.array([machine.potential(start)]), abs(end - start)
    tolerance = _START_ERROR * torques.recoil * length
    motion = solve_ivp(
        gained, (0.0, length), begin, events=kinetic, rtol=_START_ERROR, atol=tolerance
    )
    return bool(motion.status == 0)


def _legs(
    machine: Machine | LeverMachine, torques: Torques, angle: float, amplitude: float
) -> list[SwingPart]:
    """Return the four arcs of a swing, to and from the impulse, there and back."""
    if isinstance(machine, Machine) and not _is_uneven(machine):
        pair = [
            _leg(machine, torques, -amplitude, angle, -1.0),
            _leg(machine, torques, amplitude, angle, 1.0),
        ]
        return pair + pair
    # the turning point on the other side has the same V + R |θ|
    turn = machine.far_turning(amplitude)
    if torques.recoil:
        height = float(machine.potential(amplitude)) + torques.recoil * amplitude

        def above(angle: float) -> float:
            return float(machine.potential(angle)) - torques.recoil * angle - height

        # the two angles at which V alone, or R |θ| alone, is the same, bracket it
        turn, high = sorted((turn, -amplitude))
        if above(turn) > 0.0:
            turn = root_of(above, turn, high, _ROUNDING)
    return [
        _leg(machine, torques, turn, angle, -1.0),
        _leg(machine, torques, amplitude, angle, 1.0),
        _leg(machine, torques, amplitude, -angle, -1.0),
        _leg(machine, torques, turn, -angle, 1.0),
    ]


def _leg(
    machine: Machine | LeverMachine, torques: Torques, turning: float, end: float, sign: float
) -> SwingPart:
    """Return loss and time between a turning point and an angle [rad].

    The sign is −1 if the turning point comes first, 1 if it comes last.
    """
    centre, ends = 0.0, np.array([turning, end])
    if isinstance(machine, Machine) and _is_uneven(machine):
        centre = machine.rest_angle
        top, at_end = machine.raised(ends).tolist()
    else:
        top, at_end = machine.potential(ends).tolist()
    across = math.sqrt(min(at_end / top, 1.0))
    w_end = math.acos(math.copysign(across, (end - centre) * (turning - centre)))
    if w_end == 0.0:
        return SwingPart(0.0, 0.0)
    edges, w, mass, slowness = _free_swing(machine, turning, w_end)
    sine = np.sin(w)
    speed, path = np.sqrt(2.0 * top / mass) * sine, slowness * np.sqrt(2.0 * top / mass) * sine
    eased = running(torques.recoil * path, edges)[0] / (top * sine * sine)
    share, since = 1.0 + eased, np.zeros_like(w)
    for _ in range(_ITERATIONS):
        torque = torques.drag.torque(speed * np.sqrt(share))
        old, (since, lost) = since, running(torque * path, edges)
        # the exact value of such a loss does not matter
        if lost > 1e6 * top:
            break
        share = np.maximum(1.0 + eased + sign * since / (top * sine * sine), 0.0)
        if np.max(np.abs(since - old)) <= _SETTLED * lost:
            if np.min(share) <= 0.0:
                break
            return SwingPart(lost, running(slowness / np.sqrt(share), edges)[1])
    return SwingPart(lost, math.inf)


def _free_swing(
    machine: Machine | LeverMachine, turning: float, w_end: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return panels of W from 0 to `w_end`, W, M and dt/dW there, of a free swing."""
    cuts = [0.5 * math.pi]
    uneven = _is_uneven(machine)
    if isinstance(machine, Machine) and uneven:
        cam, centre = machine.cam, machine.rest_angle
        ends = sorted((turning, machine.far_turning(turning)))
        joints = np.concatenate([-cam.joints, [0.0] * cam.kinked, cam.joints])
        joints = joints[(joints > ends[0]) & (joints < ends[1])]
        inner = np.sqrt(machine.raised(joints) / machine.raised(np.array([turning])))
        cuts += np.arccos(np.copysign(inner, (joints - centre) * (turning - centre))).tolist()
    elif isinstance(machine, Machine):
        joints = machine.cam.joints[machine.cam.joints < abs(turning)]
        inner = np.sqrt(machine.potential(joints) / machine.potential(turning))
        cuts += [*np.arccos(inner), *np.arccos(-inner)]
    edges = np.array([0.0, *sorted(cut for cut in cuts if 0.0 < cut < w_end), w_end])
    for _ in range(_HALVINGS):
        w = panel_nodes(edges)
        # M and dt/dW for V = V(A) cos²W
        if isinstance(machine, LeverMachine):
            tau, slowness = machine.swing(turning, w)
            ratio = machine.geometry.slopes(tau)[0]
            mass = machine.inertia + machine.turned_inertia * ratio * ratio
        elif uneven:
            angle, slowness = machine.uneven_swing(turning, w)
            mass = machine.mass(angle)
        else:
            angle, slowness = machine.swing(abs(turning), np.abs(0.5 * math.pi - w))
            mass = machine.mass(angle)
        if unresolved(slowness) <= 1e-11:
            return edges, w, mass, slowness
        edges = np.sort(np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])]))
    raise QuadratureError(
        f'a swing of {abs(turning):.6g} rad is too stiff to be followed. Use more drag or a '
        'weaker escapement'
    )
