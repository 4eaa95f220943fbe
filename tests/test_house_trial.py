"""The page of the trial at sea is made from the folder of a trial, also of one ended early."""

from __future__ import annotations

from dataclasses import replace
from datetime import datetime, timedelta
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from modules import module_of
from PIL import Image
from trial_examples import CLOCK, HEADER, OTHER, clock, write_log

from tauto_core.ensembles import trials
from tauto_core.ensembles.trials import Sailing, Trial, TriedClock, is_wanted
from tauto_core.scene.loader import read_mapping, scene_yaml
from tauto_core.ship.logbook import read_passages

ROOT = Path(__file__).parents[1]
ERRORS = {CLOCK: (-1200.5, 29.0, 31.0), OTHER: (3.0, 61.0, 12.0)}
"""Errors rated in harbour, of the three passages in the order of the log [nmi]."""


@pytest.fixture(scope='module')
def page() -> ModuleType:
    return module_of(ROOT / 'docs' / 'trial.py')


def log_of(folder: Path) -> str:
    """Write a log-book of three passages of 44 days, and one of 10 that the Act does not judge."""
    lines = [HEADER]
    for number, (days, celsius) in enumerate(((44, ''), (44, '11'), (44, ''), (10, ''))):
        for day in range(days + 1):
            utc = datetime(1770 + number, 5, 1, 12) + timedelta(days=day)
            place = f'{40 - 0.5 * day:.1f},-{20 + 0.3 * day:.1f}'
            lines.append(
                f'{utc:%Y}0501-{number},French,La Une,,,{utc:%Y-%m-%dT%H:%M},{place},90,'
                f'6.7,{celsius}\n'
            )
    return write_log(folder, ''.join(lines))


def rows_of(trial: Trial, sailing: Sailing, _: object) -> list[dict[str, Any]]:
    """Return made-up rows of a passage."""
    number, passage = sailing
    return [
        {
            **dict.fromkeys(trials.COLUMNS),
            'ship': number * len(trial.clocks) + place,
            'clock': each.name,
            'passage': passage.name,
            'seed': 0,
            'error_nmi': ERRORS[each.name][number],
            'raw_error_nmi': 2.0 * ERRORS[each.name][number],
            'sensed_error_nmi': 0.25 if each.name == CLOCK else None,
            'noon_error_nmi': [1.0] * 45,
            'run_s': 1800.0,
        }
        for place, each in enumerate(trial.clocks)
    ]


def folder_of(path: Path, logs: str, monkeypatch: pytest.MonkeyPatch, *, sailed: int) -> Path:
    """Return the folder of a trial of two clocks that was ended after some passages."""
    done: list[int] = []

    def ended(trial: Trial, sailing: Sailing, progress: object) -> list[dict[str, Any]]:
        if len(done) == sailed:
            raise KeyboardInterrupt
        done.append(sailing[0])
        return rows_of(trial, sailing, progress)

    contents = {name: read_mapping(scene_yaml(clock(name)), name) for name in (CLOCK, OTHER)}
    clocks = tuple(TriedClock(name, name, content) for name, content in contents.items())
    passages = tuple(filter(is_wanted, read_passages(logs)))
    monkeypatch.setattr(trials, 'sail_passage', ended)
    monkeypatch.setattr(Trial, 'check', lambda _: None)
    try:
        trials.sail_trial(Trial(logs, clocks, 1, 14.0, passages=passages), 1, path)
    except KeyboardInterrupt:
        assert sailed < len(passages)
    return path


def cells(text: str) -> list[list[str]]:
    return [[each.strip() for each in line.split('|')[1:-1]] for line in text.splitlines()][2:]


def test_a_trial_is_told_whole(
    page: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = log_of(tmp_path)
    folder = folder_of(tmp_path / 'trial', logs, monkeypatch, sailed=3)
    trial, rows, of = page.read_trial(folder, logs)
    answers = page.answers_of(trial, rows)
    made = page.blocks(trial, rows, answers, of)
    said = made['sailed'].replace('\n', ' ')
    assert '**3 of the 3 passages** were sailed, 1770 to 1772, of 44 to 44 days, with 2' in said
    assert 'That took 3 hours of one processor' in said
    assert 'A thermometer was read on 1 passage' in said
    shares = cells(made['shares'])
    assert [row[:3] for row in shares] == [
        [CLOCK, 'dial alone', '0: 0 % (0–56)'],
        [CLOCK, 'rated in harbour', '1: 33 % (6–79)'],
        [CLOCK, 'with thermometer and IMU', '3: 100 % (44–100)'],
        [OTHER, 'dial alone', '2: 67 % (21–94)'],
        [OTHER, 'rated in harbour', '2: 67 % (21–94)'],
    ]
    assert shares[1][3:5] == ['2', '2']
    assert shares[1][5] == '31.0'  # the median of 29, 31, 1200.5
    heads, *rows = page.passage_rows(trial, answers)
    assert heads[4:6] == [
        f'{CLOCK}: rated in harbour [nmi]',
        f'{CLOCK}: with thermometer and IMU [nmi]',
    ]
    assert [row[4:] for row in rows] == [
        ['1200', '0.25', '3.00'],
        ['29.0', '0.25', '61.0'],
        ['31.0', '0.25', '12.0'],
    ]
    answer = made['answer'].replace('\n', ' ')
    assert answer.startswith('Repeated on [3 real passages](docs/trial.md) of 1770 to 1772: ')
    assert f'ends within 30 miles on 1, the best of 2 clocks ({OTHER}) does on 2.' in answer


def test_a_trial_ended_early_is_told_as_far_as_it_went(
    page: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = log_of(tmp_path)
    folder = folder_of(tmp_path / 'trial', logs, monkeypatch, sailed=2)
    pages = [tmp_path / 'trial.md', tmp_path / 'README.md']
    for copy, original in zip(pages, page.PAGES, strict=True):
        copy.write_text(original.read_text('utf-8'), 'utf-8')
    monkeypatch.setattr(page, 'PAGES', pages)
    monkeypatch.setattr(page, 'PICTURE', tmp_path / 'trial.png')
    monkeypatch.setattr(page, 'PASSAGES', tmp_path / 'trial.csv')
    page.main([str(folder), '--logs', logs])
    assert '**2 of the 3 passages** were sailed' in pages[0].read_text('utf-8')
    assert 'Repeated on [2 real passages]' in pages[1].read_text('utf-8')
    assert len((tmp_path / 'trial.csv').read_text('utf-8').splitlines()) == 1 + 2
    with Image.open(tmp_path / 'trial.png') as picture:
        assert (picture.format, picture.mode) == ('PNG', 'P')
        assert 'rated in harbour' in str(picture.info['Title'])


def test_a_trial_without_a_verdict_leaves_the_page(
    page: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    logs = log_of(tmp_path)
    folder = folder_of(tmp_path / 'trial', logs, monkeypatch, sailed=3)
    trial, rows, of = page.read_trial(folder, logs)
    short = replace(trial, longest_s=40 * 86400.0)
    with pytest.raises(SystemExit, match='no passage of six weeks'):
        page.blocks(short, rows, page.answers_of(short, rows), of)


def test_each_block_of_the_pages_is_made(page: ModuleType) -> None:
    """`make trial` writes them; its voyages take too long for a test."""
    found = [
        name
        for each in page.PAGES
        for _, name, _ in page.BLOCK.findall(each.read_text(encoding='utf-8'))
    ]
    assert sorted(found) == ['answer', 'map', 'parts', 'sailed', 'shares']
