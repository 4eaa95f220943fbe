"""`tauto euler`: every claim of Euler's papers, checked."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer

from tauto_core.cli.options import AsJson

if TYPE_CHECKING:
    from rich.table import Table

    from tauto_core.euler import Claim


def euler(as_json: AsJson = False) -> None:
    """Check every claim of Euler's papers: what is printed against what is computed.

    Exit code 1 if a claim that should hold does not, or the other way round.
    """
    from tauto_core.euler.papers import all_claims

    claims = all_claims()
    if as_json:
        typer.echo(json.dumps({'claims': [_object(claim) for claim in claims]}, allow_nan=False))
    else:
        from rich.console import Console

        Console().print(claims_table(claims))
    wrong = [claim for claim in claims if claim.verdict != claim.expected]
    for claim in wrong:
        typer.echo(
            f'tauto: {claim.paper} §{claim.paragraph}, {claim.claim}: {claim.verdict} (off by '
            f'{claim.difference:.3g}, tolerance {claim.tolerance:.3g}), should be '
            f'{claim.expected}. Look for the fault in what was computed',
            err=True,
        )
    if wrong:
        raise typer.Exit(1)


def _object(claim: Claim) -> dict[str, Any]:
    """Return a claim as JSON; what cannot be evaluated is None."""
    return {
        'paper': claim.paper,
        'paragraph': claim.paragraph,
        'claim': claim.claim,
        'printed': claim.printed,
        'printed_value': _finite(claim.printed_value),
        'computed': claim.computed,
        'difference': _finite(claim.difference),
        'tolerance': claim.tolerance,
        'verdict': claim.verdict,
        'expected': claim.expected,
        'corrected': claim.corrected or None,
        'corrected_value': claim.corrected_value,
        'because': claim.because or None,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def claims_table(claims: Sequence[Claim]) -> Table:
    """Return the claims as a table, a section for each paper."""
    from rich.table import Table
    from rich.text import Text

    count = dict.fromkeys(('holds', 'misprint', 'fails'), 0)
    for claim in claims:
        count[claim.verdict] += 1
    table = Table(
        title=f'{len(claims)} claims: {count["holds"]} hold, {count["misprint"]} are misprinted, '
        f'{count["fails"]} fail',
        title_justify='left',
    )
    table.add_column('§', no_wrap=True)
    table.add_column('claim', overflow='fold', ratio=3)
    table.add_column('printed', overflow='fold', ratio=3)
    for name in ('value', 'computed', 'off by'):
        table.add_column(name, justify='right', no_wrap=True)
    table.add_column('verdict', overflow='fold', ratio=4)
    for number, claim in enumerate(claims):
        if number and claims[number - 1].paper != claim.paper:
            table.add_section()
        # as it is: brackets of formulas are no markup
        table.add_row(*map(Text, _row(claim)))
    return table


def _row(claim: Claim) -> tuple[str, ...]:
    said: str = claim.verdict
    if claim.verdict == 'misprint':
        said = f'misprint for {claim.corrected}: {claim.because}'
    elif claim.verdict == 'fails':
        said = f'does not hold: {claim.because}'
    return (
        f'{claim.paper} {claim.paragraph}',
        claim.claim,
        claim.printed,
        _figure(claim.printed_value, '.9g'),
        _figure(claim.computed, '.9g'),
        _figure(claim.difference, '.1e'),
        said,
    )


def _figure(value: float, form: str) -> str:
    return f'{value:{form}}' if math.isfinite(value) else '–'
