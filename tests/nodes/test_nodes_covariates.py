"""The drift estimator on real nodes where the scene's rate follows the ship's motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from conftest import Bench, overrides

from tauto_core.bags import read_bag
from tauto_core.navigation import estimate_names
from tauto_core.samples import CORRECTED, ESTIMATE, SHIP_IMU, JointSamples
from tauto_core.scene import load_scene, scene_yaml
from tauto_core.voyage import sail
from tauto_nodes.drift_estimator import DriftEstimator
from tauto_nodes.longitude import Longitude
from tauto_nodes.recorder import Recorder
from tauto_nodes.ship_motion import ShipMotion
from tauto_nodes.trochlea import Trochlea

DRIFT = {
    'observation_interval': 20.0,
    'observation_sigma': 0.5,
    'covariates': ['heave', 'roll'],
    'coefficients': {
        'heave': {'value': 1.0, 'sigma': 0.05},
        'roll': {'value': 0.01, 'sigma': 0.02},
    },
}


def test_the_graph_says_what_the_offline_run_says(bench: Bench, tmp_path: Path) -> None:
    scene = load_scene('involute_weight_at_sea', duration=60.0, drift=DRIFT)
    file = tmp_path / 'scene.yaml'
    file.write_text(scene_yaml(scene), encoding='utf-8')
    common: dict[str, Any] = {'flow_control': 'credits', 'scene': str(file)}
    estimator = DriftEstimator(**overrides(**common))
    recorder = Recorder(**overrides(output=str(tmp_path / 'graph'), **common))
    ship = ShipMotion(**overrides(speed=0.0, **common))
    bench.add(recorder, Longitude(**overrides(**common)), estimator)
    bench.add(Trochlea(**overrides(**common)), ship)
    assert SHIP_IMU in estimator.inputs
    bench.until(lambda: recorder.over)
    assert estimator.inputs[SHIP_IMU].taken == scene.samples + scene.samples_beyond_end
    sail(scene, tmp_path / 'alone')
    graph, alone = read_bag(tmp_path / 'graph'), read_bag(tmp_path / 'alone')
    for topic in (ESTIMATE, CORRECTED, 'longitude/error'):
        assert graph.payloads(topic)[1] == alone.payloads(topic)[1]
    estimate = graph.samples(ESTIMATE)
    assert isinstance(estimate, JointSamples)
    assert estimate.name == estimate_names(('heave', 'roll'))
    grown = estimate.position[:, estimate.name.index('roll_integral_s')]
    assert np.all(np.diff(grown) > 0.0)


def test_without_covariates_the_motion_is_not_subscribed_to(bench: Bench) -> None:
    estimator = bench.add(DriftEstimator(**overrides(scene='involute_weight_at_sea')))
    assert SHIP_IMU not in estimator.inputs
    topic = estimator.resolve_topic_name(SHIP_IMU)
    assert estimator.get_subscriptions_info_by_topic(topic) == []
