"""The state of a stage in a file: versioned, checked, replaced in one step, read without pickle.

The first line is JSON about the rest, the second the state as JSON: arrays as base64 of their
bytes, what JSON does not have (tuples, samples, keys that are no strings) under one-key objects.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core import samples as s
from tauto_core.samples import State
from tauto_core.scene import Scene, scene_yaml
from tauto_core.version import code
from tauto_core.whole_file import write_whole
from tauto_nodes.errors import ParameterError

VERSION = 1
FORMAT = 'tauto state'

_SAMPLES = {
    kind.__name__: kind
    for kind in (s.TextSamples, s.ImuSamples, s.JointSamples, s.TimeSamples, s.FixSamples)
}
_DTYPES = ('<f8', '<i8', '|b1', '|i1', '|u1', '<u2', '<i4')


class StateFile:
    """One node's state file.

    Args:
        folder: where it lies; made if it is not there.
        node: fully qualified name of the node.
        scene: the scene that the stage was made from; a state of another one is refused.
    """

    def __init__(self, folder: Path, node: str, scene: Scene) -> None:
        self.path = folder / f'{node.strip("/").replace("/", ".")}.state'
        self._head = {
            'format': FORMAT,
            'version': VERSION,
            'code': code(),
            'node': node,
            'scene': hashlib.sha256(scene_yaml(scene).encode()).hexdigest(),
        }
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ParameterError(
                f'state_folder = {str(folder)!r}: cannot be made ({error.strerror}); '
                'name another folder'
            ) from error

    def load(self) -> State | None:
        """Return the state; None where there is no file.

        Raises:
            ParameterError: a file that is damaged, or of another version, code, node or scene.
        """
        try:
            head, body = self.path.read_bytes().split(b'\n', 1)
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise self._refused(f'cannot be read ({error})') from error
        try:
            said = json.loads(head)
        except ValueError as error:
            raise self._refused('is not a state file') from error
        for name, value in self._head.items():
            found = said.get(name) if isinstance(said, dict) else None
            if found != value:
                raise self._refused(f'is of another {name} ({found} in place of {value})')
        if said.get('sha256') != hashlib.sha256(body).hexdigest():
            raise self._refused('is damaged')
        state: State = _opened(json.loads(body))
        return state

    def save(self, state: State) -> None:
        """Replace the file in one step; OSError where the file system refuses."""
        body = json.dumps(_packed(state)).encode()
        head = json.dumps({**self._head, 'sha256': hashlib.sha256(body).hexdigest()}).encode()
        write_whole(self.path, head + b'\n' + body)

    def remove(self) -> None:
        """Remove the file: the run is over."""
        self.path.unlink(missing_ok=True)

    def _refused(self, why: str) -> ParameterError:
        return ParameterError(
            f'{self.path} {why}; move it away to start with a dial that is set anew, or name '
            'another state_folder'
        )


def _packed(value: Any) -> Any:
    """Return a value of a state as JSON can hold it."""
    match value:
        case None | bool() | int() | float() | str():
            packed: Any = value.item() if isinstance(value, np.generic) else value
        case np.generic():
            packed = value.item()
        case np.ndarray() if value.dtype == object:
            packed = {'objects': [_packed(one) for one in value.tolist()]}
        case np.ndarray():
            octets = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
            packed = {'array': [value.dtype.str, list(value.shape), octets]}
        case tuple():
            packed = {'tuple': [_packed(one) for one in value]}
        case list():
            packed = [_packed(one) for one in value]
        case Mapping():
            packed = {'items': [[_packed(key), _packed(one)] for key, one in value.items()]}
        case _ if type(value).__name__ in _SAMPLES:
            packed = {'samples': [type(value).__name__, _packed(vars(value))]}
        case _:
            raise TypeError(f'a state holds {type(value).__name__}, which has no spelling')
    return packed


def _opened(value: Any) -> Any:
    """Return what `_packed` was given."""
    if isinstance(value, list):
        return [_opened(one) for one in value]
    if not isinstance(value, dict):
        return value
    ((kind, held),) = value.items()
    opened: Any
    match kind:
        case 'array':
            dtype, shape, octets = held
            if dtype not in _DTYPES:
                raise ValueError(f'an array of {dtype}')
            opened = np.frombuffer(base64.b64decode(octets), dtype).reshape(shape).copy()
        case 'objects':
            opened = np.empty(len(held), object)
            opened[:] = [_opened(one) for one in held]
        case 'tuple':
            opened = tuple(_opened(one) for one in held)
        case 'items':
            opened = {_opened(key): _opened(one) for key, one in held}
        case _:
            name, fields = held
            opened = _SAMPLES[name](**_opened(fields))
    return opened
