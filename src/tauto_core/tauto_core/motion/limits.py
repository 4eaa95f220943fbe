"""Errors that end a motion, the same for all propagators."""

from __future__ import annotations

from tauto_core.machines import Machine
from tauto_core.scene.errors import PropagationError


def edge_reached(machine: Machine, time_s: float) -> PropagationError:
    """Return the error of a cam angle that reached the edge of the cam."""
    return PropagationError(
        f'the cam angle reached the edge of the cam at ±{machine.cam.range_rad:.6g} rad. Use a '
        'cam with a longer range, a smaller release angle, a weaker escapement or a calmer sea',
        time_s,
    )


def released_beyond(machine: Machine, felt: float) -> PropagationError:
    """Return the error of a release that puts the cam angle beyond the cam."""
    return PropagationError(
        f'the release angle {machine.release_angle:.6g} rad and the roll at the start put the cam '
        f"angle at {felt:.6g} rad, beyond the cam's range of ±{machine.cam.range_rad:.6g} rad. "
        'Release at a smaller angle',
        0.0,
    )


def thread_slack(time_s: float) -> PropagationError:
    """Return the error of a thread that would have to push."""
    return PropagationError(
        'the thread went slack (its tension fell to 0 N, and a thread cannot push). Use a lighter '
        'weight, a smaller release angle, a stronger pull or a calmer sea; smooth the '
        'accelerations of a noisy sensor',
        time_s,
    )


def lifted_off(time_s: float) -> PropagationError:
    """Return the error of a case whose axle would have to be held down."""
    return PropagationError(
        'the axle of the suspension lifted off its bearing (the contact force fell to 0 N). Keep '
        "its period away from the sea's, hang the case nearer to the roll axis (ship.height), or "
        'choose a calmer sea',
        time_s,
    )


def turned_over(time_s: float) -> PropagationError:
    """Return the error of a case that swings all the way round."""
    return PropagationError(
        'the suspended case turned over (more than 3 rad from the contact or from the vertical). '
        "Keep its period away from the sea's, or hang it nearer to the roll axis (ship.height)",
        time_s,
    )


def beyond_small_angles(tilt: float, limit: float, time_s: float) -> PropagationError:
    """Return the error of a suspended case that swings wider than its equations hold."""
    return PropagationError(
        f'the suspended case swings {tilt:.3g} rad from the vertical; the equations of small '
        f'angles are taken up to {limit:g} rad. Set suspension.large_angles to true, or keep the '
        "case's periods away from the sea's",
        time_s,
    )
