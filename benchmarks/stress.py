"""Numerical stability: a table of measured figures and the limits that they must keep.

    .venv/bin/python benchmarks/stress.py [SECTION ...]

Without sections all are run; most of the time goes to 1e8 oscillations. A section that is run
alone replaces its rows in benchmarks/stress.json and leaves the others with their date. The exit
code is 1 if a row is unexpectedly out of its limits, or unexpectedly within them.
"""

from __future__ import annotations

import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import stress_forecast
import stress_hull
import stress_live
import stress_motion
import stress_search
from stress_cases import Row

RESULTS = Path(__file__).with_suffix('.json')
LIBRARIES = ('numpy', 'scipy', 'llvmlite', 'hypothesis')

SECTIONS: dict[str, tuple[Callable[[], list[Row]], ...]] = {
    'drift': (
        partial(stress_motion.weight_driven, 1e8),
        partial(stress_motion.isochronous, 1e5, 8),
    ),
    'land': (
        stress_motion.tolerances,
        stress_motion.amplitudes,
        stress_motion.mass_ratios,
        stress_motion.springs_and_holes,
        stress_motion.drag,
        stress_motion.escapement,
    ),
    'sea': (
        stress_motion.strong_roll,
        stress_motion.resonance,
        stress_motion.rates,
        stress_motion.ratios,
    ),
    'forecast': (
        stress_forecast.bounds,
        stress_forecast.accuracies,
        stress_forecast.hours,
        stress_forecast.extrapolations,
    ),
    'search': (partial(stress_search.search, 200),),
    'counting': (stress_search.recoil,),
    'hull': (stress_hull.direct_runs,),
    'live': (stress_live.live,),
}


def measure(section: str) -> dict[str, Any]:
    """Return the rows of a section, with date and run time."""
    began = time.perf_counter()
    rows = []
    for part in SECTIONS[section]:
        for row in part():
            rows.append(
                {
                    'name': row.name,
                    'setting': row.setting,
                    'measured': float(f'{row.measured:.4g}')
                    if math.isfinite(row.measured)
                    else None,
                    'limit': row.limit,
                    'holds': row.holds,
                    **({'known_fault': row.known_fault} if row.known_fault else {}),
                }
            )
            figures = f'{row.name} | {row.setting} | {row.measured:.3g} | {row.limit}'
            print(f'{figures}   {row.verdict}'.rstrip(), flush=True)
    return {
        'date': datetime.now(UTC).date().isoformat(),
        'run_s': round(time.perf_counter() - began, 1),
        'machine': {
            'cpus': os.cpu_count(),
            'processor': platform.machine(),
            'python': platform.python_version(),
            **{name: version(name) for name in LIBRARIES},
        },
        'rows': rows,
    }


def main(wanted: list[str]) -> int:
    """Measure, print and write; return 1 if a row is unexpected, 2 for an unknown section."""
    unknown = [section for section in wanted if section not in SECTIONS]
    if unknown:
        print(f'{unknown[0]!r} is no section; there are {", ".join(SECTIONS)}', file=sys.stderr)
        return 2
    for section in wanted or SECTIONS:
        found = measure(section)
        # read again, since another process may have measured another section meanwhile
        known = json.loads(RESULTS.read_text('utf-8')) if RESULTS.exists() else {}
        known[section] = found
        ordered = {name: known[name] for name in SECTIONS if name in known}
        RESULTS.write_text(json.dumps(ordered, indent=2) + '\n', 'utf-8')
    table = json.loads(RESULTS.read_text('utf-8'))
    rows = [row for part in table.values() for row in part['rows']]
    return int(not all(row['holds'] != bool(row.get('known_fault')) for row in rows))


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
