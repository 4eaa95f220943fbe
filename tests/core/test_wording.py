"""Numbers and durations in words."""

from __future__ import annotations

import pytest

from tauto_core.wording import counted, printed, significant, span


@pytest.mark.parametrize(
    ('value', 'said'),
    [
        (0.0, '0'),
        (-0.0, '0'),
        (None, '–'),
        (1.0, '1.000'),
        (-48.119572, '−48.12'),
        (0.0774512, '0.07745'),
        (999.96, '1,000'),
        (1219.4, '1,219'),
        (123_456.0, '123,500'),
        (1.25e7, '1.25e7'),
        (7.125e-6, '7.125e-6'),
        (float('inf'), 'inf'),
    ],
)
def test_four_digits_are_enough(value: float | None, said: str) -> None:
    assert significant(value) == said


def test_a_sign_is_given_where_it_is_asked_for() -> None:
    assert significant(2.0, 2, signed=True) == '+2.0'
    assert significant(-2.0, 2, signed=True) == '−2.0'
    assert significant(0.0, signed=True) == '0'


@pytest.mark.parametrize(
    ('value', 'form', 'said'),
    [
        (-1.5, '.2f', '−1.50'),
        (-4e-10, '+z.9f', '+0.000000000'),
        (-2e-5, 'g', '−2e-05'),
    ],
)
def test_a_format_has_a_minus_sign_and_none_before_a_zero(
    value: float, form: str, said: str
) -> None:
    assert printed(value, form) == said


@pytest.mark.parametrize(
    ('seconds', 'said'),
    [
        (1.0, '1 second'),
        (60.0, '60 seconds'),
        (600.0, '10 minutes'),
        (86_400.0, '24 hours'),
        (8_207_940.0, '95 days'),
    ],
)
def test_span_uses_the_unit_a_reader_would(seconds: float, said: str) -> None:
    assert span(seconds) == said


def test_a_noun_agrees_with_its_number() -> None:
    assert counted(1, 'observation') == '1 observation'
    assert counted(1200, 'reading') == '1,200 readings'
