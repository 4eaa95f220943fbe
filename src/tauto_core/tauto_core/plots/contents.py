"""The pictures of a voyage: their contents as charts, and their files.

Matplotlib draws the charts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from pathlib import Path
from statistics import median
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from tauto_core.files import check_plot, write_figure
from tauto_core.machines import FluidPendulum, HangingMachine, OtherRegulator, compile_machine
from tauto_core.machines.compiling import amplitude_of, recoil_energy, swing_energy
from tauto_core.plots.chart import Chart, Colour, Line, Mark, draw
from tauto_core.plots.machine import cam_lines, draw_machine
from tauto_core.results import damage_sentence
from tauto_core.samples import READING, SHIP_IMU, FloatArray, ImuSamples, TimeSamples, take
from tauto_core.scene import Scene
from tauto_core.scene.errors import Argument, EstimationError, UsageError
from tauto_core.scene.times import DAY_S, NS_PER_S
from tauto_core.scene.units import quantity
from tauto_core.ship import Passage
from tauto_core.ship.coast import place_name
from tauto_core.ship.imu import attitude
from tauto_core.ship.motions.sea import SeaShip
from tauto_core.ship.weathers import WeatherState
from tauto_core.voyage import Voyage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# -----------------------------------------------------------------------------
# The ship's motion on a part of a voyage: roll, and heave in metres.

PART_S = 600.0
"""Length of a part [s]. In a picture of weeks waves could not be seen."""
MOST_SAMPLES = 1_000_000
"""Largest number of samples of the motion in a picture: 28 hours at 10 Hz, some 0.3 GB."""
LOWEST_HZ = 0.03
"""Lowest frequency [Hz]. Below it an accelerometer shows drift rather than waves."""
TAPER_S = 30.0
"""Time of the heave's taper at both ends of a record [s]."""


@dataclass(frozen=True)
class Seaway:
    """The motion on a part of a voyage.

    Attributes:
        time_s: time from the first reading, (n,) [s].
        roll_rad: roll, (n,), positive with starboard down.
        vertical_m_s2: acceleration of the clock upwards, less its mean, (n,).
        plumb_rad: angle from the true to the apparent vertical, (n,), positive like the roll.
        note: further information for the reader, or empty.
    """

    time_s: FloatArray
    roll_rad: FloatArray
    vertical_m_s2: FloatArray
    plumb_rad: FloatArray
    note: str = ''

    @cached_property
    def heave_m(self) -> FloatArray:
        """Height of the clock above its mean [m], (n,).

        The acceleration integrated twice: −a/ω² for every frequency from `LOWEST_HZ` up.
        """
        count = len(self.time_s)
        if count < 4:
            return np.zeros(count)
        step_s = float(self.time_s[-1] - self.time_s[0]) / (count - 1)
        frequency = np.fft.rfftfreq(count, step_s)
        ends = np.minimum(np.arange(count), np.arange(count)[::-1]) * step_s
        fade = np.sin(0.5 * np.pi * np.minimum(ends / TAPER_S, 1.0)) ** 2
        spectrum = np.fft.rfft(self.vertical_m_s2 * fade)
        passband = frequency >= LOWEST_HZ
        spectrum[~passband] = 0.0
        spectrum[passband] /= -np.square(2.0 * np.pi * frequency[passband])
        heave: FloatArray = np.fft.irfft(spectrum, count)
        return heave


@dataclass(frozen=True)
class _Window:
    """A part of a voyage, from the first reading. `note` says why it was chosen, if it was."""

    from_s: float
    to_s: float
    note: str = ''


def seaway(voyage: Voyage, from_s: float = 0.0, length_s: float = PART_S) -> Seaway:
    """Return the logged motion from `from_s` for `length_s`, or computed from the scene."""
    if SHIP_IMU in voyage.samples:
        imu = voyage.samples[SHIP_IMU]
        assert isinstance(imu, ImuSamples)
        part = slice(*np.searchsorted(voyage.motion_time_s, (from_s, from_s + length_s)))
        return _felt(take(imu, part), voyage.motion_time_s[part], '')
    ship, step_s = voyage.ship_motion, voyage.scene.step_ns * 1e-9
    begin = min(round(from_s / step_s), max(ship.total - 1, 0))
    ship.restore({'next': begin})
    motion = ship.produce(max(round(length_s / step_s), 1))
    time_s = np.arange(begin, begin + len(motion.stamp_ns), dtype=np.float64) * step_s
    return _felt(motion, time_s, 'computed again from the scene')


def window(voyage: Voyage, from_s: float | None, to_s: float | None) -> _Window:
    """Return the part of a voyage to show: the given one, or the roughest.

    With only one end given it lasts `PART_S`.

    Raises:
        UsageError: the part is not within the voyage, or is too long to draw.
    """
    end_s = float(voyage.time_s[-1])
    if from_s is None:
        if to_s is None:
            return _roughest(voyage, end_s)
        from_s = max(to_s - PART_S, 0.0)
    if to_s is None:
        to_s = min(from_s + PART_S, end_s)
    if not 0.0 <= from_s < to_s <= end_s:
        raise UsageError(
            f'from {from_s:.9g} to {to_s:.9g} s: is not a part of the voyage, which lasts '
            f'{end_s:.9g} s ({end_s / DAY_S:.6g} days). Give a beginning and a later '
            'end within it'
        )
    most_s = MOST_SAMPLES * voyage.scene.step_ns * 1e-9
    if to_s - from_s > most_s:
        raise UsageError(
            f'from {from_s:.9g} to {to_s:.9g} s: has more than {MOST_SAMPLES} samples of the '
            f'motion. Show at most {most_s:.6g} s ({most_s / DAY_S:.4g} days)'
        )
    return _Window(from_s, to_s)


def _roughest(voyage: Voyage, end_s: float) -> _Window:
    """Return the ten minutes of the greatest logged motion, or else about the highest sea.

    The measure is the mean square of the roll and of the vertical acceleration over g.
    """
    if end_s <= PART_S:
        return _Window(0.0, end_s)
    if SHIP_IMU in voyage.samples:
        motion = seaway(voyage, 0.0, end_s + 1.0)
        size = np.square(motion.roll_rad) + np.square(motion.vertical_m_s2 / voyage.scene.g)
        sums = np.concatenate(([0.0], np.cumsum(size)))
        ends = np.searchsorted(motion.time_s, motion.time_s + PART_S, side='right')
        is_full = motion.time_s + PART_S <= motion.time_s[-1]
        mean = (sums[ends] - sums[:-1]) / (ends - np.arange(len(size)))
        from_s = float(motion.time_s[np.argmax(np.where(is_full, mean, -1.0))])
        return _Window(from_s, from_s + PART_S, 'the roughest ten minutes')
    met = weather(voyage.scene)
    if not met:
        return _Window(0.0, PART_S, 'the first ten minutes')
    highest = max(
        met[:1] + tuple(state for state in met if state.at_ns <= end_s * NS_PER_S),
        key=lambda state: state.height,
    )
    from_s = min(max(highest.at_ns / NS_PER_S - 0.5 * PART_S, 0.0), end_s - PART_S)
    return _Window(from_s, from_s + PART_S, 'the ten minutes about the highest sea')


@lru_cache(maxsize=4)
def weather(scene: Scene) -> tuple[WeatherState, ...]:
    """Return the states of the sea during a scene, if it has a weather.

    The first is at the start or before it, the last at the end or after it.
    """
    ship = scene.ship
    if not isinstance(ship, SeaShip) or ship.weather is None:
        return ()
    states = ship.states(scene)
    begun = sum(state.at_ns <= 0 for state in states)
    ended = sum(state.at_ns < scene.duration_ns for state in states)
    return states[max(begun - 1, 0) : ended + 1]


def _felt(imu: ImuSamples, time_s: FloatArray, note: str) -> Seaway:
    ship = attitude(imu)
    upwards = ship.force_y * np.sin(ship.roll) + ship.force_z * np.cos(ship.roll)
    return Seaway(
        time_s,
        ship.roll,
        upwards - (upwards.mean() if len(upwards) else 0.0),
        ship.roll - np.arctan2(ship.force_y, ship.force_z),
        note,
    )


# -----------------------------------------------------------------------------
# The contents of the pictures.

MOST_POINTS = 2000
"""Largest number of points of a line. Longer lines are thinned, but keep every extreme."""
# Number of pieces of a voyage over which the rate is measured.
_PIECES = 25
MOST_CHANGES = 8
"""Largest number of marked changes of the weather. More could not be distinguished."""
SEGMENT_S = 120.0
"""Length of the segments whose spectra are averaged [s]."""
TITLE_LENGTH = 64
"""Characters of a line of a title."""


def check_picture(what: str, file: str | Path | None, *, part: bool = False) -> None:
    """Refuse an unknown picture (`check_what`) or a file (`files.check_plot`)."""
    check_what(what, part=part)
    if file is not None:
        check_plot(Path(file), 'file')


def picture(
    voyage: Voyage,
    what: str,
    file: str | Path | None = None,
    *,
    from_s: float | str | None = None,
    to_s: float | str | None = None,
) -> Figure:
    """Return one of `PICTURES` as a figure, and write it to a file, .svg, .png or .pdf, if given.

    Raises:
        UsageError: the picture is unknown or has no data, or the suffix is another.
        OutputError: the file cannot be written.
    """
    check_picture(what, file, part=from_s is not None or to_s is not None)
    name = '\n'.join([*wrap(damage_sentence(voyage.result), TITLE_LENGTH), voyage.scene.name])
    begin, end = (
        None if at is None else quantity(at, 's', Argument(argument, repr(at), spaced=True))
        for argument, at in (('from_s', from_s), ('to_s', to_s))
    )
    figure = draw(chart(voyage, what, begin, end), name)
    if file is not None:
        write_figure(lambda: figure, Path(file), 'file')
    return figure


def chart(
    voyage: Voyage, what: str, from_s: float | None = None, to_s: float | None = None
) -> Chart:
    """Return one of `PICTURES` of a voyage.

    For `OF_A_PART` it shows a part, in seconds from the first reading, by default the roughest.

    Raises:
        UsageError: the picture is unknown or has no data, or the part cannot be shown.
    """
    check_what(what, part=from_s is not None or to_s is not None)
    if what in OF_A_PART:
        view = window(voyage, from_s, to_s)
        motion = seaway(voyage, view.from_s, view.to_s - view.from_s)
        return _PICTURES[what](voyage, view, motion)
    return _PICTURES[what](voyage)


def check_what(what: str, *, part: bool = False) -> None:
    """Raise UsageError for an unknown picture, or for a part of one of the whole voyage."""
    if what not in PICTURES:
        raise UsageError(f'{what!r}: is not a picture. Choose one of {", ".join(PICTURES)}')
    if part and what not in OF_A_PART:
        raise UsageError(
            f'{what}: shows the whole voyage, not a part. Leave from and to out, or draw '
            f'{" or ".join(OF_A_PART)}'
        )


def thinned(
    x: FloatArray, y: FloatArray, most: int = MOST_POINTS
) -> tuple[FloatArray, FloatArray]:
    """Return a line of at most `most` >= 4 points: the extremes in each interval."""
    if len(x) <= most:
        return x, y
    stretches = most // 2 - 1
    edges = np.linspace(0, len(x), stretches + 1).astype(np.int64)
    places = {0, len(x) - 1}
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        places |= {begin + int(np.argmin(y[begin:end])), begin + int(np.argmax(y[begin:end]))}
    which = np.array(sorted(places))
    return x[which], y[which]


def _line(name: str, x: FloatArray, y: FloatArray, colour: Colour = 'blue') -> Line:
    return Line(name, *thinned(x, y), colour)


def _band(name: str, x: FloatArray, middle: FloatArray, sigma: FloatArray) -> Line:
    at, low = thinned(x, middle - sigma)
    return Line(name, at, low, 'orange', 'band', np.interp(at, x, middle + sigma))


def time_unit(length_s: float) -> tuple[float, str]:
    """Return the unit of the time axis for a length [s], and its name."""
    for size, unit in ((DAY_S, 'days'), (3600.0, 'hours'), (60.0, 'minutes')):
        if length_s >= 2.0 * size:
            return size, unit
    return 1.0, 's'


def _over_time(voyage: Voyage, title: str, y_label: str, lines: Sequence[Line]) -> Chart:
    """Return a chart of lines against time [s], with the voyage's events marked."""
    end_s = float(voyage.time_s[-1])
    unit, name = time_unit(end_s)
    events, note = _marks(voyage, 0.0, end_s)
    marks = [Mark(event.x / unit, event.name) for event in events]
    scaled = [replace(line, x=line.x / unit) for line in lines]
    return Chart(title, f'time [{name}]', y_label, scaled, marks=marks, note=note)


def _marks(voyage: Voyage, from_s: float, to_s: float) -> tuple[list[Mark], str]:
    """Return the events in a part of a voyage, at times from the first reading [s], and a note.

    Departure, landfalls, arrival and the storm are named, changes of the weather are not.
    """
    scene = voyage.scene
    shift_ns = scene.starts_at_ns - voyage.start_ns if READING in voyage.samples else 0
    named: list[tuple[int, str]] = []
    if scene.voyage is not None:
        passage = Passage(scene, scene.voyage)
        named = [(passage.sails_ns, 'sails'), (passage.arrives_ns, 'arrives')]
        named += [(at_ns, 'landfall') for at_ns in passage.landfalls_ns[:-1]]
    met = weather(scene)
    highest = max(met, key=lambda state: state.height, default=None)
    # a storm is twice as high as the median
    if highest and len(met) > 2 and highest.height >= 2.0 * median(state.height for state in met):
        named.append((highest.at_ns, 'storm'))
    else:
        highest = None
    marks = [Mark((at_ns + shift_ns) / NS_PER_S, name) for at_ns, name in sorted(named)]
    changes = [
        Mark((state.at_ns + shift_ns) / NS_PER_S)
        for previous, state in pairwise(met)
        if state is not highest and not state.goes_on(previous)
    ]
    inner = [mark for mark in changes if from_s < mark.x < to_s]
    note = ''
    if len(inner) > MOST_CHANGES:
        note = f'The sea changes {len(inner)} times, see the picture weather.'
    elif inner:
        marks += inner
        note = 'Dotted: the sea has changed.'
    # a departure at the start of a scene is not an event
    return [mark for mark in marks if from_s < mark.x <= to_s], note


def _error(voyage: Voyage) -> Chart:
    time = voyage.time_s
    return _over_time(
        voyage,
        'Error of the clock',
        'reading − true time [s]',
        [
            _band('estimate ± 1σ', time, voyage.estimated_error_s, voyage.estimated_error_sigma_s),
            _line('estimated', time, voyage.estimated_error_s, 'orange'),
            _line('dial', time, voyage.clock_error_s),
            Line('observed', voyage.observation_time_s, voyage.observed_error_s, 'grey', 'points'),
        ],
    )


def _drift(voyage: Voyage) -> Chart:
    time = voyage.time_s
    zero = np.zeros_like(time)
    return _over_time(
        voyage,
        'Error left by the correction',
        'corrected time − true time [s]',
        [
            _band('± 1σ of the navigator', time, zero, voyage.estimated_error_sigma_s),
            _line('corrected clock', time, voyage.corrected_error_s),
        ],
    )


def _rate(voyage: Voyage) -> Chart:
    time, error = voyage.time_s, voyage.clock_error_s
    count = len(time) - 1
    marks, _ = _marks(voyage, 0.0, float(time[-1]))
    # a mean over less than half a piece, such as the minute after arrival, would show the noise
    smallest = max(count // (2 * _PIECES), 1)
    cuts = [0]
    for cut in sorted(np.searchsorted(time, [mark.x for mark in marks]).tolist()):
        if cuts[-1] + smallest <= cut <= count - smallest:
            cuts.append(cut)
    edges = [0]
    for begin, end in pairwise([*cuts, count]):
        pieces = min(max(round(_PIECES * (end - begin) / count), 1), end - begin)
        edges += np.linspace(begin, end, pieces + 1).round().astype(int)[1:].tolist()
    measured = np.diff(error[edges]) / np.diff(time[edges]) * DAY_S
    estimated = voyage.estimated_mean_rate_s_per_day
    sigma = voyage.estimated_mean_rate_sigma_s_per_day
    return _over_time(
        voyage,
        'Rate of the clock',
        'rate [s/day], fast is positive',
        [
            _band('estimate ± 1σ', time, estimated, sigma),
            _line('estimated', time, estimated, 'orange'),
            Line(
                'dial, mean of each step', np.repeat(time[edges], 2)[1:-1], np.repeat(measured, 2)
            ),
        ],
    )


def _temperature(voyage: Voyage) -> Chart:
    celsius = voyage.temperature_celsius
    if not len(celsius):
        raise UsageError(
            f'temperature: {voyage.scene.name} has no air, or the bag no ship/temperature. Write '
            '`air: …` in the scene, or draw error or rate'
        )
    line = _line('', voyage.time_s, celsius)
    return _over_time(voyage, "Temperature in the clock's box", 'temperature [°C]', [line])


def _longitude(voyage: Voyage) -> Chart:
    time = voyage.time_s
    error = voyage.longitude_error_nmi
    if len(error) != len(time):
        raise UsageError('longitude: the bag has no longitude for some readings. Draw error')
    return _over_time(
        voyage,
        'Error of the longitude',
        'east of the truth [nmi]',
        [
            _band('corrected ± 1σ', time, error, voyage.longitude_sigma_nmi),
            _line('corrected', time, error, 'orange'),
            _line('by the dial', time, voyage.raw_longitude_error_nmi),
        ],
    )


def _amplitude(voyage: Voyage) -> Chart:
    _needs(voyage.angle_rad, 'amplitude', 'the wheel')
    every = max(len(voyage.time_s) // 500, 1)
    time, angle, rate = (
        data[::every] for data in (voyage.time_s, voyage.angle_rad, voyage.angular_velocity_rad_s)
    )
    machine = compile_machine(voyage.scene)
    if isinstance(machine, OtherRegulator | HangingMachine):
        size, name = np.hypot(angle, rate / machine.frequency), 'amplitude of a small swing'
    else:
        energy = swing_energy(machine, angle, rate) + recoil_energy(machine, angle, rate)
        size = np.array([amplitude_of(machine, joule) for joule in energy.tolist()])
        name = 'amplitude'
    of = 'arc [m]' if isinstance(machine, FluidPendulum) else 'angle [rad]'
    return _over_time(voyage, 'Amplitude of the swing', of, [Line(name, time, size)])


def _phase(voyage: Voyage) -> Chart:
    _needs(voyage.angle_rad, 'phase', 'the wheel')
    every = -(-len(voyage.angle_rad) // MOST_POINTS)
    machine = compile_machine(voyage.scene)
    unit = 'm' if isinstance(machine, FluidPendulum) else 'rad'
    return Chart(
        'Phase portrait',
        f'position [{unit}]',
        f'velocity / ω [{unit}]',
        [
            Line(
                '',
                voyage.angle_rad[::every],
                voyage.angular_velocity_rad_s[::every] / machine.frequency,
                kind='points',
            )
        ],
        equal=True,
        note='One point per logged sample.',
    )


def _roll(voyage: Voyage, view: _Window, motion: Seaway) -> Chart:
    unit, name = time_unit(view.to_s - view.from_s)
    time = (motion.time_s - view.from_s) / unit
    marks, _ = _marks(voyage, view.from_s, view.to_s)
    marks = [Mark((mark.x - view.from_s) / unit, mark.name) for mark in marks if mark.name]
    size, units = time_unit(float(voyage.time_s[-1]))
    since = '' if view.from_s == 0.0 else f' since {view.from_s / size:.7g} {units}'
    label = f'time{since} [{name}]'
    slowest = f'waves of {1.0 / LOWEST_HZ:.0f} s and shorter, faded at both ends'
    heave = Chart(
        '',
        label,
        'heave [m]',
        [_line('', time, motion.heave_m)],
        marks=[replace(mark, name='') for mark in marks],
        note=_of_part(voyage, view, motion, f'heave: {slowest}'),
    )
    roll = _line('', time, np.degrees(motion.roll_rad), 'green')
    title = 'Motion of the ship'
    return Chart(title, label, 'roll [°]', [roll], marks=marks, below=heave)


def _of_part(voyage: Voyage, view: _Window, motion: Seaway, *remarks: str) -> str:
    """Return a note on the part of the voyage that a picture shows."""
    size, unit = time_unit(float(voyage.time_s[-1]))
    is_all = view.from_s == 0.0 and view.to_s >= voyage.time_s[-1]
    part = f'{view.from_s / size:.7g} to {view.to_s / size:.7g} {unit}'
    parts = '' if is_all else f'{view.note}, {part}' if view.note else part
    text = '; '.join(filter(None, (parts, motion.note, *remarks)))
    return f'{text[0].upper()}{text[1:]}.' if text else ''


def _spectrum(voyage: Voyage, view: _Window, motion: Seaway) -> Chart:
    from scipy.signal import welch

    time = motion.time_s
    if len(time) < 32:
        raise UsageError('spectrum: too few samples of the motion. Sail or show a longer time')
    if not (motion.roll_rad.any() or motion.vertical_m_s2.any()):
        raise UsageError('spectrum: the ship does not move. Draw error, rate or amplitude')
    rate = 1.0 / float(time[1] - time[0])
    segment = min(len(time), round(SEGMENT_S * rate))
    panel: Chart | None = None
    for name, unit, values, colour, power in (
        ('heave', 'm²/Hz', motion.vertical_m_s2, 'blue', 4),
        ('roll', '°²/Hz', np.degrees(motion.roll_rad), 'green', 0),
    ):
        frequency, density = welch(values, rate, nperseg=segment)
        waves = (frequency >= LOWEST_HZ) & (frequency <= 1.0)
        density = density[waves] / (2.0 * np.pi * frequency[waves]) ** power
        # six decades: below, the axis would show leakage of Welch's windows
        mask = density > 1e-6 * float(density.max(initial=0.0))
        line = Line('', frequency[waves][mask], density[mask], colour)  # type: ignore[arg-type]
        panel = Chart(
            'Spectrum of the motion' if panel else '',
            'frequency [Hz]',
            f'{name} [{unit}]',
            [line],
            log_y=bool(mask.any()),
            note='' if panel else _of_part(voyage, view, motion),
            below=panel,
        )
    assert panel is not None
    return panel


def _weather(voyage: Voyage) -> Chart:
    """Return height, period and heading of the sea in each state of the weather."""
    scene = voyage.scene
    states = weather(scene)
    if not states:
        raise UsageError(
            f'weather: {scene.name} has no sea that changes. Draw roll or spectrum, or a scene '
            'with ship.weather'
        )
    size, unit = time_unit(scene.duration)
    end = scene.duration / size
    at_s = np.array([max(state.at_ns, 0) / NS_PER_S for state in states])
    # in a change the variances of both seas add with the squares of the weights
    share = np.linspace(0.0, 1.0, 9)[:-1]
    turn = 0.5 * np.pi * share**4 * (35.0 - share * (84.0 - share * (70.0 - 20.0 * share)))
    height = np.array([state.height for state in states])
    faded = np.hypot(np.cos(turn) * height[:-1, None], np.sin(turn) * height[1:, None])
    between = at_s[:-1, None] + share * np.diff(at_s)[:, None]
    time = np.concatenate((between.ravel(), at_s[-1:])) / size
    # the sea is constant before the first state and after the last
    grid = np.unique(np.clip(np.concatenate(([0.0], time, [end])), 0.0, end))
    line = _line('', grid, np.interp(grid, time, np.concatenate((faded.ravel(), height[-1:]))))
    met = [
        (at, state.sea.peak_period, math.remainder(state.heading, math.tau))
        for at, state in zip(at_s / size, states, strict=True)
        if state.sea is not None and at <= end
    ]
    when, period, turned = np.array(met).reshape(-1, 3).T
    marks, _ = _marks(voyage, 0.0, scene.duration)
    marks = [Mark(mark.x / size, mark.name) for mark in marks if mark.name]
    faint = [replace(mark, name='') for mark in marks]
    label = f'time [{unit}]'
    heading = Chart(
        '',
        label,
        'heading [°]',
        [Line('', when, np.degrees(turned), 'green', 'points')],
        marks=faint,
        note='Heading: direction in which the waves run, from the bow to port: 0 following, ±180 '
        'head seas.',
    )
    peak = Line('', when, period, 'orange', 'points')
    periods = Chart('', label, 'peak period [s]', [peak], marks=faint, below=heading)
    title = 'The weather'
    return Chart(title, label, 'significant height [m]', [line], marks=marks, below=periods)


def _stability(voyage: Voyage) -> Chart:
    """Return deviations of frequency and of time against τ, with error bars."""
    result = voyage.result.get('stability')
    if result is None:
        from tauto_core.navigation.stability import stability_of

        reading = voyage.samples[READING]
        assert isinstance(reading, TimeSamples)
        try:
            result = stability_of(reading)
        except EstimationError as error:
            raise UsageError(f'stability: {error}') from None
    rows, percent = result['rows'], f'{100 * result["confidence"]:g} %'
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0] if name != 'noise'}
    tau, label = columns['tau_s'], 'averaging time τ [s]'

    def bars(of: str, name: str) -> Line:
        low, high = columns[f'{of}_low'], columns[f'{of}_high']
        return Line(f'{percent} of {name}', tau, low, 'grey', 'bars', high)

    in_time = Chart(
        '',
        label,
        'time deviation [s]',
        [bars('time', 'time'), Line('time', tau, columns['time'])],
        log_x=True,
        log_y=True,
        note=f'From {result["samples"]:,} readings. The bars contain the deviation of the clock '
        f'with {percent} probability.',
    )
    return Chart(
        'Stability of the clock',
        label,
        'deviation of relative frequency',
        [
            bars('allan', 'Allan'),
            Line('Allan', tau, columns['allan']),
            Line('modified Allan', tau, columns['modified'], 'orange'),
            Line('Hadamard', tau, columns['hadamard'], 'green'),
        ],
        log_x=True,
        log_y=True,
        below=in_time,
    )


def _map(voyage: Voyage) -> Chart:
    """Return the true track, and the tracks by the dial and by the navigator, over the coasts."""
    _needs(voyage.latitude_deg, 'map', 'the place of the ship')
    every = map_samples(voyage)
    latitude = voyage.latitude_deg[every]
    longitude = np.unwrap(voyage.longitude_deg, period=360.0)[every]
    # miles to the east, as degrees of longitude
    degrees = 1.0 / (60.0 * np.maximum(np.cos(np.radians(latitude)), 1e-3))
    lines = []
    error, sigma = voyage.longitude_error_nmi, voyage.longitude_sigma_nmi
    if len(error) == len(voyage.latitude_deg):
        dial, believed, wide = (
            longitude + degrees * miles[every]
            for miles in (voyage.raw_longitude_error_nmi, error, error + sigma)
        )
        wide -= believed
        band = np.concatenate((believed - wide, (believed + wide)[::-1]))
        there_and_back = np.concatenate((latitude, latitude[::-1]))
        lines = [
            Line('± 1σ', band, there_and_back, 'orange', 'band'),
            Line('by the dial', dial, latitude),
            Line('corrected', believed, latitude, 'orange'),
        ]
    lines.append(Line('the ship', longitude, latitude, 'green'))
    ends = [0, -1]
    lines.append(Line('departure and end', longitude[ends], latitude[ends], 'grey', 'points'))
    return Chart(
        'The voyage',
        'longitude [° east]',
        'latitude [° north]',
        lines,
        is_map=True,
        names=_names(voyage.scene, longitude, latitude),
    )


def map_samples(voyage: Voyage) -> slice:
    """Return the samples on the map of a voyage. A band has twice as many points."""
    return slice(None, None, max(-(-2 * len(voyage.latitude_deg) // MOST_POINTS), 1))


def _names(
    scene: Scene, longitude: FloatArray, latitude: FloatArray
) -> list[tuple[str, float, float]]:
    """Return name, longitude and latitude of departure, landfalls and arrival.

    The longitude is continuous with the track, which may run beyond ±180°.
    """
    voyage = scene.voyage
    if voyage is None:
        return []
    stops = [('departure', *voyage.departure)]
    stops += [('landfall', *stop.place) for stop in voyage.waypoints or () if stop.landfall]
    stops.append(('arrival', *voyage.arrival))
    names = []
    for what, north, east in stops:
        away = np.remainder(longitude - east + 180.0, 360.0) - 180.0
        nearest = int(np.argmin(np.square(away) + np.square(latitude - north)))
        # the bag may end before a place
        if math.hypot(float(away[nearest]), float(latitude[nearest]) - north) < NEAR_DEG:
            name = place_name(north, east) or what
            names.append((name, float(longitude[nearest] - away[nearest]), north))
    return names


NEAR_DEG = 0.2
"""Distance from a place at which the track has reached it [°]."""


def _machine(voyage: Voyage) -> Chart:
    drawn = draw_machine(voyage.scene)
    return Chart(
        'The machine at rest',
        'across [mm]',
        'upwards, to the same scale, broken' if drawn.is_broken else 'upwards [mm]',
        drawn.parts,
        equal=True,
        note=drawn.note,
        y_ticks=not drawn.is_broken,
    )


def _needs(values: FloatArray, what: str, part: str) -> None:
    if not len(values) or not math.isfinite(float(values[0])):
        raise UsageError(f'{what}: the bag does not hold {part}. Draw error, rate or longitude')


_PICTURES: dict[str, Callable[..., Chart]] = {
    'error': _error,
    'rate': _rate,
    'drift': _drift,
    'longitude': _longitude,
    'stability': _stability,
    'amplitude': _amplitude,
    'phase': _phase,
    'weather': _weather,
    'temperature': _temperature,
    'roll': _roll,
    'spectrum': _spectrum,
    'map': _map,
    'cam': lambda voyage: Chart(
        'The cam', 'across [mm]', 'along the thread [mm]', cam_lines(voyage.scene), equal=True
    ),
    'machine': _machine,
}
OF_A_PART = ('roll', 'spectrum')
"""The pictures that can show a part of the voyage."""
OF_A_SCENE = ('weather', 'cam', 'machine')
"""The pictures that need only a scene."""
PICTURES = tuple(_PICTURES)
"""The pictures by name, in the order of the report."""
