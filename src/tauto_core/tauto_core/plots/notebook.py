"""Results as HTML for notebooks: the answer in a sentence, a small picture or a table.

Jupyter calls `_repr_html_` of an object. Pictures are embedded PNG of a few tens of kB.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from tauto_core.plots.chart import draw
from tauto_core.plots.contents import chart
from tauto_core.plots.picture import picture_html
from tauto_core.wording import figure, significant

if TYPE_CHECKING:
    from tauto_core.ensembles.comparison import Comparison
    from tauto_core.ensembles.fleets import Fleet
    from tauto_core.ensembles.trials import TrialAnswers
    from tauto_core.voyage import Voyage


def voyage_html(voyage: Voyage) -> str:
    """Return the answer of a voyage, with its clock's error against time."""
    sentence = _sentence(f'{voyage.scene.name}: {voyage.answer}')
    if len(voyage.time_s) < 2:  # a bag with figures alone, or an empty one
        return sentence
    error = chart(voyage, 'error')
    return sentence + picture_html(draw(error, voyage.scene.name), error.described)


def comparison_html(result: Comparison) -> str:
    """Return which clock errs least, and a table of all."""
    judged = any(row.prize_pounds is not None for row in result.rows)
    rolls = len({row.roll_deg for row in result.rows}) > 1
    names = ['case', *['roll [°]'] * rolls, 'rate [s/day]', 'error [s]']
    names += ['by the dial [nmi east]', 'rated in port [nmi east]', *['prize [£]'] * judged]
    rows = []
    for row in result.rows:
        prize = '–' if row.prize_pounds is None else f'{row.prize_pounds:,}'
        rate = figure(row.rate_s_per_day, 's/day', signed=True)
        rows.append(
            [
                row.clock,
                'hung' if row.suspended else 'fixed',
                *[significant(row.roll_deg)] * rolls,
                f'stopped {row.stopped.why}' if row.stopped else rate,
                figure(row.error_s, 's', signed=True),
                figure(row.raw_error_nmi, 'nmi', signed=True),
                figure(row.error_nmi, 'nmi', signed=True),
                *[prize] * judged,
            ]
        )
    return _sentence(result.answer) + _table(['clock', *names], rows)


def fleet_html(fleet: Fleet) -> str:
    """Return the answer of a fleet, and the distribution of its errors."""
    from tauto_core.plots.ensembles import fleet_figure

    answer = f'{fleet.plan.scene.name}: {fleet.answers.answer}'
    return _sentence(answer) + picture_html(fleet_figure(fleet), fleet.answers.answer)


def trial_html(answers: TrialAnswers) -> str:
    """Return the answer of a trial, and a table of the passages within the prizes' limits."""
    prizes = answers.clocks[0].ways['raw'].prizes
    if not prizes:
        return _sentence(answers.answer)
    rows = [
        [clock.clock, way, *(f'{prize.passages} of {answers.judged}' for prize in shares.prizes)]
        for clock in answers.clocks
        for way, shares in clock.ways.items()
    ]
    limits = [f'within {prize.limit_nmi:g} nmi' for prize in prizes]
    return _sentence(answers.answer) + _table(['clock', 'way', *limits], rows)


def _sentence(text: str) -> str:
    return f'<p>{escape(text)}</p>'


def _table(names: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    def line(cells: Sequence[str], kind: str) -> str:
        return '<tr>' + ''.join(f'<{kind}>{escape(cell)}</{kind}>' for cell in cells) + '</tr>'

    head, body = line(names, 'th'), ''.join(line(row, 'td') for row in rows)
    return f'<table><thead>{head}</thead><tbody>{body}</tbody></table>'
