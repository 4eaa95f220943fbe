"""The assumptions of the navigator about the clock and the observations before the voyage."""

from __future__ import annotations

from dataclasses import replace

from tauto_core.navigation.kalman import (
    LUNAR_SIGMA_S,
    RANDOM_WALK_FM_FLOOR_PER_S,
    WHITE_FM_FLOOR_S,
    ClockModel,
)
from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.scene import Scene
from tauto_core.scene.sections import walk_per_s, white_s

PATIENCE = 3.0
"""Number of observation intervals for which the filter rejects outliers."""


def clock_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with covariates.

    The coefficients are those of the scene or, where it gives none, those from trial runs of its
    machine (`coefficient_runs`).
    """
    model = dial_model(scene)
    if not scene.drift.covariates:
        return model
    from tauto_core.navigation.coefficient_runs import coefficients

    return replace(model, coefficients=coefficients(scene))


def expected_walk_per_s(scene: Scene) -> float:
    """Return the density of the random walk of the rate that the navigator expects [1/s].

    The dial's own, which is simulated, or what the scene's `drift` says, whichever is larger.
    """
    return max(scene.clock.random_walk_fm_per_s, walk_per_s(scene.drift.random_walk_fm or 0.0))


def dial_model(scene: Scene) -> ClockModel:
    """Return the clock model of the scene's `drift`, with at least the noise of a good clock.

    Outliers are refused for three observation intervals. After that, as at a landfall, a change of
    the clock is more likely than an error of the observer.
    """
    drift, clock = scene.drift, scene.clock
    return ClockModel(
        observation_sigma_s=drift.observation_sigma,
        prior_rate_sigma=drift.prior_rate_sigma / SECONDS_PER_DAY,
        states=drift.states,
        white_fm_s=max(WHITE_FM_FLOOR_S, clock.white_fm_s, white_s(drift.white_fm or 0.0)),
        random_walk_fm_per_s=max(RANDOM_WALK_FM_FLOOR_PER_S, expected_walk_per_s(scene)),
        gate=drift.gate,
        patience_s=PATIENCE * drift.observation_interval,
        lunar_sigma_s=LUNAR_SIGMA_S if drift.lunars is None else drift.lunars.sigma,
    )
