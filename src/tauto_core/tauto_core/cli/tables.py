"""Results as tables on a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console, ConsoleOptions, Group, RenderResult
from rich.measure import Measurement
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from tauto_core.results import SIGNS, answer, budget_rows, groups
from tauto_core.scene.times import DAY_S, LEGIBLE
from tauto_core.wording import (
    counted,
    figure,
    percent,
    printed,
    significant,
    span,
    with_sigma,
)

if TYPE_CHECKING:
    from rich.console import RenderableType

    from tauto_core.ensembles.answers import Answers, ClockAnswers, TrialAnswers
    from tauto_core.ensembles.comparison import Comparison, Row


# -----------------------------------------------------------------------------
# A table that is never cut, since half a figure would be misread.


class WholeTable(Table):
    """A table that may be wider than the terminal.

    Columns with `no_wrap` are as wide as their content. Others wrap between words, or with
    overflow `fold` within long words.
    """

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Set the least widths of the columns, and render the table."""
        roomy = options.update(max_width=10_000)
        for column in self.columns:
            if column.overflow == 'fold' and not column.no_wrap:
                column.min_width = None  # folded, never cut
                continue
            cells = [column.header, *column.cells]
            widths = [Measurement.get(console, roomy, cell) for cell in cells if cell]
            column.min_width = max(
                (size.maximum if column.no_wrap else size.minimum for size in widths), default=None
            )
        if all(column.min_width for column in self.columns):
            needed = Measurement.get(console, roomy, self).minimum
            options = options.update(max_width=max(options.max_width, needed))
        yield from super().__rich_console__(console, options)


def _table(title: str, *columns: str, caption: str | None = None, pad: int = 0) -> Table:
    """Return a table without rows, with figures in all columns but the first."""
    justify: Any = {'title_justify': 'left', 'caption_justify': 'left'}
    table = WholeTable(
        title=title or None, caption=caption, box=box.SIMPLE_HEAD, padding=(0, pad), **justify
    )
    for place, name in enumerate(columns):
        table.add_column(name, justify='right' if place else 'left')
    return table


Facts = Mapping[str, Any]

# width of the longest label, at which a sentence without a figure is wrapped
_SENTENCE = 43


def voyage_table(result: Facts) -> RenderableType:
    """Return the result of a voyage as text: the answer, a table in groups, and the bag."""
    seconds = result.get('duration_s')
    title = str(result.get('scene') or 'bag')
    table = WholeTable.grid(padding=(0, 2, 0, 0))
    table.add_column()
    table.add_column(justify='right', no_wrap=True)
    table.add_column(no_wrap=True)
    for name, rows in groups(result):
        table.add_row(Text(name, style='bold'))
        for label, value, unit in rows:
            cell = label if value else fill(label, _SENTENCE)
            table.add_row(Padding(cell, (0, 0, 0, 2)), value, unit)
    parts: list[RenderableType] = [
        Text(title if seconds is None else f'{title}: {span(seconds)}', style='italic'),
        Text(answer(result), style='bold'),
        Text(''),
        table,  # a padding around it would cut it
        Text(''),
        Text(SIGNS),
    ]
    if bag := result.get('bag'):
        parts.append(Text(f'Bag: {bag}', no_wrap=True, overflow='ignore'))
    return Group(*parts)


# -----------------------------------------------------------------------------
# The stability of a replayed clock.


def stability_table(stability: Facts) -> Table:
    """Return the deviations of the clock against the averaging time, with confidence bounds."""
    percent = f'{100.0 * stability["confidence"]:g} %'
    title = (
        f'stability from {stability["samples"]:,} readings, as deviations of the relative '
        f'frequency\n(1e-5 is 0.864 s/day), each followed by bounds of {percent} confidence,\n'
        'in per cent below and above it'
    )
    table = _table(title, 'τ, s', 'Allan', 'modified', 'Hadamard', 'noise', pad=1)
    for row in stability['rows']:
        deviations = []
        for kind in ('allan', 'modified', 'hadamard'):
            value, low, high = row[kind], row[f'{kind}_low'], row[f'{kind}_high']
            if not value:
                deviations.append('0')
                continue
            below, above = 100.0 * (1.0 - low / value), 100.0 * (high / value - 1.0)
            deviations.append(f'{value:.1e} −{below:.0f} +{above:.0f}')
        table.add_row(f'{row["tau_s"]:g}', *deviations, row['noise'])
    return table


# -----------------------------------------------------------------------------
# The weather of a scene.

ROWS = 24
"""Largest number of rows of a table. More states share rows."""


def weather_words(weather: Mapping[str, Any]) -> str:
    """Return a ship's weather (`ship.motions.sea.weather_metadata`) as a line of text."""
    bridged = weather.get('gaps_bridged')
    return (
        f'{weather.get("source", weather["kind"])}, {len(weather["states"])} states, Hs '
        f'{weather["median_m"]:.3g} m in the median, {weather["highest_m"]:.3g} m at most, '
        f'seed {weather["seed"]}; {weather["seas_at_once"]:.3g} seas summed at once'
        + (f'; {bridged} gaps bridged' if bridged else '')
    )


def weather_table(weather: Mapping[str, Any]) -> Table:
    """Return the states as a table, if they are many as ranges."""
    states = weather['states']
    together = math.ceil(len(states) / ROWS)
    title = 'weather' if together == 1 else f'weather, {together} states a row'
    caption = 'heading: direction the waves run to, from the bow to port; 0 following'
    heads = 'from day', 'Hs, m', 'Tp, s', 'heading, °', 'speed, m/s'
    table = _table(title, *heads, caption=caption, pad=1)
    for begin in range(0, len(states), together):
        row = states[begin : begin + together]
        headings = (state['heading_rad'] for state in row)
        table.add_row(
            f'{row[0]["at_s"] / DAY_S:.2f}',
            _range([state['significant_wave_height_m'] for state in row], 2),
            _range([state['peak_period_s'] for state in row], 1),
            # −180° to 180°: following seas are about 0
            _range(
                [
                    None if angle is None else math.degrees(math.remainder(angle, math.tau))
                    for angle in headings
                ],
                0,
            ),
            _range([state['speed_m_s'] for state in row], 2),
        )
    return table


def _range(values: Sequence[float | None], decimals: int) -> str:
    """Return the range of the known values, a dash for a calm."""
    sizes = [value for value in values if value is not None]
    if not sizes:
        return '–'
    low, high = (printed(value, f'z.{decimals}f') for value in (min(sizes), max(sizes)))
    return low if low == high else f'{low} to {high}'


# -----------------------------------------------------------------------------
# The facts of `tauto scene check`: the propagator, its cost and a bound of its error.


def facts_table(facts: dict[str, Any]) -> RenderableType:
    """Return the facts of a scene as a table, and its weather as another."""
    table = WholeTable(
        title=f'{facts["scene"]}: can sail',
        title_justify='left',
        show_header=False,
        box=box.SQUARE,
    )
    table.add_column()
    table.add_column(overflow='fold')
    for row in _scene_rows(facts):
        table.add_row(*row)
    table.add_section()
    expected = facts['expected']
    table.add_row('propagator', f'{facts["propagator"]}: {facts["reason"]}')
    if expected['steps_a_swing'] is not None:
        steps, tolerance = expected['steps_a_swing'], expected['tolerance']
        table.add_row('steps', f'{steps:.3g} a swing, each to {tolerance:g} of the swing')
    if expected['accuracy'] is not None:
        table.add_row('accuracy asked', f'{expected["accuracy"]:g} s a day')
    absent = [effect for effect in facts['left_out'] if effect['key']]
    table.add_row('not in this scene', '\n'.join(map(_left_out_words, absent)))
    never = [effect for effect in facts['left_out'] if not effect['key']]
    table.add_row('not simulated', '\n'.join(map(_left_out_words, never)))
    run = span(expected['run_s'], digits=1)
    machine = expected['measured_on']
    table.add_row(
        'expected run time', f'roughly {run} after the start, without a bag, on {machine}'
    )
    table.add_row('expected error', '\n'.join(_error_lines(facts)))
    table.add_section()
    return Group(table, weather_table(facts['weather'])) if 'weather' in facts else table


def _regulator_rows(facts: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the regulator, with curve, support or cam, and its release."""
    if 'curve' in facts:
        start, end = facts['curve_range_m']
        begins = 'no end' if start is None else f'{printed(start, ".4g")} m'
        yield 'curve', f'{facts["curve"]}, {begins} to {end:.4g} m of arc'
        yield 'released at', f'{printed(facts["release_arc_m"], "g")} m of arc'
    elif 'support' in facts:
        lengths = ' and '.join(f'{length:.4g} m' for length in facts['lengths_m'])
        yield 'support', f'{facts["support"]}, {facts["contact"]}; small swings as of {lengths}'
        yield 'released at', f'{printed(facts["release_tilt_rad"], "g")} rad in the ship'
    else:
        edge = facts['cam_range_rad']
        reach = 'at any angle' if edge is None else f'±{edge:.4g} rad'
        yield 'cam', f'{facts["cam"]}, {reach}'
        yield 'released at', f'{printed(facts["release_angle_rad"], "g")} rad in the case'


def _thread_rows(facts: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield whether the thread can be taken as ideal, and how often it goes slack."""
    if hanging := facts['thread']:
        low, high = hanging['fair_lengths_m']
        until = '' if high is None else f' and much shorter than {high:.3g} m (waves)'
        fair = f'much longer than {low:.3g} m (wheel){until}'
        if hanging['swings_in_s'] is None:
            yield 'thread', f'ideal, which is valid if it is {fair}'
        else:
            text = f'{hanging["length_m"]:g} m, natural period {hanging["swings_in_s"]:.4g} s'
            yield 'thread', f'{text}{_departs(hanging)}; an ideal thread is {fair}'
    if slack := facts.get('slack'):
        often = slack['times_a_day']
        # less than once in a hundred such voyages in that sea
        seldom = often * facts['duration_s'] < 0.01 * DAY_S
        rate = 'not expected' if seldom else f'about {often:.3g} times a day'
        yield (
            'slack thread',
            f'{rate} in the highest sea, with a vertical acceleration of '
            f'{slack["acceleration_m_s2"]:.2g} m/s² rms',
        )


def _scene_rows(facts: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the rows of ship, sea, route and clock."""
    yield 'duration', span(facts['duration_s'])
    step, interval = facts['motion_step_s'], facts['log_interval_s']
    yield 'ship', f'{facts["ship"]}: {facts["motion_samples"]:,} samples, one every {step:g} s'
    if 'sea' in facts:
        of = facts['sea']
        heading = printed(math.degrees(of['heading_rad']), '.4g')
        yield (
            'sea',
            f'{of.get("source", of["spectrum"])}, Hs {of["significant_wave_height_m"]:.3g} m, '
            f'Tp {of["peak_period_s"]:.3g} s, seed {of["seed"]}; waves {heading}° off following, '
            f'speed {of["speed_m_s"]:g} m/s',
        )
    if 'weather' in facts:
        yield 'weather', weather_words(facts['weather'])
    sea = facts.get('sea') or facts.get('weather') or {}
    if 'hull' in sea:
        yield 'hull', sea['hull']
    elif sea.get('heave') and 'operator' not in sea:
        yield 'hull', 'none: it heaves with the waves, and their sideways half is left out'
    if hung := facts['suspension']:
        periods = ' and '.join(f'{period:.4g} s' for period in hung['periods_s'])
        angles = 'any angles' if hung['large_angles'] else 'small angles'
        yield (
            'suspension',
            f'{hung["kind"]}, {angles}: the case swings in {periods}, '
            f'sampled every {hung["step_s"]:g} s{_departs(hung)}',
        )
    yield from _thread_rows(facts)
    if way := facts['voyage']:
        under_way, times = way['arrives_at_s'] - way['sails_at_s'], way['landfalls_s']
        landfalls = ', '.join(span(time) for time in times)
        suffix = ', beyond the end' if times[-1:] > [facts['duration_s'] + 1e-3] else ''
        parts = [f'landfall{"s" * (len(times) > 1)} after {landfalls}{suffix}'] if times else []
        parts += [f'ends {way["ends"]}'] if 'ends' in way else []
        yield (
            'voyage',
            f'{way["track"]} of {way["length_m"] / 1852.0:,.1f} nmi in {span(under_way)}, '
            f'{significant(way["speed_m_s"])} m/s, {"; ".join(parts)}',
        )
    if air := facts.get('air'):
        yield (
            'air',
            f'{air["lowest_celsius"]:.1f} to {air["highest_celsius"]:.1f} °C in the box of the '
            f'clock, which follows the air in {air["box_hours"]:g} h',
        )
    word = 'with' if facts['motion_kept'] else 'without'
    logged = facts['logged_samples']
    yield 'log', f'{logged:,} samples, one every {interval:g} s, {word} the motion'
    small_s = facts['small_period_s']
    yield (
        'period of small swings',
        'none: the smaller, the longer' if small_s is None else f'{small_s:.9f} s',
    )
    yield 'nominal period', f'{facts["nominal_period_s"]:.9f} s'
    yield from _regulator_rows(facts)
    if swing := facts['steady_swing']:
        yield 'steady swing, on land', _swing_words(swing)
    for name, entry in facts.get('covariates', {}).items():
        value = with_sigma(entry['value'], entry['sigma'], signed=False)
        # to 1e-4, a fiftieth of the smallest standard deviation
        trials = (
            ', '.join(
                f'{printed(round(k, 4), "zg")} in waves of {float(period):g} s'
                for period, k in (entry.get('at_periods') or {}).items()
            )
            or ', '.join(
                f'{printed(round(k, 4), "zg")} in gravity of {100.0 * float(change):+g} %'
                for change, k in (entry.get('at_changes') or {}).items()
            )
            or ', '.join(
                f'{printed(k, ".4g")} over {float(change):+.3g} K'
                for change, k in (entry.get('at_kelvin') or {}).items()
            )
        )
        source = f'from trial runs: {trials}' if trials else 'from the scene'
        yield f'coefficient of {name}', f'{value}, {source}'


def _left_out_words(row: Facts) -> str:
    """Return an omitted effect as a sentence, after the key that includes it."""
    why = row['why'] if row['worth'] is None else f'{row["why"][:-1]} ({row["worth"]}).'
    return f'{row["key"] or row["what"]}: {why}'


def _swing_words(swing: dict[str, Any]) -> str:
    if 'why' in swing:
        return f'none: {swing["why"]}'
    rate = figure(swing['rate_s_per_day'], 's/day', signed=True)
    text = f'{swing["amplitude_rad"]:.4g} rad, rate {rate} s/day'
    if swing['time_constant_s'] is None:
        return text
    # a small part of the rate: shown by itself
    kept_up = swing['rate_s_per_day'] - swing['free_rate_s_per_day']
    return (
        f'{text} ({figure(kept_up, "s/day", signed=True)} of it by drag and escapement); a '
        f'departure falls e-fold in {span(swing["time_constant_s"])}'
    )


def _departs(hung: dict[str, Any]) -> str:
    if hung['departure'] is None:
        return ''
    return (
        f'; departs from the apparent vertical by {1e3 * hung["departure_rad"]:.2g} mrad rms, '
        f'{hung["departure"]:.2g} of its tilt'
    )


# propagators without trial runs, and why
_UNTRIED = {'axle': 'a body on an axle is not tried at finer steps of the ship'}


def _error_lines(facts: dict[str, Any]) -> list[str]:
    """Return the bound of the simulation's error and its parts, one line each."""
    expected = facts['expected']
    error, tried, growth = expected['error_s'], expected['tried_s'], expected['growth']
    until = expected['bounded_until_s']
    partly = tried is not None and tried < facts['duration_s']
    if error is not None:
        lines = [f'at most {error:.1g} s of the reading']
        if partly:
            lines[0] += f', extrapolated from {span(tried, digits=2)}'
        if error > LEGIBLE * facts['nominal_period_s']:
            lines.append('the dial at the end cannot be predicted')
    elif until is not None:
        lines = [f'cannot be bounded beyond {span(until, digits=2)}']
    elif expected['was_cut']:
        lines = ['not known: the trial runs cost too much']
    else:
        finer = 'the step of ship.rate has no divisor to try a finer one'
        lines = [f'not known: {_UNTRIED.get(facts["propagator"], finer)}']
    if expected['was_cut']:
        lines.append(
            f'trial runs ended after {expected["longest_trial_s"]:g} s of processor time, at '
            f'{span(tried, digits=2)} of the voyage'
        )
    if growth is not None and growth['is_chaotic']:
        low, high = (
            1.0 / max(growth['per_s'] + way * growth['per_s_sigma'], 1.0 / facts['duration_s'])
            for way in (1.0, -1.0)
        )
        lines.append(
            f'chaotic: a small difference grows e-fold in {span(low, digits=2)} to '
            f'{span(high, digits=2)}, measured over {span(growth["followed_s"], digits=2)}'
        )
    if until is not None:
        return lines
    sampling, shortest = expected['sampling_error_s'], expected['shortest_wave_s']
    if sampling is not None:
        waves = 'the motion' if shortest is None else f'waves down to {shortest:.3g} s'
        sea = expected['decided_by']
        in_sea = (
            ''
            if sea is None or sea['peak_period_s'] is None  # no weather, or a calm
            else f' in the sea {sea["why"]}, on day {sea["at_s"] / DAY_S:.2f}: Hs '
            f'{sea["significant_wave_height_m"]:.3g} m, Tp {sea["peak_period_s"]:.3g} s'
        )
        lines.append(f'{sampling:.1g} s from sampling {waves}{in_sea}')
    if facts['ship'] == 'recorded':
        lines.append('the motion is taken as measured')
    if expected['steps_error_s']:
        of = 'the period' if expected['steps_a_swing'] is None else 'the tolerance'
        lines.append(f'{expected["steps_error_s"]:.1g} s from {of}')
    return [*lines, f'{expected["rounding_error_s"]:.1g} s from rounding']


# -----------------------------------------------------------------------------
# Several clocks through the same sea, side by side.


def failures(result: Comparison) -> list[str]:
    """Return why clocks stopped: one line for each clock and case, at the first roll."""
    reasons: dict[tuple[str, str], str] = {}
    for row in result.rows:
        if row.stopped is not None:
            reasons.setdefault((row.clock, _case(row)), row.stopped.why)
    return [f'{clock}, {case}: {why}' for (clock, case), why in reasons.items()]


def comparison_table(result: Comparison) -> Table:
    """Return one line for each clock: rate, spread, error at the end, longitudes, prizes."""
    releases = ', '.join(f'{angle:g}' for angle in sorted({row.release for row in result.rows}))
    judged = any(row.prize_pounds is not None for row in result.rows)
    pays = 'pays nothing for a voyage of less than six weeks'
    prize = '£: prize by the Act of 1714' if judged else f'the Act of 1714 {pays}'
    caption = (
        'rate: mean of the run; spread: standard deviation of the rates over '
        f'{span(result.piece_s)} each; nmi: east of the truth, by the dial, and rated: corrected '
        f'for the rate observed in port, in the same sea; {prize}'
    )
    rolls = len({row.roll_deg for row in result.rows}) > 1
    columns = 'rate\ns/day', 'spread\ns/day', 'error\ns', 'dial\nnmi', 'rated\nnmi'
    pounds = ('dial\n£', 'rated\n£')[: 2 * judged]
    table = _table(
        f'{span(result.duration_s)} in the same sea, released at {releases} rad',
        *('clock', 'case', *['roll\n°'] * rolls, *columns, *pounds),
        caption=caption,
    )
    for row in result.rows:
        roll = [significant(row.roll_deg)] * rolls
        name = row.clock.removeprefix('clock_').replace('_', ' ')
        prizes = (row.raw_prize_pounds, row.prize_pounds)[: 2 * judged]
        table.add_row(
            name,
            _case(row),
            *roll,
            'stopped' if row.stopped else figure(row.rate_s_per_day, 's/day', signed=True),
            figure(row.rate_spread_s_per_day, 's/day'),
            figure(row.error_s, 's', signed=True),
            figure(row.raw_error_nmi, 'nmi', signed=True),
            figure(row.error_nmi, 'nmi', signed=True),
            *('–' if pounds is None else f'{pounds:,}' for pounds in prizes),
        )
    return table


def _case(row: Row) -> str:
    return 'hung' if row.suspended else 'fixed'


# -----------------------------------------------------------------------------
# The budget of a rate: its causes, its uncertainty, and the effect of small changes.


def budget_tables(facts: Facts) -> list[RenderableType]:
    """Return a budget (`Budget.facts`) as texts and tables."""
    total = figure(facts['whole']['rate_s_per_day'], 's/day', signed=True)
    causes = _table('', 'cause', 's/day', 'nmi at the end', 'found')
    rows = budget_rows(facts)
    for place, cells in enumerate(rows):
        causes.add_row(*cells, end_section=place == len(rows) - 4)
    parts: list[RenderableType] = [
        Text(f'{facts["scene"]}: why the rate is {total} s/day', style='italic'),
        causes,
        Text(f'{facts["sailed"]}.'),
    ]
    if facts['fixed_s_per_day'] is not None:
        fixed = figure(facts['fixed_s_per_day'], 's/day', signed=True)
        parts.append(Text(f'With its case fixed to the ship: {fixed} s/day.'))
    if facts['rough']:
        spread = figure(facts['rough_s_per_day'], 's/day')
        parts.append(Text(f'\nBadly known numbers leave an uncertainty of ± {spread} s/day:'))
        rough = _table('', 'key', 'from', 's/day', 'to', 's/day')
        for row in facts['rough']:
            unit = f' {row["unit"]}' if row['unit'] else ''
            rough.add_row(
                row['key'],
                f'{significant(row["least"])}{unit}',
                figure(row['least_s_per_day'], 's/day', signed=True),
                f'{significant(row["most"])}{unit}',
                figure(row['most_s_per_day'], 's/day', signed=True),
            )
        parts.append(rough)
    parts.append(Text('\nEffect of small changes, on land:'))
    worth = _table('', 'change', 's/day')
    for row in facts['worth']:
        worth.add_row(row['what'], figure(row['rate_s_per_day'], 's/day', signed=True))
    return [*parts, worth]


# -----------------------------------------------------------------------------
# A fleet: how often is the longitude found?

_CLOCKS = {'raw': 'dial', 'corrected': 'rated'}


def fleet_tables(result: Answers) -> list[Table]:
    """Return quantiles of the error, influences, and for a long voyage shares by the Act."""
    tables = []
    if prizes := result.within:
        limits = (f'{prize.limit_nmi:g} nmi' for prize in prizes['raw'])
        tables.append(_table('ships within', 'clock', *limits))
        for clock, label in _CLOCKS.items():
            shares = (
                f'{percent(prize.share)} ({percent(prize.low)}–{percent(prize.high)})'
                for prize in prizes[clock]
            )
            tables[-1].add_row(label, *shares)
    title = 'quantiles of the error of the longitude over the ships [nmi]'
    sizes = ((label, result.quantiles_nmi[clock]) for clock, label in _CLOCKS.items())
    tables.append(_quantiles(title, sizes))
    if result.influences:
        clocks = tuple(_CLOCKS.values())
        title = 'rank correlation with the error, and with its size'
        tables.append(_table(title, 'key', *clocks, *(f'{name}, size' for name in clocks)))
        for row in result.influences:
            ranks = (row.raw, row.corrected, row.raw_size, row.corrected_size)
            signed = ('–' if rank is None else printed(rank, '+z.2f') for rank in ranks)
            tables[-1].add_row(row.key, *signed)
    return tables


def _quantiles(title: str, rows: Iterable[tuple[str, Sequence[float | None] | None]]) -> Table:
    """Return the quantiles of the error of each clock, dashes if unknown."""
    from tauto_core.ensembles.answers import QUANTILES

    table = _table(title, 'clock', *map(percent, QUANTILES))
    for clock, sizes in rows:
        table.add_row(clock, *(figure(size, 'nmi') for size in sizes or [None] * len(QUANTILES)))
    return table


# -----------------------------------------------------------------------------
# Clocks on the passages of a log-book.

WAYS = {
    'raw': 'dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def trial_tables(answers: TrialAnswers) -> Iterator[Table]:
    """Yield the table of prizes, the quantiles, and the parts by season and by ocean."""
    several = len(answers.clocks) > 1
    rows = [(clock, way) for clock in answers.clocks for way in clock.ways]

    def called(clock: ClockAnswers, way: str) -> str:
        return f'{clock.clock}, {WAYS[way]}' if several else WAYS[way]

    if answers.judged:
        limits = [f'{prize.limit_nmi:g} nmi' for prize in answers.clocks[0].ways['raw'].prizes]
        table = _table('passages within (95 % confidence)', 'clock', *limits)
        for clock, way in rows:
            table.add_row(called(clock, way), *(prize.said for prize in clock.ways[way].prizes))
        yield table
    title = 'quantiles of the error over the passages [nmi]'
    sizes = ((called(clock, way), clock.ways[way].quantiles_nmi) for clock, way in rows)
    yield _quantiles(title, sizes)
    if answers.judged:
        for title, parts in (('season', 'seasons'), ('ocean', 'oceans')):
            yield _parts(answers, title, parts, called)


def _parts(answers: TrialAnswers, title: str, parts: str, called: Any) -> Table:
    table = _table('', title, 'clock', 'passages', '30 nmi', '40 nmi', '60 nmi', 'median, nmi')
    for clock in answers.clocks:
        for way in clock.ways:
            for part in getattr(clock.ways[way], parts):
                cells = [str(count) for count in (part.passages, *part.within)]
                median = figure(part.median_nmi, 'nmi')
                table.add_row(part.name, called(clock, way), *cells, median)
    return table


def trial_remarks(answers: TrialAnswers) -> Iterator[str]:
    """Yield voyages that ended early, and ends at sea."""
    from tauto_core.ship.coast import LANDFALL_KM

    for clock in answers.clocks:
        if clock.stopped:
            yield f'{clock.clock}: stopped on {counted(clock.stopped, "passage")}'
        for why, number in clock.failures.items():
            yield f'{clock.clock}: {counted(number, "passage")} failed: {why}'
    away = list(dict.fromkeys(row['passage'] for row in answers.voyages if row['ends']))
    if away:
        yield (
            f'the last entry of {counted(len(away), "passage")} is at sea, more than '
            f'{LANDFALL_KM:g} km from the coast, without a landfall: {", ".join(away[:5])}'
            + ', …'
            * (len(away) > 5)
        )


# -----------------------------------------------------------------------------
# A hull: its motions in waves, and its cost to a clock.


def hull_page(facts: Facts) -> RenderableType:
    """Return a hull as text: sizes, response amplitude operators, and rates."""
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
    heads = ('heading, °', 'heave, m', 'wave, s', 'roll, °', 'wave, s', 'pitch, °', 'wave, s')
    peaks = _table('largest motions, per metre of wave', *heads, pad=1)
    for operator in facts['operators']:
        at = {
            name: '–' if (period := operator[f'{name}_at_s']) is None else f'{period:.1f}'
            for name in ('heave', 'roll', 'pitch')
        }
        peaks.add_row(
            f'{math.degrees(operator["heading_rad"]):.0f}',
            *(f'{operator["heave_m_per_m"]:.2f}', at['heave']),
            *(f'{math.degrees(operator["roll_rad_per_m"]):.1f}', at['roll']),
            *(f'{math.degrees(operator["pitch_rad_per_m"]):.1f}', at['pitch']),
        )
    sea = facts['sea']
    height, period = sea['significant_wave_height_m'], sea['peak_period_s']
    table = _table(
        f'a weight in a Bretschneider sea of {height} m, {period:g} s: s/day',
        *('heading, °', 'forward, m', 'up, m', 'heave', 'athwart', 'fore and aft'),
        *('plane kept vertical', 'leaning freely', 'plane pitches with ship'),
        caption='heading: direction the waves run to, from the bow to port; 180 head seas',
        pad=1,
    )
    parts = ('heave', 'athwart', 'fore_and_aft', 'kept_vertical', 'leaning_freely', 'pitching')
    for rate in facts['rates_s_per_day']:
        table.add_row(
            f'{math.degrees(rate["heading_rad"]):.0f}',
            *(f'{rate["forward_m"]:.1f}', f'{rate["up_m"]:.1f}'),
            *(printed(rate[part], 'z.1f') for part in parts),
        )
    return Group(*map(Text, lines), Text(''), peaks, Text(''), table)
