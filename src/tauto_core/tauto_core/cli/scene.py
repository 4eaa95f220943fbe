"""`tauto scenes`, `tauto scene …`: what ships, what one would run, one to start from."""

from __future__ import annotations

import shlex
from importlib.resources import files
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand, TyperOption

from tauto_core.cli.terminal import say
from tauto_core.scene.times import DAY_S, LEGIBLE
from tauto_core.wording import figure, printed, significant, span, with_sigma

if TYPE_CHECKING:
    from rich.console import RenderableType


# -----------------------------------------------------------------------------
# `tauto scenes` and `tauto scene check` in words: what ships, and what a scene would run.


def shipped_summary(name: str) -> str:
    """Return the description of a shipped scene: its first comment, up to the colon."""
    text = (files('tauto_core.scene') / 'shipped' / f'{name}.yaml').read_text(encoding='utf-8')
    lines = []
    for line in text.splitlines():
        if not line.startswith('#'):
            break
        lines.append(line.lstrip('# '))
    return ' '.join(lines).partition(':')[0]


def facts_table(facts: dict[str, Any]) -> RenderableType:
    """Return the facts of a scene as a table, and its weather as another."""
    from rich import box
    from rich.console import Group

    from tauto_core.cli.tables import WholeTable

    table = WholeTable(
        title=f'{facts["scene"]}: can sail',
        title_justify='left',
        show_header=False,
        box=box.SQUARE,
    )
    table.add_column()
    table.add_column(overflow='fold')
    for section in (_scene_rows(facts), _running_rows(facts)):
        for row in section:
            table.add_row(*row)
        table.add_section()
    if 'weather' not in facts:
        return table
    from tauto_core.cli.tables import weather_table

    return Group(table, weather_table(facts['weather']))


def _scene_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    from tauto_core.cli.tables import sea_words, weather_words

    kept = 'with' if facts['motion_kept'] else 'without'
    step, interval = facts['motion_step_s'], facts['log_interval_s']
    return [
        ('duration', span(facts['duration_s'])),
        (
            'ship',
            f'{facts["ship"]}: {facts["motion_samples"]:,} samples, one every {step:g} s',
        ),
        *([('sea', sea_words(facts['sea']))] if 'sea' in facts else []),
        *([('weather', weather_words(facts['weather']))] if 'weather' in facts else []),
        *_suspension_row(facts['suspension']),
        *_thread_row(facts['thread']),
        *_voyage_row(facts['voyage']),
        (
            'log',
            f'{facts["logged_samples"]:,} samples, one every {interval:g} s, {kept} the motion',
        ),
        ('period of small swings', f'{facts["small_period_s"]:.9f} s'),
        ('nominal period', f'{facts["nominal_period_s"]:.9f} s'),
        *_regulator_rows(facts),
        *_swing_row(facts['steady_swing']),
        *_covariate_rows(facts.get('covariates', {})),
    ]


def _covariate_rows(covariates: dict[str, dict[str, Any]]) -> list[tuple[str, str]]:
    rows = []
    for name, found in covariates.items():
        said = with_sigma(found['value'], found['sigma'], signed=False)
        if found['at_periods'] is None:
            said += ', as the scene says'
        else:
            each = (
                f'{_short(k)} in waves of {float(period):g} s'
                for period, k in found['at_periods'].items()
            )
            said += f', from trial runs: {", ".join(each)}'
        rows.append((f'coefficient of {name}', said))
    return rows


def _short(coefficient: float) -> str:
    """Return a coefficient rounded to 1e-4, a fiftieth of the least standard deviation."""
    return printed(round(coefficient, 4), 'zg')


def _swing_row(swing: dict[str, Any] | None) -> list[tuple[str, str]]:
    if swing is None:
        return []
    if 'why' in swing:
        return [('steady swing, on land', f'none: {swing["why"]}')]
    rate = figure(swing['rate_s_per_day'], 's/day', signed=True)
    said = f'{swing["amplitude_rad"]:.4g} rad, rate {rate} s/day'
    if swing['time_constant_s'] is not None:
        # next to the rate of a free swing as wide this would be lost in its last digits
        kept_up = swing['rate_s_per_day'] - swing['free_rate_s_per_day']
        said += (
            f' ({figure(kept_up, "s/day", signed=True)} of it by drag and escapement); a '
            f'departure falls e-fold in {span(swing["time_constant_s"])}'
        )
    return [('steady swing, on land', said)]


def _regulator_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    if 'curve' in facts:
        low, high = facts['curve_range_m']
        start = 'no end' if low is None else f'{printed(low, ".4g")} m'
        return [
            ('curve', f'{facts["curve"]}, {start} to {high:.4g} m of arc'),
            ('released at', f'{printed(facts["release_arc_m"], "g")} m of arc'),
        ]
    edge = facts['cam_range_rad']
    return [
        ('cam', f'{facts["cam"]}, ' + ('at any angle' if edge is None else f'±{edge:.4g} rad')),
        ('released at', f'{printed(facts["release_angle_rad"], "g")} rad in the case'),
    ]


def _suspension_row(hung: dict[str, Any] | None) -> list[tuple[str, str]]:
    if hung is None:
        return []
    slow, fast = hung['periods_s']
    angles = 'any angles' if hung['large_angles'] else 'small angles'
    return [
        (
            'suspension',
            f'{hung["kind"]}, {angles}: the case swings in {slow:.4g} s and {fast:.4g} s, '
            f'sampled every {hung["step_s"]:g} s' + _departs(hung),
        )
    ]


def _thread_row(hanging: dict[str, Any] | None) -> list[tuple[str, str]]:
    if hanging is None:
        return []
    low, high = hanging['fair_lengths_m']
    until = '' if high is None else f' and much shorter than {high:.3g} m (waves)'
    fair = f'much longer than {low:.3g} m (wheel){until}'
    if hanging['swings_in_s'] is None:
        return [('thread', f'ideal, as is fair of one {fair}')]
    own = f'{hanging["length_m"]:g} m, swings by itself in {hanging["swings_in_s"]:.4g} s'
    return [('thread', f'{own}{_departs(hanging)}; to take it for ideal it should be {fair}')]


def _departs(hung: dict[str, Any]) -> str:
    if hung['departure'] is None:
        return ''
    return (
        f'; departs from the apparent vertical by {1e3 * hung["departure_rad"]:.2g} mrad rms, '
        f'{hung["departure"]:.2g} of its tilt'
    )


def _voyage_row(way: dict[str, Any] | None) -> list[tuple[str, str]]:
    if way is None:
        return []
    under_way, times = way['arrives_at_s'] - way['sails_at_s'], way['landfalls_s']
    landfalls = ', '.join(span(time) for time in times)
    speed = significant(way['speed_m_s'])
    return [
        (
            'voyage',
            f'{way["track"]} of {way["length_m"] / 1852.0:,.1f} nmi in {span(under_way)}, '
            f'{speed} m/s, landfall{"s" * (len(times) > 1)} after {landfalls}',
        )
    ]


def _running_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    expected = facts['expected']
    run = span(expected['run_s'], digits=1)
    rows = [('propagator', f'{facts["propagator"]}: {facts["reason"]}')]
    if expected['steps_a_swing'] is not None:
        rows.append(
            (
                'steps',
                f'{expected["steps_a_swing"]:.3g} a swing, each to {expected["tolerance"]:g} of '
                'the swing',
            )
        )
    return [
        *rows,
        ('left out', ', '.join(facts['left_out'])),
        (
            'expected run time',
            f'roughly {run} without a bag, on {expected["measured_on"]}',
        ),
        ('expected error', '\n'.join(_error_lines(facts))),
    ]


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
            lines.append('what the dial shows at the end cannot be predicted')
    elif until is not None:
        lines = [f'cannot be bounded beyond {span(until, digits=2)}']
    elif expected['was_cut']:
        lines = ['not known: the trial runs cost too much']
    else:
        lines = ['not known: the step of ship.rate has no divisor to try a finer one']
    if expected['was_cut']:
        lines.append(
            f'trial runs were cut after {expected["longest_trial_s"]:g} s of processor time; '
            f'they tried {span(tried, digits=2)}, and no more could be'
        )
    if growth is not None and growth['is_chaotic']:
        low, high = (
            1.0 / max(growth['per_s'] + way * growth['per_s_sigma'], 1.0 / facts['duration_s'])
            for way in (1.0, -1.0)
        )
        lines.append(
            f'chaotic: a small difference grows e-fold in {span(low, digits=2)} to '
            f'{span(high, digits=2)}, found over {span(growth["followed_s"], digits=2)}'
        )
    if until is not None:
        return lines
    sampling, shortest = expected['sampling_error_s'], expected['shortest_wave_s']
    if sampling is not None:
        waves = 'the motion' if shortest is None else f'waves down to {shortest:.3g} s'
        lines.append(f'{sampling:.1g} s from sampling {waves}{_decided_by(expected)}')
    if facts['ship'] == 'recorded':
        lines.append('the motion is taken as measured')
    if expected['steps_error_s']:
        of = 'the period' if expected['steps_a_swing'] is None else 'the tolerance'
        lines.append(f'{expected["steps_error_s"]:.1g} s from {of}')
    return [*lines, f'{expected["rounding_error_s"]:.1g} s from rounding']


def _decided_by(expected: dict[str, Any]) -> str:
    """Return which sea of a weather decides the bound; '' without weather, or in a calm."""
    sea = expected['decided_by']
    if sea is None or sea['peak_period_s'] is None:
        return ''
    return (
        f' in the sea {sea["why"]}, that of day {sea["at_s"] / DAY_S:.2f}: Hs '
        f'{sea["significant_wave_height_m"]:.3g} m, Tp {sea["peak_period_s"]:.3g} s'
    )


# -----------------------------------------------------------------------------
# `tauto scene new`: a scene to start from. `tauto scene schema`: what editors check it with.

Choice = Annotated[str | None, typer.Option(metavar='KIND')]


class NewCommand(TyperCommand):
    """`tauto scene new`: its help names the kinds that are found when it is asked for."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help, with the kinds of each section."""
        from tauto_core.scene.fields import kind_of, kinds_in
        from tauto_core.scene.reference import ASKED

        for option in self.params:
            if isinstance(option, TyperOption) and option.name in ASKED:
                names = [kind_of(model) for model in kinds_in(ASKED[option.name])]
                none = '; without it there is none' if option.name == 'escapement' else ''
                option.help = f'{", ".join(names[:-1])} or {names[-1]}{none}.'
        super().format_help(ctx, formatter)


def new(
    ship: Choice = None,
    cam: Choice = None,
    thread: Choice = None,
    power: Choice = None,
    escapement: Choice = None,
    out: Annotated[
        str | None,  # a Path drops the slash of a folder
        typer.Option(
            '--out',
            '-o',
            metavar='FILE',
            help='The file, ending in .yaml; without it, standard output.',
        ),
    ] = None,
) -> None:
    """Write a scene that sails, with the unit and meaning of every key.

    Kinds that are not asked for are chosen to go with those that are; with none asked for it is
    Euler's involute under a weight, in a wind sea.
    """
    from tauto_core.scene.reference import write_scene

    asked = {'ship': ship, 'cam': cam, 'thread': thread, 'power': power, 'escapement': escapement}
    text = write_scene(out, {key: kind for key, kind in asked.items() if kind is not None})
    if out is None:
        typer.echo(text, nl=False)
    else:
        say(f'wrote {out}. Sail it with: {shlex.join(("tauto", "sail", out))}')


def schema() -> None:
    """Print the JSON schema with which editors check scenes."""
    from tauto_core.scene.reference import FILE

    typer.echo(FILE.read_text(encoding='utf-8'), nl=False)
