"""What commands share: options, messages, streams, endings by signal, the progress bar."""

from __future__ import annotations

import codecs
import io
import os
import signal
import sys
import threading
import unicodedata
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from tauto_core.scene.errors import ABSENT, Argument, SceneError, TautoWarning, UsageError, spelled

if TYPE_CHECKING:
    from rich.console import RenderableType

    from tauto_core.scene import Scene


# -----------------------------------------------------------------------------
# Arguments and options that several commands share.


def measured(unit: str) -> Callable[[str | float], float]:
    """Return the parser of an option: a number in the unit, or a number with a unit, as `5 mm`."""

    def number(text: str | float) -> float:
        try:
            return float(text)  # nearly always, and without an import
        except ValueError:
            from tauto_core.scene.units import measure
        try:
            return measure(text, unit)
        except ValueError as error:
            raise typer.BadParameter(f'{text!r} {error}') from None

    return number


SceneName: TypeAlias = Annotated[
    str,
    typer.Argument(metavar='SCENE', help='A YAML file, or a name that `tauto scenes` lists.'),
]
AsJson: TypeAlias = Annotated[
    bool, typer.Option('--json', help='Print one JSON object on stdout, nothing else there.')
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Another value for a key of the scene, such as ship.sea.peak_period=8; may come '
        'several times. The value null removes the key.',
    ),
]


def given_values(
    settings: list[str] | None, duration: float | None = None, accuracy: float | None = None
) -> dict[str, Any]:
    """Return the values that --set, --duration and --accuracy change, by the paths of the keys.

    `ABSENT` stands for null, which removes a key.

    Raises:
        UsageError: no KEY=VALUE, a value that is not YAML or is empty, or a key given twice.
    """
    from tauto_core.scene.loader import read_mapping

    values: dict[str, Any] = {} if duration is None else {'duration': duration}
    if accuracy is not None:
        values['solver.accuracy'] = accuracy
    for setting in settings or ():
        path, equals, text = (part.strip() for part in setting.partition('='))
        if not path or not equals:
            raise UsageError(f'--set {setting}: has no KEY=. Write for example duration=600')
        if path in values:
            raise UsageError(f'--set {setting}: {path} is given twice. Leave one of them out')
        try:
            values[path] = read_mapping(f'value: {text}', '--set')['value']
        except SceneError as error:
            raise UsageError(
                f'--set {setting}: {error.problem}. Write one value, in quotes for the shell '
                "where it has blanks or brackets: --set 'voyage.departure=[50.8, -1.1]'"
            ) from None
        if values[path] is None and text.lower() not in ('null', '~'):
            raise UsageError(f'--set {setting}: has no value. Write one after the =')
        if values[path] is None:
            values[path] = ABSENT
    return values


# Endings of arguments that options do without.
_UNITS = ('_mm', '_deg', '_rad', '_s')


def option(argument: Argument) -> str:
    """Return an argument as it is written on the command line."""
    unit = next(filter(argument.name.endswith, _UNITS), '')
    plain = argument.name.removesuffix(unit).replace('_', '-')
    name = '--out' if argument.name == 'file' else f'--{plain}'
    if argument.value is None or argument.value is True:
        return name
    return f'{name}{" = " if argument.spaced else " "}{argument.value}'


# -----------------------------------------------------------------------------
# Messages of the commands besides their result. They go to stderr; --quiet suppresses them.

_state = {'quiet': False}


def be_quiet(quiet: bool) -> None:
    """Print only results and errors from now on, or print messages again."""
    _state['quiet'] = quiet


def is_quiet() -> bool:
    """Return whether only results and errors are wanted."""
    return _state['quiet']


def say(words: str) -> None:
    """Print a message on stderr that is useful but not part of the result."""
    if not is_quiet():
        typer.echo(f'tauto: {spelled(words, option)}', err=True)


def say_oddities(scene: Scene, origin: str, *, anyway: bool) -> list[str]:
    """Print and return warnings about a scene to be sailed, `origin` as the user named it.

    Beyond all that is known it is refused by SceneError, unless it is to sail `anyway`.
    """
    from tauto_core.checks.readiness import check_known, oddities
    from tauto_core.scene.errors import naming

    with naming(origin, scene.name):
        if not anyway:
            check_known(scene)
        odd = oddities(scene)
    for warning in odd:
        say(warning)
    return odd


def say_warnings() -> None:
    """Print the package's own Python warnings from now on as messages."""
    original = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if category.__module__.startswith('tauto_core.'):
            say(message.args[0] if isinstance(message, Warning) else message)
        else:
            original(message, category, *where, **more)

    warnings.showwarning = show


@contextmanager
def saying_warnings() -> Iterator[None]:
    """Print the package's own Python warnings as messages, each time, in this context."""
    with warnings.catch_warnings():
        warnings.simplefilter('always', TautoWarning)
        say_warnings()
        yield


def print_rich(*parts: RenderableType, err: bool = False) -> None:
    """Print texts and tables below each other, without blanks at the ends of lines.

    A text stands as it is, without rich's markup.
    """
    from rich.console import Console

    console = Console(stderr=err, highlight=False, markup=False)
    with console.capture() as captured:
        for part in parts:
            console.print(part, crop=False)
    lines = captured.get().splitlines()
    typer.echo('\n'.join(line.rstrip() for line in lines), err=err)


# -----------------------------------------------------------------------------
# Standard output and error that may be closed, full, or of another encoding than UTF-8.

_PLAIN = {'−': '-', '–': '-', '—': '-', '…': '...', '√': 'sqrt', '≤': '<=', '≥': '>=', '→': '->'}
_GREEK = 'GREEK SMALL LETTER '
_HANDLER = 'tauto_plain'


def prepare_streams() -> None:
    """Let any text be printed, on any terminal."""
    open_closed_streams()
    codecs.register_error(_HANDLER, _plain)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def drop_output() -> None:
    """Discard output that stdout refused; otherwise the interpreter fails on it again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def open_closed_streams() -> None:
    """Open the null device in the place of streams that were closed (`2>&-`, some daemons).

    Python has None for them, and the next file to be opened would get their number, with all that
    C libraries print.
    """
    for name, mode in (('stdin', 'r'), ('stdout', 'w'), ('stderr', 'w')):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding='utf-8'))  # noqa: SIM115


def _plain(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return the replacement of a character that an encoding lacks, and the place after it.

    A minus becomes a hyphen, so that signs are kept. Python represents bytes of a file's name that
    are not text by lone surrogates; they are printed as these bytes, as other programs do.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    character, end = error.object[error.start], error.start + 1
    if '\udc80' <= character <= '\udcff':
        return bytes([ord(character) - 0xDC00]), end
    name = unicodedata.name(character, '')
    if name.startswith(_GREEK):
        return name.removeprefix(_GREEK).lower(), end
    return _PLAIN.get(character) or ascii(character)[1:-1], end


# -----------------------------------------------------------------------------
# SIGTERM, and SIGHUP of a terminal that is closed, as an exception, so that a run ends as after
# Ctrl-C; and none is lost.

# Time after which a lost signal is sent again: what lost it has ended by then.
_AGAIN_S = 0.05


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP, its first argument, was received during a run."""


_ending: list[int] = []
"""The signal by which the run ends, while it does: its bag is being closed."""


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """Turn the first SIGTERM or SIGHUP into `Terminated` for as long as the context lasts.

    Another one would break off what the first has begun, and is ignored; so is a SIGHUP that was
    ignored before (`nohup`).
    """

    def end(number: int, _frame: object) -> None:
        if not _ending:
            _ending.append(number)
            raise Terminated(number)

    numbers = [signal.SIGTERM, signal.SIGHUP]
    if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
        numbers.pop()
    handlers = [signal.signal(number, end) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, handlers, strict=True):
            signal.signal(number, handler)
        _ending.clear()


def send_lost_again() -> None:
    """Send SIGINT, SIGTERM or SIGHUP again where Python has lost its exception.

    An exception in a callback, such as the one that frees the lock of an import, is reported and
    dropped: Ctrl-C would have no effect.
    """
    report = sys.unraisablehook

    def hear(lost: sys.UnraisableHookArgs) -> None:
        if not issubclass(lost.exc_type, KeyboardInterrupt):
            report(lost)
            return
        number = _ending.pop() if _ending else signal.SIGINT
        timer = threading.Timer(_AGAIN_S, os.kill, (os.getpid(), number))
        timer.daemon = True
        timer.start()

    sys.unraisablehook = hear


# -----------------------------------------------------------------------------
# The progress bar.


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr, if that is a terminal, for as long as the context lasts.

    While a kernel compiles, the label in front names it, with the time that it takes. It yields a
    function to call with the share done so far, from 0 to 1.
    """
    if not sys.stderr.isatty() or is_quiet():
        yield lambda _share: None
        return
    from rich.console import Console
    from rich.progress import Progress

    from tauto_core.kernels import listening

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=1.0)

        def compiles(kernel: str | None, left_s: float) -> None:
            text = label
            if kernel is not None:
                text += f': compiling {kernel.removeprefix("tauto_core.")} once'
                text += f', about {left_s:.1f} s' if left_s else ''
            bar.update(task, description=text)

        with listening(compiles):
            yield lambda share: bar.update(task, completed=share)


@contextmanager
def counting_bar(things: str) -> Iterator[Callable[[float, int], None]]:
    """Show a bar on stderr, as `progress_bar` does, with the rate and the time left.

    `things` are what is counted, in the plural. It yields a function to call with the number done
    so far, parts included, and the total; with the share and 0 while there is none yet.
    """
    if not sys.stderr.isatty() or is_quiet():
        yield lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn('{task.fields[said]}'),
        BarColumn(),
        TextColumn('{task.fields[rate]}'),
        TimeRemainingColumn(),
        TextColumn('left'),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(things, total=1.0, rate='', said=things)

        def tell(done: float, total: int) -> None:
            speed = bar.tasks[task].speed if total else None
            rate = f'{speed:.3g} a second' if speed else ''
            text = f'{done:,.0f} of {total:,} {things}' if total else 'reading'
            bar.update(task, completed=done, total=total or 1.0, rate=rate, said=text)

        yield tell
