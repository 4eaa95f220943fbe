"""The cost of weather compared with one sea: processor time per sample of ship/imu, same ship.

    python -m benchmarks.weather [--samples N]

A calm, a steady sea and a change from one sea into another are sampled in turn with the sea alone,
and the least time of each counts.
"""

from __future__ import annotations

import argparse
import time

from tauto_core.scene import Scene, load_scene
from tauto_core.ship import ShipMotion

ROUNDS = 7
HIGH = {'significant_wave_height': 2.5, 'peak_period': 9.0}
LOW = {'significant_wave_height': 1.5, 'peak_period': 7.0}
SHIP = {
    'kind': 'sea',
    'roll': {'natural_period': 11.0, 'damping_ratio': 0.08, 'slope_coefficient': 0.7},
    'heave': True,
    'height': 3.0,
    'rate': 10.0,
}


def scene_of(samples: int, *states: dict[str, object]) -> Scene:
    """Return a ship in the states at both ends of a scene, or in one sea where there are none."""
    duration = 60.0 * (samples // 600)
    sea: dict[str, object] = {'sea': {'spectrum': 'bretschneider', **HIGH}}
    if states:
        listed = [{'at': duration * k, **state} for k, state in enumerate(states)]
        sea = {'weather': {'kind': 'states', 'states': listed}}
    return load_scene('ideal', ship={**SHIP, **sea}, duration=duration)


def nanoseconds_a_sample(scene: Scene) -> float:
    """Return the processor time of a scene per sample, without set-up."""
    motion = ShipMotion(scene)
    motion.produce(1)
    began, samples = time.process_time_ns(), motion.total
    while len(motion.produce(65_536).stamp_ns):
        pass
    return (time.process_time_ns() - began) / samples


def main() -> None:
    """Print a row for each kind of weather."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--samples', type=int, default=600_000, help='of each scene')
    samples = parser.parse_args().samples
    still: dict[str, object] = {'still': True}
    scenes = {
        'one sea': scene_of(samples),
        'steady weather': scene_of(samples, HIGH, HIGH),
        'a change of seas': scene_of(samples, HIGH, LOW),
        'a sea that comes': scene_of(samples, still, HIGH),
        'a calm': scene_of(samples, still, still, HIGH),
    }
    # the calm lasts to the end of the scene, and the sea comes after it
    least = dict.fromkeys(scenes, float('inf'))
    for _ in range(ROUNDS):
        for name, scene in scenes.items():
            least[name] = min(least[name], nanoseconds_a_sample(scene))
    for name, cost in least.items():
        print(f'{name:18} {cost:7.1f} ns a sample  {cost / least["one sea"]:5.2f}')


if __name__ == '__main__':
    main()
