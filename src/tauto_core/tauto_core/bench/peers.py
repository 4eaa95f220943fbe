"""Who takes part: every program by its name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module

from tauto_core.bench.peer import MissingPeerError, Peer
from tauto_core.scene.errors import UsageError


def _member(module: str, name: str, *arguments: str) -> Callable[[], Peer]:
    """Return what makes a peer; its module is imported only then."""

    def make() -> Peer:
        peer: Peer = getattr(import_module(f'tauto_core.bench.{module}'), name)(*arguments)
        return peer

    return make


PEERS: dict[str, Callable[[], Peer]] = {
    'tauto': _member('tauto_peer', 'Tauto'),
    'heyoka': _member('heyoka_peer', 'Heyoka'),
    'heyoka_tuned': _member('heyoka_tuned', 'HeyokaTuned'),
    'dop853': _member('scipy_peers', 'SciPy', 'DOP853'),
    'dop853_compiled': _member('dop853_peer', 'CompiledDop853'),
    'lsoda': _member('scipy_peers', 'SciPy', 'LSODA'),
    'radau': _member('scipy_peers', 'SciPy', 'Radau'),
    'diffrax': _member('diffrax_peer', 'Diffrax'),
    'cvode': _member('cvode_peer', 'Cvode'),
    'mujoco': _member('mujoco_peer', 'Mujoco'),
    'verlet': _member('symplectic_peers', 'Symplectic', 'verlet'),
    'yoshida6': _member('symplectic_peers', 'Symplectic', 'yoshida6'),
    'yoshida8': _member('symplectic_peers', 'Symplectic', 'yoshida8'),
}


def make_peers(names: Sequence[str] | None = None) -> tuple[list[Peer], list[str]]:
    """Return the peers that are installed, and what is said of those that are not.

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
