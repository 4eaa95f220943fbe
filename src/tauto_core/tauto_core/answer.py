"""The answer of a voyage in one sentence: how far wrong would the clock put the ship?"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.wording import significant, span

_LEAST_NMI = 1e-3
"""Two metres; a shorter distance is stated only as being below this."""


def answer(result: Mapping[str, Any]) -> str:
    """Return the answer as a sentence; of a bag that is not whole, after one that says so.

    Args:
        result: what `voyage.sail` and `replaying.replay` return, without the sentence.
    """
    return f'The bag is not whole. {_answer(result)}' if result.get('damage') else _answer(result)


def not_whole(result: Mapping[str, Any]) -> str:
    """Return what is wrong with the bag of a result; empty where nothing is.

    Args:
        result: as for `answer`.
    """
    damage = result.get('damage')
    if not damage:
        return ''
    more = f'; and {len(damage) - 2} more' if len(damage) > 2 else ''
    return f'The bag is not whole: {"; ".join(damage[:2])}{more}'


def _answer(result: Mapping[str, Any]) -> str:
    longitude = result.get('longitude') or {}
    stopped_s = (result.get('trochlea') or {}).get('stopped_s')
    if stopped_s is not None:
        return (
            f'The clock stopped after {span(stopped_s)}: its swing had become too small to go '
            'on, and the longitude cannot be found from it.'
        )
    raw_nmi = longitude.get('raw_error_nmi')
    if raw_nmi is None:
        return 'The longitude is not known: no reading of the clock could be compared.'
    raw, corrected = _place(raw_nmi), longitude.get('error_nmi')
    then = '' if corrected is None else f'; rated and corrected, {_shorter(corrected, raw_nmi)}'
    return f'{_after(longitude)} the dial puts the ship {raw} of where she is{then}.'


def _after(longitude: Mapping[str, Any]) -> str:
    at_s, unchecked_s = longitude['at_s'], longitude['unchecked_days'] * SECONDS_PER_DAY
    if at_s == 0.0:
        return 'At the start'
    if unchecked_s == 0.0:
        return f'After {span(at_s)}, checked to the end,'
    if unchecked_s == at_s:
        return f'After {span(at_s)} unchecked'
    return f'After {span(at_s)}, the last {span(unchecked_s)} unchecked,'


def _place(east_nmi: float) -> str:
    """Return a distance with its direction."""
    if abs(east_nmi) < _LEAST_NMI:
        return f'within {_LEAST_NMI:g} nmi'
    return f'{significant(abs(east_nmi))} nmi {"east" if east_nmi > 0.0 else "west"}'


def _shorter(east_nmi: float, raw_nmi: float) -> str:
    """Return a distance, with its direction only where that differs from the one just named."""
    said = _place(east_nmi)
    same = east_nmi * raw_nmi > 0.0 and min(abs(east_nmi), abs(raw_nmi)) >= _LEAST_NMI
    return said.rpartition(' ')[0] if same else said
