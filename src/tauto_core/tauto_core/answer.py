"""The answer of a voyage in one sentence: how far wrong would the clock put the ship?"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tauto_core.samples import SECONDS_PER_DAY
from tauto_core.wording import figure, least, span, with_sigma


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
    trochlea = result.get('trochlea') or {}
    stopped_s = trochlea.get('stopped_s')
    if stopped_s is not None:
        return (
            f'The clock stopped after {span(stopped_s)}: {trochlea["stopped_why"]}, and the '
            'longitude cannot be found from it.'
        )
    raw_nmi = longitude.get('raw_error_nmi')
    if raw_nmi is None:
        return 'The longitude is not known: no reading of the clock could be compared.'
    return (
        f'{_after(longitude)} the dial puts the ship {_place(raw_nmi)} of where she is; rated and '
        f'corrected, {_corrected(longitude)}.'
    )


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
    if abs(east_nmi) < least('nmi'):
        return f'within {least("nmi"):g} nmi'
    return f'{figure(abs(east_nmi), "nmi")} nmi {_side(east_nmi)}'


def _corrected(longitude: Mapping[str, Any]) -> str:
    """Return the distance of the corrected longitude and its standard deviation; its direction
    only where that differs from the dial's.
    """
    east_nmi, raw_nmi = longitude['error_nmi'], longitude['raw_error_nmi']
    said = f'{with_sigma(abs(east_nmi), longitude["sigma_nmi"], signed=False)} nmi'
    same = east_nmi * raw_nmi > 0.0 and abs(raw_nmi) >= least('nmi')
    nowhere = not float(said.split(maxsplit=1)[0].replace(',', ''))
    return said if same or nowhere else f'{said} {_side(east_nmi)}'


def _side(east_nmi: float) -> str:
    return 'east' if east_nmi > 0.0 else 'west'
