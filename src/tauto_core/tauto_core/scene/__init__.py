"""Scenes: their sections, reading and writing, and the built-in scenes.

Names are imported at their first use, since errors, which all modules import, need no pydantic.
The model of each kind has its name here, too (`tauto_core.scene.InvoluteCam`).
"""

from typing import TYPE_CHECKING, Any

from tauto_core.first_use import loaded_from
from tauto_core.scene.errors import SceneError, TautoError

if TYPE_CHECKING:
    from tauto_core.machines.drags import Drag
    from tauto_core.machines.parts import Rest
    from tauto_core.machines.sections import FluidTautochroneRegulator, Trochlea
    from tauto_core.scene.loader import (
        DEFAULT_SCENE,
        Scene,
        load_scene,
        parse_scene,
        scene_yaml,
        shipped_scenes,
    )
    from tauto_core.scene.sections import Clock, DriftSettings, Itinerary, Log, Solver, Waypoint
    from tauto_core.scene.tables import data_path
    from tauto_core.ship.motions import Component
    from tauto_core.ship.motions.recorded import Recorded
    from tauto_core.ship.sections import Rao, Roll, Sea, SpectrumTable
    from tauto_core.ship.suspensions import AxleSuspension

__all__ = [
    'DEFAULT_SCENE',
    'AxleSuspension',
    'Clock',
    'Component',
    'Drag',
    'DriftSettings',
    'FluidTautochroneRegulator',
    'Itinerary',
    'Log',
    'Rao',
    'Recorded',
    'Rest',
    'Roll',
    'Scene',
    'SceneError',
    'Sea',
    'Solver',
    'SpectrumTable',
    'TautoError',
    'Trochlea',
    'Waypoint',
    'data_path',
    'load_scene',
    'parse_scene',
    'scene_yaml',
    'shipped_scenes',
]

_HOMES = {
    'loader': (
        'DEFAULT_SCENE',
        'Scene',
        'load_scene',
        'parse_scene',
        'scene_yaml',
        'shipped_scenes',
    ),
    'sections': ('Clock', 'DriftSettings', 'Itinerary', 'Log', 'Solver', 'Waypoint'),
    'tables': ('data_path',),
    'tauto_core.machines.drags': ('Drag',),
    'tauto_core.machines.parts': ('Rest',),
    'tauto_core.machines.sections': ('FluidTautochroneRegulator', 'Trochlea'),
    'tauto_core.ship.motions': ('Component',),
    'tauto_core.ship.motions.recorded': ('Recorded',),
    'tauto_core.ship.sections': ('Rao', 'Roll', 'Sea', 'SpectrumTable'),
    'tauto_core.ship.suspensions': ('AxleSuspension',),
}
_of_a_section = loaded_from(
    __name__, {name: home for home, names in _HOMES.items() for name in names}
)


def __getattr__(name: str) -> Any:
    """Import and return a section or a kind by its name."""
    if name.endswith(
        ('Air', 'Cam', 'Drag', 'Escapement', 'Power', 'Ship', 'Suspension', 'Thread', 'Weather')
    ):
        from tauto_core.scene.reference import all_kinds

        for model in all_kinds():
            if model.__name__ == name:
                return model
    return _of_a_section(name)
