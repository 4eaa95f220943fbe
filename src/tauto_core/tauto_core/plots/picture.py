"""A Matplotlib figure for notebooks."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from io import BytesIO

import matplotlib as mpl
from matplotlib.figure import Figure
from PIL import Image

from tauto_core.files import LOOK

CSS_PIXELS_AN_INCH = 96
DOTS_AN_INCH, COLOURS = 144, 48
"""Resolution and palette of a PNG. A map has a dozen colours, and half-tones at their edges."""


class Picture(Figure):
    """A Matplotlib figure that a notebook shows as an image, even without `pyplot`.

    Attributes:
        described: alternative text.
    """

    described = ''

    def _repr_html_(self) -> str:
        return picture_html(self, self.described)


def picture_html(drawn: Figure, described: str = '') -> str:
    """Return a figure as an HTML image with an alternative text."""
    image, written = BytesIO(), BytesIO()
    with mpl.rc_context(LOOK):
        drawn.savefig(image, format='png', dpi=DOTS_AN_INCH)
    # this method keeps rare colours, such as the lines'
    png = Image.open(image).convert('RGB').quantize(COLOURS, Image.Quantize.FASTOCTREE)
    png.save(written, 'png', optimize=True)
    source = b64encode(written.getvalue()).decode('ascii')
    width = round(CSS_PIXELS_AN_INCH * drawn.get_figwidth())
    return (
        f'<img alt="{escape(described)}" width="{width}" style="max-width: 100%; background: '
        f'white" src="data:image/png;base64,{source}">'
    )
