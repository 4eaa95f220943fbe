"""Stability against the data set of NIST SP 1065, closed forms, and refusals."""

import allantools
import numpy as np
import power_law_noise
import pytest
from in_pieces import times

from tauto_core.navigation.stability import (
    FEWEST,
    Difference,
    degrees_of_freedom,
    error_of,
    stability,
    stability_of,
)
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
    np.testing.assert_allclose(found[kind], PUBLISHED[kind], rtol=4e-7)
    # uniform random frequencies are white
    assert found['noise'] == ['white FM'] * 3


def test_offset_rate_and_units_do_not_matter():
    x = nbs_phases()
    plain = stability(x, 1.0)
    moved = stability(1e-6 * x + 5.0 + 1e-4 * np.arange(len(x)), 60.0)
    assert list(plain['tau_s']) == [1, 2, 4, 8, 16, 32, 64, 128]
    np.testing.assert_array_equal(moved['tau_s'], 60.0 * plain['tau_s'])
    np.testing.assert_allclose(moved['allan'], 1e-6 / 60.0 * plain['allan'], rtol=1e-8)
    np.testing.assert_allclose(moved['time'], 1e-6 * plain['time'], rtol=1e-8)
    assert moved['noise'] == plain['noise']


@pytest.mark.parametrize('alpha', [2, 1, 0, -1, -2])
def test_intervals_hold_the_deviation_as_often_as_they_say(alpha):
    rng = np.random.default_rng(7)
    runs, factors, kinds = 150, (1, 8, 64), ('allan', 'modified', 'time', 'hadamard')
    true = {k: [power_law_noise.deviation(k, {alpha: 1.0}, m) for m in factors] for k in kinds}
    held = np.zeros((len(kinds), len(factors)))
    for _ in range(runs):
        found = stability(power_law_noise.noise(alpha, 513, rng), 1.0, factors)
        for row, kind in enumerate(kinds):
            low, high = found[f'{kind}_low'], found[f'{kind}_high']
            held[row] += (low < true[kind]) & (true[kind] < high)
    # 95 % of 150 is 142.5 ± 2.7. Fewer than 128 come with a probability of 2e-6, here of 60 counts
    assert held.min() >= 128
    # intervals are not simply wide: of 60 counts the mean is 142.5 by one or two
    assert 139 < held.mean() < 146


def test_intervals_hold_where_the_kind_of_noise_changes():
    rng = np.random.default_rng(11)
    runs, factors, parts = 60, (4, 16, 64), {2: 1.0, -2: 0.003}
    true = [power_law_noise.deviation('allan', parts, m) for m in factors]
    held = np.zeros(len(factors))
    for _ in range(runs):
        found = stability(power_law_noise.mixed(parts, 513, rng), 1.0, factors)
        held += (found['allan_low'] < true) & (true < found['allan_high'])
    # 57 ± 1.7 of 60. If a kind cannot give way to another (CHANGE = 0) it is 49 at m = 64
    assert held.min() >= 52


@pytest.mark.parametrize(
    ('alpha', 'order', 'exact'),
    [
        # second and third differences of independent numbers and of their sums, whose correlations
        # are those of the binomial coefficients: 1/(1 + 2 Σ ρ²) of the number of differences
        (2, 2, 1.0 / (1.0 + 2.0 * ((4 / 6) ** 2 + (1 / 6) ** 2))),
        (0, 2, 1.0 / (1.0 + 2.0 * (1 / 2) ** 2)),
        (-2, 2, 1.0),
        (0, 3, 1.0 / (1.0 + 2.0 * ((4 / 6) ** 2 + (1 / 6) ** 2))),
        (-2, 3, 1.0 / (1.0 + 2.0 * (1 / 2) ** 2)),
    ],
)
def test_degrees_of_freedom_in_closed_form(alpha, order, exact):
    count = 100_000
    found = degrees_of_freedom(alpha, Difference(order, 1, False), count)
    # the ends of the record take less than ten differences' worth
    assert found / (count - order) == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize('alpha', [2, 0, -1, -2])
@pytest.mark.parametrize(('order', 'modified'), [(2, False), (2, True), (3, False)])
def test_degrees_of_freedom_agree_with_greenhall_and_riley(alpha, order, modified):
    """From m = 32 on it does not matter whether phases are averaged over the sampling interval."""
    for m in (32, 100, 300):
        found = degrees_of_freedom(alpha, Difference(order, m, modified), 2049)
        published = allantools.edf_greenhall(alpha, order, m, 2049, True, modified)
        # the paper gives its approximations for many samples to some percent
        assert found == pytest.approx(published, rel=0.035)


def test_readings_become_errors_at_even_intervals():
    rng = np.random.default_rng(2)
    error = rng.normal(size=100)
    found, interval = error_of(times(1e9 + 60.0 * np.arange(100), error))
    np.testing.assert_allclose(found, error, atol=1e-9)
    assert interval == 60.0
    rows = stability_of(times(60.0 * np.arange(100), error))
    assert rows['samples'] == 100
    assert [row['tau_s'] for row in rows['rows']] == [60.0, 120.0, 240.0, 480.0, 960.0]
    assert all(row['time_low'] < row['time'] < row['time_high'] for row in rows['rows'])


@pytest.mark.parametrize(
    ('readings', 'words'),
    [
        (times(range(FEWEST - 1), 0.0), '31 readings are too few'),
        (times([*range(50), *range(51, 99)], 0.0), 'at 51 s comes 2 s after'),
        (times(np.arange(99.0), 1e-3 * np.arange(99.0)), 'on a parabola'),
        (times(np.arange(99.0), 1e-3 * np.arange(99.0) ** 2), 'on a parabola'),
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
    assert found['allan'][0] > 1.0
    assert found['allan'][1] < 1e-12
    assert np.isfinite(found['allan_high']).all()
