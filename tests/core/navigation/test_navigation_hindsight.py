"""The smoother against dense conditioning of Gaussians, and its invariants."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import chi2

from tauto_core.navigation import ClockModel, Known, filter_phases, predict, prior
from tauto_core.navigation.hindsight import smooth
from tauto_core.navigation.kalman import REFUSED, REOPENED

S = 1_000_000_000


def model_of(states, gate=None):
    # units of order one, so that the dense solution keeps its digits
    return ClockModel(0.5, 0.3, states, 0.01, 0.02, 0.003 if states == 3 else 0.0, gate)


def step_of(tau, model):
    """Transition and process noise from one matrix exponential (Van Loan 1978)."""
    a = np.diag([1.0, 1.0], 1)
    w = np.diag([model.white_fm_s, model.random_walk_fm_per_s, model.random_run_per_s3])
    big = np.zeros((6, 6))
    big[:3, :3], big[:3, 3:], big[3:, 3:] = -a, w, a.T
    blocks = expm(big * tau)
    f = blocks[3:, 3:].T
    return f, f @ blocks[:3, 3:]


def dense(start, times_s, seen, phases, model, extra):
    """Mean and covariance of the state at every time given all phases, by linear algebra.

    The states are jointly normal: build their covariance from the steps and condition on the
    phases of the times in `seen`; `extra` adds to the noise of a step.
    """
    n = len(times_s)
    mean, cov = np.zeros((n, 3)), np.zeros((3 * n, 3 * n))
    p0 = np.array(
        [
            [start.xx, start.xy, start.xd],
            [start.xy, start.yy, start.yd],
            [start.xd, start.yd, start.dd],
        ]
    )
    before, at = np.array(start[:3]), 0.0
    for k, time in enumerate(times_s):
        f, q = step_of(time - at, model)
        q = q + extra.get(k, 0.0)
        here = slice(3 * k, 3 * k + 3)
        if k:
            cov[here, : 3 * k] = f @ cov[3 * k - 3 : 3 * k, : 3 * k]
            cov[: 3 * k, here] = cov[here, : 3 * k].T
            p0 = cov[3 * k - 3 : 3 * k, 3 * k - 3 : 3 * k]
        cov[here, here] = f @ p0 @ f.T + q
        mean[k] = before = f @ before
        at = time
    x = 3 * np.array(seen)
    inner = cov[np.ix_(x, x)] + model.observation_sigma_s**2 * np.eye(len(x))
    gain = np.linalg.solve(inner, cov[x]).T
    mean = mean + (gain @ (phases - mean[seen, 0])).reshape(n, 3)
    cov = cov - gain @ cov[x]
    return mean, [cov[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] for k in range(n)]


@pytest.mark.parametrize('jump', [0.0, 40.0])
@pytest.mark.parametrize('states', [2, 3])
def test_it_is_the_gaussian_given_all_observations(states, jump):
    model = model_of(states, gate=5.0 if jump else None)
    rng = np.random.default_rng(4)
    stamps = np.cumsum(rng.integers(S // 5, 3 * S, 50))
    phases = np.where(np.arange(50) % 2, 0.0, 0.3) + jump * (np.arange(50) >= 25)
    start = prior(model)._replace(dd=0.04 if states == 3 else 0.0)
    # every second instant is observed, the last few are not
    seen = np.arange(0, 44, 2)
    way = filter_phases(Known(0, start), stamps[seen].tolist(), phases[seen].tolist(), model)
    used = seen[way.fate != REFUSED]
    extra = {}
    if jump:
        assert np.count_nonzero(way.fate == REFUSED) >= 2
        for place in np.flatnonzero(way.opened_s):
            # the offset jumps there, or the rate changes right after the observation used before
            v, tau, since = way.opened_s[place], way.elapsed_s()[place], way.stamp_ns[place]
            extra[used[place]] = np.diag([v * v, 0.0, 0.0])
            first = int(np.searchsorted(stamps, since, 'right'))
            moved = np.array([(stamps[first] - since) / 1e9, 1.0, 0.0])
            grown = (v / tau) ** 2 * np.outer(moved, moved)
            extra[first] = extra.get(first, 0.0) + grown
        assert extra
    smoother = smooth(way, model)
    # where a rate changes, `at` tells the rate after it, the dense solution that before it
    told = np.setdiff1d(np.arange(50), used[np.flatnonzero(way.opened_s) - 1])
    found = smoother.at(stamps[told])
    mean, cov = dense(start, stamps / 1e9, used, phases[used], model, extra)
    # 1e-9 of a size of 1 to 40: rounding times the condition of the dense solution
    np.testing.assert_allclose(np.column_stack(found[:3]), mean[told], rtol=0, atol=1e-8)
    rows, columns = np.triu_indices(3)
    wanted = np.array([cov[k][rows, columns] for k in told])
    np.testing.assert_allclose(np.column_stack(found[3:]), wanted, rtol=1e-8, atol=1e-8)


def test_at_the_end_it_is_the_filter_and_before_it_knows_more():
    model = model_of(2)
    rng = np.random.default_rng(9)
    stamps = (S * np.arange(1, 31)).tolist()
    way = filter_phases(Known(0, prior(model)), stamps, rng.normal(size=30).tolist(), model)
    smoother = smooth(way, model)
    end = smoother.at(np.array([30 * S, 45 * S]))
    assert end.x[0] == way.states.x[-1]
    last = way.after(30).estimate
    assert tuple(column[1] for column in end) == tuple(predict(last, 15.0, model))
    between = smoother.at(np.array(stamps[:-1]))
    assert (between.xx < way.states.xx[1:-1]).all()
    assert (between.yy < way.states.yy[1:-1]).all()


def test_a_rate_that_was_never_assumed_is_found_from_the_start():
    day = 86_400.0
    model = ClockModel(0.5, 10.0 / day, gate=5.0)
    stamps = [round(k * day) * S for k in range(15)]
    way = filter_phases(Known(0, prior(model)), stamps, [-64.0 * k for k in range(15)], model)
    assert way.fate.tolist() == [0, REFUSED, REOPENED, *[0] * 12]
    found = smooth(way, model).at(np.array([round(0.5 * day) * S]))
    # the filter had known no better than 0 until the first day was over
    assert found.x[0] == pytest.approx(-32.0, abs=0.5)
    assert found.y[0] * day == pytest.approx(-64.0, abs=0.1)


def test_without_observations_it_is_the_prior():
    model = model_of(3)
    way = filter_phases(Known(0, prior(model)), [], [], model)
    found = smooth(way, model).at(np.array([0, 5 * S]))
    assert tuple(column[1] for column in found) == tuple(predict(prior(model), 5.0, model))


@pytest.mark.parametrize('states', [2, 3])
def test_its_errors_are_as_large_as_it_says(states):
    model, runs, n = model_of(states), 150, 20
    rng = np.random.default_rng(11)
    f, q = step_of(1.0, model)
    start = prior(model)._replace(dd=0.04 if states == 3 else 0.0)
    root_p = np.sqrt([start.xx, start.yy, start.dd])
    root_q = np.zeros((3, 3))
    root_q[:states, :states] = np.linalg.cholesky(q[:states, :states])
    stamps, middle = (S * np.arange(1, n + 1)).tolist(), 9
    total = 0.0
    for _ in range(runs):
        truth = np.zeros((n + 1, 3))
        truth[0] = root_p * rng.normal(size=3)
        for k in range(n):
            truth[k + 1] = f @ truth[k] + root_q @ rng.normal(size=3)
        phases = truth[1:, 0] + rng.normal(0.0, 0.5, n)
        way = filter_phases(Known(0, start), stamps, phases.tolist(), model)
        found = smooth(way, model).at(np.array([stamps[middle]]))
        xx, xy, xd, yy, yd, dd = (column[0] for column in found[3:])
        cov = np.array([[xx, xy, xd], [xy, yy, yd], [xd, yd, dd]])[:states, :states]
        miss = (truth[middle + 1] - np.array([column[0] for column in found[:3]]))[:states]
        total += miss @ np.linalg.solve(cov, miss)
    # two-sided at 1e-4: a seeded ensemble, so it passes always or never
    low, high = chi2.ppf(np.array([5e-5, 1 - 5e-5]), runs * states)
    assert low < total < high


def regression(times, sigma, prior_x, prior_y, at):
    """Variances of offset and rate of a clock with a constant rate, in exact fractions.

    The information of n observations of x + y t about x and y, with that of the prior.
    """
    weight = 1 / Fraction(sigma) ** 2
    xx = weight * len(times) + 1 / Fraction(prior_x) ** 2
    xy = weight * sum(map(Fraction, times))
    yy = weight * sum(Fraction(t) ** 2 for t in times) + 1 / Fraction(prior_y) ** 2
    free = xx * yy - xy * xy
    return float((yy - 2 * at * xy + at * at * xx) / free), float(xx / free)


@pytest.mark.parametrize(('sigma', 'rate_sigma'), [(0.5, 1000.0), (0.01, 1000.0), (0.5, 86400.0)])
def test_the_first_days_are_known_as_well_as_the_last_ones(sigma, rate_sigma):
    """A rate that is known a million times better in hindsight, against exact fractions.

    C is known to `RIDGE`, 2e-16, times the condition of P⁻ for the second observation, a day after
    the first: about (rate_sigma/sigma)². The variance of the rate, found over 80 days, takes that
    80 times.
    """
    day, n = 86_400, 81
    model = ClockModel(sigma, rate_sigma / day, white_fm_s=0.0, random_walk_fm_per_s=0.0)
    stamps = [k * day * S for k in range(n)]
    phases = np.random.default_rng(3).normal(0.0, sigma, n)
    way = filter_phases(Known(0, prior(model)), stamps, phases.tolist(), model)
    instants = [0, 1, 30_000, 86_399, 86_400, 40 * day + 1, 80 * day]
    found = smooth(way, model).at(S * np.array(instants))
    days = [k * day for k in range(n)]
    wanted = [regression(days, sigma, 10.0 * sigma, model.prior_rate_sigma, t) for t in instants]
    near = 160.0 * 2.5e-16 * (rate_sigma / sigma) ** 2
    np.testing.assert_allclose(found.xx, [xx for xx, _ in wanted], rtol=near)
    np.testing.assert_allclose(found.yy, [yy for _, yy in wanted], rtol=near)


@pytest.mark.parametrize('states', [2, 3])
def test_no_variance_is_negative_at_the_ends_of_the_ranges(states):
    day = 86_400
    for sigma, rate_sigma in ((1e-9, 86_400.0), (86_400.0, 1e-9)):
        model = ClockModel(sigma, rate_sigma / day, states)
        stamps = [k * day * S for k in range(20)]
        way = filter_phases(Known(0, prior(model)), stamps, [0.0] * 20, model)
        found = smooth(way, model).at(S * np.arange(0, 20 * day, 5000))
        for variance in (found.xx, found.yy, found.dd):
            assert (variance >= 0.0).all()
        assert np.isfinite(found.x).all()
