"""Renew the page of the trial at sea: python docs/trial.py bags/out/trial --logs FILE.

The folder is that of `tauto fleet SCENE --logs FILE --out FOLDER`, which may have been ended
early: what counts are the passages that were sailed. In `docs/trial.md` and `README.md` the text
between `<!-- trial: NAME -->` and `<!-- end -->` is replaced, and the map `docs/img/trial.png` and
the table of all passages `docs/trial.csv` are made anew.
"""

from __future__ import annotations

import argparse
import csv
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from tauto_core.ensembles.rows import QUANTILES, Row, read_rows, sizes_nmi
from tauto_core.ensembles.trials import (
    WAYS,
    ClockAnswers,
    Part,
    Prize,
    Trial,
    TrialAnswers,
    TriedClock,
    answers_of,
    is_wanted,
)
from tauto_core.files import write_figure
from tauto_core.plots.ensembles import trial_figure
from tauto_core.scene.loader import read_mapping
from tauto_core.ship.logbook import read_passages
from tauto_core.wording import counted, figure, place

DOCS = Path(__file__).parent
PAGES = (DOCS / 'trial.md', DOCS.parent / 'README.md')
PICTURE = DOCS / 'img' / 'trial.png'
PASSAGES = DOCS / 'trial.csv'
BLOCK = re.compile(r'(<!-- trial: (\w+) -->\n).*?(<!-- end -->)', re.DOTALL)

CLOCKS = {
    'esperance_to_the_cape': 'involute, weight',
    'clock_cheek_weight': 'cheek, weight',
    'clock_own_cam_weight': 'own cam, weight',
    'clock_second_cam_force': 'second cam, force',
    'clock_own_cam_spring': 'own cam, spring',
}
"""What the page calls the clocks of `make trial`; others have the names of their scenes."""

SAID = {
    'raw': 'dial alone',
    'corrected': 'rated in harbour',
    'sensed': 'with thermometer and IMU',
}


def read_trial(folder: Path, logs: str) -> tuple[Trial, list[Row], int]:
    """Return a trial with the rows in a folder, and how many passages of its log-book are judged.

    Only passages that all clocks have sailed count.
    """
    file = folder / 'fleet.yaml'
    identity = read_mapping(file.read_text('utf-8'), str(file))
    rows = read_rows(folder)
    sensed = {row['clock'] for row in rows if row['sensed_error_nmi'] is not None}
    clocks = tuple(
        TriedClock(content['name'], content['name'], content, SHAKEN * (content['name'] in sensed))
        for content in identity['clocks']
    )
    known = {each.name: each for each in read_passages(logs)}
    names = {row['passage'] for row in rows}
    passages = tuple(each for name, each in known.items() if name in names)
    return (
        Trial(logs, clocks, passages=passages, **identity['rules']),
        rows,
        sum(map(is_wanted, known.values())),
    )


SHAKEN = ('sensed',)
"""Covariates of a clock whose rows have an error with sensors: which they are is not kept."""


def blocks(trial: Trial, rows: Sequence[Row], answers: TrialAnswers, of: int) -> dict[str, str]:
    """Return the text of each block by its name."""
    if not answers.judged:
        raise SystemExit(
            f'{answers.logs}: no passage of six weeks was sailed; there is no verdict'
        )
    return {
        'sailed': _wrapped(_what_was_sailed(trial, rows, answers, of)),
        'shares': _shares(answers),
        'map': (
            f'![Tracks of {answers.passages} passages coloured by the error of the first clock, '
            'rated in harbour, and the distribution of the errors of all](img/trial.png)\n'
        ),
        'parts': _parts(answers),
        'answer': _wrapped(_short_answer(answers)),
    }


def renewed(text: str, made: dict[str, str]) -> str:
    """Return a page with its blocks written anew."""
    return BLOCK.sub(lambda found: f'{found[1]}\n{made[found[2]]}\n{found[3]}', text)


def _wrapped(text: str) -> str:
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False) + '\n'


def _table(rows: Sequence[Sequence[str]]) -> str:
    lines = [rows[0], ['---'] * len(rows[0]), *rows[1:]]
    return ''.join(f'| {" | ".join(cells)} |\n' for cells in lines)


def _called(clock: str) -> str:
    return CLOCKS.get(clock, clock)


def _what_was_sailed(trial: Trial, rows: Sequence[Row], answers: TrialAnswers, of: int) -> str:
    """Return what the figures rest on."""
    voyages = answers.voyages
    years = sorted(int(each['first_utc'][:4]) for each in voyages)
    days = sorted({each['passage']: each['days'] for each in voyages}.values())
    content = trial.clocks[0].content
    accuracy = (content.get('solver') or {}).get('accuracy')
    hours = sum(row['run_s'] for row in rows) / 3600.0
    said = (
        f'**{answers.passages} of the {of} passages** were sailed, {years[0]} to {years[-1]}, of '
        f'{days[0]:.0f} to {days[-1]:.0f} days, with {counted(len(answers.clocks), "clock")} in '
        'one sea each'
    )
    if accuracy is not None:
        said += f', to {accuracy:g} s a day'
    read = sum(each.share(5) > 0.0 for each in trial.passages)
    away = len({each['passage'] for each in voyages if each['ends']})
    failed = sum(each['failure'] is not None for each in voyages)
    stopped = sum(each['stopped_s'] is not None for each in voyages)
    ended = f'All {len(voyages)} voyages reached their end, and no clock stopped'
    if failed or stopped:
        ended = (
            f'Of {len(voyages)} voyages {counted(failed, "voyage")} ended early, on '
            f'{stopped} the clock stopped'
        )
    return (
        f'{said}. That took {hours:.3g} hours of one processor. {ended}. On '
        f'{counted(away, "passage")} the last entry is more than 30 km from the coast: no '
        'landfall is made there, and the error is that of a reckoning at sea. A thermometer was '
        f'read on {counted(read, "passage")}.'
    )


def _shares(answers: TrialAnswers) -> str:
    """Return the table of the shares within the limits of the Act."""
    first = answers.clocks[0].ways['raw'].prizes
    heads = ['clock', 'longitude', *(f'within {each.limit_nmi:g} miles' for each in first)]
    rows = [[*heads, 'median', '95 %']]
    for clock in answers.clocks:
        for way, found in clock.ways.items():
            prizes = found.prizes
            by_share = dict(zip(QUANTILES, found.quantiles_nmi or (), strict=False))
            rows.append(
                [
                    _called(clock.clock),
                    SAID[way],
                    _share(prizes[0]),
                    *(str(each.passages) for each in prizes[1:]),
                    *(figure(by_share.get(share), 'nmi') for share in (0.5, 0.95)),
                ]
            )
    return _table(rows)


def _share(prize: Prize) -> str:
    share, low, high = (round(100.0 * each) for each in (prize.share, prize.low, prize.high))
    return f'{prize.passages}: {share} % ({low}–{high})'


def _short_answer(answers: TrialAnswers) -> str:
    """Return the answer of the README."""

    def within(clock: ClockAnswers) -> int:
        return clock.ways['corrected'].prizes[0].passages

    first, best = answers.clocks[0], max(answers.clocks, key=within)
    years = sorted(int(each['first_utc'][:4]) for each in answers.voyages)
    text = (
        f'Repeated on [{answers.judged} real passages](docs/trial.md) of {years[0]} to '
        f'{years[-1]}: rated in harbour, an involute under a weight '
        + _often(within(first), answers.judged, 'ends within 30 miles')
    )
    if best is not first:
        often = _often(within(best), answers.judged, 'does')
        text += f', the best of {len(answers.clocks)} clocks ({_called(best.clock)}) {often}'
    return f'{text}.'


def _often(passages: int, of: int, verb: str) -> str:
    return (
        f'{"never" if not passages else "always"} {verb}'
        if passages in (0, of)
        else (f'{verb} on {passages}')
    )


def _parts(answers: TrialAnswers) -> str:
    """Return the passages within 30 miles, rated in harbour, by season and by ocean."""
    heads = ['rated in harbour, within 30 miles', 'passages']
    rows = [[*heads, *(_called(each.clock) for each in answers.clocks)]]
    for kind in ('seasons', 'oceans'):
        columns: list[list[Part]] = [
            getattr(each.ways['corrected'], kind) for each in answers.clocks
        ]
        for parts in zip(*columns, strict=True):
            cells = [f'{part.within[0]}, {figure(part.median_nmi, "nmi")}' for part in parts]
            rows.append([parts[0].name, str(parts[0].passages), *cells])
    return _table(rows)


def passage_rows(trial: Trial, answers: TrialAnswers) -> list[list[str]]:
    """Return the table of all passages, with the error [nmi] of each clock and way."""
    voyages: dict[tuple[str, str], dict[str, Any]] = {
        (each['passage'], each['clock']): each for each in answers.voyages
    }
    columns = [
        (clock.clock, way)
        for clock in answers.clocks
        for way in ('corrected', 'sensed')
        if way in clock.ways
    ]
    heads = [f'{_called(clock)}: {SAID[way]} [nmi]' for clock, way in columns]
    rows = [['passage', 'from', 'to', 'days', *heads]]
    for passage in trial.passages:
        ends = [place(*passage.entries[end][1:3]) for end in (0, -1)]
        sizes = [sizes_nmi([voyages[passage.name, clock]], WAYS[way])[0] for clock, way in columns]
        cells = ['stopped' if size == float('inf') else figure(size, 'nmi') for size in sizes]
        cells = [cell.replace(',', '') for cell in cells]
        rows.append([passage.name, *ends, f'{passage.days:.0f}', *cells])
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the pages, the table of passages and the map."""
    parser = argparse.ArgumentParser(description='Renew the page of the trial at sea.')
    parser.add_argument('folder', type=Path, help='folder of the trial')
    parser.add_argument('--logs', required=True, help='its log-book')
    asked = parser.parse_args(arguments)
    trial, rows, judged = read_trial(asked.folder, asked.logs)
    answers = answers_of(trial, rows)
    made = blocks(trial, rows, answers, judged)
    for page in PAGES:
        page.write_text(renewed(page.read_text('utf-8'), made), 'utf-8')
    with PASSAGES.open('w', encoding='utf-8', newline='') as file:
        csv.writer(file, lineterminator='\n').writerows(passage_rows(trial, answers))
    write_figure(lambda: trial_figure(trial, rows, answers), PICTURE)
    lighten(PICTURE)


def lighten(picture: Path) -> None:
    """Give a PNG 256 colours: a quarter of the bytes, and no difference that one sees."""
    with Image.open(picture) as whole:
        few = whole.convert('RGB').quantize(256, Image.Quantize.MEDIANCUT)
        title = PngInfo()
        title.add_text('Title', str(whole.info.get('Title', '')))
    few.save(picture, optimize=True, pnginfo=title)


if __name__ == '__main__':
    main()
