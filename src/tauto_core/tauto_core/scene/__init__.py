"""Scenes: their sections, reading and writing, and the built-in scenes.

Names are imported at their first use, since errors, which all modules import, need no pydantic.
"""

from typing import TYPE_CHECKING

from tauto_core.first_use import loaded_from
from tauto_core.scene.errors import SceneError, TautoError

if TYPE_CHECKING:
    from tauto_core.scene.loader import (
        Scene,
        load_scene,
        parse_scene,
        scene_yaml,
        shipped_scenes,
    )

__all__ = [
    'Scene',
    'SceneError',
    'TautoError',
    'load_scene',
    'parse_scene',
    'scene_yaml',
    'shipped_scenes',
]

__getattr__ = loaded_from(__name__, dict.fromkeys(__all__, 'loader'))
