"""Formulas as MathML and as numbers."""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

import pytest

from tauto_core.euler.formulas import FormulaError, evaluate, mathml
from tauto_core.euler.site import EDITIONS, all_claims

FORMULAS = sorted({each for c in all_claims() for each in (c.stands, c.must, c.adds) if each})
DIGITS = str.maketrans('⁰¹²³⁴⁵⁶⁷⁸⁹', '0123456789')
SENTENCES = [
    *(each for c in all_claims() for each in (c.claim, c.because)),
    *(words for e in EDITIONS for p in e.paragraphs for words in (p.argues, p.found, p.lacks)),
    *(figure.caption for edition in EDITIONS for figure in edition.figures),
]
LATIN = [
    formula
    for edition in EDITIONS
    for paragraph in edition.paragraphs
    # a mark about a whole formula stands outside the asterisks
    for formula in re.sub(r'‹(\*.*?\*)\|(\*.*?\*)›', r'\1 \2', paragraph.latin).split('*')[1::2]
]
INLINE = sorted({each for words in SENTENCES for each in words.split('*')[1::2]})


def _letters(text: str) -> str:
    """Return the letters and signs of a formula, without those of its layout."""
    return re.sub(r'[\s/√^(){}‹|›\[\]]', '', text.replace('½', '12').translate(DIGITS))


def test_every_letter_of_every_formula_is_there_in_its_order() -> None:
    assert len(LATIN) > 1400
    for formula in (*FORMULAS, *INLINE, *LATIN):
        found = ''.join(_read(formula).itertext()).replace('¨', '\u0308')
        # ẅ is one character, θ̈ two
        assert _letters(found) == _letters(formula), formula


def test_formulas_in_sentences_are_marked() -> None:
    """Greek letters, roots, signs, powers and single letters but a and I give them away."""
    assert len(INLINE) > 150
    for words in SENTENCES:
        pieces = words.split('*')
        assert len(pieces) % 2 == 1, words
        left = '0'.join(pieces[::2])
        # Euler's paragraphs have Roman numerals, and quantities units
        left = re.sub(r'^[IVXLC–-]+[:,]|Tab\. [IV]+|(?<=[\d.]) (?:s|m|g)\b|s a day', '', left)
        assert not re.findall(r"[α-ωϑΓ-Ω√∫²³⁴=]|(?<![\w’'])[b-hj-zB-HJ-Z]\b", left), words


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
        ('', ''),
        ('√(2g/‹b|h›)', '√[2g/b[h]]'),
    ],
)  # fmt: skip
def test_extent_of_bars_roots_and_exponents(formula: str, markup: str) -> None:
    assert _drawn(_read(formula)) == markup


def test_lines_break_before_signs_in_no_bracket() -> None:
    lines = mathml('p = (a − b)/c + 1').split('<wbr/>')
    words = [''.join(re.findall(r'>([^<]+)<', f'>{line}<')) for line in lines]
    assert words == ['p', '=a−bc', '+1']


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


LETTERS = {'a': 2.0, 'b': 3.0, 'BC': 5.0, 'c': math.e, 'ds': 7.0, 's': 0.5, 'b′': 0.25}


@pytest.mark.parametrize(
    ('formula', 'value'),
    [
        ('2ab/4b', 1.0),
        ('ab.BC/a·5', 3.0),
        ('aads²', 196.0),
        ('−a + b − BC : 2b', 1.0 / 6.0),
        ('√aab + 1', 1.0 + math.sqrt(12.0)),
        ('√(a + b)a', 2.0 * math.sqrt(5.0)),
        ('c^{as/2}', math.exp(0.5)),
        ('½b′', 0.125),
        ('a l(1 + b)/b', 2.0 * math.log(4.0) / 3.0),
        ('a log (1 + b)/b', 2.0 * math.log(4.0 / 3.0)),
        ('a sin. (b − a)(b + a)', 10.0 * math.sin(1.0)),
        ('arc. sin. s/a + arctan b', math.asin(0.25) + math.atan(3.0)),
        ('x = a = b', 2.0),
        ('a + b − etc', 5.0),
        ('a + b, the whole', 5.0),
    ],
)
def test_a_formula_is_evaluated_as_it_is_read(formula: str, value: float) -> None:
    assert evaluate(formula, LETTERS) == pytest.approx(value, rel=1e-15)


def test_equation_is_solved_on_the_first_side_with_the_letter() -> None:
    assert evaluate('ab = 4x', LETTERS, 'x') == 1.5
    assert evaluate('c^{as} − 1 = b', LETTERS, 's') == pytest.approx(math.log(4.0) / 2.0)
    # the right side has the value that the letters give
    assert evaluate('2s = as + a', LETTERS, 's') == 1.5


def test_formula_without_a_value_is_refused() -> None:
    with pytest.raises(FormulaError, match='i has no value'):
        evaluate('ai', LETTERS)
    with pytest.raises(FormulaError, match='∫ is not a known sign'):
        evaluate('∫a', LETTERS)
    with pytest.raises(FormulaError, match='no x in it'):
        evaluate('a = b', LETTERS, 'x')
