"""Whether the ± of a projection is what seeds scatter by: shipped scenes in a sea, many seeds.

    .venv/bin/python benchmarks/projection_consistency.py [--seeds 30] [--scene SCENE …]

Each seed draws the waves and the errors of the observations anew. Of the seeds whose run is
projected, the errors after 42 days are compared with their standard deviations: of the dial from
the mean over the seeds, which is what the seeds have in common; of the corrected clock its error
if the dial had that rate. `ratio` is the standard deviation over the seeds over the root mean
square of those stated, and has to lie in 0.5–2; it is None where fewer than two seeds are
projected. A reason that lies in the machine holds for all seeds, so one is tried.
`portsmouth_jamaica` is left out: it takes minutes a seed, and is a trial, which is not
projected. The result is written to benchmarks/projection_consistency.json.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tauto_core.navigation.verdict import TOO_SHORT
from tauto_core.scene import load_scene, shipped_scenes
from tauto_core.voyage import sail

LEFT_OUT = ('portsmouth_jamaica',)


def consistency(name: str, seeds: int) -> dict[str, Any]:
    """Return scatter, stated standard deviations and their ratio of a scene, and why not."""
    first, refused = [], Counter[str]()
    for seed in range(seeds):
        found = sail(load_scene(name, seed=seed)).result['longitude']
        first += [row for row in found['projection'][:1] if None not in row.values()]
        if reason := found['not_projected']:
            refused[reason.partition(', ')[0]] += 1
            if not reason.startswith(TOO_SHORT):
                break
    result: dict[str, Any] = {'scene': name, 'projected': len(first), 'refused': dict(refused)}
    if len(first) < 2:
        return {**result, 'ratio': None, 'corrected_ratio': None}
    dial, corrected = (np.array([row[f'{key}error_nmi'] for row in first]) for key in ('raw_', ''))
    stated = [
        float(np.sqrt(np.mean([row[f'{key}sigma_nmi'] ** 2 for row in first])))
        for key in ('raw_', '')
    ]
    mean = float(np.mean(dial))
    wrong = corrected - dial + mean
    scatter = float(np.std(dial, ddof=1)), float(np.sqrt(np.mean(wrong**2)))
    return {
        **result,
        'mean_nmi': mean,
        'scatter_nmi': scatter[0],
        'stated_nmi': stated[0],
        'ratio': scatter[0] / stated[0],
        'corrected_scatter_nmi': scatter[1],
        'corrected_stated_nmi': stated[1],
        'corrected_ratio': scatter[1] / stated[1],
    }


def main() -> None:
    """Print a line for each scene, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=30)
    parser.add_argument('--scene', action='append', help='instead of all', default=[])
    parser.add_argument('--out', type=Path, default=Path(__file__).with_suffix('.json'))
    given = parser.parse_args()
    at_sea = [name for name in shipped_scenes() if load_scene(name).ship.kind == 'sea']
    rows = []
    for name in given.scene or [each for each in at_sea if each not in LEFT_OUT]:
        rows.append(consistency(name, given.seeds))
        print(rows[-1], flush=True)
    result = {'seeds': given.seeds, 'rows': rows}
    given.out.write_text(json.dumps(result, indent=1, ensure_ascii=False) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
