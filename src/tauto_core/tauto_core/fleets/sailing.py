"""Sailing a fleet: ships on several processes, independently of each other.

A ship has arrived, has failed by physics, or is lost with her process or the scheduler. The lost
are no observations: they have no row, there is no answer without them, and they sail again.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from contextlib import closing, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tauto_core.fleets.answers import Answers, answers
from tauto_core.fleets.member import sail_ship
from tauto_core.fleets.plan import Plan
from tauto_core.fleets.store import Store
from tauto_core.readiness import check_scene
from tauto_core.scene.errors import TautoWarning, naming
from tauto_core.wording import counted
from tauto_core.workers import Crew, WorkerError, run_each


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
    *,
    anyway: bool = False,
) -> Fleet:
    """Sail a fleet, or the rest of it.

    Args:
        plan: the plan of the fleet.
        crew: processes that sail it.
        out: folder for the rows, written as ships finish; ships that have a row there do not sail
            again. None: the rows are only returned.
        progress: called with the number of ships done, parts of voyages included.
        anyway: sail machines and ships beyond all that are known, too.

    Raises:
        SceneError: the scene of a ship, as drawn, is invalid; no ship has sailed then.
        UsageError: the folder holds something else, or another process writes there.
        FleetError: the folder cannot be used.
        WorkerError: there are no processes available, or ships were lost with them.
    """
    store = None if out is None else Store(out, plan)
    plan.check(anyway=anyway)
    first = plan.ship(0).scene
    with naming(plan.origin, first.name):
        check_scene(first)
    with nullcontext() if store is None else store.opened():
        rows = [] if store is None else [row for row in store.rows if row['ship'] < plan.ships]
        there = {int(row['ship']) for row in rows}
        left = [number for number in range(plan.ships) if number not in there]
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

    rows: list[dict[str, Any]] = []
    lost: list[str] = []
    try:
        with closing(run_each(partial(sail_ship, plan), left, crew, tell)) as ended:
            for each in ended:
                if each.result is None:
                    why = str(each.error) or type(each.error).__name__
                    lost.append(f'ship {left[each.place]}: {why}')
                    warnings.warn(f'{lost[-1]}. She is lost', TautoWarning, stacklevel=2)
                    continue
                rows.append(each.result)
                if store is not None:
                    store.add(each.result)
        if lost:
            more = f' ({len(lost) - 1} more)' if len(lost) > 1 else ''
            raise WorkerError(
                f'{counted(len(lost), "ship")} did not end the voyage: {lost[0]}{more}'
            )
    except WorkerError as error:
        came = plan.ships - len(left) + len(rows)
        if came == 0:
            raise
        kept = (
            'with --out they would be kept, and the same command would sail the others'
            if store is None
            else 'they are kept, and the same command sails the others'
        )
        said = f'{error}. {came:,} of {counted(plan.ships, "ship")} came in; {kept}'
        raise WorkerError(said) from None
    finally:
        if store is not None:
            store.flush()
    return rows
