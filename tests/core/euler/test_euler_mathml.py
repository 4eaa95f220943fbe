"""Formulas as MathML: no letter is lost, and fractions, roots and exponents cover what they do."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from tauto_core.euler.mathml import mathml
from tauto_core.euler.page import all_claims

FORMULAS = sorted({each for c in all_claims() for each in (c.stands, c.must, c.adds) if each})
DIGITS = str.maketrans('²³⁴⁵⁶⁷⁸⁹', '23456789')


def _letters(text: str) -> str:
    """Return what a formula consists of, without what only places it."""
    return re.sub(r'[\s/√^(){}]', '', text.replace('½', '12').translate(DIGITS))


def test_every_letter_of_every_formula_is_there_in_its_order() -> None:
    for formula in FORMULAS:
        found = ''.join(_read(formula).itertext())
        assert _letters(found) == _letters(formula), formula


@pytest.mark.parametrize(
    ('formula', 'markup'),
    [
        ('ns/2ma', '<mfrac>ns|2ma</mfrac>'),
        ('P.TM/CO', '<mfrac>P.TM|CO</mfrac>'),
        ('(f + h)/4', '<mfrac>f+h|4</mfrac>'),
        ('p = b√(aa − tt)/(b + √(aa − tt))', 'p=<mfrac>b√[aa−tt]|b+√[aa−tt]</mfrac>'),
        ('(dy/y)√(2g/b)', '(dy/y)√[2g/b]'),
        ('2√½bf', '2√[<mfrac>1|2</mfrac>bf]'),
        ('c^{ns/ma}(b − t)', 'c^[ns/ma](b−t)'),
        ('(b − t)²', '(b−t)^[2]'),
        ('n = αc√2gb + α′c', 'n=αc√[2gb]+α^[′]c'),
        ('k²s/1·2 + 1', '<mfrac>k^[2]s|1·2</mfrac>+1'),
        ('BD, ED', 'BD,ED'),
    ],
)  # fmt: skip
def test_what_a_bar_a_root_and_an_exponent_cover(formula: str, markup: str) -> None:
    assert _drawn(_read(formula)) == markup


def test_lines_break_before_signs_in_no_bracket() -> None:
    lines = mathml('p = (a − b)/c + 1').split('<wbr/>')
    assert [''.join(re.findall(r'>([^<]+)<', f'>{line}<')) for line in lines] == [
        'p',
        '=a−bc',
        '+1',
    ]


def _read(formula: str) -> ElementTree.Element:
    return ElementTree.fromstring(f'<line>{mathml(formula)}</line>')


def _drawn(element: ElementTree.Element) -> str:
    parts = [_drawn(each) for each in element]
    text = (element.text or '').strip()
    if element.tag == 'mfrac':
        return f'<mfrac>{"|".join(parts)}</mfrac>'
    if element.tag == 'msqrt':
        return f'√[{"".join(parts)}]'
    if element.tag == 'msup':
        return f'{parts[0]}^[{parts[1]}]'
    return text + ''.join(parts)


def test_an_empty_formula_is_empty() -> None:
    assert mathml('') == ''
