"""Where the clock puts the ship."""

from __future__ import annotations

from typing import Any

from tauto_core.navigation import LongitudeStage
from tauto_core.samples import Stage
from tauto_nodes.parameters import Settings
from tauto_nodes.running import main_of
from tauto_nodes.stage_node import StageNode, scene_of


def _build(settings: Settings) -> Stage:
    return LongitudeStage(scene_of(settings), expect_fix=settings.text('source') == 'scene')


class Longitude(StageNode):
    """ship/fix, clock/reading, clock/corrected, drift/estimate in; longitude/… out."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('longitude', _build, **node_options)


main = main_of(Longitude)

if __name__ == '__main__':
    main()
