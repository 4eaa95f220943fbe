"""The filter against textbook matrices, least squares, and its own covariance over an ensemble."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.stats import chi2

from tauto_core.navigation import (
    ClockModel,
    Estimate,
    Known,
    filter_phases,
    predict,
    prior,
    update,
)
from tauto_core.scene.errors import EstimationError

DAY = 86_400.0


def covariance(estimate):
    xx, xy, xd, yy, yd, dd = estimate[3:]
    return np.array([[xx, xy, xd], [xy, yy, yd], [xd, yd, dd]])


def run(start, times, phases, model):
    """States after each observation, by the filter; times from the start in whole nanoseconds."""
    return filter_phases(Known(0, start), times, phases, model).states


def whole_ns(times):
    return np.rint(np.asarray(times) * 1e9).astype(np.int64).tolist()


def van_loan(tau, model):
    """Transition and process noise from one matrix exponential (Van Loan 1978)."""
    a = np.diag([1.0, 1.0], 1)
    w = np.diag([model.white_fm_s, model.random_walk_fm_per_s, model.random_run_per_s3])
    big = np.zeros((6, 6))
    big[:3, :3], big[:3, 3:], big[3:, 3:] = -a, w, a.T
    blocks = expm(big * tau)
    f = blocks[3:, 3:].T
    return f, f @ blocks[:3, 3:]


def dense_filter(start, elapsed, phases, model):
    x, p = np.array(start[:3]), covariance(start)
    h = np.array([[1.0, 0.0, 0.0]])
    for tau, z in zip(elapsed, phases, strict=True):
        f, q = van_loan(tau, model)
        x, p = f @ x, f @ p @ f.T + q
        s = h @ p @ h.T + model.observation_sigma_s**2
        gain = p @ h.T / s
        x = x + (gain * (z - h @ x)).ravel()
        p = (np.eye(3) - gain @ h) @ p
    return x, p


@pytest.mark.parametrize('states', [2, 3])
def test_filter_is_the_textbook_filter(states):
    # In units of order one, so that rounding of the short covariance form stays near 1e-13
    model = ClockModel(0.5, 0.3, states, 0.01, 0.02, 0.003 if states == 3 else 0.0)
    rng = np.random.default_rng(1)
    times, phases = whole_ns(np.cumsum(rng.uniform(0.2, 3.0, 40))), rng.normal(size=40)
    # AGEING_TIME_S is long against these times: give the prior an ageing that matters
    start = prior(model)._replace(dd=0.04 if states == 3 else 0.0)
    known = run(start, times, phases, model)
    last = Estimate(*(values[-1] for values in known))
    x, p = dense_filter(start, np.diff(times, prepend=0) / 1e9, phases, model)
    np.testing.assert_allclose(last[:3], x, rtol=0, atol=1e-11)
    np.testing.assert_allclose(covariance(last), p, rtol=0, atol=1e-11)


@pytest.mark.parametrize('states', [2, 3])
def test_without_noise_it_is_weighted_least_squares(states):
    model = ClockModel(0.5, 10.0 / DAY, states, 0.0, 0.0)
    rng = np.random.default_rng(2)
    stamps = whole_ns(np.cumsum(rng.uniform(0.5, 1.5, 15)) * DAY)
    times = np.array(stamps) / 1e9
    phases = 3.0 + times * 4.0 / DAY + rng.normal(0.0, 0.5, 15)
    start = prior(model)
    known = run(start, stamps, phases, model)
    # The state at the start, with its prior as further observations, in days
    scale = np.array([1.0, 1.0 / DAY, 1.0 / DAY**2])[:states]
    design = np.column_stack([np.ones(15), times / DAY, 0.5 * (times / DAY) ** 2])[:, :states]
    sigmas = np.sqrt([start.xx, start.yy, start.dd])[:states] / scale
    rows = np.vstack((design / 0.5, np.diag(1.0 / sigmas)))
    solution = np.linalg.lstsq(rows, np.append(phases / 0.5, np.zeros(states)), rcond=None)[0]
    spread = np.linalg.inv(rows.T @ rows)
    end = times[-1] / DAY
    move = np.array([[1.0, end, end**2 / 2], [0.0, 1.0, end], [0.0, 0.0, 1.0]])[:states, :states]
    last = Estimate(*(values[-1] for values in known))
    units = np.outer(scale, scale)
    # 1e-9: condition of the normal equations (about 1e5) times rounding
    np.testing.assert_allclose(last[:states], move @ solution * scale, rtol=1e-9)
    np.testing.assert_allclose(
        covariance(last)[:states, :states], move @ spread @ move.T * units, rtol=1e-9
    )


def test_two_days_by_hand():
    # Prior N(0, 1), observation z = 3 with R = 1 at once: half way, half the variance
    model = ClockModel(1.0, 1.0 / DAY, 2, 0.0, 0.0)
    half = update(prior(model)._replace(xx=1.0), 3.0, 1.0)
    assert half[:2] == (1.5, 0.0)
    assert half.xx == 0.5
    # a day later the rate's variance has come on top
    later = predict(half, DAY, model)
    assert later.xx == pytest.approx(0.5 + 1.0, rel=1e-15)
    assert later.xy == pytest.approx(1.0 / DAY, rel=1e-15)


@pytest.mark.parametrize('states', [2, 3])
def test_errors_and_innovations_are_as_large_as_the_filter_says(states):
    model = ClockModel(0.5, 10.0 / DAY, states, 1e-7, 1e-17, 1e-29 if states == 3 else 0.0)
    runs, n = 200, 30
    rng = np.random.default_rng(3)
    f, q = van_loan(DAY, model)
    start = prior(model)
    root_p = np.sqrt(np.diag(covariance(start)))
    scale = np.diag([1.0, DAY, DAY**2])
    root_q = np.linalg.inv(scale) @ np.linalg.cholesky(scale @ q @ scale + 1e-30 * np.eye(3))
    if states == 2:
        root_q[2] = 0.0
    nees = nis = 0.0
    for _ in range(runs):
        truth, now = root_p * rng.normal(size=3), start
        for _ in range(n):
            truth = f @ truth + root_q @ rng.normal(size=3)
            z = truth[0] + rng.normal(0.0, 0.5)
            ahead = predict(now, DAY, model)
            nis += (z - ahead.x) ** 2 / (ahead.xx + 0.25)
            now = update(ahead, z, 0.25)
        miss = (truth - np.array(now[:3]))[:states]
        nees += miss @ np.linalg.solve(covariance(now)[:states, :states], miss)
    # Two-sided at 1e-4: a seeded ensemble, so it passes always or never
    for total, freedom in ((nees, runs * states), (nis, runs * n)):
        low, high = chi2.ppf(np.array([5e-5, 1 - 5e-5]), freedom)
        assert low < total < high


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(0.0, 1e7), st.floats(-1e4, 1e4)),
        min_size=1,
        max_size=30,
    ),
    st.sampled_from([2, 3]),
    st.floats(1e-6, 10.0),
)
def test_covariance_stays_positive(steps, states, sigma):
    model = ClockModel(sigma, 10.0 / DAY, states)
    elapsed, phases = zip(*steps, strict=True)
    known = run(prior(model), whole_ns(np.cumsum(elapsed)), phases, model)
    assert (known.xx > 0).all()
    assert (known.yy > 0).all()
    assert (known.xy**2 <= known.xx * known.yy * (1 + 1e-9)).all()


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.0, 1e8), min_size=1, max_size=40), st.sampled_from([2, 3]))
def test_prediction_of_arrays_is_that_of_floats_bit_for_bit(elapsed, states):
    model = ClockModel(0.5, 10.0 / DAY, states)
    now = update(predict(prior(model), 1234.5, model), 7.0, 0.25)
    many = predict(Estimate(*(np.full(len(elapsed), v) for v in now)), np.array(elapsed), model)
    for index, tau in enumerate(elapsed):
        assert tuple(values[index] for values in many) == tuple(predict(now, tau, model))


@pytest.mark.parametrize(
    ('arguments', 'name'),
    [
        ((0.0, 1.0), 'observation_sigma_s'),
        ((float('nan'), 1.0), 'observation_sigma_s'),
        ((1.0, -1.0), 'prior_rate_sigma'),
        ((1.0, 1.0, 4), 'states'),
        ((1.0, 1.0, 2, -1e-9), 'white_fm_s'),
        ((1.0, 1.0, 3, 0.0, float('inf')), 'random_walk_fm_per_s'),
        ((1.0, 1.0, 2, 0.0, 0.0, 1.0), 'random_run_per_s3'),
        ((1.0, 1.0, 2, 0.0, 0.0, 0.0, -5.0), 'gate'),
        ((1.0, 1.0, 2, 0.0, 0.0, 0.0, float('nan')), 'gate'),
        ((1.0, 1.0, 2, 0.0, 0.0, 0.0, 5.0, 0.0), 'patience_s'),
    ],
)
def test_impossible_models_are_refused_by_name(arguments, name):
    with pytest.raises(EstimationError, match=name):
        ClockModel(*arguments)
