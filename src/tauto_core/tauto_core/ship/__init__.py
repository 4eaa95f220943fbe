"""The ship: sea, roll, recorded motion, IMU readings at the clock, observations of time.

Names are loaded at first use: kinds of motion are part of a scene, and a source of samples needs
one.
"""

from typing import TYPE_CHECKING

from tauto_core.first_use import loaded_from

if TYPE_CHECKING:
    from tauto_core.scene.times import LOOKAHEAD
    from tauto_core.ship.imu import REFUSALS, Attitude, attitude, imu_samples, screen
    from tauto_core.ship.passage import Passage
    from tauto_core.ship.source import Observations, ShipMotion, bag_metadata, schedule
    from tauto_core.ship.waves import Harmonics

__all__ = [
    'LOOKAHEAD',
    'REFUSALS',
    'Attitude',
    'Harmonics',
    'Observations',
    'Passage',
    'ShipMotion',
    'attitude',
    'bag_metadata',
    'imu_samples',
    'schedule',
    'screen',
]

__getattr__ = loaded_from(
    __name__,
    {
        'LOOKAHEAD': 'tauto_core.scene.times',
        'REFUSALS': 'imu',
        'Attitude': 'imu',
        'Harmonics': 'waves',
        'Observations': 'source',
        'Passage': 'passage',
        'ShipMotion': 'source',
        'attitude': 'imu',
        'bag_metadata': 'source',
        'imu_samples': 'imu',
        'schedule': 'source',
        'screen': 'imu',
    },
)
