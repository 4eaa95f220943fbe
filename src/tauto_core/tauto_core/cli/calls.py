"""Commands made of the calls of `tauto_core.api`: an argument of a call is an option here.

The signature of a call has the type and the default of each option; `Args` in its docstring has
the meaning and, in brackets, the unit. The rest of the docstring is the help. Besides, commands
have `--json` and, where a scene's keys can be given other values, `--set`.
"""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import typer
from typer.core import TyperCommand

from tauto_core import api
from tauto_core.cli.terminal import (
    AsJson,
    SceneName,
    Settings,
    ended_by_sigterm,
    given_values,
    measured,
    option,
    print_rich,
    progress_bar,
    say,
    say_oddities,
    saying_warnings,
)
from tauto_core.scene.errors import Argument, UsageError, naming

if TYPE_CHECKING:
    from rich.console import RenderableType

Said: TypeAlias = 'Mapping[str, Any] | str | list[RenderableType]'
"""A result as it is printed: the object of `--json`, plain text, or texts and tables."""

OF_PYTHON = {
    'progress': 'the bar on the terminal',
    'keep': 'a command prints the result alone',
    'smooth': 'is refused before the arguments are read',
}
"""Arguments that are no options, and why."""


@dataclass(frozen=True)
class Command:
    """How calls are a command.

    Attributes:
        calls: names of the calls, of which the first has the help.
        shown: returns the result as printed, with `--json` or as text, after what was given; a
            dict is its own `--json`.
        has_json: whether there is `--json`.
        has_scene: whether `--set` changes keys of the scene.
        warns: whether warnings about the scene come before it sails.
        writes: arguments whose files are named once they are written.
        instead: options that a command declares in another way; they may be left out.
        holds: whether a result is as it should be; otherwise the exit code is 1.
        run: runs the calls in place of one alone, with what was given.
        cls: class of the command, where its help is made when it is printed.
    """

    calls: tuple[str, ...]
    shown: Callable[[Any, bool, Mapping[str, Any]], Said | None]
    has_json: bool = True
    has_scene: bool = False
    warns: bool = False
    writes: tuple[str, ...] = ('plot',)
    instead: Mapping[str, Any] = field(default_factory=dict)
    holds: Callable[[Any], bool] | None = None
    run: Callable[[dict[str, Any]], Any] | None = None
    cls: type[TyperCommand] | None = None

    @property
    def docs(self) -> str:
        """The docstring of the first call."""
        return inspect.getdoc(getattr(api, self.calls[0])) or ''

    def function(self) -> Callable[..., None]:
        """Return the function of which typer makes the command."""

        def command(*, as_json: bool = False, **given: Any) -> None:
            self._called({key: each for key, each in given.items() if each is not None}, as_json)

        options = [
            _keyword(name, self.instead[name], None) if name in self.instead else _option(*each)
            for name, each in self.parameters().items()
        ]
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
        """Return the arguments that are options, with their call, and whether all calls have them.

        Those that only one of several calls has are left out unless they are given.
        """
        found: dict[str, tuple[str, inspect.Parameter, bool]] = {}
        for call in self.calls:
            for name, each in signature_of(call).items():
                if name in OF_PYTHON or each.kind is each.VAR_KEYWORD or name in found:
                    continue
                shared = all(name in signature_of(other) for other in self.calls)
                found[name] = call, each, shared
        return found

    def _called(self, given: dict[str, Any], as_json: bool) -> None:
        """Call with what was given, and print the result."""
        if self.has_scene:
            of_scene = [given.pop(key, None) for key in ('settings', 'duration', 'accuracy')]
            given |= self._unlike_arguments(given_values(*of_scene))
        with ExitStack() as held:
            held.enter_context(saying_warnings())
            odd = self._warned(given, held) if self.warns else []
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
        said = result if as_it_is else self.shown(result, as_json, given)
        if isinstance(said, str):
            typer.echo(said, nl=not said.endswith('\n'))
        elif isinstance(said, Mapping):
            typer.echo(json.dumps(said, allow_nan=False))
        elif said is not None:
            print_rich(*said)
        if self.holds is not None and not self.holds(result):
            raise typer.Exit(1)

    def _unlike_arguments(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return values of a scene; refuse what the call would take as an argument of its own."""
        for key in values.keys() - {'duration'}:
            if any(key in signature_of(call) for call in self.calls):
                argument = 'is no key of a scene but an argument of the command. See its -h'
                raise UsageError(f'--set {key}: {argument}')
        return values

    def _warned(self, given: dict[str, Any], held: ExitStack) -> list[str]:
        """Load the scene and print warnings about it, before anything starts."""
        source, asked = given.pop('scene'), signature_of(self.calls[0])
        of_scene = [key for key in given if key == 'duration' or key not in asked]
        loaded = api.load(source, **{key: given.pop(key) for key in of_scene})
        given['scene'] = loaded
        held.enter_context(naming(source, loaded.name))
        return say_oddities(loaded, source, anyway=given['anyway'])

    def _run(self, given: dict[str, Any]) -> Any:
        """Call, with a bar if the call tells its progress."""
        [name] = self.calls
        asked, given = signature_of(name), dict(given)
        at = [
            part
            for each in asked.values()
            if each.kind is each.VAR_POSITIONAL
            for part in given.pop(each.name, ())
        ]
        if 'keep' in asked:
            given['keep'] = False
        if 'progress' not in asked:
            return getattr(api, name)(*at, **given)
        first = given.get(next(iter(asked)), name)
        with ended_by_sigterm(), progress_bar(getattr(first, 'name', str(first))) as progress:
            return getattr(api, name)(*at, **given, progress=progress)


# -----------------------------------------------------------------------------
# An argument of a call as an option.


@cache
def signature_of(call: str) -> Mapping[str, inspect.Parameter]:
    """Return the parameters of a call by their names."""
    return inspect.signature(getattr(api, call)).parameters


@cache
def meanings(call: str) -> dict[str, str]:
    """Return what the docstring of a call says of each argument."""
    text = (inspect.getdoc(getattr(api, call)) or '').partition('\nArgs:\n')[2]
    found = {}
    for name, said in re.findall(
        r'^ {4}(\w+): ((?:.|\n {8})+)', re.split(r'\n(?=\S)', text)[0], re.MULTILINE
    ):
        words = ' '.join(said.split())
        if other := re.match(r'as for `(\w+)`', words):
            words = meanings(other[1])[name].rstrip('.') + words[other.end() :]
        found[name] = words
    return found


def _spelled(words: str, names: Iterable[str]) -> str:
    """Return words with the arguments of a call as the command line spells them."""
    return re.sub(
        r'`(\w+)`', lambda each: option(Argument(each[1])) if each[1] in names else each[0], words
    )


def _keyword(name: str, kind: Any, default: Any) -> inspect.Parameter:
    keyword = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, keyword, default=default, annotation=kind)


def _numbers(name: str, text: str) -> list[float | str]:
    """Return numbers with commas between; those with a unit stay texts, which the call reads."""
    from tauto_core.scene.units import in_words

    parts = [part.strip() for part in text.split(',')]
    try:
        return [part if in_words(part) else float(part) for part in parts]
    except ValueError:
        wrong = ': must be numbers with commas between. Write for example 0.1,0.5,1'
        raise UsageError(Argument(name, repr(text), spaced=True), wrong) from None


def _number_or_text(text: str) -> float | str:
    """Return the number in a text, or the text, whose unit the call knows."""
    try:
        return float(text)
    except ValueError:
        return text.strip()


def _scenes(text: str) -> list[str]:
    return [part.strip() for part in text.split(',')]


# Type, parser and metavar of an option, by the annotation of the argument.
_KINDS: dict[str, tuple[Any, Callable[[str], Any] | None, str | None]] = {
    'bool': (bool, None, None),
    'int': (int, None, 'N'),
    'float': (float, None, 'C'),
    'str': (str, None, 'NAME'),
    'File': (Path, None, 'FILE'),
    'File | Mapping[str, Mapping[str, object]]': (Path, None, 'FILE'),
    'Files': (list[Path], None, 'FILE'),
    'File | Scene': (str, None, 'SCENE'),
    'Sequence[File | Scene]': (str, _scenes, 'A,B,…'),
    'Quantity': (str, _number_or_text, 'SIZE'),
    'Range': (str, None, 'A..B'),
}
_PLACED = {'what': 'WHAT', 'source': 'BAG|SCENE', 'bag': 'BAG', 'log': 'FILE', 'clocks': 'SCENE…'}
"""Arguments that stand without a name, by their metavars."""
_METAVARS = {
    'passage': 'ID',
    'scheduler': 'ADDRESS',
    **dict.fromkeys(('length_unit', 'weight_unit'), 'UNIT'),
    **dict.fromkeys(('ship', 'cam', 'thread', 'power', 'escapement'), 'KIND'),
    **dict.fromkeys(('support', 'contact'), 'KIND'),
}
"""Metavars that the type does not tell."""
_SHORT = {'new_scene': 'file', 'design': 'file', 'logbook': 'out'}
"""Options that are `-o`, too, by call."""


def _option(call: str, each: inspect.Parameter, shared: bool) -> inspect.Parameter:
    """Return the option, or the argument, of an argument of a call."""
    words, said, default = meanings(call)[each.name], each.annotation, each.default
    said = said.removesuffix(' | None')
    required = default is each.empty and each.kind is not each.VAR_POSITIONAL
    if each.name == 'scene' and required:
        return _keyword(each.name, SceneName, each.empty)
    if not shared:
        words = f'With --logs: {words}' if call == 'trial' and each.name != 'logs' else words
        if default not in (None, False, 0, (), each.empty):
            shown = f'{default:g}' if isinstance(default, float) else default
            words = f'{words.rstrip(".")}; default: {shown}'
        default = False if default is False else None
    if not re.match(r'\w+[,:]|and |its ', words):  # a list, or the rest of a sentence
        words = words[0].upper() + words[1:]
    words = _spelled(words, signature_of(call))
    if each.name in _PLACED:
        several = each.kind is each.VAR_POSITIONAL
        kind: Any = list[str] | None if several else Path if said == 'File' else str
        placed = typer.Argument(metavar=_PLACED[each.name], help=words)
        return _keyword(each.name, Annotated[kind, placed], None if several else each.empty)
    kind, parser, metavar = _kind(each.name, said, meanings(call)[each.name])
    default = None if default == () else default
    declared = typer.Option(
        option(Argument(each.name)),
        *(['-o'] if _SHORT.get(call) == each.name else []),
        metavar='DIR' if words.startswith('Folder') else _METAVARS.get(each.name, metavar),
        help=words,
        parser=parser,
    )
    return _keyword(
        each.name, Annotated[kind | None if default is None else kind, declared], default
    )


def option_of(call: str, name: str) -> Any:
    """Return how typer is told of an argument of a call, for a command written by hand."""
    return _option(call, signature_of(call)[name], shared=True).annotation.__metadata__[0]


def _kind(name: str, said: str, words: str) -> tuple[Any, Callable[[Any], Any] | None, str | None]:
    """Return type, parser and metavar of an option; the metavar of a quantity is its unit."""
    if said.startswith('Literal'):
        return Literal[tuple(re.findall(r"'(\w+)'", said))], None, None
    if said == 'Quantity' and (found := re.search(r'\[([^\[\]]+)\]', words)):
        unit = found[1]
        return float, measured(unit), 'DAYS' if unit == 'd' else unit.upper().replace(' ', '')
    if said.endswith('[Quantity]'):
        return str, partial(_numbers, name), 'A,B,…'
    if name == 'file':
        return str, None, 'FILE'  # a Path drops the slash of a folder
    return _KINDS[said]
