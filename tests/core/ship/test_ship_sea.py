"""The sea's energy and its spectrum."""

import numpy as np
import pytest
from scipy.integrate import quad

from tauto_core.ship.sea import bretschneider, elevation, jonswap_shape
from tauto_core.ship.sections import Sea


def sea(spectrum: str, components: int = 64) -> Sea:
    return Sea(
        spectrum=spectrum, significant_wave_height=3.2, peak_period=9.5, components=components
    )


def test_bretschneider_has_the_energy_of_its_height():
    area = quad(lambda w: float(bretschneider(np.array(w), 3.2, 9.5)), 0.05, 400.0, limit=400)[0]
    # the tail beyond 400 rad/s holds Hs^2/16 (5/4) (w_p/400)^4, 3e-12 of it
    assert area == pytest.approx(3.2**2 / 16.0, rel=1e-8)


def test_peak_lies_at_the_peak_period():
    omega = np.linspace(0.3, 2.0, 100_001)
    for shape in (1.0, jonswap_shape(omega, 9.5, 3.3)):
        peak = omega[np.argmax(bretschneider(omega, 3.2, 9.5) * shape)]
        assert 2.0 * np.pi / peak == pytest.approx(9.5, rel=1e-4)


def test_jonswap_raises_the_peak_by_gamma():
    peak = np.array([2.0 * np.pi / 9.5])
    assert jonswap_shape(peak, 9.5, 3.3)[0] == pytest.approx(3.3, rel=1e-14)
    assert jonswap_shape(10.0 * peak, 9.5, 3.3)[0] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize('spectrum', ['bretschneider', 'jonswap'])
@pytest.mark.parametrize('components', [1, 64, 500])
def test_components_have_the_significant_height(spectrum, components):
    waves = elevation(sea(spectrum, components), 1726)
    assert 4.0 * np.sqrt(np.sum(waves.amplitude**2) / 2.0) == pytest.approx(3.2, rel=1e-14)
    assert len(waves.period) == components
    assert (np.diff(waves.period) < 0.0).all()


def test_components_follow_the_spectrum():
    """Energy below w is Hs^2/16 exp(-5/4 (w_p/w)^4), within what 500 jittered bins resolve."""
    waves = elevation(sea('bretschneider', 500), 5)
    energy = np.cumsum(waves.amplitude**2 / 2.0)
    expected = 3.2**2 / 16.0 * np.exp(-1.25 * (waves.period / 9.5) ** 4)
    # 0.5 % is beyond the band, one bin holds up to 0.8 %
    np.testing.assert_allclose(energy, expected, rtol=0, atol=0.015 * 3.2**2 / 16.0)


def test_steps_of_frequency_are_uneven_and_follow_the_seed():
    first, again, other = (elevation(sea('jonswap'), seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.period, again.period)
    np.testing.assert_array_equal(first.phase, again.phase)
    assert not np.isin(first.period, other.period).any()
    assert not np.isin(first.phase, other.phase).any()
    assert np.diff(np.log(first.period)).std() > 0.005
