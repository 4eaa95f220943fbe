"""`tauto hull`: the coefficients of a hull, her motion in waves, and its cost to a clock."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import (
    AsJson,
    OptionalFloat,
    Plots,
    print_rich,
    progress_bar,
    say,
    takes,
)
from tauto_core.scene.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import RenderableType

    from tauto_core.ship.hull import Hull, HullCoefficients, PlaceRate

HEIGHT_M, PERIOD_S = 2.5, 9.0
"""The standard sea of the table: significant height and peak period of a Bretschneider sea."""
HEADINGS_DEG = (180, 135, 90, 45, 0)
# Places of the clock, forward of amidships and over the waterline, as parts of the length.
_PLACES = ((0.0, 0.0), (5.0 / 44.0, 1.0 / 44.0), (12.0 / 44.0, 3.0 / 44.0))


def hull(
    shape: Annotated[
        str | None, takes('NAME', 'A shape that comes with Tauto: sloop, deptford, ketch, yacht.')
    ] = None,
    mesh: Annotated[
        Path | None, takes('FILE', 'Or a mesh: x forward, z up from the waterline [m].')
    ] = None,
    length: Annotated[
        OptionalFloat, takes('M', 'Or a parametric form: length of the waterline [m],', 'm')
    ] = None,
    beam: Annotated[OptionalFloat, takes('M', 'its beam [m],', 'm')] = None,
    draught: Annotated[OptionalFloat, takes('M', 'draught without keel [m]', 'm')] = None,
    block: Annotated[OptionalFloat, takes('C', 'and block coefficient.')] = None,
    roll_period: Annotated[
        OptionalFloat, takes('S', 'Natural period of her roll; 3.1 √beam if left out.', 's')
    ] = None,
    roll_damping: Annotated[
        float, takes('Z', 'Damping ratio of her roll besides the waves.')
    ] = 0.08,
    speed: Annotated[float, takes('M/S', 'Her speed.', 'm/s')] = 0.0,
    out: Annotated[
        Path | None, takes('FILE', 'Write the coefficients (.npz); replaces the file.')
    ] = None,
    plot: Plots = None,
    as_json: AsJson = False,
) -> None:
    """Find how a hull moves in waves, and its cost to a clock.

    The cost is given by heading and place. Boundary elements solve for the water about her
    (capytaine, the extra `hull`); a built-in shape needs no extra. --length beside --shape scales
    it. --plot draws her operators: all six motions by the period of the waves.
    """
    from tauto_core.files import check_place, check_plot
    from tauto_core.ship import hull as hulls

    if out is not None:
        if out.suffix != '.npz':
            raise UsageError(f'--out {out}: must end in .npz. Name another file')
        check_place(out, 'out')
    for path in plot or ():
        check_plot(path)
    sizes = {'length': length, 'beam': beam, 'draught': draught, 'block': block}
    # refusals that need no coefficients come first: those take a minute
    if not (math.isfinite(roll_damping) and 0.0 <= roll_damping < 1.0):
        raise UsageError(f'--roll-damping = {roll_damping}: must lie in [0, 1). Leave it out')
    if roll_period is not None and not 0.0 < roll_period < math.inf:
        raise UsageError(f'--roll-period = {roll_period}: must be above 0 s. Leave it out')
    found = _coefficients(shape, mesh, sizes, speed, roll_period)
    ship = hulls.Hull(
        found,
        roll_period=3.1 * math.sqrt(found.beam) if roll_period is None else roll_period,
        roll_damping_ratio=roll_damping,
    )
    ship.check_speed(speed)
    facts, rates = _facts(ship, speed)
    if out is not None:
        found.save(out)
        facts['path'] = str(out)
    for path in plot or ():
        from tauto_core.files import write_figure

        write_figure(lambda: _drawn(ship, speed), path)
    if as_json:
        typer.echo(json.dumps(facts, allow_nan=False))
        return
    print_rich(_page(facts, rates))
    for path in (*((out,) if out is not None else ()), *(plot or ())):
        say(f'wrote {path}')


def _coefficients(
    shape: str | None,
    mesh: Path | None,
    sizes: dict[str, OptionalFloat],
    speed: float,
    roll: OptionalFloat,
) -> HullCoefficients:
    """Return the coefficients of a hull given by shape, by mesh, or by its dimensions."""
    import numpy as np

    from tauto_core.ship import hull as hulls

    given = [name for name, size in sizes.items() if size is not None]
    if shape is not None:
        if mesh is not None or set(given) - {'length'}:
            raise UsageError(
                f'--shape {shape}: already has its proportions. Leave out --mesh, --beam, '
                '--draught and --block, or --shape'
            )
        found = hulls.named_hull(shape)
        length = sizes['length']
        return found if length is None else found.scaled(length)
    if mesh is not None:
        if given:
            raise UsageError(
                f'--mesh {mesh}: has its own sizes. Leave out --{" and --".join(given)}, or --mesh'
            )
        from tauto_core.ship import hull_bem

        panels, name = hull_bem.read_mesh(mesh), mesh.stem
    else:
        missing = [f'--{name}' for name in sizes if name not in given]
        if len(missing) == len(sizes):
            known = ', '.join(hulls.SHAPES)
            raise UsageError(
                'names no hull. Give --shape (one of '
                f'{known}), --mesh FILE, or --length, --beam, --draught and --block'
            )
        if missing:
            raise UsageError(f'--{given[0]}: needs {", ".join(missing)} beside it. Give all four')
        from tauto_core.ship import hull_bem

        length, beam, draught, block = (size or 0.0 for size in sizes.values())
        panels = hull_bem.form_mesh(hulls.Shape(length, beam, draught, block))
        name = 'parametric form'
    long, wide, _ = np.ptp(panels.vertices, axis=0)
    hulls.check_froude(speed, float(long))
    # no hull of such a beam rolls faster or slower, whatever her form
    low, high = 1.8 * math.sqrt(wide), 30.0 * math.sqrt(wide)
    if roll is not None and not low <= roll <= high:
        raise UsageError(
            f'--roll-period = {roll}: must lie in [{low:.3g}, {high:.3g}] s for a beam of '
            f'{wide:.3g} m. Leave it out'
        )
    say('boundary elements at 33 frequencies: half a minute to some minutes')
    with progress_bar('hull') as progress:
        return hull_bem.compute(panels, name, progress=progress)


def _facts(ship: Hull, speed: float) -> tuple[dict[str, Any], list[PlaceRate]]:
    """Return the result as one object, and the rates by heading and place."""
    import numpy as np

    from tauto_core.ship.hull import ClockPlace, rate_by_place
    from tauto_core.ship.sea import bretschneider

    hull = ship.coefficients
    places = [ClockPlace(x * hull.length, 0.0, z * hull.length) for x, z in _PLACES]
    headings = [math.radians(each) for each in HEADINGS_DEG]
    omega = math.sqrt(ship.gravity / hull.length) * np.geomspace(0.1, 6.0, 2000)
    peaks = []
    for heading in headings:
        size = np.abs(ship.response(omega, heading, speed).motions)
        peak: dict[str, float | None] = {'heading_rad': heading}
        for name, column, unit in (('heave', 2, 'm'), ('roll', 3, 'rad'), ('pitch', 4, 'rad')):
            row = int(np.argmax(size[:, column]))
            peak[f'{name}_{unit}_per_m'] = float(size[row, column])
            # without a resonance it is largest in waves that are long without end
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
    own = hull.damping[:, diagonal, diagonal]
    apart = np.abs(own - radiated[:, diagonal, diagonal]).max(axis=0) / own.max(axis=0)
    return {
        'hull': {
            'name': hull.name,
            'source': hull.source,
            'length_m': hull.length,
            'beam_m': hull.beam,
            'draught_m': hull.draught,
            'block_coefficient': hull.block,
            'volume_m3': hull.volume,
            'damping_off_by': float(apart.max()),
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
                'heading_rad': each.heading,
                'forward_m': each.place.forward,
                'up_m': each.place.up,
                'heave': each.heave,
                'athwart': each.athwart,
                'fore_and_aft': each.fore_and_aft,
                'kept_vertical': each.kept_vertical,
                'leaning_freely': each.leaning_freely,
                'pitching': each.pitching,
            }
            for each in rates
        ],
    }, rates


def _drawn(ship: Hull, speed: float) -> Figure:
    """Draw the sizes of the six motions per metre of wave, by period and heading."""
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
    found = [
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
                Line(name if column == 0 else '', period, size * each[:, column], colour)
                for name, colour, each in found
            ],
            below=panels,
        )
    assert panels is not None
    under_way = f' at {speed:g} m/s' if speed else ''
    hull = ship.coefficients
    return draw(panels, f'{hull.name}, {hull.length:.3g} m{under_way}')


def _page(facts: dict[str, Any], rates: list[PlaceRate]) -> RenderableType:
    """Return the result as text: the hull, her operators, and the rates."""
    from rich import box
    from rich.console import Group
    from rich.text import Text

    from tauto_core.cli.tables import WholeTable
    from tauto_core.wording import printed

    hull, ship = facts['hull'], facts['ship']
    lines = (
        f'{hull["name"]}: {hull["length_m"]:.3g} by {hull["beam_m"]:.3g} by '
        f'{hull["draught_m"]:.3g} m, {hull["volume_m3"]:.4g} m3, block coefficient '
        f'{hull["block_coefficient"]:.2f}',
        f'{hull["source"]}; damping and exciting forces agree within '
        f'{100.0 * hull["damping_off_by"]:.2g} %',
        f'rolls in {ship["roll_period_s"]:.3g} s, damping {ship["roll_damping_ratio"]:g}: '
        f'metacentric height {ship["metacentric_height_m"]:.2g} m, centre of gravity '
        f'{printed(ship["centre_of_gravity_m"], "+.2g")} m from the waterline; '
        f'{ship["speed_m_s"]:g} m/s',
    )
    peaks = WholeTable(title='largest motions, per metre of wave', title_justify='left')
    peaks.box = box.SQUARE
    for title in (
        'heading, °',
        'heave, m',
        'wave, s',
        'roll, °',
        'wave, s',
        'pitch, °',
        'wave, s',
    ):
        peaks.add_column(title, justify='right')
    for each in facts['operators']:
        at = {
            name: '–' if (period := each[f'{name}_at_s']) is None else f'{period:.1f}'
            for name in ('heave', 'roll', 'pitch')
        }
        peaks.add_row(
            f'{math.degrees(each["heading_rad"]):.0f}',
            *(f'{each["heave_m_per_m"]:.2f}', at['heave']),
            *(f'{math.degrees(each["roll_rad_per_m"]):.1f}', at['roll']),
            *(f'{math.degrees(each["pitch_rad_per_m"]):.1f}', at['pitch']),
        )
    table = WholeTable(
        title=f'a weight in a Bretschneider sea of {HEIGHT_M} m, {PERIOD_S:g} s: s/day',
        title_justify='left',
        caption='heading: direction the waves run to, from the bow to port; 180 head seas',
        box=box.SQUARE,
    )
    for title in (
        *('heading, °', 'forward, m', 'up, m', 'heave', 'athwart', 'fore and aft'),
        *('plane kept vertical', 'leaning freely', 'plane pitches with her'),
    ):
        table.add_column(title, justify='right')
    for rate in rates:
        table.add_row(
            f'{math.degrees(rate.heading):.0f}',
            *(f'{rate.place.forward:.1f}', f'{rate.place.up:.1f}'),
            *(
                printed(part, 'z.1f')
                for part in (
                    *(rate.heave, rate.athwart, rate.fore_and_aft),
                    *(rate.kept_vertical, rate.leaning_freely, rate.pitching),
                )
            ),
        )
    return Group(*map(Text, lines), Text(''), peaks, Text(''), table)
