"""How often the 95 % intervals of `tauto replay --stability` contain the true deviation.

    .venv/bin/python benchmarks/stability_coverage.py [--runs 500] [--out FILE]

Seeded noise of exactly known spectrum (`power_law_noise`) is analysed by `stability`, and each
interval is compared with the theoretical deviation: for all deviations, averaging times and kinds
of noise, some lengths of record, and clocks of one kind at short and another at long times. The
result is written to benchmarks/stability_coverage.json. With 500 runs a share of 95 % is known to
±1.0 % (one sigma).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from power_law_noise import NAMES, deviation, mixed

from tauto_core.navigation.stability import stability

LENGTHS = (65, 129, 513, 2049)
DEVIATIONS = ('allan', 'modified', 'time', 'hadamard')
PURE: tuple[dict[int, float], ...] = tuple({alpha: 1.0} for alpha in NAMES)
MIXED: tuple[dict[int, float], ...] = ({2: 1.0, 0: 0.1}, {0: 1.0, -2: 0.03}, {1: 1.0, -1: 0.1})


def coverage(parts: dict[int, float], count: int, runs: int, seed: int) -> list[dict[str, Any]]:
    """Return a row for each averaging time: the share of intervals that contain the truth."""
    random = np.random.default_rng([seed, count, *(alpha + 9 for alpha in parts)])
    held: dict[str, Any] = dict.fromkeys(DEVIATIONS, 0.0)
    named: Any = 0.0
    factors: list[int] = []
    for _ in range(runs):
        found = stability(mixed(parts, count, random), 1.0)
        factors = found.tau_s.astype(int).tolist()
        for kind in DEVIATIONS:
            true = np.array([deviation(kind, parts, factor) for factor in factors])
            each = getattr(found, kind)
            held[kind] = held[kind] + ((each.low < true) & (true < each.high))
        named = named + np.isin(found.noise, [NAMES[alpha] for alpha in parts])
    name = ' + '.join(f'{a:g} {NAMES[alpha]}' for alpha, a in parts.items())
    return [
        {
            'noise': name,
            'readings': count,
            'factor': factor,
            **{kind: round(100.0 * held[kind][place] / runs, 1) for kind in DEVIATIONS},
            'named': round(100.0 * named[place] / runs, 1),
        }
        for place, factor in enumerate(factors)
    ]


def main() -> None:
    """Print the table, write it, and name the shares outside 93 to 97 %."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--runs', type=int, default=500)
    default = Path(__file__).with_suffix('.json')
    parser.add_argument('--out', type=Path, default=default)
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    print(f'{"noise":40} {"N":>5} {"m":>4}', *(f'{kind:>9}' for kind in (*DEVIATIONS, 'named')))
    for parts in PURE + MIXED:
        for count in LENGTHS:
            for row in coverage(parts, count, given.runs, seed=1726):
                rows.append({'pure': len(parts) == 1, **row})
                shares = (f'{row[kind]:9.1f}' for kind in (*DEVIATIONS, 'named'))
                print(f'{row["noise"]:40} {count:5} {row["factor"]:4}', *shares, flush=True)
    for pure in (True, False):
        shares = np.array(
            [row[kind] for row in rows if row['pure'] is pure for kind in DEVIATIONS]
        )
        within = float(np.mean((shares >= 93.0) & (shares <= 97.0)))
        print(
            f'{"one kind" if pure else "two kinds"}: {shares.min():.1f} to {shares.max():.1f} %, '
            f'mean {shares.mean():.2f} %; {100.0 * within:.0f} % of them within 93 to 97 %'
        )
    result = {'runs': given.runs, 'confidence': 95.0, 'rows': rows}
    given.out.write_text(json.dumps(result, indent=1) + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
