"""The machine on which a benchmark ran."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

_CPU_INFO = Path('/proc/cpuinfo')


def machine_facts(versions: Mapping[str, str]) -> dict[str, Any]:
    """Return processor, number of its cores, system, Python, date and versions.

    Args:
        versions: versions of the peers, by their names.
    """
    return {
        'processor': _processor(),
        'cpus': os.cpu_count(),
        'system': platform.system(),
        'python': platform.python_version(),
        'date': datetime.now(UTC).date().isoformat(),
        'versions': {
            **versions,
            **{name: version(name) for name in ('numpy', 'numba', 'scipy')},
        },
    }


def _processor() -> str:
    if _CPU_INFO.exists():
        for line in _CPU_INFO.read_text('utf-8').splitlines():
            name, _, value = line.partition(':')
            if name.strip() == 'model name':
                return value.strip()
    return platform.processor() or platform.machine()
