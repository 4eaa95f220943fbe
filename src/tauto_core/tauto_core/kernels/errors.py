"""Errors and warnings of kernels."""

from __future__ import annotations

from tauto_core.scene.errors import TautoError


class KernelError(TautoError):
    """A kernel cannot be compiled; the message says what, and where in which file.

    Attributes:
        places: file, line and function of the fault, and of each call on the way to it.
        passed: the lowering that added the last of them.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.places: list[str] = []
        self.passed: object = None

    def __str__(self) -> str:
        return '\n  '.join([super().__str__(), *self.places])


class KernelCacheWarning(UserWarning):
    """Compiled kernels cannot be stored, so that each run compiles them again."""
