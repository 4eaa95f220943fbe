"""Draw a picture of a voyage, then a plot made by hand: the clock's error over the roll."""

import matplotlib.pyplot as plt

import tauto_core as tauto

voyage = tauto.sail('involute_weight_at_sea', duration=600.0)
voyage.plot('error', 'error.png')
tauto.plot(voyage, 'machine', 'machine.svg')

figure, (above, below) = plt.subplots(2, sharex=True)
above.plot(voyage.time_s, voyage.clock_error_s)
above.set_ylabel('clock error, s')
below.plot(voyage.time_s, voyage.roll_rad)
below.set_ylabel('roll, rad')
below.set_xlabel('time, s')
figure.savefig('own.png')
