"""Shared by commands: options, messages, streams, signals, progress bars."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from tauto_core.scene.errors import ABSENT, Argument, SceneError, TautoWarning, UsageError, spelled

if TYPE_CHECKING:
    from tauto_core.scene import Scene


# -----------------------------------------------------------------------------
# Options of several commands.


SceneName: TypeAlias = Annotated[
    str,
    typer.Argument(metavar='SCENE', help='A YAML file, or a name listed by `tauto scenes`.'),
]
AsJson: TypeAlias = Annotated[
    bool, typer.Option('--json', help='Print exactly one JSON object on stdout.')
]
Settings: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        '--set',
        metavar='KEY=VALUE',
        help='Another value for a key of the scene, such as ship.sea.peak_period=8. May be '
        'repeated. The value null removes the key.',
    ),
]


def given_values(settings: list[str] | None) -> dict[str, Any]:
    """Return the values of --set by path, `ABSENT` for null.

    UsageError without KEY=VALUE, for a wrong or empty value, or a key that is given twice.
    """
    values: dict[str, Any] = {}
    for setting in settings or ():
        from tauto_core.scene.loader import read_mapping

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
                "if it has blanks or brackets: --set 'voyage.departure=[50.8, -1.1]'"
            ) from None
        if values[path] is None and text.lower() not in ('null', '~'):
            raise UsageError(f'--set {setting}: has no value. Write one after the =')
        if values[path] is None:
            values[path] = ABSENT
    return values


# endings of arguments that options lack
_UNITS = ('_mm', '_deg', '_rad', '_s')


def option(argument: Argument) -> str:
    """Return an argument as an option of the command line."""
    unit = next(filter(argument.name.endswith, _UNITS), '')
    plain = argument.name.removesuffix(unit).replace('_', '-')
    name = '--out' if argument.name == 'file' else f'--{plain}'
    if argument.value is None or argument.value is True:
        return name
    return f'{name}{" = " if argument.spaced else " "}{argument.value}'


# -----------------------------------------------------------------------------
# Messages on stderr, which --quiet suppresses.

messages = {'are_quiet': False}
"""Whether only results and errors are printed."""


def say(words: str) -> None:
    """Print a message on stderr."""
    if not messages['are_quiet']:
        typer.echo(f'tauto: {spelled(words, option)}', err=True)


def say_plausibility(scene: Scene, origin: str, *, anyway: bool) -> list[str]:
    """Print and return warnings about a scene, which the user named `origin`.

    SceneError if machine or ship are larger than any known, unless `anyway`.
    """
    from tauto_core.checks.readiness import check_known, plausibility_warnings
    from tauto_core.scene.errors import naming

    with naming(origin, scene.name):
        if not anyway:
            check_known(scene)
        odd = plausibility_warnings(scene)
    for warning in odd:
        say(warning)
    return odd


@contextmanager
def saying_warnings() -> Iterator[None]:
    """Print all of the package's Python warnings as messages in this context."""
    original = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if category.__module__.startswith('tauto_core.'):
            say(message.args[0] if isinstance(message, Warning) else message)
        else:
            original(message, category, *where, **more)

    with warnings.catch_warnings():
        warnings.simplefilter('always', TautoWarning)
        warnings.showwarning = show
        yield


# -----------------------------------------------------------------------------
# Standard streams may be closed or full, or have another encoding than UTF-8.


def prepare_streams() -> None:
    """Open closed streams, and print characters that their encoding lacks as escapes."""
    open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors='backslashreplace')


def drop_output() -> None:
    """Discard output that stdout refused, since the interpreter would fail on it again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def open_closed_streams() -> None:
    """Open the null device for streams that were closed (`2>&-`, some daemons).

    Otherwise the next opened file would get their number, with the output of C libraries.
    """
    for name, mode in (('stdin', 'r'), ('stdout', 'w'), ('stderr', 'w')):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding='utf-8'))  # noqa: SIM115


# -----------------------------------------------------------------------------
# SIGTERM, and SIGHUP of a closed terminal, end a run with an exception, as Ctrl-C does.

# delay before a lost signal is sent again
_AGAIN_S = 0.05


class Terminated(KeyboardInterrupt):
    """SIGTERM or SIGHUP, its first argument, was received during a run."""


_ending: list[int] = []
"""The signal that ends the run, while its bag is being closed."""


@contextmanager
def ended_by_sigterm() -> Iterator[None]:
    """In a context, convert the first SIGTERM or SIGHUP to `Terminated`.

    Further ones are ignored, since they would interrupt the closing, and so is a SIGHUP that was
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
    """Send SIGINT, SIGTERM or SIGHUP again if Python has dropped its exception.

    Python only reports an exception in a callback, such as the release of an import lock.
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
# Progress bars.


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[..., None]]:
    """Show a bar on stderr, if it is a terminal; yield a function of the share done, 0 to 1.

    Items named `label` may be counted: then the function takes the number done, with fractions,
    and the total, or the share done and 0 while the total is unknown. While a kernel compiles, the
    label has its name and the expected time.
    """
    if not sys.stderr.isatty() or messages['are_quiet']:
        yield lambda *_: None
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

        def progress(done: float, total: int = 0) -> None:
            text = f'{done:,.0f} of {total:,} {label}' if total else None
            bar.update(task, completed=done, total=total or 1.0, description=text)

        with listening(compiles):
            yield progress
