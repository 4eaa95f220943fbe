"""Measured seas: energy and peak of the generated waves, and the motion of a real ship in them."""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from tauto_core.scene import load_scene
from tauto_core.ship import ShipMotion, bag_metadata
from tauto_core.ship.motions.sea import sea_motion
from tauto_core.ship.sea import band_hz, elevation, energy_below, height_and_period
from tauto_core.ship.sections import SpectrumTable

SPECTRUM = 'shipped:ndbc_44004/2000-01-01T02.csv'
OPERATOR = 'shipped:supply_rao/supply_rao.csv'


def measured(components: int = 64) -> SpectrumTable:
    return scene(components).ship.sea


def scene(components: int = 64, **keys: object):
    sea = {'spectrum': 'file', 'path': SPECTRUM, 'components': components}
    rao = {'path': OPERATOR, 'heading': 0.5 * math.pi}
    return load_scene('ideal', ship={'kind': 'sea', 'sea': sea, 'rao': rao, **keys})


@pytest.mark.parametrize('components', [1, 3, 64, 2000])
def test_components_have_the_height_of_the_spectrum(components):
    """Hs = 4 sqrt(m0) with m0 the trapezoidal sum, exact for a linear interpolant."""
    sea = measured(components)
    rows = zip(map(Fraction, sea.frequency), map(Fraction, sea.energy_density), strict=True)
    m0 = sum((b[0] - a[0]) * (a[1] + b[1]) / 2 for a, b in pairwise(rows))
    expected = 4.0 * math.sqrt(m0)
    waves = elevation(sea, 1726)
    assert 4.0 * np.sqrt(np.sum(waves.amplitude**2) / 2.0) == pytest.approx(expected, rel=1e-14)
    assert height_and_period(sea)[0] == pytest.approx(expected, rel=1e-14)
    assert len(waves.period) == components


def test_components_peak_where_the_spectrum_does():
    """The densest bin holds the peak: the frequency of its component is at most a bin off."""
    sea = measured(500)
    waves = elevation(sea, 3)
    edges = np.geomspace(*band_hz(sea), 501)
    densest = int(np.argmax(waves.amplitude**2 / np.diff(edges)))
    assert edges[densest] <= 1.0 / waves.period[densest] <= edges[densest + 1]
    assert edges[densest] <= 0.18 <= edges[densest + 1]
    assert height_and_period(sea)[1] == 1.0 / 0.18


def test_energy_below_a_frequency_is_the_integral():
    sea = SpectrumTable(
        spectrum='table', source='x', frequency=(0.1, 0.2, 0.4), energy_density=(0.0, 2.0, 1.0)
    )
    # triangle 0.1, its first quarter 0.025, trapezoid to 0.3: 0.1 (2 + 1.5)/2
    found = energy_below(sea, np.array([0.1, 0.15, 0.2, 0.3, 0.4]))
    np.testing.assert_allclose(found, [0.0, 0.025, 0.1, 0.275, 0.4], rtol=1e-14, atol=1e-17)


def test_the_band_ends_where_the_energy_does():
    density = (0.0, 0.0, 1.0, 0.0, 0.0)
    sea = SpectrumTable(
        spectrum='table', source='x', frequency=(0.1, 0.2, 0.3, 0.4, 0.5), energy_density=density
    )
    assert band_hz(sea) == (0.2, 0.4)
    assert np.all(elevation(sea, 1).amplitude > 0.0)


def test_the_supply_vessel_rolls_as_published():
    """README of the data: 0.43 to 0.51 deg RMS in three measured beam seas, this one the
    largest. A sum over the rows of the table gives 0.5135."""
    ready = scene(1000)
    roll = sea_motion(ready, ready.ship).roll
    rms = np.degrees(np.sqrt(np.sum(roll.amplitude**2) / 2.0))
    assert rms == pytest.approx(0.5135, rel=0.01)


def test_metadata_say_how_the_sea_is_met():
    ready = load_scene('buoy_44004_supply')
    told = ShipMotion(ready).metadata
    assert told['spectrum'] == 'table'
    assert told['source'] == SPECTRUM
    assert told['operator'] == OPERATOR
    assert told['significant_wave_height_m'] == pytest.approx(1.7251, abs=5e-5)
    assert told['peak_period_s'] == pytest.approx(1.0 / 0.18, rel=1e-15)
    assert (told['seed'], told['heading_rad'], told['speed_m_s']) == (1726, 1.75, 5.0)


def test_other_ships_have_nothing_to_say_of_a_sea():
    assert bag_metadata(load_scene('ideal')) == {}
    assert bag_metadata(load_scene('measured')) == {}
