"""The figures of the page of claims, and their files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tauto_core.euler import axle_figures, fluid_figures, trochlea_figures
from tauto_core.euler.claim import Paper

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LOOK: dict[Any, Any] = {'svg.hashsalt': 'tauto', 'svg.fonttype': 'none', 'font.size': 9.0}
"""Settings by which the same figure gives the same file; letters stay text, for small files."""


@dataclass(frozen=True)
class Plate:
    """A figure of the page.

    Attributes:
        name: name of its file, without ending.
        paper: the paper that it belongs to.
        caption: paragraph and content, in a line or two.
        draw: returns the figure.
    """

    name: str
    paper: Paper
    caption: str
    draw: Callable[[], Figure]


def plates() -> list[Plate]:
    """Return the figures in the order of the papers."""
    return [*_of_trochlea(), *_of_fluid(), *_of_axle()]


def _of_trochlea() -> list[Plate]:
    return [
        Plate(
            'a_involute',
            'A',
            'XIV: the wheel and its cheeks, the involutes BE and BF of the circle CB. The thread '
            'is tangent at M; TM = rθ is its lever arm, CT = CB.',
            trochlea_figures.involute_cheeks,
        ),
        Plate(
            'a_hole',
            'A',
            'XXIX: the cam for a thread through a fixed hole O, here CO = 2b. CN = MP is the '
            'lever arm t = bφ, CP = b√(a² − t²)/(b + √(a² − t²)).',
            trochlea_figures.hole_cheeks,
        ),
        Plate(
            'a_period',
            'A',
            'XX–XXI: what a clock loses on the involute by the inertia of the weight, and the '
            'cam made for that weight, which Euler did not draw.',
            trochlea_figures.weight_period,
        ),
        Plate(
            'a_lever',
            'A',
            "V: Sully's machine. The thread pulls at B on a lever that turns about A and carries "
            'the weight D; with the involute it is not isochronous. That the lever is level at '
            'rest, with B under C, is an assumption: the text does not say.',
            trochlea_figures.lever_machine,
        ),
    ]


def _of_fluid() -> list[Plate]:
    return [
        Plate(
            'b_curve',
            'B',
            '22, 26–30: descent MA and ascent AN in a fluid of a tenth of the density of the '
            'globe (β = 0.675), the cusps B and C, the congruent arcs BD and CE beyond them, and '
            'the cycloid of the same pendulum.',
            fluid_figures.curve_in_fluid,
        ),
        Plate(
            'b_speed',
            'B',
            '31–34: the height of fall v of the speed. It is greatest at an arc before A which '
            'is exactly the difference between the arcs of descent and ascent.',
            fluid_figures.speed_along_arc,
        ),
        Plate(
            'b_backward',
            'B',
            '22, the open remark: a swing in the other direction, down NA and up AM, is not '
            'isochronous; q = 1 − exp(−κs), s its first arc.',
            fluid_figures.backward_swing,
        ),
    ]


def _of_axle() -> list[Plate]:
    return [
        Plate(
            'c_modes',
            'C',
            '33–36: the two normal modes, each at both ends of its swing. O: centre of the '
            'support, C: of the axle, A: contact, G: centre of gravity, about it the circle of '
            'gyration.',
            axle_figures.both_modes,
        ),
        Plate(
            'c_lengths',
            'C',
            '37–42: the pendulum lengths b and b′ of both modes against e, and their limits; c = '
            '300 mm, k = 150 mm.',
            axle_figures.mode_lengths,
        ),
        Plate(
            'c_supports',
            'C',
            '37–40, 45–47: the body on a plane and on a convex support, and the squared '
            'frequencies of both modes against the curvature 1/e.',
            axle_figures.other_supports,
        ),
    ]


def write_plates(folder: Path) -> list[Path]:
    """Write every figure as SVG, the same bytes each time; return the files.

    Raises:
        OSError: a file that cannot be written.
    """
    import matplotlib as mpl

    files = []
    for plate in plates():
        file = folder / f'{plate.name}.svg'
        with mpl.rc_context(LOOK):
            plate.draw().savefig(file, metadata={'Date': None})
        files.append(file)
    return files
