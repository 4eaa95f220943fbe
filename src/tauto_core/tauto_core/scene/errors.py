"""The exceptions of tauto_core. Messages name the thing, its value, the limit and the remedy.

`exit_code` is the exit code of the command line: 2 for a bad command line or scene, else 1.
"""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

# Messages show long or deep values shortened.
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80
_SHORT.maxlevel = 2


@dataclass(frozen=True)
class Argument:
    """An argument of a call in a message, spelled differently by Python and the command line.

    Attributes:
        name: its name in Python.
        value: the value that was given, or an example, if any.
        spaced: whether there are blanks around the equals sign.
    """

    name: str
    value: object = None
    spaced: bool = False

    def __str__(self) -> str:
        sign = ' = ' if self.spaced else '='
        return f'{self.name}{sign}{"" if self.value is None else self.value}'


class ArgumentText(str):
    """A text with arguments: a str in the spelling of Python, with its parts."""

    parts: tuple[str | Argument, ...]

    def __new__(cls, *parts: str | Argument) -> ArgumentText:
        """Join texts and arguments."""
        text = super().__new__(cls, ''.join(map(str, parts)))
        flat = (item.parts if isinstance(item, ArgumentText) else (item,) for item in parts)
        text.parts = tuple(part for group in flat for part in group)
        return text

    def __getnewargs__(self) -> tuple[Any, ...]:
        return self.parts


def spelled(text: str, spell: Callable[[Argument], str]) -> str:
    """Return a text with its arguments, if any, spelled by `spell`."""
    parts = text.parts if isinstance(text, ArgumentText) else (text,)
    return ''.join(spell(part) if isinstance(part, Argument) else part for part in parts)


class TautoError(Exception):
    """Base of every error that tauto_core raises on purpose. It can be pickled.

    Args:
        parts: the message, as texts and `Argument`s.
    """

    exit_code = 1

    def __init__(self, *parts: str | Argument) -> None:
        super().__init__(*(parts if len(parts) < 2 else (ArgumentText(*parts),)))

    @property
    def message(self) -> str:
        """The message, an `ArgumentText` if it names arguments."""
        return self.args[0] if self.args else ''

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[TautoError], args: tuple[Any, ...], state: dict[str, Any]) -> TautoError:
    """Return an error with its class and attributes, for any signature of its constructor."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class _Absent:
    """The type of `ABSENT`, the value of a key that is absent."""

    def __repr__(self) -> str:
        return 'absent'

    def __reduce__(self) -> str:
        return 'ABSENT'


ABSENT = _Absent()


@dataclass(frozen=True)
class Problem:
    """A fault of a scene.

    Args:
        key: path to the key, for example `trochlea.cam.base_radius`, empty for the whole file.
        value: the value there, as the user wrote it, or `ABSENT`.
        problem: the fault, with the limit.
        remedy: the advice, as a sentence.
    """

    key: str
    value: object
    problem: str
    remedy: str

    def __str__(self) -> str:
        return str(self.text)

    @property
    def text(self) -> ArgumentText:
        """The problem as a message."""
        value_text = '' if self.value is ABSENT else f' = {_SHORT.repr(self.value)}'
        where = f'{self.key}{value_text}: ' if self.key else ''
        return ArgumentText(where, self.problem, '. ', self.remedy)


def problems_where(*rows: tuple[object, str, object, str, str]) -> Iterator[Problem]:
    """Yield a problem for each row (condition, *problem) if its condition is true."""
    return (Problem(key, value, *words) for holds, key, value, *words in rows if holds)


class SceneError(TautoError):
    """A scene that cannot be run. The message lists all problems, one on each line.

    Args:
        file: the scene's file or built-in name.
        key: see `Problem`, also for `value`, `problem` and `remedy`, of the first problem.
        value: see `Problem`.
        problem: see `Problem`.
        remedy: see `Problem`.
        further: the other problems of the same scene.
    """

    exit_code = 2

    def __init__(
        self,
        file: str,
        key: str,
        value: object,
        problem: str,
        remedy: str,
        *,
        further: Iterable[Problem] = (),
    ) -> None:
        self.file = file
        self.key = key
        self.value = value
        self.problem = problem
        self.remedy = remedy
        self.problems = (Problem(key, value, problem, remedy), *further)
        lines = [part for item in self.problems for part in ('\n', f'{file}: ', item.text)]
        super().__init__(*lines[1:])

    @classmethod
    def of(cls, file: str, problems: Iterable[Problem]) -> SceneError:
        """Return the error of all problems of a scene, at least one."""
        head, *further = problems
        return cls(file, head.key, head.value, head.problem, head.remedy, further=further)


@contextmanager
def naming(file: str, name: str) -> Iterator[None]:
    """In errors, replace the name of a loaded scene by the file that the user gave."""
    try:
        yield
    except SceneError as error:
        if error.file != name:
            raise
        raise SceneError.of(file, error.problems) from None


class UsageError(TautoError):
    """A wrong argument of a command or call, found before anything starts."""

    exit_code = 2


def install(extra: str) -> str:
    """Return the command that installs an extra of the package."""
    return f"pip install 'tauto_core[{extra}]'"


class CamRangeError(TautoError):
    """An angle beyond the range of a cam."""


class DescentError(TautoError):
    """A body, fluid, curve or start without a descent."""


class MotionDataError(TautoError):
    """Measured motion of a scene that cannot be used. The message has file and line."""

    exit_code = 2


class PropagationError(TautoError):
    """An event that ends the motion: slack thread, edge of the cam, no convergence.

    Args:
        what: the event, with the quantity, its limit and the remedy.
        time_s: time of the event from the start of the scene [s].
    """

    def __init__(self, what: str, time_s: float) -> None:
        self.time_s, self.what = time_s, what
        super().__init__(f'at t = {time_s:.3f} s: {what}')


class EstimationError(TautoError):
    """Readings or observations that a drift estimate cannot use."""


class BagError(TautoError):
    """A bag that cannot be read or written."""


class BagPlaceError(BagError):
    """No bag to read, or no bag can be written there, found before anything starts."""

    exit_code = 2


class TautoWarning(UserWarning):
    """A message about a result or its progress, such as a repair or a repeated attempt."""
