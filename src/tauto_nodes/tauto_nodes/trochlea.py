"""The trochlea on the moving ship, and the dial it drives."""

from __future__ import annotations

from typing import Any

from tauto_core.clockwork import LiveTrochlea, TrochleaStage
from tauto_core.samples import Stage
from tauto_core.voyage import compile_kernels
from tauto_nodes.parameters import Settings
from tauto_nodes.running import main_of
from tauto_nodes.stage_node import StageNode, scene_of


def _build(settings: Settings) -> Stage:
    scene = scene_of(settings)
    # Before there is a subscription: what compiles meanwhile would let its queue overflow.
    compile_kernels(scene)
    return LiveTrochlea(scene) if settings.text('source') == 'foreign' else TrochleaStage(scene)


class Trochlea(StageNode):
    """ship/imu in; trochlea/joint_states, trochlea/phase and clock/reading out."""

    def __init__(self, **node_options: Any) -> None:
        super().__init__('trochlea', _build, **node_options)


main = main_of(Trochlea)

if __name__ == '__main__':
    main()
