"""The exceptions of tauto_core.

Every message names the thing, its value, the limit and the remedy. `exit_code` is what the
command line returns: 2 for a bad command line or scene, 1 for anything that failed on the way.
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

# Long or deep values are shortened, so that a message stays readable whatever the file contains.
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80
_SHORT.maxlevel = 2


class TautoError(Exception):
    """Base of every error that tauto_core raises on purpose; it can be sent between processes."""

    exit_code = 1

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self.args, self.__dict__)


def _restored(kind: type[TautoError], args: tuple[Any, ...], state: dict[str, Any]) -> TautoError:
    """Return an error with its class and attributes, whatever its constructor takes."""
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
    """One thing that is wrong with a scene.

    Args:
        key: path to the key, for example `trochlea.cam.base_radius`; empty for the whole file.
        value: what was found there, as the user wrote it; `ABSENT` where nothing was.
        problem: what is wrong, with the limit.
        remedy: what to write instead, as a sentence.
    """

    key: str
    value: object
    problem: str
    remedy: str

    def __str__(self) -> str:
        if not self.key:
            return f'{self.problem}. {self.remedy}'
        found = '' if self.value is ABSENT else f' = {_SHORT.repr(self.value)}'
        return f'{self.key}{found}: {self.problem}. {self.remedy}'


class SceneError(TautoError):
    """A scene that cannot be run. The message lists all problems, one on each line.

    Args:
        file: the scene's file or shipped name.
        key: path to the key, for example `trochlea.cam.base_radius`; empty for the whole file.
        value: what was found there, as the user wrote it.
        problem: what is wrong, with the limit.
        remedy: what to write instead.
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
        super().__init__('\n'.join(f'{file}: {each}' for each in self.problems))


@contextmanager
def naming(file: str, name: str) -> Iterator[None]:
    """Replace the scene's name by its file in errors of a scene that is already loaded.

    Args:
        file: the file or name that the user gave.
        name: name of the scene.
    """
    try:
        yield
    except SceneError as error:
        if error.file != name:
            raise
        first, *further = error.problems
        raise SceneError(
            file, first.key, first.value, first.problem, first.remedy, further=further
        ) from None


class UsageError(TautoError):
    """A command or call with arguments that do not fit; nothing was started."""

    exit_code = 2


def install(extra: str) -> str:
    """Return the command that installs an extra of the package, for remedies."""
    return f"pip install 'tauto_core[{extra}]'"


class CamRangeError(TautoError):
    """An angle beyond the range of a cam."""


class DescentError(TautoError):
    """A body, fluid, curve or start that makes no descent; names value, limit and remedy."""


class MotionDataError(TautoError):
    """Measured motion that cannot be used: names file, line, value, limit, remedy.

    It is part of a scene and read before anything starts.
    """

    exit_code = 2


class PropagationError(TautoError):
    """An event that ends the motion: slack thread, edge of the cam, no convergence.

    Args:
        what: the event, with the quantity and its limit, and the remedy.
        time_s: time of the event from the start of the scene [s].
    """

    def __init__(self, what: str, time_s: float) -> None:
        self.time_s = time_s
        super().__init__(f'at t = {time_s:.3f} s: {what}')


class EstimationError(TautoError):
    """Readings or observations that a drift estimate cannot use."""


class BagError(TautoError):
    """A bag that cannot be read or written; names the file, the problem and the remedy."""


class BagPlaceError(BagError):
    """No bag to read, or a place where no bag can be written; nothing was started."""

    exit_code = 2


class TautoWarning(UserWarning):
    """What a command says besides its result: what it waits for, mends, or does again."""
