"""The contents of the pictures of a voyage, independent of the renderer.

`pictures` draws them with Matplotlib and `report` in a page, so both show the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from tauto_core.chart import Chart, Colour, Line
from tauto_core.machine_drawing import cam_lines, machine_lines
from tauto_core.machines import FluidPendulum, HangingMachine, compile_machine
from tauto_core.machines.amplitude import amplitude_of, recoil_energy, swing_energy
from tauto_core.record import Voyage
from tauto_core.samples import READING, SECONDS_PER_DAY, SHIP_IMU, FloatArray, TimeSamples
from tauto_core.scene.errors import EstimationError, UsageError
from tauto_core.seaway import LOWEST_HZ, PART_S, seaway

MOST_POINTS = 2000
"""Largest number of points of a line; longer lines are thinned so that every extreme is kept."""
PIECES = 25
"""Number of pieces of a voyage over which the rate is measured."""
SEGMENT_S = 120.0
"""Length of the segments whose spectra are averaged [s]."""


def chart(voyage: Voyage, what: str) -> Chart:
    """Return one of `PICTURES` of a voyage.

    Raises:
        UsageError: no such picture, or the voyage lacks its data.
    """
    if what not in PICTURES:
        raise UsageError(f'{what!r}: is not a picture. Choose one of {", ".join(PICTURES)}')
    return PICTURES[what](voyage)


def thinned(
    x: FloatArray, y: FloatArray, most: int = MOST_POINTS
) -> tuple[FloatArray, FloatArray]:
    """Return a line with at most `most` points: the least and the greatest of each interval.

    Args:
        x: increasing, (n,).
        y: (n,).
        most: largest number of points, >= 4.
    """
    if len(x) <= most:
        return x, y
    stretches = most // 2 - 1
    edges = np.linspace(0, len(x), stretches + 1).astype(np.int64)
    kept = {0, len(x) - 1}
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        kept |= {begin + int(np.argmin(y[begin:end])), begin + int(np.argmax(y[begin:end]))}
    which = np.array(sorted(kept))
    return x[which], y[which]


def _line(name: str, x: FloatArray, y: FloatArray, colour: Colour = 'blue') -> Line:
    return Line(name, *thinned(x, y), colour)


def _band(name: str, x: FloatArray, middle: FloatArray, sigma: FloatArray) -> Line:
    """Return the band of one standard deviation about a line."""
    at, low = thinned(x, middle - sigma)
    return Line(name, at, low, 'orange', 'band', np.interp(at, x, middle + sigma))


def _clock_axis(voyage: Voyage) -> tuple[float, str]:
    """Return the unit [s] of the time axis, and its label."""
    length = float(voyage.time_s[-1]) if len(voyage.time_s) else 0.0
    for size, unit in ((SECONDS_PER_DAY, 'days'), (3600.0, 'hours'), (60.0, 'minutes')):
        if length >= 2.0 * size:
            return size, f'time [{unit}]'
    return 1.0, 'time [s]'


def _error(voyage: Voyage) -> Chart:
    unit, label = _clock_axis(voyage)
    time = voyage.time_s / unit
    return Chart(
        'Error of the clock',
        label,
        'reading − true time [s]',
        [
            _band('estimate ± 1σ', time, voyage.offset_s, voyage.offset_sigma_s),
            _line('estimated', time, voyage.offset_s, 'orange'),
            _line('dial', time, voyage.clock_error_s),
            Line(
                'observed',
                voyage.observation_time_s / unit,
                voyage.observed_error_s,
                'grey',
                'points',
            ),
        ],
    )


def _drift(voyage: Voyage) -> Chart:
    unit, label = _clock_axis(voyage)
    time = voyage.time_s / unit
    zero = np.zeros_like(time)
    return Chart(
        'What the correction leaves',
        label,
        'corrected time − true time [s]',
        [
            _band('± 1σ of the navigator', time, zero, voyage.offset_sigma_s),
            _line('corrected clock', time, voyage.corrected_error_s),
        ],
    )


def _rate(voyage: Voyage) -> Chart:
    unit, label = _clock_axis(voyage)
    every = max((len(voyage.time_s) - 1) // PIECES, 1)
    time, error = voyage.time_s[::every], voyage.clock_error_s[::every]
    measured = np.diff(error) / np.diff(time) * SECONDS_PER_DAY
    estimated, sigma = voyage.mean_rate_s_per_day, voyage.mean_rate_sigma_s_per_day
    return Chart(
        'Rate of the clock',
        label,
        'rate [s/day], fast is positive',
        [
            _band('estimate ± 1σ', voyage.time_s / unit, estimated, sigma),
            _line('estimated', voyage.time_s / unit, estimated, 'orange'),
            _line('dial', 0.5 * (time[1:] + time[:-1]) / unit, measured),
        ],
    )


def _longitude(voyage: Voyage) -> Chart:
    unit, label = _clock_axis(voyage)
    time = voyage.time_s / unit
    error = voyage.longitude_error_nmi
    if len(error) != len(time):
        raise UsageError('longitude: the bag has no longitude for some readings. Draw error')
    return Chart(
        'Error of the longitude',
        label,
        'east of the truth [nmi]',
        [
            _band('corrected ± 1σ', time, error, voyage.longitude_sigma_nmi),
            _line('corrected', time, error, 'orange'),
            _line('by the dial', time, voyage.raw_longitude_error_nmi),
        ],
    )


def _amplitude(voyage: Voyage) -> Chart:
    unit, label = _clock_axis(voyage)
    _needs(voyage.angle_rad, 'amplitude', 'the wheel')
    every = max(len(voyage.time_s) // 500, 1)
    time, angle, rate = (
        each[::every] for each in (voyage.time_s, voyage.angle_rad, voyage.angular_velocity_rad_s)
    )
    machine = compile_machine(voyage.scene)
    if isinstance(machine, FluidPendulum | HangingMachine):
        size, name = np.hypot(angle, rate / machine.frequency), 'amplitude of a small swing'
    else:
        energy = swing_energy(machine, angle, rate) + recoil_energy(machine, angle, rate)
        size = np.array([amplitude_of(machine, each) for each in energy.tolist()])
        name = 'amplitude'
    of = 'arc [m]' if isinstance(machine, FluidPendulum) else 'angle [rad]'
    return Chart('Amplitude of the swing', label, of, [Line(name, time / unit, size)])


def _phase(voyage: Voyage) -> Chart:
    _needs(voyage.angle_rad, 'phase', 'the wheel')
    every = max(len(voyage.angle_rad) // MOST_POINTS, 1)
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
        note='One point a logged sample.',
    )


def _roll(voyage: Voyage) -> Chart:
    shown = seaway(voyage)
    whole = len(shown.time_s) == 0 or shown.time_s[-1] >= voyage.time_s[-1] - 1.0
    notes = ([] if whole else ['the first ten minutes']) + ([shown.note] if shown.note else [])
    slowest = f'heave: waves of {1.0 / LOWEST_HZ:.0f} s and shorter, faded at both ends'
    return Chart(
        'Motion of the ship',
        'time [s]',
        'roll [°]; heave [m]',
        [
            _line('roll', shown.time_s, np.degrees(shown.roll_rad), 'green'),
            _line('heave', shown.time_s, shown.heave_m),
        ],
        note=f'{"; ".join([*notes, slowest])}.'.capitalize(),
    )


def _spectrum(voyage: Voyage) -> Chart:
    from scipy.signal import welch

    motion = seaway(voyage, length_s=math.inf if SHIP_IMU in voyage.samples else PART_S)
    time = motion.time_s
    if len(time) < 32:
        raise UsageError('spectrum: too few samples of the motion. Sail longer')
    rate = 1.0 / float(time[1] - time[0])
    segment = min(len(time), round(SEGMENT_S * rate))
    lines = []
    for name, values, colour, power in (
        ('roll [°²/Hz]', np.degrees(motion.roll_rad), 'green', 0),
        ('heave [m²/Hz]', motion.vertical_m_s2, 'blue', 4),
    ):
        frequency, density = welch(values, rate, nperseg=segment)
        shown = (frequency >= LOWEST_HZ) & (frequency <= 1.0)
        density = density[shown] / (2.0 * np.pi * frequency[shown]) ** power
        lines.append(Line(name, frequency[shown], density, colour))  # type: ignore[arg-type]
    floor = 1e-6 * max(float(line.y.max(initial=0.0)) for line in lines)
    kept = [
        Line(each.name, each.x[each.y > floor], each.y[each.y > floor], each.colour)
        for each in lines
    ]
    title = 'Spectrum of the motion'
    return Chart(title, 'frequency [Hz]', 'density', kept, log_y=floor > 0.0, note=motion.note)


def _stability(voyage: Voyage) -> Chart:
    from tauto_core.navigation.stability import stability_of

    reading = voyage.samples[READING]
    assert isinstance(reading, TimeSamples)
    try:
        found = stability_of(reading)
    except EstimationError as error:
        raise UsageError(f'stability: {error}') from None
    rows = found['rows']
    tau = np.array([row['tau_s'] for row in rows])
    columns = {
        name: np.array([row[name] for row in rows])
        for name in ('allan', 'allan_low', 'allan_high', 'modified', 'hadamard')
    }
    return Chart(
        'Stability of the clock',
        'averaging time τ [s]',
        'deviation of relative frequency',
        [
            Line(
                f'{100 * found["confidence"]:g} % of Allan',
                tau,
                columns['allan_low'],
                'grey',
                'bars',
                columns['allan_high'],
            ),
            Line('Allan', tau, columns['allan']),
            Line('modified Allan', tau, columns['modified'], 'orange'),
            Line('Hadamard', tau, columns['hadamard'], 'green'),
        ],
        log_x=True,
        log_y=True,
    )


def _map(voyage: Voyage) -> Chart:
    latitude, longitude = voyage.latitude_deg, voyage.longitude_deg
    _needs(latitude, 'map', 'the place of the ship')
    every = max(len(latitude) // MOST_POINTS, 1)
    shift = voyage.raw_longitude_error_nmi / 60.0
    lines = [Line('the ship', longitude[::every], latitude[::every], 'green')]
    if len(shift) == len(latitude):
        dial = longitude + shift / np.maximum(np.cos(np.radians(latitude)), 1e-3)
        lines.append(Line('by the dial', dial[::every], latitude[::every]))
    clock = voyage.clock_longitude_deg
    if len(clock) == len(latitude):
        lines.append(Line('corrected', clock[::every], latitude[::every], 'orange'))
    ends = [0, -1]
    lines.append(Line('departure and end', longitude[ends], latitude[ends], 'grey', 'points'))
    return Chart('The voyage', 'longitude [° east]', 'latitude [° north]', lines)


def _cam(voyage: Voyage) -> Chart:
    return Chart(
        'The cam', 'across [mm]', 'along the thread [mm]', cam_lines(voyage.scene), equal=True
    )


def _machine(voyage: Voyage) -> Chart:
    lines = machine_lines(voyage.scene)
    return Chart('The machine at rest', 'across [mm]', 'upwards [mm]', lines, equal=True)


def _needs(values: FloatArray, what: str, part: str) -> None:
    if not len(values) or not math.isfinite(float(values[0])):
        raise UsageError(f'{what}: the bag does not hold {part}. Draw error, rate or longitude')


PICTURES: dict[str, Callable[[Voyage], Chart]] = {
    'error': _error,
    'rate': _rate,
    'drift': _drift,
    'longitude': _longitude,
    'stability': _stability,
    'amplitude': _amplitude,
    'phase': _phase,
    'roll': _roll,
    'spectrum': _spectrum,
    'map': _map,
    'cam': _cam,
    'machine': _machine,
}
"""The pictures by name, in the order of the report."""
