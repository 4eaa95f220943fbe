"""Kernels: functions in a subset of Python that are compiled through LLVM (docs/kernels.md)."""

from tauto_core.kernels.entries import Entry, entry, optimised
from tauto_core.kernels.errors import KernelCacheWarning, KernelError
from tauto_core.kernels.marks import compiled, inlined, intrinsic
from tauto_core.kernels.progress import listening

__all__ = [
    'Entry',
    'KernelCacheWarning',
    'KernelError',
    'compiled',
    'entry',
    'inlined',
    'intrinsic',
    'listening',
    'optimised',
]
