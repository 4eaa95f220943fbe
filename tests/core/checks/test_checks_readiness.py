"""Whether the parts of a scene fit together: the dial and the stamps that it can reach."""

import pytest

import tauto_core as tauto
from tauto_core.checks.readiness import check_scene
from tauto_core.scene.errors import SceneError
from tauto_core.scene.times import LAST_STAMP_S


@pytest.mark.parametrize('duration', [3600.0, 86400.0])
def test_a_dial_may_go_as_far_as_stamps_reach_and_no_further(duration: float) -> None:
    """The wheel of `ideal` swings once a second, and the dial goes on by the nominal period."""
    begins = tauto.load('ideal').starts_at
    longest = (LAST_STAMP_S - begins) / duration
    for share in (0.5, 0.999):
        clock = {'nominal_period': share * longest}
        check_scene(tauto.load('ideal', duration=duration, clock=clock))
    with pytest.raises(SceneError, match='with a period of 1 s'):
        check_scene(
            tauto.load('ideal', duration=duration, clock={'nominal_period': 1.001 * longest})
        )
