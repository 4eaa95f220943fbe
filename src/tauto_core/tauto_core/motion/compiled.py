"""The decorators of the compiled kernels: no GIL, a cache on disk that follows the package."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, cast

from numba import njit

from tauto_core.curves import levers

# Nothing is allocated in kernels: without counting references, arrays are as cheap as pointers.
_OPTIONS: dict[str, Any] = {'cache': True, 'nogil': True, 'error_model': 'numpy', '_nrt': False}

_INTERNAL: dict[str, Any] = {**_OPTIONS, 'no_cpython_wrapper': True, 'no_cfunc_wrapper': True}

# Constants and lever laws of these are compiled into the kernels.
_KERNELS = (
    'arc_length',
    'arrival',
    'axle',
    'compiled',
    'counting',
    'event_search',
    'events',
    'gauss',
    'hanging_planes',
    'lanes',
    'layout',
    'lever_plane',
    'lever_shape',
    'mechanism',
    'outside',
    'roots',
    'rotation',
    'span_events',
    'spans',
    'step_size',
    'stepping',
    'turn_and_add',
    'turning',
    'wells',
    'wheel_plane',
)
_ENGINE = (
    *(Path(__file__).with_name(f'{name}.py') for name in _KERNELS),
    Path(levers.__file__),
)
_LANES = tuple(Path(__file__).with_name(f'{name}.py') for name in ('compiled', 'lanes'))


@cache
def _hash(sources: tuple[Path, ...]) -> str:
    """Return the hash of all that kernels are made from."""
    whole = sha256()
    for path in sources:
        whole.update(path.read_bytes())
    return whole.hexdigest()


def _cached(kernel: Any, sources: tuple[Path, ...]) -> Callable[..., Any]:
    index: Any = getattr(getattr(kernel, '_cache', None), '_cache_file', None)
    if hasattr(index, '_source_stamp'):
        index._source_stamp = (index._source_stamp, _hash(sources))
    return cast(Callable[..., Any], kernel)


def inlined(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile into whatever calls it: for what is short, or called in one place that is hot."""
    options = {**_INTERNAL, 'forceinline': True}
    return _cached(njit(**options)(function), _ENGINE)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile for calls from other compiled functions only."""
    return _cached(njit(**_INTERNAL)(function), _ENGINE)


def entry(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile for calls from Python; kept on disk until any source of this package changes.

    Numba's own cache looks at the file that defines a function, not at those it calls into. Its
    stamp is private: where a later numba hides it, only who edits the kernels must clear
    `__pycache__` by hand.
    """
    return _cached(njit(**_OPTIONS)(function), _ENGINE)


def on_lanes(**options: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator for what uses lanes outside the engine, and may allocate.

    Kept on disk until its own file or that of the lanes changes.

    Args:
        options: of numba, besides the cache and no GIL.
    """

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        return _cached(njit(cache=True, nogil=True, **options)(function), _LANES)

    return decorate
