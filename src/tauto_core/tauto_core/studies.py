"""Studies without a voyage: a hull in waves, a body on a cylindrical axle, three altitudes.

Each function returns the object of `--json`, see `tauto_core.api`.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.scene.errors import Argument, TautoWarning, UsageError
from tauto_core.scene.times import DAY_S

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tauto_core.machines.axle_pendulum import AxleClock
    from tauto_core.ship.hull import Hull, HullCoefficients

# -----------------------------------------------------------------------------
# A hull: its motions in waves, and its cost to a clock.

HEIGHT_M, PERIOD_S = 2.5, 9.0
"""Significant wave height and peak period of the table's Bretschneider sea."""
HEADINGS_DEG = (180, 135, 90, 45, 0)
SHAPE = Argument('shape')
# Places of the clock, forward of amidships and above the waterline, in lengths of the ship.
_PLACES = ((0.0, 0.0), (5.0 / 44.0, 1.0 / 44.0), (12.0 / 44.0, 3.0 / 44.0))


def hull_in_waves(
    shape: str | None,
    mesh: Path | None,
    sizes: Mapping[str, float | None],
    *,
    roll_period: float | None,
    roll_damping: float,
    speed: float,
    out: Path | None,
    plots: Sequence[Path],
    progress: Callable[[float], None] | None,
) -> dict[str, Any]:
    """Return the motions of a hull in waves, and its cost to a clock, see `api.hull`."""
    from tauto_core.files import check_place, write_figure
    from tauto_core.ship import hull as hulls

    if out is not None:
        if out.suffix != '.npz':
            raise UsageError(Argument('out', out), ': must end in .npz. Name another file')
        check_place(out, 'out')
    # check the arguments first, since computing coefficients takes a minute
    if not (math.isfinite(roll_damping) and 0.0 <= roll_damping < 1.0):
        argument = Argument('roll_damping', roll_damping, spaced=True)
        raise UsageError(argument, ': must lie in [0, 1). Leave it out')
    if roll_period is not None and not 0.0 < roll_period < math.inf:
        argument = Argument('roll_period', roll_period, spaced=True)
        raise UsageError(argument, ': must be above 0 s. Leave it out')
    coefficients = _coefficients(shape, mesh, sizes, speed, roll_period, progress)
    ship = hulls.Hull(
        coefficients,
        roll_period=3.1 * math.sqrt(coefficients.beam) if roll_period is None else roll_period,
        roll_damping_ratio=roll_damping,
    )
    ship.check_speed(speed)
    facts = _facts(ship, speed)
    if out is not None:
        coefficients.save(out)
        facts['path'] = str(out)
    for path in plots:
        write_figure(lambda: _drawn(ship, speed), path)
    return facts


def _listed(names: Iterable[str]) -> Iterator[str | Argument]:
    """Yield arguments separated by commas and `and`, as parts of a message."""
    words = list(names)
    for place, name in enumerate(words):
        if place:
            yield ' and ' if place == len(words) - 1 else ', '
        yield Argument(name)


def _coefficients(
    shape: str | None,
    mesh: Path | None,
    sizes: Mapping[str, float | None],
    speed: float,
    roll: float | None,
    progress: Callable[[float], None] | None,
) -> HullCoefficients:
    """Return the coefficients of a hull given by shape, by mesh, or by its dimensions."""
    import numpy as np

    from tauto_core.ship import hull as hulls

    names = [name for name, size in sizes.items() if size is not None]
    if shape is not None:
        if mesh is not None or set(names) - {'length'}:
            dimensions = _listed(('mesh', 'beam', 'draught', 'block'))
            remedy = ': fixes the proportions. Leave out ', *dimensions, ', or ', SHAPE
            raise UsageError(Argument('shape', shape), *remedy)
        hull = hulls.named_hull(shape)
        length = sizes['length']
        return hull if length is None else hull.scaled(length)
    if mesh is not None:
        if names:
            remedy = ': has its own sizes. Leave out ', *_listed(names), ', or ', Argument('mesh')
            raise UsageError(Argument('mesh', mesh), *remedy)
        from tauto_core.ship import hull_bem

        panels, name = hull_bem.read_mesh(mesh), mesh.stem
    else:
        if not names:
            shapes = f' (one of {", ".join(hulls.SHAPES)}), '
            given = SHAPE, shapes, Argument('mesh', 'FILE'), ', or ', *_listed(sizes)
            raise UsageError('no hull is given. Give ', *given)
        missing = [name for name in sizes if name not in names]
        if missing:
            needs = ': needs ', *_listed(missing), '. Give all four'
            raise UsageError(Argument(names[0]), *needs)
        from tauto_core.ship import hull_bem

        length, beam, draught, block = (size or 0.0 for size in sizes.values())
        panels = hull_bem.form_mesh(hulls.Shape(length, beam, draught, block))
        name = 'parametric form'
    long, wide, _ = np.ptp(panels.vertices, axis=0)
    hulls.check_froude(speed, float(long))
    # limits of the roll period for any form with this beam
    low, high = 1.8 * math.sqrt(wide), 30.0 * math.sqrt(wide)
    if roll is not None and not low <= roll <= high:
        between = f'must lie in [{low:.3g}, {high:.3g}] s for a beam of {wide:.3g} m'
        raise UsageError(Argument('roll_period', roll, spaced=True), f': {between}. Leave it out')
    words = 'boundary elements at 33 frequencies: half a minute to some minutes'
    warnings.warn(words, TautoWarning, stacklevel=2)
    return hull_bem.compute(panels, name, progress=progress)


def _facts(ship: Hull, speed: float) -> dict[str, Any]:
    """Return the response amplitude operators, and the rates by heading and place."""
    import numpy as np

    from tauto_core.ship.hull import ClockPlace, rate_by_place
    from tauto_core.ship.sea import bretschneider

    hull = ship.coefficients
    places = [ClockPlace(x * hull.length, 0.0, z * hull.length) for x, z in _PLACES]
    headings = [math.radians(degrees) for degrees in HEADINGS_DEG]
    omega = math.sqrt(ship.gravity / hull.length) * np.geomspace(0.1, 6.0, 2000)
    peaks = []
    for heading in headings:
        size = np.abs(ship.response(omega, heading, speed).motions)
        peak: dict[str, float | None] = {'heading_rad': heading}
        for name, column, unit in (('heave', 2, 'm'), ('roll', 3, 'rad'), ('pitch', 4, 'rad')):
            row = int(np.argmax(size[:, column]))
            peak[f'{name}_{unit}_per_m'] = float(size[row, column])
            # without a resonance the maximum is in infinitely long waves
            peak[f'{name}_at_s'] = float(2.0 * np.pi / omega[row]) if row else None
        peaks.append(peak)
    rates = rate_by_place(
        ship,
        lambda at: bretschneider(at, HEIGHT_M, PERIOD_S),
        headings=headings,
        places=places,
        speed=speed,
    )
    radiated = hull.radiated_damping()
    diagonal = np.arange(6)
    total = hull.damping[:, diagonal, diagonal]
    error = np.abs(total - radiated[:, diagonal, diagonal]).max(axis=0) / total.max(axis=0)
    return {
        'hull': {
            'name': hull.name,
            'source': hull.source,
            'length_m': hull.length,
            'beam_m': hull.beam,
            'draught_m': hull.draught,
            'block_coefficient': hull.block,
            'volume_m3': hull.volume,
            'damping_off_by': float(error.max()),
        },
        'ship': {
            'roll_period_s': ship.roll_period,
            'roll_damping_ratio': ship.roll_damping_ratio,
            'metacentric_height_m': ship.gm,
            'centre_of_gravity_m': ship.z_g,
            'speed_m_s': speed,
        },
        'operators': peaks,
        'sea': {
            'spectrum': 'bretschneider',
            'significant_wave_height_m': HEIGHT_M,
            'peak_period_s': PERIOD_S,
        },
        'rates_s_per_day': [
            {
                'heading_rad': row.heading,
                'forward_m': row.place.forward,
                'up_m': row.place.up,
                'heave': row.heave,
                'athwart': row.athwart,
                'fore_and_aft': row.fore_and_aft,
                'kept_vertical': row.kept_vertical,
                'leaning_freely': row.leaning_freely,
                'pitching': row.pitching,
            }
            for row in rates
        ],
    }


def _drawn(ship: Hull, speed: float) -> Figure:
    """Draw the amplitudes of the six motions per metre of wave, by period and heading."""
    import numpy as np

    from tauto_core.plots.chart import Chart, Colour, Line, draw

    unit = math.sqrt(ship.coefficients.length / ship.gravity)
    period = unit * np.linspace(1.5, 12.0, 400)
    headings: tuple[tuple[float, str, Colour], ...] = (
        (180.0, 'head', 'blue'),
        (135.0, 'bow', 'orange'),
        (90.0, 'beam', 'green'),
        (0.0, 'following', 'grey'),
    )
    curves = [
        (
            f'{name}, {degrees:g}°',
            colour,
            np.abs(ship.response(math.tau / period, math.radians(degrees), speed).motions),
        )
        for degrees, name, colour in headings
    ]
    panels: Chart | None = None
    for column, motion in reversed(
        list(enumerate(('surge', 'sway', 'heave', 'roll', 'pitch', 'yaw')))
    ):
        size = 1.0 if column < 3 else math.degrees(1.0)
        panels = Chart(
            title='motions per metre of wave',
            x_label='period of the waves, s',
            y_label=f'{motion}, {"m" if column < 3 else "°"}/m',
            lines=[
                Line(name if column == 0 else '', period, size * motions[:, column], colour)
                for name, colour, motions in curves
            ],
            below=panels,
        )
    assert panels is not None
    under_way = f' at {speed:g} m/s' if speed else ''
    hull = ship.coefficients
    return draw(panels, f'{hull.name}, {hull.length:.3g} m{under_way}')


# -----------------------------------------------------------------------------
# A body on a cylindrical axle: its lengths, and its motion.

MOST_ROWS = 10_000


def axle_motion(
    keys: Mapping[str, Any], gravity: float, duration: float, every: float
) -> dict[str, Any]:
    """Return lengths and motion of a body, from the keys of a scene's regulator."""
    from pydantic import ValidationError

    from tauto_core.machines.axle_pendulum import AxleRegulator
    from tauto_core.motion.axle import axle_table

    try:
        body = AxleRegulator(kind='axle', **keys)
    except ValidationError as error:
        detail = error.errors()[0]
        argument = Argument(str(detail['loc'][0]), repr(detail['input']), spaced=True)
        raise UsageError(argument, f': {detail["msg"]}. Correct it') from None
    for problem in body.problems({}, 'still', still=True):
        argument = Argument(problem.key.removeprefix('regulator.'))
        raise UsageError(argument, f': {problem.problem}. {problem.remedy}')
    for name, value in (('gravity', gravity), ('duration', duration), ('every', every)):
        if not 0.0 < value < math.inf:
            argument = Argument(name, repr(value), spaced=True)
            raise UsageError(argument, ': must be above 0 and finite. Write for example 0.1')
    if duration / every > MOST_ROWS:
        rows = f': makes more than {MOST_ROWS} rows of {duration!r} s. Give a longer interval'
        raise UsageError(Argument('every', repr(every), spaced=True), rows)
    clock = body.clock(gravity)
    table = axle_table(clock, duration, every)
    lengths = body_lengths(clock)
    columns = {
        name: values.tolist() for name, values in asdict(table).items() if name[:5] != 'ends_'
    }
    return {
        **lengths,
        # the old names, for one release
        **{f'b{name[1:]}': length for name, length in lengths.items() if name.startswith('h')},
        'ends_s': table.ends_s,
        'ends_why': table.ends_why or None,
        'rows': [
            dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)
        ],
    }


def body_lengths(clock: AxleClock) -> dict[str, float | None]:
    """Return lengths and periods of small swings, and the shapes of the modes.

    A rolling axle has one length. A mode that drifts has None.
    """
    if clock.contact != 'smooth':
        length = clock.lengths[0]
        period = math.tau * math.sqrt(length / clock.body.gravity) if length > 0.0 else None
        return {'length_m': length, 'period_s': period}
    modes, lengths = clock.body.modes, {}
    shapes = modes.tilt_per_arc
    for name, length, shape in (('h', modes.h, shapes[0]), ('h_prime', modes.h_prime, shapes[1])):
        finite = math.isfinite(length)
        lengths[f'{name}_m'] = length if finite else None
        lengths[f'{name}_period_s'] = (
            math.tau * math.sqrt(length / clock.body.gravity) if finite and length > 0.0 else None
        )
        # φ : s, finite also on a plane
        lengths[f'{name}_tilt_per_arc_rad/m'] = shape if math.isfinite(shape) else None
    return lengths


# -----------------------------------------------------------------------------
# Three altitudes and two intervals of a clock: D. Bernoulli's problem (docs/altitudes.md).

TURN_S = {'star': 86164.0905, 'sun': DAY_S}
"""Time between two culminations of a star or the mean Sun [s]."""


def three_altitudes(
    heights: Sequence[float], times: Sequence[float], account: float, rate: float, body: str
) -> dict[str, Any]:
    """Return latitude, declination and culmination, see `api.altitudes`; angles in degrees.

    sin h = A + B cos H, with A = sin φ sin δ and B = cos φ cos δ. The hour angle H of the first
    altitude follows from Bernoulli's lemma with corrected sign, and gives B, A and φ ± δ.
    """
    import numpy as np

    gaps, turn_s = np.diff(times), TURN_S.get(body, DAY_S)
    rises = len(times) == 3 and gaps.min() > 0.0 and gaps.sum() < 0.5 * turn_s
    fits = len(heights) == 3 and np.all(np.abs(heights) < 90.0)
    for name, value, holds, words in (
        ('altitudes_deg', list(heights), fits, 'be three, each within 90 deg'),
        ('times', list(times), rises, f'be three that rise, within {0.5 * turn_s:.0f} s'),
        ('latitude_deg', account, abs(account) < 90.0, 'be within 90 deg'),
        ('rate', rate, abs(rate) < 0.5 * DAY_S, f'be within {0.5 * DAY_S:.0f} s/day'),
        ('body', body, body in TURN_S, 'be star or sun'),
    ):
        if not holds:
            argument = Argument(name, repr(value), spaced=True)
            raise UsageError(argument, f': must {words}. Correct it')
    turn = math.tau / turn_s / (1.0 + rate / DAY_S)  # by the clock [rad/s]
    turned, height = turn * (np.array(times) - times[0]), np.radians(heights)
    sines, (_, a, b) = np.sin(height), turned
    lm, ln = sines[0] - sines[1:]
    # sin b vers a − sin a vers b
    common = -4.0 * math.sin(0.5 * a) * math.sin(0.5 * b) * math.sin(0.5 * (b - a))
    across = 2.0 * (ln * math.sin(0.5 * a) ** 2 - lm * math.sin(0.5 * b) ** 2) / common
    along = (lm * math.sin(b) - ln * math.sin(a)) / common
    hour, reach = math.atan2(across, along), math.hypot(across, along)
    level = sines[0] - along
    if reach < 1e-9 or max(reach + level, reach - level) >= 1.0:
        argument = Argument('altitudes_deg', repr(list(heights)), spaced=True)
        wrong = ': no star that rises and sets has these at these times. Check both'
        raise UsageError(argument, wrong)
    small, large = math.acos(reach + level), math.acos(reach - level)
    p, q = 0.5 * (large + small), 0.5 * (large - small)
    places = (p, q), (q, p), (-p, -q), (-q, -p)
    phi, delta = min(places, key=lambda pair: abs(pair[0] - math.radians(account)))
    # errors of φ, δ and H: they cancel the effect of each cause on sin h
    cosine, by_hour = np.cos(hour + turned), -reach * np.sin(hour + turned)
    by_phi = math.cos(phi) * math.sin(delta) - math.sin(phi) * math.cos(delta) * cosine
    by_delta = math.sin(phi) * math.cos(delta) - math.cos(phi) * math.sin(delta) * cosine
    gains = 1.0 / (DAY_S + rate)
    causes = np.column_stack((-by_hour * gains * turned, np.diag(np.cos(height) * _ARCMIN)))
    shifts = np.linalg.solve(np.column_stack((by_phi, by_delta, by_hour)), causes)
    late = (np.array([gains * hour, 0.0, 0.0, 0.0]) - shifts[2]) / turn
    names = '1 s/day of the rate', *(f'1 arcmin of altitude {k}' for k in (1, 2, 3))
    return {
        'latitude_deg': math.degrees(phi),
        'declination_deg': math.degrees(delta),
        'culmination_s': times[0] - hour / turn,
        'highest_deg': 90.0 - math.degrees(abs(phi - delta)),
        'errors': [
            {'of': of, 'latitude_nmi': north, 'declination_arcmin': up, 'culmination_s': delay}
            for of, north, up, delay in zip(
                names, *(shifts[:2] / _ARCMIN).tolist(), late.tolist(), strict=True
            )
        ],
    }


_ARCMIN = math.tau / 21_600.0
