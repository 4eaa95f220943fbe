"""Results as tables of text.

A table is never cut nor wrapped, since half a figure would be misread. On a narrow terminal its
lines go on below.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from operator import itemgetter
from shutil import get_terminal_size
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any, TypeAlias

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
    from tauto_core.ensembles.comparison import Comparison, Row
    from tauto_core.ensembles.fleets import Answers
    from tauto_core.ensembles.trials import TrialAnswers

# width of titles, remarks and of a narrow terminal
_WIDTH = 80

Columns: TypeAlias = 'Iterable[tuple[str, Callable[[Any], str]]]'
"""Headings, of one or several lines, and functions from a row to its cells."""


def aligned(rows: Iterable[Iterable[str]], first: str = '<') -> Iterator[str]:
    """Yield rows as lines, with figures in all columns but the first, aligned by `first`."""
    cells = list(map(tuple, rows))
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    formats = [f'{">" if place else first}{width}' for place, width in enumerate(widths)]
    for row in cells:
        yield '  '.join(map(format, row, formats)).rstrip()


def table(title: str, columns: Columns, rows: Iterable[Any], caption: str = '') -> str:
    """Return a table with its title, and a remark below it."""
    named = list(columns)
    words = [name.split('\n') for name, _ in named]
    depth = max(map(len, words))
    heads = zip(*([''] * (depth - len(lines)) + lines for lines in words), strict=True)
    body = ([cell(row) for _, cell in named] for row in rows)
    lines = list(aligned([*heads, *body]))
    rule = '─' * max(map(len, lines))
    parts = wrap(title, _WIDTH), lines[:depth], [rule], lines[depth:], wrap(caption, _WIDTH)
    return '\n'.join(line for part in parts for line in part)


def placed(*heads: str) -> Columns:
    """Return the columns of rows that are sequences of texts."""
    return [(head, itemgetter(place)) for place, head in enumerate(heads)]


def listed(rows: Iterable[tuple[str, str]]) -> str:
    """Return labels with texts, which are wrapped beside them."""
    pairs = list(rows)
    width = max(len(label) for label, _ in pairs) + 2
    room = max(get_terminal_size().columns - width, _WIDTH // 2)
    lines = []
    for label, text in pairs:
        parts = [part for line in text.split('\n') for part in wrap(line, room)]
        lines += [
            f'{head:{width}}{part}'.rstrip()
            for head, part in zip_longest([label], parts, fillvalue='')
        ]
    return '\n'.join(lines)


def paragraphs(parts: Iterable[str]) -> str:
    """Return tables, and sentences, which are wrapped, with blank lines between."""
    return '\n\n'.join(part if '\n' in part else fill(part, _WIDTH) for part in parts)


Facts = Mapping[str, Any]

# width of the longest label, at which a sentence without a figure is wrapped
_SENTENCE = 43


def voyage_table(result: Facts) -> str:
    """Return the result of a voyage as text: the answer, a table in groups, and the bag."""
    seconds, sections = result.get('duration_s'), dict(groups(result))
    rows = [row for section in sections.values() for row in section]
    width = max((len(label) for label, value, _ in rows if value), default=0)
    figures = max((len(value) for _, value, _ in rows), default=0)
    title = str(result.get('scene') or 'bag')
    lines = [title if seconds is None else f'{title}: {span(seconds)}']
    lines += [*wrap(answer(result), _WIDTH), '']
    for name, section in sections.items():
        lines.append(name)
        for label, value, unit in section:
            text = f'{label:{width}}  {value:>{figures}}  {unit}'.rstrip()
            lines += [f'  {part}' for part in ([text] if value else wrap(label, _SENTENCE))]
    lines += ['', *wrap(SIGNS, _WIDTH)]
    return '\n'.join([*lines, f'Bag: {result["bag"]}'] if result.get('bag') else lines)


# -----------------------------------------------------------------------------
# The stability of a replayed clock.


def stability_table(stability: Facts) -> str:
    """Return the deviations of the clock against the averaging time, with confidence bounds."""

    def deviation(row: Facts, kind: str) -> str:
        value, low, high = row[kind], row[f'{kind}_low'], row[f'{kind}_high']
        if not value:
            return '0'
        return (
            f'{value:.1e} −{100.0 * (1.0 - low / value):.0f} +{100.0 * (high / value - 1.0):.0f}'
        )

    return table(
        f'stability from {stability["samples"]:,} readings, as deviations of the relative '
        'frequency (1e-5 is 0.864 s/day), each followed by bounds of '
        f'{100.0 * stability["confidence"]:g} % confidence, in per cent below and above it',
        [
            ('τ, s', lambda row: f'{row["tau_s"]:g}'),
            ('Allan', lambda row: deviation(row, 'allan')),
            ('modified', lambda row: deviation(row, 'modified')),
            ('Hadamard', lambda row: deviation(row, 'hadamard')),
            ('noise', lambda row: row['noise']),
        ],
        stability['rows'],
    )


# -----------------------------------------------------------------------------
# The weather of a scene.

ROWS = 24
"""Largest number of rows of a table. More states share rows."""


def weather_words(weather: Mapping[str, Any]) -> str:
    """Return a ship's weather (`ship.motions.sea.SeaShip.metadata`) as a line of text."""
    bridged = weather.get('gaps_bridged')
    return (
        f'{weather.get("source", weather["kind"])}, {len(weather["states"])} states, Hs '
        f'{weather["median_m"]:.3g} m in the median, {weather["highest_m"]:.3g} m at most, '
        f'seed {weather["seed"]}; {weather["seas_at_once"]:.3g} seas summed at once'
        + (f'; {bridged} gaps bridged' if bridged else '')
    )


def weather_table(weather: Mapping[str, Any]) -> str:
    """Return the states as a table, if they are many as ranges."""
    states = weather['states']
    together = math.ceil(len(states) / ROWS)
    return table(
        'weather' if together == 1 else f'weather, {together} states a row',
        [
            ('from day', lambda row: f'{row[0]["at_s"] / DAY_S:.2f}'),
            ('Hs, m', lambda row: _range(row, 'significant_wave_height_m', 2)),
            ('Tp, s', lambda row: _range(row, 'peak_period_s', 1)),
            ('heading, °', lambda row: _range(row, 'heading_rad', 0)),
            ('speed, m/s', lambda row: _range(row, 'speed_m_s', 2)),
        ],
        [states[begin : begin + together] for begin in range(0, len(states), together)],
        'heading: direction the waves run to, from the bow to port; 0 following',
    )


def _range(states: Sequence[Facts], key: str, decimals: int) -> str:
    """Return the range of the known values of some states, a dash for a calm."""
    sizes = [state[key] for state in states if state[key] is not None]
    if key == 'heading_rad':  # −180° to 180°: following seas are about 0
        sizes = [math.degrees(math.remainder(size, math.tau)) for size in sizes]
    if not sizes:
        return '–'
    low, high = (printed(value, f'z.{decimals}f') for value in (min(sizes), max(sizes)))
    return low if low == high else f'{low} to {high}'


# -----------------------------------------------------------------------------
# The facts of `tauto scene check`: the propagator, its cost and a bound of its error.


def facts_table(facts: dict[str, Any]) -> str:
    """Return the facts of a scene as a table, and its weather as another."""
    expected = facts['expected']
    steps, tolerance = expected['steps_a_swing'], expected['tolerance']
    absent, never = (
        '\n'.join(_left_out_words(row) for row in facts['left_out'] if bool(row['key']) is has_key)
        for has_key in (True, False)
    )
    rows = [
        *_scene_rows(facts),
        ('', ''),
        ('propagator', f'{facts["propagator"]}: {facts["reason"]}'),
        ('steps', steps and f'{steps:.3g} a swing, each to {tolerance:g} of the swing'),
        ('accuracy asked', expected['accuracy'] and f'{expected["accuracy"]:g} s a day'),
        ('not in this scene', absent),
        ('not simulated', never),
        (
            'expected run time',
            f'roughly {span(expected["run_s"], digits=1)} after the start, without a bag, on '
            f'{expected["measured_on"]}',
        ),
        ('expected error', '\n'.join(_error_lines(facts))),
    ]
    table = listed((label, text) for label, text in rows if text is not None)
    weather = ['', weather_table(facts['weather'])] if 'weather' in facts else []
    return '\n'.join([f'{facts["scene"]}: can sail', '', table, *weather])


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
        tried = any(key.startswith('at_') and value for key, value in entry.items())
        yield f'coefficient of {name}', f'{value}, from {"trial runs" if tried else "the scene"}'


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


def comparison_table(result: Comparison) -> str:
    """Return one line for each clock: rate, spread, error at the end, longitudes, prizes."""
    releases = ', '.join(f'{angle:g}' for angle in sorted({row.release for row in result.rows}))
    judged = any(row.prize_pounds is not None for row in result.rows)
    rolls = len({row.roll_deg for row in result.rows}) > 1

    def pounds(prize: int | None) -> str:
        return '–' if prize is None else f'{prize:,}'

    columns: list[tuple[str, Callable[[Row], str]]] = [
        ('clock', lambda row: row.clock.removeprefix('clock_').replace('_', ' ')),
        ('case', _case),
        *([('roll\n°', lambda row: significant(row.roll_deg))] if rolls else []),
        (
            'rate\ns/day',
            lambda row: (
                'stopped' if row.stopped else figure(row.rate_s_per_day, 's/day', signed=True)
            ),
        ),
        ('spread\ns/day', lambda row: figure(row.rate_spread_s_per_day, 's/day')),
        ('error\ns', lambda row: figure(row.error_s, 's', signed=True)),
        ('dial\nnmi', lambda row: figure(row.raw_error_nmi, 'nmi', signed=True)),
        ('rated\nnmi', lambda row: figure(row.error_nmi, 'nmi', signed=True)),
        ('dial\n£', lambda row: pounds(row.raw_prize_pounds)),
        ('rated\n£', lambda row: pounds(row.prize_pounds)),
    ]
    pays = 'pays nothing for a voyage of less than six weeks'
    prize = '£: prize by the Act of 1714' if judged else f'the Act of 1714 {pays}'
    return table(
        f'{span(result.duration_s)} in the same sea, released at {releases} rad',
        columns if judged else columns[:-2],
        result.rows,
        'rate: mean of the run; spread: standard deviation of the rates over '
        f'{span(result.piece_s)} each; nmi: east of the truth, by the dial, and rated: corrected '
        f'for the rate observed in port, in the same sea; {prize}',
    )


def _case(row: Row) -> str:
    return 'hung' if row.suspended else 'fixed'


# -----------------------------------------------------------------------------
# The budget of a rate: its causes, its uncertainty, and the effect of small changes.


def budget_text(facts: Facts) -> str:
    """Return a budget (`Budget.facts`) as texts and tables."""

    def rate(value: float) -> str:
        return figure(value, 's/day', signed=True)

    heads = placed('cause', 's/day', 'nmi at the end', 'found')
    total = rate(facts['whole']['rate_s_per_day'])
    causes = table(f'{facts["scene"]}: why the rate is {total} s/day', heads, budget_rows(facts))
    parts = [causes, f'{facts["sailed"]}.']
    if facts['fixed_s_per_day'] is not None:
        parts.append(f'With its case fixed to the ship: {rate(facts["fixed_s_per_day"])} s/day.')
    if facts['rough']:
        spread = figure(facts['rough_s_per_day'], 's/day')
        rough: Columns = [
            ('key', lambda row: row['key']),
            ('from', lambda row: f'{significant(row["least"])} {row["unit"]}'.strip()),
            ('s/day', lambda row: rate(row['least_s_per_day'])),
            ('to', lambda row: f'{significant(row["most"])} {row["unit"]}'.strip()),
            ('s/day', lambda row: rate(row['most_s_per_day'])),
        ]
        title = f'Badly known numbers leave an uncertainty of ± {spread} s/day:'
        parts.append(table(title, rough, facts['rough']))
    worth = ('change', lambda row: row['what']), ('s/day', lambda row: rate(row['rate_s_per_day']))
    parts.append(table('Effect of small changes, on land:', worth, facts['worth']))
    return paragraphs(parts)


# -----------------------------------------------------------------------------
# A fleet: how often is the longitude found?

_CLOCKS = {'raw': 'dial', 'corrected': 'rated'}


def fleet_tables(result: Answers) -> list[str]:
    """Return quantiles of the error, influences, and for a long voyage shares by the Act."""
    tables = []
    if prizes := result.within:
        limits = [f'{prize.limit_nmi:g} nmi' for prize in prizes['raw']]
        shares = (
            (label, *(prize.said for prize in prizes[clock])) for clock, label in _CLOCKS.items()
        )
        tables.append(table('ships within', placed('clock', *limits), shares))
    title = 'quantiles of the error of the longitude over the ships [nmi]'
    sizes = ((label, result.quantiles_nmi[clock]) for clock, label in _CLOCKS.items())
    tables.append(_quantiles(title, sizes))
    if result.influences:
        ranks = (
            (row.key, *map(_rank, (row.raw, row.corrected, row.raw_size, row.corrected_size)))
            for row in result.influences
        )
        clocks = _CLOCKS.values()
        heads = placed('key', *clocks, *(f'{name}, size' for name in clocks))
        tables.append(table('rank correlation with the error, and with its size', heads, ranks))
    return tables


def _rank(rank: float | None) -> str:
    return '–' if rank is None else printed(rank, '+z.2f')


def _miles(size: float | None) -> str:
    return figure(size, 'nmi')


def _quantiles(title: str, rows: Iterable[tuple[str, Sequence[float | None] | None]]) -> str:
    """Return the quantiles of the error of each clock, dashes if unknown."""
    from tauto_core.ensembles.rows import QUANTILES

    cells = ((clock, *map(_miles, sizes or [None] * len(QUANTILES))) for clock, sizes in rows)
    return table(title, placed('clock', *map(percent, QUANTILES)), cells)


# -----------------------------------------------------------------------------
# Clocks on the passages of a log-book.

WAYS = {
    'raw': 'dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def trial_tables(answers: TrialAnswers) -> Iterator[str]:
    """Yield the table of prizes, the quantiles, and the parts by season and by ocean."""
    several = len(answers.clocks) > 1
    rows = [
        (f'{clock.clock}, {WAYS[way]}' if several else WAYS[way], result)
        for clock in answers.clocks
        for way, result in clock.ways.items()
    ]
    if answers.judged:
        limits = (f'{prize.limit_nmi:g} nmi' for prize in answers.clocks[0].ways['raw'].prizes)
        shares = ((label, *(prize.said for prize in result.prizes)) for label, result in rows)
        yield table('passages within (95 % confidence)', placed('clock', *limits), shares)
    title = 'quantiles of the error over the passages [nmi]'
    yield _quantiles(title, ((label, result.quantiles_nmi) for label, result in rows))
    for title, parts in (('season', 'seasons'), ('ocean', 'oceans')) if answers.judged else ():
        heads = placed(title, 'clock', 'passages', '30 nmi', '40 nmi', '60 nmi', 'median, nmi')
        cells = (
            (part.name, label, *map(str, (part.passages, *part.within)), _miles(part.median_nmi))
            for label, result in rows
            for part in getattr(result, parts)
        )
        yield table('', heads, cells)


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


def hull_text(facts: Facts) -> str:
    """Return a hull as text: sizes, response amplitude operators, and rates."""
    hull, ship, sea = facts['hull'], facts['ship'], facts['sea']
    lines = [
        f'{hull["name"]}: {hull["length_m"]:.3g} by {hull["beam_m"]:.3g} by '
        f'{hull["draught_m"]:.3g} m, {hull["volume_m3"]:.4g} m3, block coefficient '
        f'{hull["block_coefficient"]:.2f}',
        f'{hull["source"]}; damping and exciting forces agree within '
        f'{100.0 * hull["damping_off_by"]:.2g} %',
        f'rolls in {ship["roll_period_s"]:.3g} s, damping {ship["roll_damping_ratio"]:g}: '
        f'metacentric height {ship["metacentric_height_m"]:.2g} m, centre of gravity '
        f'{printed(ship["centre_of_gravity_m"], "+.2g")} m from the waterline; '
        f'{ship["speed_m_s"]:g} m/s',
    ]

    def degrees(row: Facts, key: str) -> str:
        return f'{math.degrees(row[key]):.{0 if key == "heading_rad" else 1}f}'

    def period(row: Facts, name: str) -> str:
        return '–' if row[f'{name}_at_s'] is None else f'{row[f"{name}_at_s"]:.1f}'

    peaks = table(
        'largest motions, per metre of wave',
        [
            ('heading, °', lambda row: degrees(row, 'heading_rad')),
            ('heave, m', lambda row: f'{row["heave_m_per_m"]:.2f}'),
            ('wave, s', lambda row: period(row, 'heave')),
            ('roll, °', lambda row: degrees(row, 'roll_rad_per_m')),
            ('wave, s', lambda row: period(row, 'roll')),
            ('pitch, °', lambda row: degrees(row, 'pitch_rad_per_m')),
            ('wave, s', lambda row: period(row, 'pitch')),
        ],
        facts['operators'],
    )
    parts = {
        'forward, m': 'forward_m',
        'up, m': 'up_m',
        'heave': 'heave',
        'athwart': 'athwart',
        'fore\nand aft': 'fore_and_aft',
        'plane kept\nvertical': 'kept_vertical',
        'leaning\nfreely': 'leaning_freely',
        'plane pitches\nwith ship': 'pitching',
    }
    height, peak = sea['significant_wave_height_m'], sea['peak_period_s']
    rates = table(
        f'a weight in a Bretschneider sea of {height} m, {peak:g} s: s/day',
        placed('heading, °', *parts),
        (
            (degrees(row, 'heading_rad'), *(printed(row[key], 'z.1f') for key in parts.values()))
            for row in facts['rates_s_per_day']
        ),
        'heading: direction the waves run to, from the bow to port; 180 head seas',
    )
    return '\n'.join([*lines, '', peaks, '', rates])
