"""Commands made of the calls of `tauto_core.api`.

Arguments of a call become options: their type and default come from the signature, their meaning
and unit (in brackets) from `Args` in the docstring. The rest of the docstring is the help.
Commands also have `--json` and, with a scene, `--set`.
"""

from __future__ import annotations

import inspect
import json
import os
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import typer

from tauto_core import api
from tauto_core.cli.terminal import (
    AsJson,
    SceneName,
    Settings,
    ended_by_sigterm,
    given_values,
    option,
    progress_bar,
    say,
    say_plausibility,
)
from tauto_core.scene.errors import Argument, UsageError, naming

Said: TypeAlias = Mapping[str, Any] | str
"""A printable result: the object of `--json`, or text."""

OF_PYTHON = {
    'progress': 'the bar on the terminal',
    'keep': 'a command prints the result alone',
}
"""Arguments that are not options, and why."""


@dataclass(frozen=True)
class Command:
    """A command made of one or several calls.

    Attributes:
        calls: names of the calls. The first has the help.
        shown: returns the printable result, from the result, whether `--json` is given, and the
            arguments. A dict is its own `--json`.
        has_json: whether there is `--json`.
        has_scene: whether `--set` changes keys of the scene.
        warns: whether warnings about the scene are printed before it sails.
        writes: arguments that name files to be reported as written.
        default_file: default of `file`, named after the source.
        holds: whether a result is good. Otherwise the exit code is 1.
        run: runs the calls with the arguments, instead of the only call.
    """

    calls: tuple[str, ...]
    shown: Callable[[Any, bool, Mapping[str, Any]], Said | None]
    has_json: bool = True
    has_scene: bool = False
    warns: bool = False
    writes: tuple[str, ...] = ('plot',)
    default_file: str = ''
    holds: Callable[[Any], bool] | None = None
    run: Callable[[dict[str, Any]], Any] | None = None

    @property
    def docs(self) -> str:
        """The docstring of the first call."""
        return inspect.getdoc(getattr(api, self.calls[0])) or ''

    def function(self) -> Callable[..., None]:
        """Return the function from which typer makes the command."""

        def command(*, as_json: bool = False, **given: Any) -> None:
            self._called({key: item for key, item in given.items() if item is not None}, as_json)

        options = [_option(*parts) for parts in self.parameters().values()]
        if self.has_scene:
            options.append(_keyword('settings', Settings, None))
        if self.has_json:
            options.append(_keyword('as_json', AsJson, default=False))
        command.__doc__ = _spelled(
            self.docs.partition('\nArgs:')[0], {*self.parameters(), 'anyway'}
        )
        command.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
        command.__annotations__ = {}
        return command

    def parameters(self) -> dict[str, tuple[str, inspect.Parameter, bool]]:
        """Return for each option its call, its argument, and whether it has the call's default.

        Others, which some calls lack or the command sets, are passed only if given.
        """
        options: dict[str, tuple[str, inspect.Parameter, bool]] = {}
        for call in self.calls:
            for name, argument in signature_of(call).items():
                if name in OF_PYTHON or argument.kind is argument.VAR_KEYWORD or name in options:
                    continue
                shared = all(name in signature_of(sibling) for sibling in self.calls)
                options[name] = (
                    call,
                    argument,
                    shared and not (name == 'file' and self.default_file),
                )
        return options

    def _called(self, given: dict[str, Any], as_json: bool) -> None:
        """Run the command with its arguments, and print the result."""
        for key, item in given_values(given.pop('settings', None)).items():
            if key in given and key == 'duration':
                raise UsageError(f'--set {key}: {key} is given twice. Leave one of them out')
            if key != 'duration' and any(key in signature_of(call) for call in self.calls):
                argument = 'is not a key of a scene but an argument of the command. See its -h'
                raise UsageError(f'--set {key}: {argument}')
            given[key] = item
        with ExitStack() as stack:
            odd = self._warned(given, stack) if self.warns else []
            result = (self.run or self._run)(given)
        if isinstance(result, Mapping) or hasattr(result, 'result'):
            facts = result if isinstance(result, Mapping) else result.result
            for warning in facts.get('warnings', ()):
                if warning not in odd:
                    say(warning)
        for name in self.writes:
            files = given.get(name, ())
            for file in [files] if isinstance(files, str | Path) else files:
                say(f'wrote {file}')
        as_it_is = as_json and isinstance(result, dict)
        output = result if as_it_is else self.shown(result, as_json, given)
        if isinstance(output, str):
            typer.echo(output, nl=not output.endswith('\n'))
        elif output is not None:
            typer.echo(json.dumps(output, allow_nan=False))
        if self.holds is not None and not self.holds(result):
            raise typer.Exit(1)

    def _warned(self, given: dict[str, Any], stack: ExitStack) -> list[str]:
        """Load the scene, unless it is a bag, and print and return warnings about it."""
        parameters = signature_of(self.calls[0])
        name, times = next(iter(parameters)), ('duration', 'accuracy')
        source = given[name]
        if self.default_file:
            place = Path(os.path.abspath(given['source']))  # `.` has no name
            title = place.name if place.is_dir() else place.stem
            given.setdefault('file', Path(self.default_file.format(title=title, **given)))
        if name == 'source' and api.is_bag(source):
            return []
        of_scene = [key for key in given if key in times or key not in parameters]
        loaded = api.load(source, **{key: given[key] for key in of_scene})
        if name == 'scene':  # loaded once; a report shows its settings
            for key in of_scene:
                del given[key]
            given[name] = loaded
            stack.enter_context(naming(source, loaded.name))
        sails = given.get('what') not in ('weather', 'cam', 'machine')
        return say_plausibility(loaded, source, anyway=given['anyway'] or not sails)

    def _run(self, given: dict[str, Any]) -> Any:
        """Run the only call, with a progress bar if possible."""
        [name] = self.calls
        parameters, given = signature_of(name), dict(given)
        at = [
            part
            for parameter in parameters.values()
            if parameter.kind is parameter.VAR_POSITIONAL
            for part in given.pop(parameter.name, ())
        ]
        if 'keep' in parameters:
            given['keep'] = False
        if 'progress' not in parameters:
            return getattr(api, name)(*at, **given)
        source = given.get(next(iter(parameters)), name)
        with ended_by_sigterm(), progress_bar(getattr(source, 'name', str(source))) as progress:
            return getattr(api, name)(*at, **given, progress=progress)


# -----------------------------------------------------------------------------
# An argument of a call as an option.


@cache
def signature_of(call: str) -> Mapping[str, inspect.Parameter]:
    """Return the parameters of a call by their names."""
    return inspect.signature(getattr(api, call)).parameters


@cache
def meanings(call: str) -> dict[str, str]:
    """Return the meaning of each argument, from the docstring of a call."""
    text = (inspect.getdoc(getattr(api, call)) or '').partition('\nArgs:\n')[2]
    texts = {}
    for name, entry in re.findall(
        r'^ {4}(\w+): ((?:.|\n {8})+)', re.split(r'\n(?=\S)', text)[0], re.MULTILINE
    ):
        words = ' '.join(entry.split())
        if link := re.match(r'as for `(\w+)`', words):
            words = meanings(link[1])[name].rstrip('.') + words[link.end() :]
        texts[name] = words
    return texts


def _spelled(words: str, names: Iterable[str]) -> str:
    """Return words with arguments spelled as options."""
    return re.sub(
        r'`(\w+)`', lambda hit: option(Argument(hit[1])) if hit[1] in names else hit[0], words
    )


def _keyword(name: str, kind: Any, default: Any) -> inspect.Parameter:
    keyword = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, keyword, default=default, annotation=kind)


# type, parser and metavar of an option, by the annotation of the argument
_KINDS: dict[str, tuple[Any, Callable[[str], Any] | None, str | None]] = {
    'bool': (bool, None, None),
    'int': (int, None, 'N'),
    'float': (float, None, 'C'),
    'str': (str, None, 'NAME'),
    'File': (Path, None, 'FILE'),
    'File | Mapping[str, Mapping[str, object]]': (Path, None, 'FILE'),
    'Files': (list[Path], None, 'FILE'),
    'File | Scene': (str, None, 'SCENE'),
    'Sequence[File | Scene]': (str, lambda text: list(map(str.strip, text.split(','))), 'A,B,…'),
    'Quantity': (str, None, 'SIZE'),
    'Iterable[Quantity]': (str, None, 'A,B,…'),
    'Sequence[Quantity]': (str, None, 'A,B,…'),
    'Range': (str, None, 'A..B'),
}
_PLACED = {'what': 'WHAT', 'source': 'BAG|SCENE', 'bag': 'BAG', 'log': 'FILE', 'clocks': 'SCENE…'}
"""Metavars of positional arguments."""
_METAVARS = {
    'passage': 'ID',
    **dict.fromkeys(('ship', 'cam', 'thread', 'power', 'escapement'), 'KIND'),
    **dict.fromkeys(('support', 'contact'), 'KIND'),
}
"""Metavars that do not follow from the type."""
_SHORT = {**dict.fromkeys(('new_scene', 'design', 'plot', 'report'), 'file'), 'logbook': 'out'}
"""Options with the short form `-o`, by call."""


def _option(call: str, item: inspect.Parameter, shared: bool) -> inspect.Parameter:
    """Return the option or positional argument for an argument of a call."""
    words, hint, default = meanings(call)[item.name], item.annotation, item.default
    hint = hint.removesuffix(' | None')
    required = default is item.empty and item.kind is not item.VAR_POSITIONAL
    if item.name == 'scene' and required:
        return _keyword(item.name, SceneName, item.empty)
    if not shared:
        words = f'With --logs: {words}' if call == 'trial' and item.name != 'logs' else words
        if default not in (None, False, 0, (), item.empty):
            text = f'{default:g}' if isinstance(default, float) else default
            words = f'{words.rstrip(".")}. Default: {text}.'
        default = False if default is False else None
    if not re.match(r'\w+[,:]|and |its ', words):  # a list, or the rest of a sentence
        words = words[0].upper() + words[1:]
    words = _spelled(words, signature_of(call))
    if item.name in _PLACED:
        several = item.kind is item.VAR_POSITIONAL
        kind: Any = list[str] | None if several else Path if hint == 'File' else str
        placed = typer.Argument(metavar=_PLACED[item.name], help=words)
        return _keyword(item.name, Annotated[kind, placed], None if several else item.empty)
    kind, parser, metavar = _kind(item.name, hint, meanings(call)[item.name])
    default = None if default == () else default
    declared = typer.Option(
        option(Argument(item.name)),
        *(['-o'] if _SHORT.get(call) == item.name else []),
        metavar='DIR' if words.startswith('Folder') else _METAVARS.get(item.name, metavar),
        help=words,
        parser=parser,
    )
    return _keyword(
        item.name, Annotated[kind | None if default is None else kind, declared], default
    )


def option_of(call: str, name: str) -> Any:
    """Return typer's declaration of an argument of a call, for a command written by hand."""
    return _option(call, signature_of(call)[name], shared=True).annotation.__metadata__[0]


def _kind(name: str, hint: str, words: str) -> tuple[Any, Callable[[Any], Any] | None, str | None]:
    """Return type, parser and metavar of an option. The metavar of a quantity is its unit."""
    if hint.startswith('Literal'):
        return Literal[tuple(re.findall(r"'(\w+)'", hint))], None, None
    if hint == 'Quantity' and (match := re.search(r'\[([^\[\]]+)\]', words)):
        unit = match[1]
        return str, None, 'DAYS' if unit == 'd' else unit.upper().replace(' ', '')
    if name == 'file':
        return str, None, 'FILE'  # a Path drops the slash of a folder
    return _KINDS[hint]
