"""Results of calls as commands print them: the object of `--json`, or text and tables."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import asdict
from importlib.resources import files
from itertools import takewhile
from typing import TYPE_CHECKING, Any

import typer

from tauto_core.cli.terminal import option, say
from tauto_core.scene.errors import spelled
from tauto_core.wording import counted, left_out, place, printed, significant

if TYPE_CHECKING:
    from tauto_core.bags import BagReport, Recovered
    from tauto_core.cli.calls import Said
    from tauto_core.ensembles.budget import Budget
    from tauto_core.ensembles.comparison import Comparison
    from tauto_core.ensembles.fleets import Fleet
    from tauto_core.ensembles.trials import TrialAnswers
    from tauto_core.euler import Claim
    from tauto_core.machines import Isochronism
    from tauto_core.machines.design import WheelDesign
    from tauto_core.machines.fluid_pendulum import DescentIsochronism
    from tauto_core.plots.cutting import CamOutline
    from tauto_core.voyage import Voyage

Given = Mapping[str, Any]


def shipped_summary(name: str) -> str:
    """Return the description of a built-in scene: its first comment, up to the colon."""
    text = (files('tauto_core.scene') / 'shipped' / f'{name}.yaml').read_text(encoding='utf-8')
    lines = takewhile(lambda line: line.startswith('#'), text.splitlines())
    return ' '.join(line.lstrip('# ') for line in lines).partition(':')[0]


def scenes(names: list[str], as_json: bool, _: Given) -> Said:
    """Return the built-in scenes with their descriptions."""
    summaries = {name: shipped_summary(name) for name in names}
    if as_json:
        return {'scenes': summaries}
    width = max(map(len, summaries))
    return '\n'.join(f'{name:{width}}  {summary}' for name, summary in summaries.items())


def voyage(found: Voyage, as_json: bool, _: Given) -> Said:
    """Return a voyage."""
    if as_json:
        return found.result
    from tauto_core.cli.tables import stability_table, voyage_table

    text, stability = voyage_table(found.result), found.result.get('stability')
    return f'{text}\n\n{stability_table(stability)}' if stability else text


def facts(found: dict[str, Any], _as_json: bool, _: Given) -> Said:
    """Return the facts of a scene."""
    from tauto_core.cli.tables import facts_table

    return facts_table(found)


def scene(text: str, _as_json: bool, given: Given) -> str | None:
    """Return a new scene, unless it was written to a file."""
    if file := given.get('file'):
        say(f'wrote {file}. Sail it with: {shlex.join(("tauto", "sail", str(file)))}')
        return None
    return text


def cam(made: CamOutline, as_json: bool, given: Given) -> Said | None:
    """Return a plate with its cost, or a few points if no file is written."""
    wheel = made.scene.trochlea
    if 'reach_rad' not in given and wheel is not None:
        say(
            f'the cheeks end at {made.reach_rad:.4g} rad, for a wheel released at '
            f'{abs(wheel.release_angle):g} rad; --reach changes this'
        )
    if made.meeting_rad is not None:
        say(
            f'the cheeks cross at {made.meeting_rad:.4g} rad and cannot be cut from one plate '
            'beyond it: give a smaller --reach'
        )
    if made.acts_from_rad is not None and made.plate is None:
        say(f'the thread bends round the edges up to {made.acts_from_rad:.4g} rad')
    for line in (
        *left_out(made.keys_left_out),
        *filter(None, [made.too_small]),
        *(f'wrote {file}' for file in made.files),
    ):
        say(line)
    if as_json:
        return made.facts()
    from tauto_core.cli.tables import aligned

    if made.plate is not None and made.plate.rates is not None:
        heads = 'amplitude, rad', 'rounded cusp, s/day', 'as drawn', '1 µm too deep'
        from tauto_core.plots.cutting import plate_words

        rows = (
            (f'{amplitude:.4g}', *(significant(rate, 2, signed=True) for rate in cost))
            for amplitude, *cost in zip(*made.plate.rates, strict=True)
        )
        return '\n'.join([*plate_words(made.plate), *aligned([heads, *rows], first='>')])
    if made.files:
        return None
    columns = made.columns()
    points = zip(*(column.tolist() for column in columns.values()), strict=True)
    # a tenth of a micrometre; --csv has all digits. Other programs read a hyphen as the minus.
    return '\n'.join(
        aligned([columns, *([f'{value:z.4f}' for value in row] for row in points)], first='>')
    )


def isochronism(found: Isochronism | DescentIsochronism, as_json: bool, _: Given) -> Said:
    """Return period and rate against amplitude."""
    if not as_json:
        return str(found)
    columns = found.columns()
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return {
        'nominal_period_s': found.nominal_period_s,
        'rows': [dict(zip(columns, row, strict=True)) for row in rows],
        'keys_left_out': list(found.keys_left_out),
        **({'warnings': list(found.warnings)} if found.warnings else {}),
    }


def design(found: WheelDesign, as_json: bool, given: Given) -> Said:
    """Return the numbers of a design, in the units of the first length and weight given."""
    sizes = {name: value for name, value in asdict(found).items() if value is not None}
    if as_json:
        return sizes
    if small := sizes.pop('too_small'):
        say(small)
    from tauto_core.machines.design import size_in_si
    from tauto_core.scene.units import unit_in

    lengths, weights = ('pendulum', 'disc_radius', 'base_radius'), ('disc_weight', 'pull')
    length, weight = (
        next(filter(None, (unit_in(given.get(name)) for name in names)), default)
        for names, default in ((lengths, 'm'), (weights, 'N'))
    )
    printed = (  # the longest ending first
        ('_kg_m2', 'kg m2', 1.0),
        ('_m_s2', 'm/s2', 1.0),
        ('_s', 's', 1.0),
        ('_m', length, size_in_si('', f'1 {length}', 'm', found.gravity_m_s2)),
        ('_n', weight, size_in_si('', f'1 {weight}', 'N', found.gravity_m_s2)),
    )
    lines = []
    for key, value in sizes.items():
        ending, unit, size = next(row for row in printed if key.endswith(row[0]))
        # six digits: a micrometre in a metre, 0.05 s/day of the period; --json has all
        lines.append(f'{key.removesuffix(ending).replace("_", " "):14} {value / size:.6g} {unit}')
    return '\n'.join(lines)


def axle(found: dict[str, Any], _as_json: bool, _: Given) -> Said:
    """Return lengths and periods of small swings, and the motion."""
    from tauto_core.cli.tables import aligned

    rows, lines = found['rows'], []
    for name, length in found.items():
        # b and b_prime are the old names of h and h_prime
        if isinstance(length, float) and name[:2] != 'b_' and name != 'ends_s':
            words, _unit, unit = name.rpartition('_')
            lines.append(f'{words.replace("_", " "):22} {length:.9g} {unit}')
    heads = ('time s', 'θ rad', 'φ rad', 's m', 'N/Mg', 'slip m/s', 'φ small')
    figures = ([printed(value, '+z.6f') for value in row.values()] for row in rows)
    if found['ends_s'] is not None:
        say(f'after {found["ends_s"]:.6g} s {found["ends_why"]}')
    return '\n'.join([*lines, *aligned([heads, *figures], first='>')])


def altitudes(found: dict[str, Any], _as_json: bool, _: Given) -> Said:
    """Return latitude, declination and culmination, and a table of their errors."""
    from tauto_core.cli.tables import aligned

    lines = [
        f'{name.rpartition("_")[0]:12} {size:.6f} {name.rpartition("_")[2]}'
        for name, size in found.items()
        if name != 'errors'
    ]
    heads = 'wrong by', 'latitude nmi', "declination '", 'culmination s'
    rows = (
        (of, *(printed(size, '+.4f') for size in sizes))
        for of, *sizes in map(dict.values, found['errors'])
    )
    return '\n'.join([*lines, *aligned([heads, *rows])])


def hull(found: dict[str, Any], _as_json: bool, _: Given) -> Said:
    """Return how a hull moves in waves, and its cost to a clock."""
    from tauto_core.cli.tables import hull_text

    return hull_text(found)


def logbook(found: list[dict[str, Any]] | str, as_json: bool, given: Given) -> Said | None:
    """Return the passages of a log-book, or the scene of one, unless it was written to a file."""
    if isinstance(found, str):
        return scene(found, as_json, {'file': given.get('out')})
    if as_json:
        return {'passages': found}
    width = max([len(row['passage']) for row in found] + [7])
    ends = [', '.join(place(*row[key]) for key in ('first_place', 'last_place')) for row in found]
    way = max(map(len, [*ends, 'from, to']))
    lines = [
        f'{"passage":{width}}  first day   days  entries  wind   air  {"from, to":{way}}  '
        'ship; doubts'
    ]
    for row, between in zip(found, ends, strict=True):
        remarks = [f'cannot be sailed: {problem}' for problem in row['problems']] or row['notes']
        days = '' if row['days'] is None else f'{row["days"]:.1f}'
        lines.append(
            f'{row["passage"]:{width}}  {row["first_utc"][:10]:10} {days:>5}  {row["entries"]:7}  '
            f'{row["wind_share"]:4.0%}  {row["air_share"]:4.0%}  {between:{way}}  '
            + '; '.join([row['ship'] or '?', *remarks])
        )
    sound = sum(not row['problems'] for row in found)
    summary = f'{len(found)} passages, {sound} of them can be sailed: --passage ID writes a scene'
    return '\n'.join([*lines, summary])


def budget(found: Budget, as_json: bool, given: Given) -> Said:
    """Return the causes of a clock's rate."""
    from tauto_core.bags.write import BUDGET

    if out := given.get('out'):
        say(f'wrote {out / BUDGET}')
    if as_json:
        return found.facts()
    from tauto_core.cli.tables import budget_text

    return budget_text(found.facts())


def comparison(found: Comparison, as_json: bool, _: Given) -> Said:
    """Return several clocks side by side."""
    if as_json:
        return asdict(found)
    from tauto_core.cli.tables import comparison_table, failures

    return '\n'.join([comparison_table(found), *failures(found)])


def fleet(found: Fleet | TrialAnswers, as_json: bool, given: Given) -> Said:
    """Return how many ships, or clocks on how many passages, find the longitude."""
    from tauto_core.ensembles.trials import TrialAnswers

    if out := given.get('out'):
        say(f'wrote {out / "ships.parquet"}')
    if isinstance(found, TrialAnswers):
        if as_json:
            return asdict(found)
        from tauto_core.cli.tables import paragraphs, trial_remarks, trial_tables

        remarks = [*trial_remarks(found), *left_out(found.keys_left_out)]
        return paragraphs([found.answer, *trial_tables(found), *remarks])
    if as_json:
        return {'scene': found.plan.scene.name, **asdict(found.answers)}
    from tauto_core.cli.tables import fleet_tables, paragraphs

    lost = found.answers.failures.items()
    failed = (f'{counted(number, "ship")} failed: {why}' for why, number in lost)
    return paragraphs([found.answers.answer, *fleet_tables(found.answers), *failed])


def soundness(found: BagReport, as_json: bool, given: Given) -> Said:
    """Return the faults of a bag."""
    notes, counts = [spelled(note, option) for note in found.notes], found.bag.counts
    if as_json:
        return {
            'bag': str(given['bag']),
            'whole': found.whole,
            'cut_short': found.cut_short,
            'marks': found.marks,
            'damage': found.damage,
            'faults': found.faults,
            'notes': notes,
            'topics': counts,
        }
    contents = f'{sum(counts.values()):,} messages on {len(counts)} topics'
    lines, path = [*found.damage, *found.faults, *found.marks], found.bag.path
    if found.damage:
        lines.append(f'{path} is damaged; {contents} can be read: `tauto bag recover {path}`')
    elif found.whole:
        lines.append(f'{path} is whole: {contents}')
    else:
        lines.append(f'{path}: its files are whole, {contents}')
    return '\n'.join([*lines, *(f'note: {note}' for note in notes)])


def recovered(made: Recovered, as_json: bool, given: Given) -> Said:
    """Return the counts of a recovered bag, and its losses."""
    if as_json:
        return {
            'bag': str(given['bag']),
            'recovered': str(made.path),
            'start_ns': made.start_ns,
            'end_ns': made.end_ns,
            'lost': list(made.lost),
            'missing': made.missing,
            'topics': made.counts,
        }
    missing = f'{made.missing} messages that the index counts cannot be read'
    span_s = (made.end_ns - made.start_ns) * 1e-9
    total = sum(made.counts.values())
    holds = f'{made.path} has {total:,} messages on {len(made.counts)} topics, {span_s:g} s'
    return '\n'.join([*made.lost, *([missing] if made.missing else []), holds])


# -----------------------------------------------------------------------------
# Every claim of Euler's papers, checked.


def claims(found: list[Claim], as_json: bool, given: Given) -> Said | None:
    """Return the claims, unless the site was written. Print unexpected verdicts."""
    for claim in (claim for claim in found if claim.verdict != claim.expected):
        text = f'{claim.paper} §{claim.paragraph}, {claim.said}: {claim.verdict} (off by '
        text += f'{claim.difference:.3g}, tolerance {claim.tolerance:.3g}), should be '
        text += f'{claim.expected}. Check the computation'
        typer.echo(f'tauto: {text}', err=True)
    if as_json:
        return {'claims': list(map(claim_facts, found))}
    if given.get('site'):
        return None
    from tauto_core.cli.tables import listed
    from tauto_core.euler.site import summary

    rows = ((f'{claim.paper} §{claim.paragraph}', claim_text(claim)) for claim in found)
    return listed([*rows, ('', summary(found))])


def claim_facts(claim: Claim) -> dict[str, Any]:
    """Return a claim as JSON, with None for values that cannot be evaluated."""
    return {
        'paper': claim.paper,
        'paragraph': claim.paragraph,
        'claim': claim.said,
        'stands': claim.stands or None,
        'value': claim.value if math.isfinite(claim.value) else None,
        'computed': claim.computed if math.isfinite(claim.computed or 0.0) else None,
        'difference': claim.difference if math.isfinite(claim.difference) else None,
        'tolerance': claim.tolerance,
        'verdict': claim.verdict,
        'expected': claim.expected,
        'must': claim.must or None,
        'must_value': claim.must_value,
        'adds': claim.adds or None,
        'because': claim.reason or None,
        'whose': claim.whose or None,
    }


def claim_text(claim: Claim) -> str:
    """Return the verdict on a claim, the printed formula with its value, and its fault."""
    value = f' = {claim.value:.9g}' if math.isfinite(claim.value) else ''
    formulas = (
        claim.stands and f'as it stands: {claim.stands}{value}',
        claim.must and f'as it must be: {claim.must}',
        claim.adds and f'Tauto adds: {claim.adds}' + ('' if claim.stands else value),
        '' if claim.computed is None else f'computed: {claim.computed:.9g}',
        f'off by {claim.difference:.1e}' if math.isfinite(claim.difference) else '',
    )
    whose = claim.whose and f'whose fault: {claim.whose}'
    verdict, formula = f'{claim.verdict}: {claim.said}', '; '.join(filter(None, formulas))
    return '\n'.join(filter(None, (verdict, formula, claim.reason, whose)))
