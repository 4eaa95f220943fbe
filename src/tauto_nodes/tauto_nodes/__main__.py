"""One node in a process: `python -m tauto_nodes NODE --ros-args …`, as `tauto graph` starts it.

`ros2 run tauto_nodes NODE` calls the same functions (setup.py).
"""

from __future__ import annotations

import sys
from importlib import import_module

_MODULES = {
    'ship_motion': 'simulation.ship',
    'player': 'live.player',
    'trochlea': 'live.stages',
    'drift_estimator': 'live.stages',
    'longitude': 'live.stages',
    'recorder': 'live.recorder',
    'markers': 'live.markers',
}


def main() -> None:
    """Run the node that the first argument names; `compose`: all nodes of the graph."""
    name = sys.argv.pop(1) if len(sys.argv) > 1 else ''
    if name == 'compose':
        from tauto_nodes.live import main_of
        from tauto_nodes.live.recorder import RecorderNode
        from tauto_nodes.live.stages import DriftEstimatorNode, LongitudeNode, TrochleaNode
        from tauto_nodes.simulation.ship import ShipMotionNode

        main_of(RecorderNode, LongitudeNode, DriftEstimatorNode, TrochleaNode, ShipMotionNode)()
    elif name in _MODULES:
        getattr(import_module(f'tauto_nodes.{_MODULES[name]}'), name)()
    else:
        sys.exit(f'node {name!r}: must be compose or one of {", ".join(_MODULES)}')


main()
