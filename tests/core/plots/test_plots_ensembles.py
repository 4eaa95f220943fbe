"""Tracks on a map, coloured by the error, against the rows and the log."""

import numpy as np
from matplotlib.collections import LineCollection

from tauto_core.ensembles.trials import Trial, TriedClock, answers_of
from tauto_core.plots.ensembles import trial_figure
from tauto_core.ship.logbook import LoggedPassage


def passage(name, longitudes):
    entries = tuple(
        (f'1770-01-{day:02}T12:00', 10.0, longitude, 90.0, 5.0, None)
        for day, longitude in enumerate(longitudes, 1)
    )
    return LoggedPassage(name, 'log.csv', entries=entries)


def row(name, errors, failure=None):
    end = None if failure else errors[-1]
    ends = dict.fromkeys(('raw_error_nmi', 'error_nmi', 'sensed_error_nmi'), end)
    row = {'clock': 'made', 'passage': name, 'noon_error_nmi': errors, **ends}
    return {**row, 'stopped_s': None, 'failure': failure}


def test_each_leg_has_the_colour_of_the_error_at_its_end():
    """A track does not jump at the dateline, and ends when the clock fails."""
    passages = (
        passage('17700101-1', [170.0, 175.0, -180.0, -175.0]),
        passage('17700101-2', [-30.0, -31.0, -32.0]),
    )
    one = row('17700101-1', [0.0, 2.0, -20.0, 5000.0])
    rows = [one, row('17700101-2', [0.0, 40.0], 'it failed')]
    clocks = (TriedClock('made.yaml', 'made', {'ship': {}}),)
    trial = Trial('log.csv', clocks, 0, 14.0, passages=passages)
    chart, errors, *_ = trial_figure(trial, rows, answers_of(trial, rows)).axes
    [tracks] = [each for each in chart.collections if isinstance(each, LineCollection)]
    legs = np.array(tracks.get_segments())
    assert len(legs) == 4
    assert np.allclose(np.abs(np.diff(legs[:, :, 0], axis=1)).ravel(), [5.0, 5.0, 5.0, 1.0])
    assert np.allclose(tracks.get_array(), [2.0, 20.0, 3000.0, 40.0])
    tracks.update_scalarmappable()  # as when it is drawn
    assert np.allclose(tracks.get_color(), tracks.to_rgba([2.0, 20.0, 3000.0, 40.0]))
    assert len(np.unique(tracks.get_color(), axis=0)) == 4
    # one of two passages has arrived, with an error above 60 nmi
    for line in errors.get_lines()[:2]:
        assert np.asarray(line.get_ydata())[-1] == 100.0
        assert np.count_nonzero(np.asarray(line.get_xdata()) <= 60.0) == 1
