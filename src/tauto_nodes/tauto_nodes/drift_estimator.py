"""The drift of the clock as the navigator estimates it from his observations."""

from __future__ import annotations

from typing import Any

from tauto_core.navigation import DriftStage
from tauto_core.samples import Stage
from tauto_nodes.parameters import Settings
from tauto_nodes.running import main_of
from tauto_nodes.stage_node import StageNode, scene_of


def _build(settings: Settings) -> Stage:
    return DriftStage(scene_of(settings), expect_schedule=settings.text('source') == 'scene')


class DriftEstimator(StageNode):
    """clock/reading, clock/observation in, with covariates ship/imu; estimate, correction out."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('drift_estimator', _build, **node_options)


main = main_of(DriftEstimator)

if __name__ == '__main__':
    main()
