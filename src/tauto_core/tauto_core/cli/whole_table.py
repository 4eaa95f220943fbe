"""A table that a narrow terminal does not cut: half a figure would be read as another."""

from __future__ import annotations

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.table import Column, Table

_ANY_WIDTH = 10_000


class WholeTable(Table):
    """A table in which columns with `no_wrap` stay as wide as what they hold.

    Other columns wrap between words, or within those too long if their overflow is `fold`. Where
    that is not enough, the table is wider than the terminal, which breaks its lines.
    """

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Render the table once the columns know how wide they have to be."""
        roomy = options.update(max_width=_ANY_WIDTH)
        for column in self.columns:
            column.min_width = _narrowest(column, console, roomy)
        if all(column.min_width for column in self.columns):
            needed = Measurement.get(console, roomy, self).minimum
            options = options.update(max_width=max(options.max_width, needed))
        yield from super().__rich_console__(console, options)


def _narrowest(column: Column, console: Console, options: ConsoleOptions) -> int | None:
    """Return the width below which a column would be cut; None if it never is."""
    if column.overflow == 'fold' and not column.no_wrap:
        return None
    cells = [column.header, *column.cells]
    widths = [Measurement.get(console, options, cell) for cell in cells if cell]
    return max((each.maximum if column.no_wrap else each.minimum for each in widths), default=None)
