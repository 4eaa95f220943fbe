"""Roll and heave for the pictures, against a motion in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import tauto_core as tauto
from tauto_core.plots.contents import TAPER_S, seaway

SHIP = {
    'kind': 'components',
    'rate': 20.0,
    'height': 0.0,
    'components': [{'amplitude': 0.1, 'period': 11.0}],
    'heave': [{'amplitude': 1.5, 'period': 8.0}, {'amplitude': 0.4, 'period': 5.0, 'phase': 1.0}],
}


@pytest.fixture(scope='module', params=[True, False], ids=['kept', 'made anew'])
def voyage(request: pytest.FixtureRequest) -> tauto.Voyage:
    log = {'interval': 1.0, 'motion': request.param}
    return tauto.sail('second_cam_at_sea', ship=SHIP, log=log, duration=1500.0)


def test_heave_is_the_acceleration_integrated_twice(voyage: tauto.Voyage) -> None:
    """Fading and what leaks below the lowest frequency leave 3 % of the larger wave."""
    found = seaway(voyage, 300.0, 600.0)
    assert found.time_s[0] == pytest.approx(300.0, abs=0.051)
    assert found.time_s[-1] == pytest.approx(900.0, abs=0.1)
    t = found.time_s
    heave = 1.5 * np.cos(2 * np.pi * t / 8.0) + 0.4 * np.cos(2 * np.pi * t / 5.0 + 1.0)
    inside = slice(int(TAPER_S * 20.0), -int(TAPER_S * 20.0))
    np.testing.assert_allclose(found.heave_m[inside], heave[inside], atol=0.045)
    np.testing.assert_allclose(found.roll_rad, 0.1 * np.cos(2 * np.pi * t / 11.0), atol=1e-9)


def test_a_ship_that_lies_still_has_no_heave() -> None:
    found = seaway(tauto.sail('ideal', duration=60.0))
    assert np.all(found.heave_m == 0.0)
