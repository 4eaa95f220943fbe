"""Stability against the data set of NIST SP 1065, closed forms, and what must be refused."""

import numpy as np
import pytest

from tauto_core.navigation.stability import FEWEST, error_of, stability, stability_of
from tauto_core.samples import TimeSamples, same
from tauto_core.scene.errors import EstimationError

S = 1_000_000_000


def nbs_phases():
    """The 1000 frequencies of NIST SP 1065, section 12.4, summed to phases at τ0 = 1 s."""
    n = [1_234_567_890]
    for _ in range(999):
        n.append(16_807 * n[-1] % 2_147_483_647)
    assert n[1:4] == [395_529_916, 1_209_410_747, 633_705_974]
    return np.concatenate(([0.0], np.cumsum(np.array(n) / 2_147_483_647)))


# NIST SP 1065 (2008), table 31: τ = 1, 10, 100 s, seven digits
PUBLISHED = {
    'allan': (2.922319e-01, 9.159953e-02, 3.241343e-02),
    'modified': (2.922319e-01, 6.172376e-02, 2.170921e-02),
    'time': (1.687202e-01, 3.563623e-01, 1.253382e00),
    'hadamard': (2.943883e-01, 9.581083e-02, 3.237638e-02),
}


@pytest.mark.parametrize('kind', PUBLISHED)
def test_the_published_deviations_of_the_1000_point_set(kind):
    found = stability(nbs_phases(), 1.0, (1, 10, 100))
    # half a unit of the last digit printed, at most 4e-7 of the number
    np.testing.assert_allclose(getattr(found, kind).value, PUBLISHED[kind], rtol=4e-7)
    # uniform random frequencies are white
    assert found.noise == ('white FM',) * 3


def test_offset_rate_and_units_do_not_matter():
    x = nbs_phases()
    plain = stability(x, 1.0)
    moved = stability(1e-6 * x + 5.0 + 1e-4 * np.arange(len(x)), 60.0)
    assert list(plain.tau_s) == [1, 2, 4, 8, 16, 32, 64, 128]
    np.testing.assert_array_equal(moved.tau_s, 60.0 * plain.tau_s)
    np.testing.assert_allclose(moved.allan.value, 1e-6 / 60.0 * plain.allan.value, rtol=1e-8)
    np.testing.assert_allclose(moved.time.value, 1e-6 * plain.time.value, rtol=1e-8)
    assert moved.noise == plain.noise


@pytest.mark.parametrize(
    ('sums', 'noise', 'allan'),
    [
        (0, 'white PM', lambda tau: np.sqrt(3.0) / tau),
        (1, 'white FM', lambda tau: 1.0 / np.sqrt(tau)),
        (2, 'random walk FM', lambda tau: np.sqrt((2.0 * tau**2 + 1.0) / (6.0 * tau))),
    ],
)
def test_confidence_intervals_hold_the_closed_form_as_often_as_they_say(sums, noise, allan):
    rng = np.random.default_rng(7)
    runs, held, told = 60, 0, 0
    for _ in range(runs):
        x = rng.normal(size=513)
        for _ in range(sums):
            x = np.cumsum(x)
        found = stability(x, 1.0, (1, 8, 64))
        told += found.noise[0] == noise
        true = allan(found.tau_s)
        held += np.count_nonzero((found.allan.low < true) & (true < found.allan.high))
    # of 180, 171 are expected; the three of a run are not independent: σ < 5
    assert 155 <= held < 180
    assert told > 0.9 * runs


def test_a_clock_in_between_is_told_by_its_noise():
    rng = np.random.default_rng(3)
    walk = 3e-2 * np.cumsum(np.cumsum(rng.normal(size=20_000)))
    found = stability(walk + np.cumsum(rng.normal(size=20_000)), 60.0)
    assert found.noise[0] == 'white FM'
    assert found.noise[-1] == 'random walk FM'


def reading(stamps_s, error_s):
    stamps = np.asarray(np.rint(np.asarray(stamps_s) * S), np.int64)
    errors = np.asarray(np.rint(np.broadcast_to(error_s, stamps.shape) * S), np.int64)
    return TimeSamples(stamps, '', stamps + errors, same('dial', len(stamps)))


def test_readings_become_errors_at_even_intervals():
    rng = np.random.default_rng(2)
    error = rng.normal(size=100)
    found, interval = error_of(reading(1e9 + 60.0 * np.arange(100), error))
    np.testing.assert_allclose(found, error, atol=1e-9)
    assert interval == 60.0
    rows = stability_of(reading(60.0 * np.arange(100), error))
    assert rows['samples'] == 100
    assert [row['tau_s'] for row in rows['rows']] == [60.0, 120.0, 240.0, 480.0, 960.0]
    assert all(row['time_low'] < row['time'] < row['time_high'] for row in rows['rows'])


@pytest.mark.parametrize(
    ('readings', 'words'),
    [
        (reading(range(FEWEST - 1), 0.0), '31 readings are too few'),
        (reading([*range(50), *range(51, 99)], 0.0), 'at 51 s comes 2 s after'),
        (reading(np.arange(99.0), 1e-3 * np.arange(99.0)), 'on a parabola'),
        (reading(np.arange(99.0), 1e-3 * np.arange(99.0) ** 2), 'on a parabola'),
    ],
)
def test_what_has_no_stability_is_refused_by_name(readings, words):
    with pytest.raises(EstimationError, match=words):
        stability_of(readings)


def test_a_tau_beyond_a_sixth_of_the_readings_is_refused():
    with pytest.raises(EstimationError, match='6 τ'):
        stability(np.random.default_rng(1).normal(size=100), 1.0, (1, 17))


def test_an_error_that_repeats_itself_is_no_noise_at_its_period():
    found = stability(np.tile([0.0, 1.0], 100), 1.0)
    assert found.allan.value[0] > 1.0
    assert found.allan.value[1] < 1e-12
    assert np.isfinite(found.allan.high).all()
