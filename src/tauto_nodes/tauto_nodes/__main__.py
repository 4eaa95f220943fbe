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
    """Run the node that the first argument names."""
    name = sys.argv.pop(1) if len(sys.argv) > 1 else ''
    if name in _MODULES:
        getattr(import_module(f'tauto_nodes.{_MODULES[name]}'), name)()
    else:
        sys.exit(f'node {name!r}: must be one of {", ".join(_MODULES)}')


main()
