"""The version of this code, and a hash of all its files.

The hash decides whether two machines give the same bits: it includes uncommitted changes and needs
no git.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from functools import cache
from pathlib import Path

BASE = '0.3.0.dev0'
"""The release, or with `.dev0` the next release. setup.py reads it; a test compares other copies.
"""

_PACKAGE = Path(__file__).resolve().parent


@cache
def version() -> str:
    """Return the base, in a git checkout with the commit unless it has the tag `v<base>`.

    Example: `0.3.0.dev0+g17e64160a2b1`, with `.dirty` appended if tracked files have changed.
    """
    root = _PACKAGE.parents[2]
    if not (root / '.git').exists():
        return BASE
    tag = f'v{BASE}'
    words = ('describe', '--tags', '--always', '--dirty', '--abbrev=12', '--match', tag)
    # in a hook of another repository GIT_DIR would name that one
    clean = {name: value for name, value in os.environ.items() if not name.startswith('GIT_')}
    try:
        run = subprocess.run(
            ('git', '-C', str(root), *words),
            capture_output=True,
            text=True,
            check=True,
            env=clean | {'GIT_OPTIONAL_LOCKS': '0'},
        )
    except (OSError, subprocess.CalledProcessError):
        return BASE
    text = run.stdout.strip()
    commit = text.removesuffix('-dirty').removeprefix(tag).rpartition('-')[2].removeprefix('g')
    parts = [f'g{commit}'] if commit else []
    parts += ['dirty'] if text.endswith('-dirty') else []
    return '+'.join([BASE, '.'.join(parts)]) if parts else BASE


@cache
def code(package: Path = _PACKAGE) -> str:
    """Return twelve digits of a hash of all files in the folder of this package."""
    digest = hashlib.sha256()
    for file in sorted(package.rglob('*')):
        name = file.relative_to(package).as_posix()
        hidden = '__pycache__' in file.parts or file.name.startswith('.')
        if file.is_file() and not hidden:
            content = file.read_bytes()
            digest.update(f'{name}\0{len(content)}\0'.encode() + content)
    return digest.hexdigest()[:12]


def identity() -> str:
    """Return base and hash. If they are equal, a scene gives the same bits."""
    return f'{BASE} (code {code()})'
