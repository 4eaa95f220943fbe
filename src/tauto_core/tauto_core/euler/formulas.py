"""Formulas of the claims: a parser, from which they are set as MathML and evaluated.

A formula is a line of text. Adjacent letters and numbers are a product. A slash makes a fraction
of the products before and after it, a root without brackets covers the rest of its product, and
braces enclose exponents. A colon between spaces divides, too, after the slash. Within brackets,
roots and exponents a slash stays a slash, since few fonts have brackets and roots that grow.
'‹b|h›' is a faulty letter and the right one, which is set behind it in brackets.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from html import escape
from itertools import takewhile
from typing import NamedTuple

_PHRASES = (
    'it is certain', 'by virtual work, with', 'to a tenth of a second a day', 'for any', 'here',
    'by circle and arc tangent, where', 'a drag coefficient of', 'on the section', 'left as it is',
    'punctum flexus contrarii', 'punctum reuersionis', 'totus arcus descensus',
    'totus arcus ascensus', 'Dicitur unum', 'Dicatur nunc', 'constans', 'always', 'with', 'loco',
)  # fmt: skip
_FUNCTIONS: dict[str, Callable[[float], float]] = {
    'arcsin': math.asin,
    'arctan': math.atan,
    'sinh': math.sinh,
    'sin.': math.sin,
    'sin': math.sin,
    'cos.': math.cos,
    'log': math.log,
}
_WORDS = ('arc.', 'scrup.', 'etc', 'rad')
_TOKEN = re.compile(
    r'(?P<word>(?<![A-Za-z²³])(?:'
    + '|'.join(map(re.escape, (*_PHRASES, 'arcsin', 'arctan', 'arc.', *_FUNCTIONS, *_WORDS)))
    + r')(?![A-Za-z]))'
    r'|(?P<number>\d+(?:\.\d+)?)|(?P<half>½)|(?P<power>[⁰¹²³⁴⁵⁶⁷⁸⁹]+)'
    r'|(?P<letter>[^\W\d_]\u0308?′*)'
    r'|(?P<open>[({])|(?P<close>[)}])|(?P<space>\s+)|(?P<raise>\^)|(?P<root>√)|(?P<over>/)'
    r'|(?P<fault>‹[^›]*›)|(?P<dot>[.·](?=\S))|(?P<other>.)'
)
_DIGITS = str.maketrans('⁰¹²³⁴⁵⁶⁷⁸⁹', '0123456789')
_FACTORS = frozenset({'letter', 'number', 'half', 'word', 'power', 'drawn', 'fraction', 'fault'})
_IN_PRODUCT = _FACTORS | {'group', 'dot'}


class FormulaError(ValueError):
    """A formula without a value, because of a letter without a value or an unknown sign."""


class _Node(NamedTuple):
    """A piece of a row.

    Attributes:
        kind: a kind of token, or `group` (in brackets or braces), `power`, `drawn` (a root) or
            `fraction`.
        text: text of a token, or the bracket of a group.
        parts: content of a group or a root, numerator, or base of a power.
        below: denominator or exponent.
    """

    kind: str
    text: str = ''
    parts: tuple[_Node, ...] = ()
    below: tuple[_Node, ...] = ()


_Row = Sequence[_Node]

# -----------------------------------------------------------------------------
# The parser.


def _tokens(formula: str) -> list[_Node]:
    return [_Node(str(match.lastgroup), match[0]) for match in _TOKEN.finditer(formula)]


def _row(tokens: _Row, at: int = 0) -> tuple[tuple[_Node, ...], int]:
    """Return the row up to its closing bracket, and the index after that."""
    nodes: list[_Node] = []
    while at < len(tokens):
        token = tokens[at]
        at += 1
        if token.kind == 'close':
            break
        if token.kind == 'open':
            inner, at = _row(tokens, at)
            nodes.append(_Node('group', token.text, inner))
        elif token.kind == 'power':
            number = _Node('number', token.text.translate(_DIGITS))
            nodes.append(_Node('power', '', _base(nodes), (number,)))
        elif token.kind == 'raise':
            # an exponent in braces
            inner, at = _row(tokens, at + 1)
            nodes.append(_Node('power', '{', _base(nodes), inner))
        else:
            nodes.append(token)
    return tuple(_fractions(_roots(_spaced(nodes)))), at


def _base(nodes: list[_Node]) -> tuple[_Node, ...]:
    return (nodes.pop(),) if nodes and nodes[-1].kind in _FACTORS | {'group'} else ()


def _spaced(nodes: _Row) -> list[_Node]:
    """Drop the spaces around signs, which MathML adds."""
    return [
        node
        for k, node in enumerate(nodes)
        if node.kind != 'space'
        or not any(peer.kind == 'other' for peer in nodes[max(k - 1, 0) : k + 2])
    ]


def _roots(nodes: _Row) -> list[_Node]:
    """Extend roots over the next group, or over the rest of the product."""
    drawn: list[_Node] = []
    at = 0
    while at < len(nodes):
        node = nodes[at]
        at += 1
        if node.kind == 'root':
            under: tuple[_Node, ...]
            if at < len(nodes) and nodes[at].kind == 'group':
                under, at = nodes[at].parts, at + 1
            else:
                under = tuple(takewhile(lambda n: n.kind in _FACTORS, nodes[at:]))
                at += len(under)
            node = _Node('drawn', '', under)
        drawn.append(node)
    return drawn


def _fractions(nodes: _Row) -> list[_Node]:
    """Set a product over a product. A slash without a product on one side stays a slash."""
    drawn: list[_Node] = []
    at = 0
    while at < len(nodes):
        node = nodes[at]
        at += 1
        if node.kind == 'over':
            above: list[_Node] = []
            while drawn and drawn[-1].kind in _IN_PRODUCT:
                above.insert(0, drawn.pop())
            below = tuple(takewhile(lambda n: n.kind in _IN_PRODUCT, nodes[at:]))
            if above and below:
                at += len(below)
                node = _Node('fraction', '/', tuple(above), below)
            else:
                drawn += above
        drawn.append(node)
    return drawn


# -----------------------------------------------------------------------------
# MathML, which browsers set without a script.


def mathml(formula: str, *, flat: bool = False) -> str:
    """Return a formula as `math` elements, or '' if it is empty.

    A flat formula keeps its slashes, and the height of a line of text. Browsers break lines only
    between elements: an element ends before each sign between spaces outside brackets.
    """
    tokens = _tokens(formula)
    lines: list[list[_Node]] = [[]]
    depth = 0
    for k, token in enumerate(tokens):
        depth += (token.kind == 'open') - (token.kind == 'close')
        kinds = [item.kind for item in tokens[max(k - 1, 0) : k + 2]]
        if depth == 0 and kinds == ['space', 'other', 'space']:
            lines[-1] = lines[-1][:-1]  # MathML adds the space of a sign
            lines.append([])
        lines[-1].append(token)
    return '<wbr/>'.join(
        f'<math>{_markups(_row(line)[0], flat=flat)}</math>' for line in lines if line
    )


def _markups(row: _Row, *, flat: bool = True) -> str:
    return ''.join(_markup(node, flat=flat) for node in row)


def _markup(node: _Node, *, flat: bool = True) -> str:
    kind, text, parts, below = node
    inner, under = _markups(parts), _markups(below)
    if kind == 'group':
        return f'<mrow>{_sign("(")}{inner}{_sign(")")}</mrow>' if text == '(' else inner
    if kind == 'power':
        exponent = f'<mrow>{under}</mrow>' if text else under
        return f'<msup>{inner or "<mrow/>"}{exponent}</msup>'
    if kind == 'drawn':
        return f'<msqrt>{inner}</msqrt>'
    if kind == 'fraction':
        if flat:
            return inner + _sign(text) + under
        return f'<mfrac>{_product(parts)}{_product(below)}</mfrac>'
    return _letter_markup(text) if kind == 'letter' else _token_markup(kind, text)


def _token_markup(kind: str, text: str) -> str:
    if kind == 'fault':
        stands, must = (_markups(_row(_tokens(part))[0]) for part in text[1:-1].split('|'))
        must = f'<mrow class="must"><mo>[</mo>{must}<mo>]</mo></mrow>'
        return f'<mrow><mrow class="fault">{stands}</mrow>{must}</mrow>'
    phrase = 'mtext' if text in _PHRASES else 'mi'
    return {
        'space': '<mspace width="0.25em"></mspace>',
        'word': f'<{phrase}>{escape(text)}</{phrase}>',
        'half': '<mfrac><mn>1</mn><mn>2</mn></mfrac>',
        'number': f'<mn>{text}</mn>',
    }.get(kind) or _sign(text)


def _letter_markup(text: str) -> str:
    markup, suffix = f'<mi>{text[0]}</mi>', text[1:]
    if suffix.startswith('\u0308'):
        markup, suffix = f'<mover accent="true">{markup}<mo>¨</mo></mover>', suffix[1:]
    return f'<msup>{markup}<mo>{suffix}</mo></msup>' if suffix else markup


def _product(row: _Row) -> str:
    """Return the markup of a numerator or denominator, without its outer brackets."""
    alone = len(row) == 1 and row[0].kind == 'group'
    return f'<mrow>{_markups(row[0].parts if alone else row)}</mrow>'


def _sign(text: str) -> str:
    # a sign keeps its spaces at the beginning of a line
    form = ' form="infix"' if text in '=+−:<>≥' else ''
    return f'<mo{form}>{escape(text)}</mo>'


# -----------------------------------------------------------------------------
# Values.

Letters = Mapping[str, float]


def evaluate(formula: str, letters: Letters, of: str = '') -> float:
    """Return the value of a formula, or of the right side of an equation.

    Args:
        formula: formula of a claim.
        letters: the values of its letters, of differentials (dx) and of lines (BC).
        of: letter for which to solve the equation: on the first side that has it, with the other
            side's value by `letters`.

    Raises:
        FormulaError: a formula without a value.
    """
    # words behind a comma explain the letters
    sides = _split(_row(_tokens(formula.split(', ', maxsplit=1)[0]))[0], '=')
    if not of:
        return _sum(sides[min(1, len(sides) - 1)], letters)
    for side, opposite in (sides[:2], sides[1::-1]):
        x = letters.get(of, 1.0)
        values = {of: x, **letters}
        aim = _sum(opposite, values)
        off = _sum(side, values) - aim
        x_old, off_old = 1.01 * x + 1e-3, 0.0
        off_old = _sum(side, {**letters, of: x_old}) - aim
        # secant method, until rounding ends it
        for _ in range(60 if off != off_old else 0):
            if off in (0.0, off_old):
                return x
            x_old, x = x, x - off * (x - x_old) / (off - off_old)
            off_old, off = off, _sum(side, {**letters, of: x}) - aim
    raise FormulaError(f'{formula}: no {of} in it')


def _split(row: _Row, sign: str) -> list[_Row]:
    parts: list[list[_Node]] = [[]]
    for node in row:
        if node == ('other', sign, (), ()):
            parts.append([])
        else:
            parts[-1].append(node)
    return list(parts)


def _sum(row: _Row, letters: Letters) -> float:
    total = 0.0
    for part in _split(row, '+'):
        for j, term in enumerate(_split(part, '−')):
            # a sign may come first, and "etc" last
            if [node for node in term if node.text not in ('etc', '…')]:
                value, *divisors = (_times(factor, letters) for factor in _split(term, ':'))
                total += (-1.0 if j else 1.0) * value / math.prod(divisors)
    return total


def _times(row: _Row, letters: Letters) -> float:
    """Return the value of a product, with functions of the factors behind them."""
    product = 1.0
    at = 0
    while at < len(row):
        node = row[at]
        inverse = node.text == 'arc.'
        if inverse:
            at += 2
            node = row[at]
        named = node.text == 'l' and 'l' not in letters
        if (node.kind == 'word' and node.text in _FUNCTIONS) or named:
            function = math.asin if inverse else math.log if named else _FUNCTIONS[node.text]
            at += 1 + (row[at + 1].kind == 'space')
            end = at + 1
            if row[at].kind != 'group':
                while end < len(row) and row[end].kind in _IN_PRODUCT - {'word'}:
                    end += 1
            product *= function(_times(row[at:end], letters))
            at = end
        elif _letter(node):
            value, at = _named(row, at, letters)
            product *= value
        else:
            product *= _value(node, letters)
            at += 1
    return product


def _letter(node: _Node) -> str:
    if node.kind == 'power' and len(node.parts) == 1:
        node = node.parts[0]
    return node.text if node.kind == 'letter' else ''


def _named(row: _Row, at: int, letters: Letters) -> tuple[float, int]:
    """Return the value of the longest name from an index on, and the index behind it."""
    run = []
    for node in row[at:]:
        if not _letter(node):
            break
        run.append(node)
        if node.kind == 'power':
            break
    for size in range(len(run), 0, -1):
        name = ''.join(map(_letter, run[:size]))
        if name in letters:
            final = run[size - 1]
            power = _sum(final.below, letters) if final.kind == 'power' else 1.0
            return math.pow(letters[name], power), at + size
    raise FormulaError(f'{_letter(row[at])} has no value')


def _value(node: _Node, letters: Letters) -> float:
    if node.kind == 'fraction':
        return _times(node.parts, letters) / _times(node.below, letters)
    if node.kind == 'power' and node.parts:
        return math.pow(_value(node.parts[0], letters), _sum(node.below, letters))
    if node.kind in ('group', 'drawn'):
        total = _sum(node.parts, letters)
        return total if node.kind == 'group' else math.sqrt(total)
    if node.kind == 'number':
        return float(node.text)
    if node.kind == 'half':
        return 0.5
    if node.kind in ('space', 'dot') or node.text in ('scrup.', 'etc', '…'):
        return 1.0
    raise FormulaError(f'{node.text} is not a known sign')
