"""Send fleets of several clocks to Madeira in a winter's Atlantic: how often is she found?

The ship is a cork, under one gravity and without heat: the sea alone decides.

    python docs/img/which_clock.py [--ships N] [--jobs N] [--out DIR] [--part P] [--plot FILE]

writes which_clock.svg beside it and prints the table of docs/which_clock.md. Ships of the same
number meet the same seas in every fleet. With --out it goes on where it was ended.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tauto_core.ensembles.fleets import Fleet, Plan, sail_fleet
from tauto_core.ensembles.rows import ERRORS, has_arrived, shares_within, sizes_nmi
from tauto_core.files import write_figure
from tauto_core.navigation.longitude import AWARDS
from tauto_core.scene import Scene, load_scene
from tauto_core.scene.errors import ABSENT

DAY_S = 86_400.0
IN_PORT_S, AT_SEA_S = 3.0 * DAY_S, 12.0 * DAY_S
WEIGHT, FORCE = 'portsmouth_jamaica', 'clock_second_cam_force'
EQUATION: dict[str, Any] = {'covariates': ['heave', 'roll']}
LUNARS: dict[str, Any] = {'lunars': {'interval': DAY_S, 'sigma': 60.0}, 'clouds': 0.4}

NOMINAL_S = {WEIGHT: 1.0050970956953766, FORCE: 1.000003096}
"""Nominal periods for 9.80665 m/s2, on land: of free swings of 1 rad, and of the steady swing."""

FLEETS: dict[str, tuple[str, dict[str, Any]]] = {
    'weight': (WEIGHT, {}),
    'equation': (WEIGHT, EQUATION),
    'lunars': (WEIGHT, EQUATION | LUNARS),
    'force': (FORCE, {}),
}
"""Whose machine sails in a fleet, and what the navigator does beside rating it in port."""

LINES = (
    ('weight', 'raw', "weight on Euler's involute, the dial as set", '#a07a6c'),
    ('weight', 'corrected', 'the same, rated in port', '#e0701a'),
    ('equation', 'corrected', 'the same, with the rate equation', '#2e8fce'),
    ('lunars', 'corrected', 'the same, and lunar distances', '#003f88'),
    ('force', 'raw', 'second cam under a force, the dial as set', '#7fb069'),
    ('force', 'corrected', 'the same, rated in port', '#2b7a3d'),
)
"""What is compared: fleet, clock of `fleets.answers.ERRORS`, name, colour."""

LEAST_NMI, MOST_NMI = 0.01, 1000.0
"""Where the figure begins, 19 m, and ends."""


def scene_of(fleet: str, part: float = 1.0) -> Scene:
    """Return the scene of a fleet: its machine, on a part of the common passage."""
    machine, navigator = FLEETS[fleet]
    ship = load_scene(WEIGHT).ship.model_dump(exclude_none=True)
    ship['weather']['regions'] = ship['weather']['regions'][:1]
    del ship['hull']
    ship |= {'heave': True, 'roll': ship['roll'] | {'slope_coefficient': 0.7}}
    arrives_at = IN_PORT_S + AT_SEA_S
    return load_scene(
        machine,
        duration=60.0 + 60.0 * round(part * arrives_at / 60.0),
        ship={**ship, 'rate': 5.0},
        air=ABSENT,
        gravity=9.80665,
        drag={'viscous': 1.25e-5},
        clock={'nominal_period': NOMINAL_S[machine]},
        **{'trochlea.material': ABSENT, 'trochlea.at_celsius': ABSENT},
        **({'suspension': ABSENT, 'trochlea.power.material': ABSENT} if machine == FORCE else {}),
        voyage={
            'departure': [50.79, -1.11],
            'waypoints': [[48.5, -6.0]],
            'arrival': [32.6, -16.9],
            'sails_at': IN_PORT_S,
            'arrives_at': arrives_at,
        },
        drift={'observation_interval': 0.25 * DAY_S, 'observation_sigma': 0.5, **navigator},
        log={'interval': 60.0, 'motion': False},
        solver={'tolerance': 1.0e-6},
        seed=1761,
    )


def sailed(ships: int, jobs: int, out: Path | None, part: float) -> dict[str, Fleet]:
    """Return the fleets by name."""
    return {
        name: sail_fleet(
            Plan(scene_of(name, part), name, ships), jobs, None if out is None else out / name
        )
        for name in FLEETS
    }


def table(fleets: dict[str, Fleet]) -> str:
    """Return, as Markdown, shares within the Act's limits with Wilson's intervals, and errors.

    The last columns hold the median of the standard deviation that the navigators state, and mean
    and standard deviation of the error divided by it.
    """
    limits = ' | '.join(f'within {limit:g} nmi' for limit, _ in AWARDS)
    rows = [
        f'| clock | {limits} | half are within | stated σ | error by stated σ |',
        '|---|---|---|---|---|---|---|',
    ]
    for fleet, clock, name, _ in LINES:
        shares = ' | '.join(
            f'{100 * each.share:.0f} % ({100 * each.low:.0f}–{100 * each.high:.0f})'
            for each in shares_within(sizes_nmi(fleets[fleet].rows, ERRORS[clock]))
        )
        quantiles = fleets[fleet].answers.quantiles_nmi[clock]
        half = '–' if quantiles is None else f'{quantiles[2]:.3g} nmi'
        rows.append(f'| {name} | {shares} | {half} | {_stated(fleets[fleet], clock)} |')
    return '\n'.join(rows)


def _stated(fleet: Fleet, clock: str) -> str:
    """Return the cells about the standard deviation that navigators state; dials state none."""
    arrived = list(filter(has_arrived, fleet.rows))
    if clock == 'raw' or not arrived:
        return '– | –'
    error, sigma = (
        np.array([row[name] for row in arrived]) for name in ('error_nmi', 'sigma_nmi')
    )
    ratio = error / sigma
    return f'{np.median(sigma):.2g} nmi | {ratio.mean():+.2g} ± {ratio.std():.2g}'


def figure_of(fleets: dict[str, Fleet]) -> Figure:
    """Return the distributions of the size of the error, a line a clock; dials are dashed."""
    figure = Figure(figsize=(7.0, 4.4), layout='constrained')
    axes = figure.subplots()
    for fleet, clock, name, colour in LINES:
        rows = fleets[fleet].rows
        sizes = np.sort(sizes_nmi(rows, ERRORS[clock]))
        sizes = sizes[np.isfinite(sizes)]
        shares = 100.0 * np.arange(len(sizes) + 1) / len(rows)
        dash = '--' if clock == 'raw' else '-'
        steps = np.concatenate([[0.0], sizes, [MOST_NMI]]), np.append(shares, shares[-1])
        axes.step(*steps, dash, where='post', color=colour, linewidth=1.6, label=name)
    for limit, _ in AWARDS:  # without the prizes: the passage is too short to be judged
        axes.axvline(limit, color='#777777', linewidth=0.8, linestyle=':')
    axes.set_xscale('log')
    axes.set_xlim(LEAST_NMI, MOST_NMI)
    axes.set_ylim(-1.0, 102.0)
    axes.set_xlabel('error of the longitude at Madeira [nautical miles]')
    axes.set_ylabel('ships within [%]')
    figure.legend(frameon=False, fontsize=7.0, loc='outside upper center', ncols=2)
    return figure


def main() -> None:
    """Sail, draw, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--ships', type=int, default=100)
    parser.add_argument('--jobs', type=int, default=2)
    parser.add_argument('--out', type=Path, help='folder for the rows of all fleets')
    parser.add_argument(
        '--plot', type=Path, default=Path(__file__).with_suffix('.svg'), help='figure'
    )
    parser.add_argument('--part', type=float, default=1.0, help='of the passage that is sailed')
    asked = parser.parse_args()
    fleets = sailed(asked.ships, asked.jobs, asked.out, asked.part)
    print(table(fleets))
    write_figure(lambda: figure_of(fleets), asked.plot)


if __name__ == '__main__':
    main()
