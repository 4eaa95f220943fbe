"""Parameter files: that of a graph is written, and what all nodes share in others is found."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml

_SHARED = '/**'
_FILE = '--params-file'


def write_parameters(
    folder: Path, namespace: str, own: Mapping[str, Mapping[str, object]]
) -> Path:
    """Write a file with the parameters of a graph's nodes; return its path.

    Args:
        folder: where to write it.
        namespace: namespace of the graph; empty: the root.
        own: parameters of each node, by its name.
    """
    space = f'/{namespace.strip("/")}'.rstrip('/')
    # No object comes twice: the parser of ROS takes no YAML aliases.
    content = {f'{space}/{node}': {'ros__parameters': {**held}} for node, held in own.items()}
    file = folder / 'parameters.yaml'
    file.write_text(yaml.safe_dump(content), 'utf-8')
    return file


def shared_names(node: str, arguments: Sequence[str]) -> frozenset[str]:
    """Return the names in the section `/**` of the files that no section for this node sets.

    What the command line sets (`-p`) is not among them, whatever files say.

    Args:
        node: fully qualified name.
        arguments: arguments of the command line that names the files.
    """
    shared: set[str] = set()
    own = {word.partition(':=')[0] for word in arguments if ':=' in word}
    for section, names in _sections(arguments):
        if section == _SHARED:
            shared |= names
        elif _matches(section, node):
            own |= names
    return frozenset(shared - own)


def _sections(arguments: Sequence[str]) -> Iterator[tuple[str, set[str]]]:
    """Yield the sections of the files with the names that each sets; ROS checks the files."""
    for word, file in pairwise(arguments):
        if word != _FILE:
            continue
        content = yaml.safe_load(Path(file).read_text('utf-8'))
        for section, held in (content or {}).items():
            yield section, set(_flat(held.get('ros__parameters', {})))


def _flat(parameters: Mapping[str, Any], prefix: str = '') -> Iterator[str]:
    for name, value in parameters.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f'{prefix}{name}.')
        else:
            yield f'{prefix}{name}'


def _matches(section: str, node: str) -> bool:
    """Whether the section of a file is of this node: `*` is one token, `**` any number of them."""
    pattern = re.escape('/' + section.strip('/')).replace(r'\*\*', '.*').replace(r'\*', '[^/]*')
    return re.fullmatch(pattern.replace('/.*/', '/(.*/)?'), node) is not None
