"""The angle at which a cam has lifted its thread by a given amount."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tauto_core.curves.cam import Cam
from tauto_core.curves.newton import bracketed_newton
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import CamRangeError

_ROUNDING = 4.0 * np.finfo(np.float64).eps


def invert_lift(cam: Cam, lift: ArrayLike) -> FloatArray:
    """Return the ϑ ≥ 0 with h(ϑ) = lift [rad], to rounding.

    Newton's method on √h, which is nearly linear in ϑ. The lever arm must be positive for ϑ > 0.

    Raises:
        CamRangeError: a lift that is negative, NaN or beyond that at the cam's range.
    """
    lift = np.asarray(lift, dtype=np.float64)
    edge = cam.range_rad
    highest = float(cam.lift(edge))
    # the lift at the range is itself rounded
    if not np.all((lift >= 0.0) & (lift <= highest * (1.0 + _ROUNDING))):
        worst = (float(np.min(lift)), float(np.max(lift)))
        raise CamRangeError(
            f'lifts from {worst[0]!r} to {worst[1]!r} m: the cam {cam!r} lifts by 0 to '
            f'{highest!r} m and no more; use a smaller amplitude or a cam with a wider range'
        )
    goal = np.sqrt(lift)
    start = np.minimum(np.sqrt(2.0 * lift / float(cam.lever_rate(0.0))), 0.5 * edge)

    def excess(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        root, arm = np.sqrt(cam.lift(angle)), cam.lever_arm(angle)
        return root - goal, np.divide(arm, 2.0 * root, np.zeros_like(arm), where=root > 0.0)

    return bracketed_newton(excess, start, (0.0, edge), relative=_ROUNDING)
