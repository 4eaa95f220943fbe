"""Formulas of the claims as MathML, which browsers set without a script.

The claims keep each formula as a line of text, letter by letter. Adjacent letters and numbers are
a product. A slash makes a fraction of the product before it and the product after it, a root
without brackets covers the rest of its product, and braces enclose exponents. Within brackets,
roots and exponents a slash stays one: many a computer has no font whose brackets and roots grow.
"""

from __future__ import annotations

import re
from html import escape
from typing import NamedTuple

_PHRASES = (
    'it is certain', 'by virtual work, with', 'to a tenth of a second a day', 'for any', 'here',
    'by circle and arc tangent, where', 'a drag coefficient of', 'on the section', 'left as it is',
    'punctum flexus contrarii', 'punctum reversionis', 'totus arcus descensus',
    'totus arcus ascensus', 'constans', 'always', 'with', 'for',
)  # fmt: skip
_FUNCTIONS = (
    'arcsin',
    'arctan',
    'arc.',
    'sinh',
    'sin.',
    'sin',
    'cos.',
    'log',
    'scrup.',
    'etc',
    'rad',
)
_TOKEN = re.compile(
    r'(?P<word>(?<![A-Za-z²³])(?:'
    + '|'.join(map(re.escape, (*_PHRASES, *_FUNCTIONS)))
    + r')(?![A-Za-z]))'
    r'|(?P<number>\d+(?:\.\d+)?)|(?P<half>½)|(?P<power>[⁰¹²³⁴⁵⁶⁷⁸⁹]+)'
    r'|(?P<letter>[^\W\d_]\u0308?′*)'
    r'|(?P<open>[({])|(?P<close>[)}])|(?P<space>\s+)|(?P<raise>\^)|(?P<root>√)|(?P<over>/)'
    r'|(?P<dot>[.·](?=\S))|(?P<other>.)'
)
_DIGITS = str.maketrans('⁰¹²³⁴⁵⁶⁷⁸⁹', '0123456789')


class _Item(NamedTuple):
    """A piece of a row: a factor, a group in brackets, a dot between factors, or a sign."""

    kind: str
    markup: str
    inner: str = ''


def mathml(formula: str, *, flat: bool = False) -> str:
    """Return a formula of a claim as `math` elements; an empty one as an empty string.

    A flat one keeps its slashes, so that a line of text is no higher for it.

    Browsers break no line within an element. So one ends before each sign between spaces that
    stands in no bracket.
    """
    tokens = [(str(found.lastgroup), found[0]) for found in _TOKEN.finditer(formula)]
    lines: list[list[tuple[str, str]]] = [[]]
    depth = 0
    for k, (kind, text) in enumerate(tokens):
        depth += (kind == 'open') - (kind == 'close')
        beside = [each for each, _ in tokens[max(k - 1, 0) : k + 2]]
        if depth == 0 and beside == ['space', 'other', 'space']:
            lines[-1] = lines[-1][:-1]  # the sign brings its own space
            lines.append([])
        lines[-1].append((kind, text))
    return '<wbr/>'.join(f'<math>{_row(line, 0, flat=flat)[0]}</math>' for line in lines if line)


def _row(tokens: list[tuple[str, str]], at: int, *, flat: bool = False) -> tuple[str, int]:
    """Return the markup up to the bracket that closes the row, and the place behind it.

    A flat row keeps its slashes.
    """
    items: list[_Item] = []
    while at < len(tokens):
        kind, text = tokens[at]
        at += 1
        if kind == 'close':
            break
        if kind == 'open':
            inner, at = _row(tokens, at, flat=True)
            shown = f'<mrow>{_sign("(")}{inner}{_sign(")")}</mrow>' if text == '(' else inner
            items.append(_Item('group', shown, inner))
        elif kind == 'power':
            items.append(_raised(items, f'<mn>{text.translate(_DIGITS)}</mn>'))
        elif kind == 'raise':
            # an exponent in braces
            inner, at = _row(tokens, at + 1, flat=True)
            items.append(_raised(items, f'<mrow>{inner}</mrow>'))
        else:
            items.append(_single(kind, text))
    items = _roots(_spaced(items))
    return ''.join(item.markup for item in (items if flat else _fractions(items))), at


def _spaced(items: list[_Item]) -> list[_Item]:
    """Leave out the spaces beside signs, which bring their own."""
    return [
        item
        for k, item in enumerate(items)
        if item.kind != 'space'
        or not any(each.kind == 'other' for each in items[max(k - 1, 0) : k + 2])
    ]


def _single(kind: str, text: str) -> _Item:
    if kind in ('root', 'over', 'dot', 'other'):
        return _Item(kind, _sign(text))
    if kind == 'space':
        return _Item(kind, '<mspace width="0.25em"></mspace>')
    if kind == 'letter':
        markup, rest = f'<mi>{text[0]}</mi>', text[1:]
        if rest.startswith('\u0308'):
            markup, rest = f'<mover accent="true">{markup}<mo>¨</mo></mover>', rest[1:]
        if rest:
            markup = f'<msup>{markup}<mo>{rest}</mo></msup>'
    elif kind == 'word':
        element = 'mi' if text in _FUNCTIONS else 'mtext'
        markup = f'<{element}>{escape(text)}</{element}>'
    elif kind == 'half':
        markup = '<mfrac><mn>1</mn><mn>2</mn></mfrac>'
    else:
        markup = f'<mn>{text}</mn>'
    return _Item('factor', markup)


def _sign(text: str) -> str:
    # a sign keeps its spaces where a line begins with it
    form = ' form="infix"' if text in '=+−:<>≥' else ''
    return f'<mo{form}>{escape(text)}</mo>'


def _raised(items: list[_Item], exponent: str) -> _Item:
    base = items.pop().markup if items and items[-1].kind in ('factor', 'group') else '<mrow/>'
    return _Item('factor', f'<msup>{base}{exponent}</msup>')


def _roots(items: list[_Item]) -> list[_Item]:
    """Draw roots over the group that follows, or over the rest of the product."""
    drawn: list[_Item] = []
    at = 0
    while at < len(items):
        item = items[at]
        at += 1
        if item.kind != 'root':
            drawn.append(item)
            continue
        if at < len(items) and items[at].kind == 'group':
            under, at = items[at].inner, at + 1
        else:
            start = at
            while at < len(items) and items[at].kind == 'factor':
                at += 1
            under = ''.join(each.markup for each in items[start:at])
        drawn.append(_Item('factor', f'<msqrt>{under}</msqrt>'))
    return drawn


def _fractions(items: list[_Item]) -> list[_Item]:
    """Set a product over a product; a slash that has none on one side stays a slash."""
    drawn: list[_Item] = []
    at = 0
    while at < len(items):
        if items[at].kind != 'over':
            drawn.append(items[at])
            at += 1
            continue
        above: list[_Item] = []
        while drawn and drawn[-1].kind in ('factor', 'group', 'dot'):
            above.insert(0, drawn.pop())
        start = at = at + 1
        while at < len(items) and items[at].kind in ('factor', 'group', 'dot'):
            at += 1
        below = items[start:at]
        if above and below:
            parts = ''.join(f'<mrow>{_product(part)}</mrow>' for part in (above, below))
            drawn.append(_Item('factor', f'<mfrac>{parts}</mfrac>'))
        else:
            drawn += [*above, _Item('other', _sign('/')), *below]
    return drawn


def _product(items: list[_Item]) -> str:
    """Return the markup of a product over or under a bar, which replaces its own brackets."""
    if len(items) == 1 and items[0].kind == 'group':
        return items[0].inner
    return ''.join(item.markup for item in items)
