"""The counters of the drift stage as text."""

from __future__ import annotations

from collections.abc import Mapping

from tauto_core.scene import Scene
from tauto_core.wording import counted

_SAID = {
    'readings_out_of_order': '{readings} {were} out of order and left out',
    'observations_out_of_order': '{observations} came after later ones and {were} left out',
    'observations_repeated': '{observations} had the stamp of another and {were} left out',
    'observations_delayed': '{observations} came after later ones; the filter went back for '
    '{them}',
    'observations_from_future': '{observations} {were} stamped a day or more after the newest '
    'reading and left out: check whose clock stamped {them}',
    'observations_unscheduled': '{observations} {were} not at the times of the scene and left out',
    'observations_missing': '{observations} of the scene did not come',
    'observations_too_old': '{observations} {were} older than what is remembered and left out',
    'observations_unmatched': '{observations} {were} stamped after the last reading and left out',
    'observations_gated': '{observations} {were} refused as {outliers}, beyond drift.gate = '
    '{gate:g} sigmas',
    'motion_refused': '{samples} of ship/imu could not be used and {were} left out',
    'motion_gaps': 'ship/imu broke off {times}; what the motion adds to the rate went on as usual',
    'motion_unknown': 'ship/imu did not reach {readings}; what the motion adds to the rate was '
    'taken as usual',
    'dial_stops': 'the dial had stood still {times}; the offset was moved and reopened by that',
    'dial_settings': 'the dial was set anew {times}; the estimate began again',
    'estimates_reopened': '{observations} beyond drift.gate = {gate:g} sigmas had to be believed: '
    'the clock has jumped, or its rate is not what was assumed (drift.prior_rate_sigma = '
    '{prior:g} s/day)',
}


def drift_warnings(health: Mapping[str, int], scene: Scene) -> list[str]:
    """Return warnings for the counters of the drift stage.

    Args:
        health: its counters; those of other stages are ignored.
        scene: the scene of the run.
    """
    values = {'gate': scene.drift.gate, 'prior': scene.drift.prior_rate_sigma}
    return [
        f'drift: {words.format(**values, **_agreeing(health[name]))}'
        for name, words in _SAID.items()
        if health.get(name)
    ]


def _agreeing(number: int) -> dict[str, str]:
    """Return words in the singular or plural."""
    return {
        'observations': counted(number, 'observation'),
        'samples': counted(number, 'sample'),
        'readings': counted(number, 'reading'),
        'were': 'was' if number == 1 else 'were',
        'them': 'it' if number == 1 else 'them',
        'outliers': 'an outlier' if number == 1 else 'outliers',
        'times': 'once' if number == 1 else f'{number} times',
    }
