"""`tauto euler`: every claim of Euler's papers, checked."""

from __future__ import annotations

import json
import math
from pathlib import Path
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tauto_core.cli.terminal import AsJson

if TYPE_CHECKING:
    from tauto_core.euler import Claim

_NARROWEST = 60
_INDENT = ' ' * 23


def euler(
    page: Annotated[
        Path | None,
        typer.Option(
            metavar='DIR', help='Write DIR/euler.md and DIR/figures/*.svg instead of the list.'
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Check what Euler's papers claim against what is computed.

    Exit code 1 if a claim that should hold does not, or the other way round.
    """
    from tauto_core.euler.page import all_claims, summary

    claims = all_claims()
    if page is not None:
        from tauto_core.euler.page import write_page

        for file in write_page(page, claims):
            typer.echo(f'wrote {file}', err=True)
    if as_json:
        typer.echo(json.dumps({'claims': [_object(claim) for claim in claims]}, allow_nan=False))
    elif page is None:
        width = max(get_terminal_size().columns, _NARROWEST)
        for claim in claims:
            typer.echo('\n'.join(claim_lines(claim, width)))
        typer.echo('\n'.join(wrap(summary(claims), width)))
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
        'stands': claim.stands or None,
        'value': _finite(claim.value),
        'computed': claim.computed,
        'difference': _finite(claim.difference),
        'tolerance': claim.tolerance,
        'verdict': claim.verdict,
        'expected': claim.expected,
        'must': claim.must or None,
        'must_value': claim.must_value,
        'adds': claim.adds or None,
        'because': claim.because or None,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def claim_lines(claim: Claim, width: int) -> list[str]:
    """Return a claim in lines: words and verdict, the formula as it stands, and its fault."""
    head = f'{claim.paper} §{claim.paragraph}'
    lines = wrap(f'{head:<12} {claim.verdict:<9} {claim.claim}', width, subsequent_indent=_INDENT)
    value = f' = {claim.value:.9g}' if math.isfinite(claim.value) else ''
    said = [f'as it stands: {claim.stands}{value}'] if claim.stands else []
    if claim.must:
        said.append(f'as it must be: {claim.must}')
    if claim.adds:
        said.append(f'Tauto adds: {claim.adds}' + ('' if claim.stands else value))
    said.append(f'computed: {claim.computed:.9g}')
    if math.isfinite(claim.difference):
        said.append(f'off by {claim.difference:.1e}')
    for words in ('; '.join(said), claim.because):
        lines += wrap(words, width, initial_indent=_INDENT, subsequent_indent=_INDENT)
    return lines
