"""Scenes: what they may contain, how they are read and written, and those that ship.

The names are loaded at their first use: errors, which everything imports, need no pydantic.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tauto_core.scene.errors import SceneError, TautoError

if TYPE_CHECKING:
    from tauto_core.scene.data import data_path
    from tauto_core.scene.loader import (
        DEFAULT_SCENE,
        load_scene,
        parse_scene,
        scene_yaml,
        shipped_scenes,
    )
    from tauto_core.scene.models import Clock, DriftSettings, Log, Scene, Solver
    from tauto_core.scene.regulators import (
        CircularArcCam,
        Drag,
        Escapement,
        FluidTautochroneRegulator,
        ForcePower,
        HangingThread,
        HoleCam,
        HoleThread,
        InvoluteCam,
        LeverCorrectedCam,
        LeverThread,
        Rest,
        SpringCorrectedCam,
        SpringPower,
        TableCam,
        Trochlea,
        VerticalThread,
        WeightCorrectedCam,
        WeightPower,
    )
    from tauto_core.scene.ships import (
        AxleSuspension,
        Component,
        ComponentsShip,
        Rao,
        Recorded,
        RecordedShip,
        Roll,
        Sea,
        SeaShip,
        SpectrumTable,
        StillShip,
    )
    from tauto_core.scene.voyages import Voyage, Waypoint

__all__ = [
    'DEFAULT_SCENE',
    'AxleSuspension',
    'CircularArcCam',
    'Clock',
    'Component',
    'ComponentsShip',
    'Drag',
    'DriftSettings',
    'Escapement',
    'FluidTautochroneRegulator',
    'ForcePower',
    'HangingThread',
    'HoleCam',
    'HoleThread',
    'InvoluteCam',
    'LeverCorrectedCam',
    'LeverThread',
    'Log',
    'Rao',
    'Recorded',
    'RecordedShip',
    'Rest',
    'Roll',
    'Scene',
    'SceneError',
    'Sea',
    'SeaShip',
    'Solver',
    'SpectrumTable',
    'SpringCorrectedCam',
    'SpringPower',
    'StillShip',
    'TableCam',
    'TautoError',
    'Trochlea',
    'VerticalThread',
    'Voyage',
    'Waypoint',
    'WeightCorrectedCam',
    'WeightPower',
    'data_path',
    'load_scene',
    'parse_scene',
    'scene_yaml',
    'shipped_scenes',
]

_HOMES = ('data', 'regulators', 'ships', 'voyages', 'models', 'loader')


def __getattr__(name: str) -> Any:
    """Return a public name from the module that defines it."""
    if name in __all__:
        for home in _HOMES:
            module = import_module(f'{__name__}.{home}')
            if hasattr(module, name):
                globals()[name] = getattr(module, name)
                return globals()[name]
    raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
