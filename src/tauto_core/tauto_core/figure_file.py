"""Figures as files: arguments are checked first, and the same figure gives the same bytes."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.scene.errors import TautoError, UsageError
from tauto_core.whole_file import check_place, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_AN_INCH = 192
"""Twice the 96 of a CSS pixel, for the screens of laptops and telephones."""
# letters stay letters, to search and to read aloud
_LOOK: dict[Any, Any] = {'svg.hashsalt': 'tauto', 'font.size': 9.0, 'svg.fonttype': 'none'}
_NO_DATE: dict[str, dict[str, Any]] = {
    '.svg': {'Date': None},
    '.png': {'Software': None},
    '.pdf': {'CreationDate': None},
}
"""Metadata left out of a file, so that it does not change from run to run."""


class FigureError(TautoError):
    """A figure that cannot be written."""


def check_plot(path: Path, option: str = '--plot') -> None:
    """Refuse, before anything runs, a file to which a figure cannot be written.

    Args:
        path: the file.
        option: the option that named it.

    Raises:
        UsageError: a suffix other than .svg, .png and .pdf, or see `check_place`.
    """
    if path.suffix not in _NO_DATE:
        raise UsageError(f'{option} {path}: must end in .svg, .png or .pdf. Name another file')
    check_place(path, option)


def write_figure(draw: Callable[[], Figure], path: Path, option: str = '--plot') -> None:
    """Draw a figure and write it to an SVG, PNG or PDF file; replaces the file.

    Args:
        draw: returns the figure.
        path: name of the file, ending in .svg, .png or .pdf.
        option: the option that named it, for error messages.

    Raises:
        FigureError: the file cannot be written.
        UsageError: see `check_plot`.
    """
    import matplotlib as mpl

    check_plot(path, option)
    drawn = BytesIO()
    with mpl.rc_context(_LOOK):
        figure = draw()
        titles = [axes.get_title(loc) for axes in figure.axes for loc in ('left', 'center')]
        title = next(filter(None, titles), None)
        figure.savefig(
            drawn,
            format=path.suffix[1:],
            dpi=DOTS_AN_INCH,
            metadata={'Title': title, **_NO_DATE[path.suffix]} if title else _NO_DATE[path.suffix],
        )
    try:
        write_whole(path, drawn.getvalue())
    except OSError as error:
        raise FigureError(
            f'{path}: cannot be written: {error.strerror}. Name another file'
        ) from None
