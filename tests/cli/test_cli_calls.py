"""The two faces of a command: its options are the arguments of its call, and both do the same."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from command_line import invoke, refused
from typer.main import get_command

import tauto_core as tauto
from tauto_core import api
from tauto_core.cli import calls
from tauto_core.cli.app import ENTRIES, ROS_COMMANDS, Group, app
from tauto_core.cli.calls import OF_PYTHON, Command, meanings
from tauto_core.cli.terminal import option
from tauto_core.scene.errors import Argument, UsageError, spelled

OF_THE_LINE = {
    '--json': 'a call returns the object',
    '--set': 'a call takes keys of the scene as arguments',
}
"""Options that are no arguments, and why."""
WITHOUT_CALL = {
    'schema': 'prints a file, without options',
    'show': 'prints a file',
    **dict.fromkeys(ROS_COMMANDS, 'of another distribution'),
}


def commands() -> Iterator[tuple[str, Any, Any]]:
    for name, entry in ENTRIES.items():
        built = get_command(app).commands[name]
        if isinstance(entry, Group):
            for word, each in entry.commands.items():
                yield word, each, built.commands[word]
        else:
            yield name, entry, built


@pytest.mark.parametrize(('name', 'row'), api.GONE.items(), ids=api.GONE)
def test_an_argument_that_was_taken_away_says_what_to_use(name: str, row: Any) -> None:
    command, instead = row
    if command in ENTRIES:
        said = refused(command, 'ideal', f'{option(Argument(name))}=1')
        assert re.sub(r'[\s│]+', ' ', spelled(instead, option))[:40] in said
    if command != 'replay':
        with pytest.raises(UsageError, match=f'{name}=1: .*'):
            tauto.load('ideal', **{name: 1})


@pytest.mark.parametrize(
    ('name', 'entry', 'built'), list(commands()), ids=[name for name, *_ in commands()]
)
def test_options_are_arguments_and_arguments_are_options(
    name: str, entry: Any, built: Any
) -> None:
    if name in WITHOUT_CALL:
        return
    asked = {
        option(Argument(each.name))
        for call in entry.calls
        for each in inspect.signature(getattr(api, call)).parameters.values()
        if each.kind is not each.VAR_KEYWORD and each.name not in OF_PYTHON
    }
    found = {
        option(Argument(each.name)) if each.param_type_name == 'argument' else each.opts[0]
        for each in built.params
        if not each.hidden
    }
    assert found - OF_THE_LINE.keys() == asked


def test_every_argument_has_a_meaning() -> None:
    for _, entry, _ in commands():
        for call in entry.calls if isinstance(entry, Command) else ():
            asked = inspect.signature(getattr(api, call)).parameters
            assert meanings(call).keys() == asked.keys(), call


@pytest.mark.parametrize('given', ['1e-3', '1 ms'])
def test_an_accuracy_is_asked_for_in_both_faces(given: str) -> None:
    words = ['sail', 'second_cam_at_sea', '--duration', '60', '--accuracy', given, '--json']
    printed = json.loads(invoke(*words).stdout)
    asked = float(given) if given == '1e-3' else given
    called = dict(tauto.sail('second_cam_at_sea', duration='60 s', accuracy=asked).result)
    assert called['accuracy']['asked_s_per_day'] == 1e-3
    assert {**printed, 'wall_s': 0} == json.loads(json.dumps({**called, 'wall_s': 0}))


@pytest.mark.parametrize(
    'call', [tauto.load, tauto.check, tauto.budget, tauto.fleet, tauto.compare, tauto.isochronism]
)
def test_every_call_with_a_scene_takes_the_accuracy(call: Any) -> None:
    asked = {'amplitudes': [1.0]} if call is tauto.isochronism else {}
    with pytest.raises(tauto.TautoError, match=r'ideal: solver\.accuracy = -1'):
        call('ideal', **asked, accuracy=-1)


def test_a_bar_has_the_name_of_what_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    labels: list[str] = []

    def bar(label: str) -> Any:
        labels.append(label)
        return nullcontext(lambda _share: None)

    monkeypatch.setattr(calls, 'progress_bar', bar)
    for words in (['logbook', __file__], ['sail', 'ideal', '--duration', '60'], ['hull']):
        invoke(*words)
    assert labels == [Path(__file__).name, 'ideal', 'hull']
