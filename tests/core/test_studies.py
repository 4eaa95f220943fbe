"""Three altitudes by a ship's clock: D. Bernoulli's problem of 1729."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import tauto_core as tauto
from tauto_core.cli.app import app

DAY, STAR = 86_400.0, 86_164.0905


def seen(phi_deg: float, delta_deg: float, hours_deg: list[float]) -> list[float]:
    """Return altitudes [deg]: the star's direction on its axis, turned to the zenith's frame."""
    phi, delta, hours = np.radians(phi_deg), np.radians(delta_deg), np.radians(hours_deg)
    star = np.array([np.cos(delta) * np.cos(hours), np.cos(delta) * np.sin(hours)])
    height = np.cos(phi) * star[0] + np.sin(phi) * np.sin(delta)
    return list(np.degrees(np.arcsin(height)))


def solved(phi: float, delta: float, hours: list[float], **more: Any) -> dict[str, Any]:
    """Return the answer if the clock is right and began at 0, and the account is 2° off."""
    times = [(each - hours[0]) / 360.0 * STAR for each in hours]
    given = {'altitudes_deg': seen(phi, delta, hours), 'times': times, 'latitude_deg': phi + 2.0}
    return tauto.altitudes(**given | more)


@pytest.mark.parametrize(
    ('phi', 'delta', 'hours'),
    [
        (50.0, 20.0, [-60.0, -30.0, 10.0]),
        (-35.0, -8.0, [5.0, 40.0, 71.0]),
        (18.0, 38.8, [-50.0, -49.0, -46.0]),
        (10.0, -30.0, [-20.0, 0.0, 20.0]),
        (60.0, 80.0, [100.0, 150.0, 200.0]),
    ],
)
def test_the_place_and_the_culmination_are_those_of_the_sphere(phi, delta, hours):
    """Over a few degrees the cosines share four digits, and their differences eight."""
    found = solved(phi, delta, hours)
    assert found['latitude_deg'] == pytest.approx(phi, abs=1e-6)
    assert found['declination_deg'] == pytest.approx(delta, abs=1e-6)
    assert found['highest_deg'] == pytest.approx(90.0 - abs(phi - delta), abs=1e-6)
    assert found['culmination_s'] == pytest.approx(-hours[0] / 360.0 * STAR, abs=1e-3)


def test_the_lemma_of_1729_lacks_a_minus():
    """IP, PQ, QR = 0.4, 0.5, 0.7: as printed it is −tan IP. `culmination_s` has IP itself."""
    i_p, p_q, p_r = 0.4, 0.5, 1.2
    l_m = math.cos(i_p) - math.cos(i_p + p_q)
    l_n = math.cos(i_p) - math.cos(i_p + p_r)
    over = l_n * (1.0 - math.cos(p_q)) - l_m * (1.0 - math.cos(p_r))
    printed = over / (l_n * math.sin(p_q) - l_m * math.sin(p_r))
    assert printed == pytest.approx(-math.tan(i_p), rel=1e-12)
    found = solved(40.0, 10.0, list(np.degrees([i_p, i_p + p_q, i_p + p_r])))
    assert -found['culmination_s'] / STAR * math.tau == pytest.approx(i_p, rel=1e-9)


@pytest.mark.parametrize('apart', [5.0, 30.0, 60.0])
def test_a_rate_shifts_latitude_by_the_closed_form_about_noon(apart):
    """dφ = (a cot ½a)/(tan φ + tan δ) per turned angle: 2/(tan φ + tan δ) of near altitudes."""
    phi, delta, a = math.radians(48.0), math.radians(12.0), math.radians(apart)
    errors = solved(48.0, 12.0, [-apart, 0.0, apart])['errors']
    exact = a / math.tan(0.5 * a) / (math.tan(phi) + math.tan(delta)) / DAY
    assert errors[0]['latitude_nmi'] == pytest.approx(math.degrees(exact) * 60.0, rel=1e-6)
    assert errors[0]['declination_arcmin'] == pytest.approx(errors[0]['latitude_nmi'], rel=1e-6)
    assert errors[0]['culmination_s'] == pytest.approx(0.0, abs=1e-9)


def test_errors_are_the_changes_of_the_answer_itself():
    """A fast clock turned back by its rate, and one altitude raised. The differences are central.

    Both steps are half a unit: the third order is some 1e-5 of the change.
    """
    place = 44.0, -15.0, [-40.0, -12.0, 33.0]
    errors = solved(*place)['errors']
    keys = {'latitude_nmi': ('latitude_deg', 60.0), 'culmination_s': ('culmination_s', 1.0)}
    for k in range(4):
        ends = []
        for step in (-0.5, 0.5):
            raised = np.array(seen(*place))
            if k:
                raised[k - 1] += step / 60.0
                ends.append(solved(*place, altitudes_deg=raised))
            else:
                ends.append(solved(*place, rate=-step))  # uncorrected
        for key, (of, size) in keys.items():
            assert errors[k][key] == pytest.approx(size * (ends[1][of] - ends[0][of]), rel=1e-4)


def test_the_command_says_the_same():
    words = ['altitudes', '--altitudes', '33.8,52.5 deg,62.5', '--times', '0,2 h,4 h']
    said = CliRunner().invoke(app, [*words, '--latitude', '48', '--json'])
    given = {'altitudes_deg': [33.8, 52.5, 62.5], 'times': [0.0, 7200.0, 14400.0]}
    assert json.loads(said.stdout) == tauto.altitudes(**given, latitude_deg=48.0)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'altitudes_deg': [30.0, 40.0]}, 'must be three, each within 90 deg'),
        ({'altitudes_deg': [30.0, 40.0, 95.0]}, 'must be three, each within 90 deg'),
        ({'latitude_deg': math.nan}, 'must be within 90 deg'),
        ({'times': [0.0, 900.0, 900.0]}, 'must be three that rise, within 43082 s'),
        ({'rate': math.inf}, 'rate = inf: must be within 43200 s/day'),
        ({'altitudes_deg': [30.0, 80.0, 30.0]}, 'no star that rises'),
        ({'altitudes_deg': [30.0, 30.0, 30.0]}, 'no star that rises'),
        ({'body': 'moon'}, "body = 'moon': must be star or sun"),
    ],
)
def test_what_no_place_sees_is_refused(change, words):
    given = {'altitudes_deg': [30.0, 40.0, 41.0], 'times': [0.0, 3600.0, 7200.0]}
    with pytest.raises(tauto.TautoError, match=words):
        tauto.altitudes(**{**given, 'latitude_deg': 48.0, **change})
