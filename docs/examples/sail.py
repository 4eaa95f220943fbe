"""Load a scene, sail it, and read what came of it."""

import tauto_core as tauto

scene = tauto.load('measured')
print(f'{scene.name}: {scene.duration:g} s on a ship that is {scene.ship.kind}')

voyage = tauto.sail(scene)
print(voyage.answer)
print(f'clock error at the end: {voyage.clock_error_s[-1]:+.4f} s')
print(f'largest roll: {abs(voyage.roll_rad).max():.4f} rad')
