"""The rate equation in the filter: least squares, port and sea, consistency, the longitude."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import chi2

from tauto_core.navigation import ClockModel, Known, filter_phases, predict, prior
from tauto_core.navigation.drift import Track
from tauto_core.navigation.hindsight import smooth
from tauto_core.navigation.kalman import Coefficient, covariance, means, same_fields
from tauto_core.samples import SECONDS_PER_DAY as DAY

S = 1_000_000_000
BOTH = (Coefficient('heave', 1.0, 0.2), Coefficient('roll', -0.3, 0.4))
NAMES = ('heave', 'roll')


def model_of(states, noise=1.0):
    # units of order one, so that the dense solution keeps its digits
    run = 0.003 * noise if states == 3 else 0.0
    return ClockModel(0.5, 0.3, states, 0.01 * noise, 0.02 * noise, run, coefficients=BOTH)


def start_of(model, dd=0.04):
    ageing = dd if model.states == 3 else 0.0
    return Known(0, prior(model)._replace(dd=ageing), integrals_s=(0.0, 0.0))


def step_of(tau, model):
    """Transition and process noise of the clock from one matrix exponential (Van Loan 1978)."""
    a = np.diag([1.0, 1.0], 1)
    w = np.diag([model.white_fm_s, model.random_walk_fm_per_s, model.random_run_per_s3])
    big = np.zeros((6, 6))
    big[:3, :3], big[:3, 3:], big[3:, 3:] = -a, w, a.T
    blocks = expm(big * tau)
    f = blocks[3:, 3:].T
    return f, f @ blocks[:3, 3:]


def least_squares(start, times_s, integrals, phases, model):
    """Weighted least squares for all unknowns at once: the coefficients, the clock at all times.

    Rows are the prior, the steps of the clock by the root of their noise, and the observations.
    """
    n, states = len(times_s), model.states
    size = 2 + states * (n + 1)
    rows, right = [], []

    def add(weights, columns, values):
        row = np.zeros((len(values), size))
        for at, block in columns:
            row[:, at : at + block.shape[1]] = weights @ block
        rows.append(row)
        right.append(weights @ values)

    known = np.array([start.x, start.y, start.d])[:states]
    spread = np.sqrt([start.xx, start.yy, start.dd])[:states]
    add(np.diag(1.0 / spread), [(2, np.eye(states))], known)
    for k, (_, value, sigma) in enumerate(BOTH):
        add(np.eye(1) / sigma, [(k, np.eye(1))], np.array([value]))
    before, passed = 0.0, np.zeros(2)
    for i, (time, moved) in enumerate(zip(times_s, integrals, strict=True)):
        f, q = step_of(time - before, model)
        root = np.linalg.inv(np.linalg.cholesky(q[:states, :states]))
        of_k = np.zeros((states, 2))
        of_k[0] = -(moved - passed)
        old, new = 2 + states * i, 2 + states * (i + 1)
        terms = [(0, of_k), (old, -f[:states, :states]), (new, np.eye(states))]
        add(root, terms, np.zeros(states))
        seen = np.zeros((1, states))
        seen[0, 0] = 1.0
        add(np.eye(1) / model.observation_sigma_s, [(new, seen)], phases[i : i + 1])
        before, passed = time, moved
    table = np.concatenate(rows)
    orthogonal, upper = np.linalg.qr(table)
    solution = np.linalg.solve(upper, orthogonal.T @ np.concatenate(right))
    inverse = np.linalg.inv(upper)
    return solution, inverse @ inverse.T


@pytest.mark.parametrize('states', [2, 3])
def test_filter_and_smoother_are_batch_least_squares(states):
    model, rng = model_of(states), np.random.default_rng(1)
    stamps = np.cumsum(rng.integers(S // 5, 3 * S, 25))
    integrals = np.cumsum(rng.uniform(0.0, 2.0, (25, 2)) * [-1.0, 1.0], axis=0)
    phases = np.cumsum(rng.normal(size=25))
    start = start_of(model)
    way = filter_phases(
        start, stamps.tolist(), phases.tolist(), model, integrals_s=integrals.tolist()
    )
    solution, spread = least_squares(start.estimate, stamps / 1e9, integrals, phases, model)
    found = smooth(way, model).at(stamps, integrals)
    clock = solution[2:].reshape(26, states)[1:]
    mean = means(found, NAMES)
    # 1e-9: rounding times the condition of the whole least-squares problem
    np.testing.assert_allclose(mean[:, :states], clock, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(mean[:, 3:], np.tile(solution[:2], (25, 1)), rtol=1e-9)
    last = np.array([*range(len(solution) - states, len(solution)), 0, 1])
    at = [*range(states), 3, 4]
    ours = covariance(way.states, NAMES)[-1][np.ix_(at, at)]
    np.testing.assert_allclose(ours, spread[np.ix_(last, last)], rtol=1e-9, atol=1e-12)
    filtered = means(way.states, NAMES)[-1, at]
    np.testing.assert_allclose(filtered, solution[last], rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize('states', [2, 3])
def test_a_ship_at_rest_has_the_filter_without_covariates(states):
    model, rng = model_of(states), np.random.default_rng(2)
    plain = ClockModel(0.5, 0.3, states, 0.01, 0.02, model.random_run_per_s3)
    stamps = np.cumsum(rng.integers(S // 5, 3 * S, 30)).tolist()
    phases = rng.normal(size=30).tolist()
    start = start_of(model)
    alone = Known(0, prior(plain)._replace(dd=start.estimate.dd))
    still = [(0.0, 0.0)] * 30
    ours = filter_phases(start, stamps, phases, model, integrals_s=still).states
    theirs = filter_phases(alone, stamps, phases, plain).states
    for field in theirs._fields:
        np.testing.assert_allclose(
            getattr(ours, field), getattr(theirs, field), rtol=1e-12, atol=1e-14
        )
    np.testing.assert_array_equal(ours.heave, 1.0)
    np.testing.assert_allclose(ours.heave_heave, 0.04, rtol=1e-15)


@pytest.mark.parametrize('states', [2, 3])
def test_one_at_a_time_late_and_all_at_once_give_the_same_bits(states):
    model, rng = model_of(states), np.random.default_rng(3)
    stamps = np.cumsum(rng.integers(S // 5, 3 * S, 40)).tolist()
    phases = rng.normal(size=40).tolist()
    integrals = np.cumsum(rng.uniform(0.0, 1.0, (40, 2)), axis=0).tolist()
    start = start_of(model)
    whole = filter_phases(start, stamps, phases, model, integrals_s=integrals).after(40)
    track = Track(start, model)
    order = [*range(1, 40, 2), *range(0, 40, 2)]
    for k in order[:25]:
        track.use([stamps[k]], [phases[k]], integrals_s=[tuple(integrals[k])])
    resumed = Track(start, model)
    resumed.restore(track.state())
    for k in order[25:]:
        resumed.use([stamps[k]], [phases[k]], integrals_s=[tuple(integrals[k])])
    assert resumed.last == whole
    many = same_fields(prior(model), (np.full(5, value) for value in whole.estimate))
    ahead = np.arange(5.0)
    moved = 0.3 * ahead, 0.7 * ahead
    later = predict(many, ahead, model, moved)
    for k in range(5):
        one = predict(whole.estimate, float(k), model, (float(moved[0][k]), float(moved[1][k])))
        assert tuple(column[k] for column in later) == tuple(one)


HEAVY = -(0.075**2) / 8.0
"""Mean of x_heave where the heave's acceleration is 0.075 g, root mean square: -61 s/day."""


def daily(days, seas, model, truth, rng):
    """The filter over daily observations; `seas` gives the mean regressors of each day."""
    integrals = np.cumsum(np.array(seas) * DAY, axis=0)
    stamps = (np.arange(1, days + 1) * DAY * 1e9).astype(np.int64)
    dial = truth[0] * stamps / 1e9 + integrals @ truth[1:]
    phases = dial + rng.normal(0.0, model.observation_sigma_s, days)
    start = Known(0, prior(model), integrals_s=(0.0,) * len(model.coefficients))
    return filter_phases(
        start, stamps.tolist(), phases.tolist(), model, integrals_s=integrals.tolist()
    )


def test_in_port_the_coefficients_stay_where_they_are_and_say_so():
    model = ClockModel(0.5, 1000.0 / DAY, coefficients=(Coefficient('heave', 1.0, 0.05),))
    rng, truth = np.random.default_rng(4), np.array([3.0 / DAY, 1.08])
    port = [[HEAVY]] * 14
    way = daily(14, port, model, truth, rng)
    # the rate is known to 1000 s/day beforehand, the coefficient to 3 s/day in this swell: the
    # observations can tell (3/1000)² of it
    assert way.states.heave[-1] == pytest.approx(1.0, abs=0.05 * 0.01)
    assert np.sqrt(way.states.heave_heave[-1]) == pytest.approx(0.05, rel=1e-4)
    spread = 0.05 * abs(HEAVY) * DAY
    assert np.sqrt(way.states.yy[-1]) * DAY == pytest.approx(spread, rel=0.02)
    # the rate in that very sea is known all the same, to the daily observations
    last = same_fields(way.states, (column[-1:] for column in way.states))
    tomorrow = predict(last, np.array([DAY]), model, (np.array([HEAVY * DAY]),))
    assert np.sqrt(tomorrow.xx[0]) < 0.5
    calm = predict(last, np.array([DAY]), model, (np.array([0.0]),))
    assert np.sqrt(calm.xx[0]) > spread


def test_at_sea_they_are_learned():
    model = ClockModel(0.5, 1000.0 / DAY, coefficients=(Coefficient('heave', 1.0, 0.05),))
    rng, truth = np.random.default_rng(5), np.array([3.0 / DAY, 1.08])
    way = daily(28, [[0.02 * HEAVY]] * 14 + [[HEAVY]] * 14, model, truth, rng)
    sigma = np.sqrt(way.states.heave_heave)
    assert sigma[14] == pytest.approx(0.05, rel=1e-3)
    assert sigma[-1] < 0.005
    assert abs(way.states.heave[-1] - 1.08) < 3.0 * sigma[-1]
    assert way.states.y[-1] * DAY == pytest.approx(3.0, abs=3.0 * np.sqrt(way.states.yy[-1]) * DAY)


def test_errors_are_as_large_as_the_filter_says():
    """Seas, rates and coefficients drawn anew: eT P^-1 e is chi-squared with four freedoms."""
    known = (Coefficient('heave', 1.0, 0.05), Coefficient('roll', 0.0, 0.02))
    model = ClockModel(0.5, 10.0 / DAY, coefficients=known)
    runs, days, total = 200, 30, 0.0
    _, q = step_of(DAY, model)
    scale = np.diag([1.0, DAY])
    root = np.linalg.inv(scale) @ np.linalg.cholesky(scale @ q[:2, :2] @ scale)
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        first = prior(model)
        truth = rng.normal([0.0, 0.0], np.sqrt([first.xx, first.yy]))
        k = rng.normal([c.value for c in known], [c.sigma for c in known])
        heave = HEAVY * np.exp(rng.normal(0.0, 0.7, days))
        roll = 0.01 * np.exp(rng.normal(0.0, 0.7, days))
        integrals = np.cumsum(np.column_stack((heave, roll)) * DAY, axis=0)
        phases = np.empty(days)
        for day in range(days):
            grown = integrals[day] - (integrals[day - 1] if day else 0.0)
            truth = np.array([truth[0] + DAY * truth[1] + grown @ k, truth[1]])
            truth = truth + root @ rng.normal(size=2)
            phases[day] = truth[0] + rng.normal(0.0, 0.5)
        stamps = (np.arange(1, days + 1) * DAY * 1e9).astype(np.int64).tolist()
        start = Known(0, first, integrals_s=(0.0, 0.0))
        way = filter_phases(start, stamps, phases.tolist(), model, integrals_s=integrals.tolist())
        at = [0, 1, 3, 4]
        wrong = means(way.states, NAMES)[-1, at] - np.concatenate((truth, k))
        units = np.array([1.0, DAY, 1.0, 1.0])
        p = covariance(way.states, NAMES)[-1][np.ix_(at, at)] * np.outer(units, units)
        total += float((wrong * units) @ np.linalg.solve(p, wrong * units))
    # two-sided at 1e-4: a seeded ensemble, so it passes always or never
    low, high = (chi2.ppf(each, 4 * runs) for each in (5e-5, 1 - 5e-5))
    assert low < total < high
