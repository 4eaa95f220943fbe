"""No result depends on uninitialised memory: `np.empty` keeps old content."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import tauto_core as tauto

EMPTY, EMPTY_LIKE = np.empty, np.empty_like


def poisoned(array: Any) -> Any:
    """Fill an array with what spoils every sum: NaN, or the largest whole number."""
    if array.dtype.kind == 'f':
        array.fill(np.nan)
    elif array.dtype.kind in 'iu':
        array.fill(np.iinfo(array.dtype).max)
    return array


SCENES = (
    'ideal', 'measured', 'second_cam_at_sea', 'involute_weight_at_sea', 'hanging_thread_at_sea',
    'sully_lever_at_sea', 'globe_in_oil', 'axle_at_sea', 'clock_pendulum', 'portsmouth_jamaica',
)  # fmt: skip
"""One of each propagator, and of each kind of ship."""


@pytest.mark.parametrize('scene', SCENES)
def test_a_voyage_is_the_same_whatever_its_memory_held(
    scene: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = tauto.sail(scene, duration=60.0)  # compiles, which reads the names of NumPy
    monkeypatch.setattr(np, 'empty', lambda *a, **k: poisoned(EMPTY(*a, **k)))
    monkeypatch.setattr(np, 'empty_like', lambda *a, **k: poisoned(EMPTY_LIKE(*a, **k)))
    found = tauto.sail(scene, duration=60.0)
    for name in (
        'angle_rad',
        'clock_error_s',
        'estimated_error_s',
        'longitude_error_nmi',
        'roll_rad',
    ):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
