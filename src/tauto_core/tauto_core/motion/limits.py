"""What ends a motion: the same words whichever propagator finds it."""

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
