"""Kernels: functions in a subset of Python that are compiled through LLVM (docs/kernels.md)."""

from tauto_core.kernels.entries import CompiledFunction, entry, optimised
from tauto_core.kernels.marks import (
    KernelCacheWarning,
    KernelError,
    compiled,
    inlined,
    intrinsic,
    listening,
)

__all__ = [
    'CompiledFunction',
    'KernelCacheWarning',
    'KernelError',
    'compiled',
    'entry',
    'inlined',
    'intrinsic',
    'listening',
    'optimised',
]
