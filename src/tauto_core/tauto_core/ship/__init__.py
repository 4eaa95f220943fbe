"""The ship: sea, roll, recorded motion, what an IMU at the clock reads, observations of time."""

from tauto_core.scene.times import LOOKAHEAD
from tauto_core.ship.imu import FRAME_ID, REFUSALS, Attitude, attitude, imu_samples, screen
from tauto_core.ship.observations import Observations, schedule
from tauto_core.ship.passage import Passage
from tauto_core.ship.sea import bag_metadata
from tauto_core.ship.source import ShipMotion
from tauto_core.ship.waves import Harmonics

__all__ = [
    'FRAME_ID',
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
