"""The programs that take part, by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module

from benchmarks.work_precision.peer import MissingPeerError, Peer
from tauto_core.scene.errors import UsageError


def _member(module: str, name: str) -> Callable[[], Peer]:
    """Return the constructor of a peer; its module is imported only then."""

    def make() -> Peer:
        peer: Peer = getattr(import_module(f'benchmarks.work_precision.peers.{module}'), name)()
        return peer

    return make


PEERS: dict[str, Callable[[], Peer]] = {
    'tauto': _member('tauto', 'Tauto'),
    'heyoka': _member('heyoka', 'Heyoka'),
    'heyoka_tuned': _member('heyoka', 'HeyokaTuned'),
    'heyoka_batch': _member('heyoka', 'HeyokaBatch'),
    'dop853_compiled': _member('dop853', 'CompiledDop853'),
}


def make_peers(names: Sequence[str] | None = None) -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and messages about the others.

    Args:
        names: keys of `PEERS`; None: all.

    Raises:
        UsageError: a name that is not known.
    """
    asked = list(PEERS) if names is None else list(names)
    unknown = [name for name in asked if name not in PEERS]
    if unknown:
        raise UsageError(f'peer {unknown[0]!r} is not known. Choose from {", ".join(PEERS)}')
    found, missing = [], []
    for name in asked:
        try:
            found.append(PEERS[name]())
        except MissingPeerError as error:
            missing.append(str(error))
    return found, missing
