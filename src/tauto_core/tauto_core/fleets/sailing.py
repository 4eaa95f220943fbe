"""Sailing a fleet: ships on several processes, independently of each other."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tauto_core.fleets.answers import Answers, answers
from tauto_core.fleets.member import FIGURES, sail_ship
from tauto_core.fleets.plan import Plan
from tauto_core.fleets.store import Store
from tauto_core.readiness import check_scene
from tauto_core.scene.errors import naming
from tauto_core.workers import Crew, Ended, run_each


@dataclass(frozen=True)
class Fleet:
    """A fleet that has sailed.

    Attributes:
        plan: the plan of the fleet.
        rows: results of `member.sail_ship`, in the order of the ships.
        answers: statistics of the rows.
    """

    plan: Plan
    rows: list[dict[str, Any]]
    answers: Answers


def sail_fleet(
    plan: Plan,
    crew: Crew,
    out: Path | None = None,
    progress: Callable[[float], None] | None = None,
) -> Fleet:
    """Sail a fleet, or the rest of it.

    Args:
        plan: the plan of the fleet.
        crew: processes that sail it.
        out: folder for the rows, written as ships finish; ships that have a row there do not sail
            again. None: the rows are only returned.
        progress: called with the number of ships done, parts of voyages included.

    Raises:
        SceneError: the scene of a ship, as drawn, is invalid; no ship has sailed then.
        UsageError: the folder holds something else.
        FleetError: the folder cannot be used.
        WorkerError: there are no processes available.
    """
    store = None if out is None else Store(out, plan)
    plan.check()
    first = plan.ship(0).scene
    with naming(plan.origin, first.name):
        check_scene(first)
    rows = [] if store is None else [row for row in store.rows if row['ship'] < plan.ships]
    there = {int(row['ship']) for row in rows}
    left = [number for number in range(plan.ships) if number not in there]
    if store is not None:
        store.open()
    if left:
        rows += _sailed(plan, left, crew, store, progress)
    if store is not None:
        store.close()
    rows.sort(key=lambda row: int(row['ship']))
    return Fleet(plan, rows, answers(plan, rows))


def _sailed(
    plan: Plan,
    left: list[int],
    crew: Crew,
    store: Store | None,
    progress: Callable[[float], None] | None,
) -> list[dict[str, Any]]:
    """Return the rows of the ships that have not sailed yet, stored as they finish."""

    def tell(share: float) -> None:
        if progress is not None:
            progress(plan.ships - len(left) * (1.0 - share))

    rows = []
    try:
        with closing(run_each(partial(sail_ship, plan), left, crew, tell)) as ended:
            for each in ended:
                rows.append(_row(plan, left[each.place], each))
                if store is not None:
                    store.add(rows[-1])
    finally:
        if store is not None:
            store.flush()
    return rows


def _row(plan: Plan, number: int, ended: Ended[dict[str, Any]]) -> dict[str, Any]:
    """Return the row of a ship, or one with the failure if its process died."""
    if ended.result is not None:
        return ended.result
    ship = plan.ship(number)
    return {
        'ship': number,
        'seed': ship.scene.seed,
        **ship.drawn,
        **dict.fromkeys(FIGURES),
        'failure': str(ended.error) or type(ended.error).__name__,
        'run_s': None,
    }
