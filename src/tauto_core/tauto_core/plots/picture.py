"""A figure of Matplotlib as a notebook shows it."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from io import BytesIO

import matplotlib as mpl
from matplotlib.figure import Figure
from PIL import Image

from tauto_core.files import LOOK

LARGEST_SVG = 45_000
"""Bytes from which a picture, such as a map with long coasts, is shown as PNG instead: 60 kB in
the notebook, where each three bytes are four letters."""
CSS_PIXELS_AN_INCH = 96
DOTS_AN_INCH, COLOURS = 144, 48
"""Of these PNGs. A map has a dozen colours, and half-tones at their edges."""


class Picture(Figure):
    """A figure of Matplotlib that a notebook shows.

    A bare figure that `pyplot` has not made is shown as text.

    Attributes:
        described: the picture in words, for those who do not see it.
    """

    described = ''

    def _repr_html_(self) -> str:
        return picture_html(self, self.described)


def picture_html(drawn: Figure, described: str = '') -> str:
    """Return a figure as an image of HTML."""
    written, kind = BytesIO(), 'svg+xml'
    with mpl.rc_context(LOOK):
        drawn.savefig(written, format='svg', metadata={'Date': None})
        if written.tell() > LARGEST_SVG:
            image, written, kind = BytesIO(), BytesIO(), 'png'
            drawn.savefig(image, format='png', dpi=DOTS_AN_INCH)
            # this method keeps colours that are rare, as those of lines are
            png = Image.open(image).convert('RGB').quantize(COLOURS, Image.Quantize.FASTOCTREE)
            png.save(written, 'png', optimize=True)
    source = b64encode(written.getvalue()).decode('ascii')
    width = round(CSS_PIXELS_AN_INCH * drawn.get_figwidth())
    return (
        f'<img alt="{escape(described)}" width="{width}" style="max-width: 100%; background: '
        f'white" src="data:image/{kind};base64,{source}">'
    )
