"""Change one thing, sail again, and compare: what does the sea cost a weight?"""

import tauto_core as tauto

at_sea = 'involute_weight_at_sea'
heights = {}
for metres in (0.5, 1.5, 2.5):
    voyage = tauto.sail(at_sea, duration=600.0, ship__sea__significant_wave_height=metres)
    heights[metres] = voyage.clock_error_s[-1]

for metres, error_s in heights.items():
    print(f'waves of {metres} m: {error_s:+.4f} s in ten minutes')
