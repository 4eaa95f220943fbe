"""Numbers and durations in words."""

from __future__ import annotations

import pytest

from tauto_core.wording import (
    counted,
    figure,
    percent,
    printed,
    significant,
    span,
    to_sigma,
    with_sigma,
)


@pytest.mark.parametrize(
    ('value', 'said'),
    [
        (0.0, '0'),
        (-0.0, '0'),
        (None, '–'),
        (1.0, '1.00'),
        (-48.119572, '−48.1'),
        (999.6, '1,000'),
        (123_456.0, '123,000'),
        (1.25e7, '1.25e7'),
        (7.125e-6, '7.13e-6'),
        (float('inf'), 'inf'),
    ],
)
def test_three_digits_are_enough(value: float | None, said: str) -> None:
    assert significant(value) == said


@pytest.mark.parametrize(
    ('value', 'unit', 'said'),
    [
        (None, 'nmi', '–'),
        (0.0, 'nmi', '0'),
        (0.006526, 'nmi', '<0.01'),
        (-0.404, 'nmi', '−0.40'),
        (9.996, 'nmi', '10.00'),
        (1016.269, 'nmi', '1,016'),
        (-0.013491, 's/day', '−0.013'),
        (-56_000.720113, 's/day', '−56,001'),
        (-4272.58285654, 's', '−4,272.6'),
        (2e9, 's', '2e9'),
        (float('inf'), 's', 'inf'),
    ],
)
def test_a_figure_is_no_finer_than_a_clock_is_steady(
    value: float | None, unit: str, said: str
) -> None:
    assert figure(value, unit) == said


@pytest.mark.parametrize(
    ('value', 'sigma', 'said'),
    [
        (468.428, 323.1, '+470 ± 320'),
        (-319.267, 1035.03, '−300 ± 1,000'),
        (-0.0751592, 0.209912, '−0.08 ± 0.21'),
        (-0.004, 0.209912, '0.00 ± 0.21'),
        (3.0, 320.0, '0 ± 320'),
        (12.0, 0.0996, '+12.00 ± 0.10'),
        (2.675, 0.11, '+2.67 ± 0.11'),
        (3.34612e-4, 2.14e-8, '+3.34612e-4 ± 2.1e-8'),
        (1e-12, 2.14e-8, '0 ± 2.1e-8'),
        (1.5e9, 2.5e8, '+1.50e9 ± 2.5e8'),
        (12.3456, None, '+12.3'),
        (12.3456, 0.0, '+12.3'),
        (float('inf'), 1.0, 'inf ± 1.0'),
        (1.0, float('inf'), '+1.0 ± inf'),
    ],
)
def test_a_value_ends_where_its_standard_deviation_does(
    value: float, sigma: float | None, said: str
) -> None:
    assert with_sigma(value, sigma) == said


def test_another_figure_can_be_held_against_an_estimate() -> None:
    assert to_sigma(-31.80204, 0.012873) == '−31.802'
    assert with_sigma(31.80204, 0.012873, signed=False) == '31.802 ± 0.013'


def test_a_sign_is_given_where_it_is_asked_for() -> None:
    assert significant(2.0, 2, signed=True) == '+2.0'
    assert significant(-2.0, 2, signed=True) == '−2.0'
    assert significant(0.0, signed=True) == '0'


@pytest.mark.parametrize(
    ('value', 'form', 'said'),
    [(-1.5, '.2f', '−1.50'), (-4e-10, '+z.9f', '+0.000000000'), (-2e-5, 'g', '−2e-05')],
)
def test_a_format_has_a_minus_sign_and_none_before_a_zero(
    value: float, form: str, said: str
) -> None:
    assert printed(value, form) == said


@pytest.mark.parametrize(
    ('seconds', 'said'),
    [
        (1.0, '1 second'),
        (600.0, '10 minutes'),
        (86_400.0, '24 hours'),
        (8_207_940.0, '95 days'),
        (592.0, '9.87 minutes'),
        (5_083_920.0, '58.8 days'),
    ],
)
def test_span_uses_the_unit_a_reader_would(seconds: float, said: str) -> None:
    assert span(seconds) == said


def test_a_noun_agrees_with_its_number() -> None:
    assert counted(1, 'observation') == '1 observation'
    assert counted(1200, 'reading') == '1,200 readings'


@pytest.mark.parametrize(
    ('share', 'said'),
    [(0.0, '0 %'), (8.09e-130, '<0.01 %'), (1e-4, '0.01 %'), (0.184324, '18.4 %'), (1.0, '100 %')],
)
def test_a_share_has_no_digits_that_say_nothing(share: float, said: str) -> None:
    assert percent(share) == said
