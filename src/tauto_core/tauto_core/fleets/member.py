"""The voyage of one ship of a fleet: a row of figures, or the reason why there are none.

A voyage that physics ends is an observation, and a row. One that never ended, for want of memory
or of a file, is none: its error is raised, and she sails again.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from tauto_core import voyage
from tauto_core.fleets.plan import Plan
from tauto_core.scene.errors import MotionDataError, TautoError

FIGURES: dict[str, tuple[str, str]] = {
    'clock_error_s': ('clock', 'error_s'),
    'rate_s_per_day': ('clock', 'rate_s_per_day'),
    'estimated_rate_s_per_day': ('drift', 'rate_s_per_day'),
    'estimated_rate_sigma_s_per_day': ('drift', 'rate_sigma_s_per_day'),
    'raw_error_nmi': ('longitude', 'raw_error_nmi'),
    'error_nmi': ('longitude', 'error_nmi'),
    'sigma_nmi': ('longitude', 'sigma_nmi'),
    'judged_at_s': ('longitude', 'at_s'),
    'unchecked_days': ('longitude', 'unchecked_days'),
    'raw_prize_pounds': ('longitude', 'raw_prize_pounds'),
    'prize_pounds': ('longitude', 'prize_pounds'),
    'worst_raw_error_nmi': ('longitude', 'worst_raw_error_nmi'),
    'worst_raw_at_s': ('longitude', 'worst_raw_at_s'),
    'worst_error_nmi': ('longitude', 'worst_error_nmi'),
    'worst_at_s': ('longitude', 'worst_at_s'),
    'stopped_s': ('trochlea', 'stopped_s'),
}
"""Columns of a row, and their place in the result of `voyage.sail`. They belong to the sample by
which a voyage is judged, the last one before the landfall or the end (`navigation.tally`), and are
positive to the east.
"""


def sail_ship(plan: Plan, number: int, progress: Callable[[float], None]) -> dict[str, Any]:
    """Return the row of a ship: number and seed, drawn values, FIGURES, and processor time.

    `failure` is None, or says what ended the voyage early; then there are no figures. `run_s` is
    the processor time of the thread, the only column that differs in another run.

    Args:
        plan: the plan of the fleet.
        number: number of the ship.
        progress: called with the fraction done, from 0 to 1.

    Raises:
        Exception: what has nothing to do with her voyage, such as a MemoryError.
    """
    ship, began, failure = plan.ship(number), time.thread_time(), None
    report: dict[str, Any] = {}
    try:
        report = voyage.sail(
            ship.scene,
            origin=plan.origin,
            anyway=True,  # all ships were checked together
            progress=progress,
        )
    except MotionDataError:  # a file that is not on this machine, or cannot be read
        raise
    except TautoError as error:
        failure = str(error) or type(error).__name__
    return {
        'ship': number,
        'seed': ship.scene.seed,
        **ship.drawn,
        **{column: report.get(section, {}).get(key) for column, (section, key) in FIGURES.items()},
        'failure': failure,
        'run_s': time.thread_time() - began,
    }
