"""Sully and Euler's sea clock on a rolling ship: how far wrong would it put the ship?

    import tauto_core as tauto

    voyage = tauto.sail('measured', duration=300.0)
    print(voyage.answer)
    voyage.plot('error', 'error.png')

`load` reads a scene, `new_scene` writes one to start from, `check` checks one without sailing it.
`sail` sails a scene, `replay` reads a bag, `budget` breaks a clock's rate down into its causes.
`cam` returns a curve, and writes it as a drawing or a plate; `isochronism` gives its periods.
`design` completes the design of a wheel, `axle` computes the motion of a body on an axle, `hull`
the motion of a ship in waves, `altitudes` a latitude. `logbook` lists passages, `claims` checks
Euler's papers. `compare` sails several clocks in one sea, `fleet` many ships on one voyage,
`trial` clocks along the passages of a log-book. `plot` and `report` draw. Notebooks show results
with their pictures. `check_bag` and `recover_bag` are for damaged bags. Errors derive from
`TautoError`. Other modules may change in any version.
"""

from typing import TYPE_CHECKING, Any

from tauto_core.api import (
    altitudes,
    axle,
    budget,
    cam,
    check,
    check_bag,
    claims,
    compare,
    design,
    fleet,
    hull,
    isochronism,
    load,
    logbook,
    new_scene,
    plot,
    recover_bag,
    replay,
    report,
    sail,
    scenes,
    trial,
)
from tauto_core.first_use import loaded_from
from tauto_core.scene.errors import TautoError

if TYPE_CHECKING:
    from tauto_core.voyage import Voyage

    __version__: str

__all__ = [
    'TautoError',
    'Voyage',
    '__version__',
    'altitudes',
    'axle',
    'budget',
    'cam',
    'check',
    'check_bag',
    'claims',
    'compare',
    'design',
    'fleet',
    'hull',
    'isochronism',
    'load',
    'logbook',
    'new_scene',
    'plot',
    'recover_bag',
    'replay',
    'report',
    'sail',
    'scenes',
    'trial',
]

_at_first_use = loaded_from(__name__, {'Voyage': 'voyage'})


def __getattr__(name: str) -> Any:
    """Return the version, or the class of voyages, which needs NumPy."""
    if name == '__version__':
        from tauto_core.version import version

        return version()
    return _at_first_use(name)


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__
