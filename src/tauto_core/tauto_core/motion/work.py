"""The workspace of the steps: one record of named rows, made once, so that no kernel allocates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.motion.gauss import gauss
from tauto_core.motion.lanes import SIZE
from tauto_core.samples import FloatArray

TERMS = 24
"""Most powers of the polynomials that stand for the forcing."""

PLANE = np.dtype([(name, 'f8') for name in ('x', 'x_rest', 'y', 'y_rest')])
ROTATION = np.dtype([(name, 'f8') for name in ('h', 'cos', 'cos_rest', 'sin', 'sin_rest')])
WHOLE_STEP, PART_STEP = 0, 1
"""Tables of rotations: of steps that are laid out, mostly alike, and of steps of any length."""


class PlaneState(Protocol):
    """X and Y of a rotating plane (stages), and what rounding left over of each."""

    x: float
    x_rest: float
    y: float
    y_rest: float


Planes: TypeAlias = Sequence[PlaneState]

Omega: TypeAlias = tuple[float, ...]
"""Frequencies of the rotating planes [rad/s]."""


class Rotation(Protocol):
    """The rotation of a plane over a step: its length h [s], then cos ωh and sin ωh, twofold."""

    h: float
    cos: float
    cos_rest: float
    sin: float
    sin_rest: float


class Work(Protocol):
    """The record in compiled code; a row has a number for each stage, where nothing else is said.

    Attributes:
        coefficients: a_ij of stage i in row j (gauss).
        folded: the same folded (`gauss.Gauss.folded`), then two rows to work in for each plane.
        expansion: row j: powers of the integral of the polynomial that is 1 at stage j alone.
        quadrature, fractions, tail: weights and nodes of the quadrature, and the weights of the
            last Legendre coefficient.
        piece: the polynomials of the ship's motion, a power of x in each row of eight (`outside`).
        u, v, k1, k2, x, y, d1, d2: the variables of `stages`, a row for each plane; k1 and k2 are
            the slopes of u and v, d1 and d2 stay zero unless a system writes them.
        f1, f2: integrals of k1 and k2 over the fraction of the step, in powers.
        cosine, sine: of ωt at the stages, a row for each plane: of WHOLE_STEP, then of PART_STEP.
        slopes: slopes in Newton's method, a row for each U, then for each V.
        nodes: a record of rows of the system's own.
        end: X and Y of each plane at the end of a step.
        rotations: over a step, one for each plane: of WHOLE_STEP, then of PART_STEP.
        matrix, right: the linear equations of Newton's method.
    """

    coefficients: FloatArray
    folded: FloatArray
    expansion: FloatArray
    quadrature: FloatArray
    fractions: FloatArray
    tail: FloatArray
    piece: FloatArray
    u: FloatArray
    v: FloatArray
    k1: FloatArray
    k2: FloatArray
    x: FloatArray
    y: FloatArray
    d1: FloatArray
    d2: FloatArray
    f1: FloatArray
    f2: FloatArray
    cosine: FloatArray
    sine: FloatArray
    slopes: FloatArray
    nodes: Any
    end: Planes
    rotations: Sequence[Rotation]
    matrix: FloatArray
    right: FloatArray


def make_work(planes: int, nodes: Sequence[str], stages: int = SIZE) -> NDArray[np.void]:
    """Return the record of a system of so many planes, with rows of its own at the nodes.

    Rows begin at cache lines: one that lies across two costs twice the time.
    """
    unknowns = 2 * planes * stages
    rows = {
        **dict.fromkeys(('coefficients', 'expansion'), stages),
        'folded': stages // 2 + 1 + 2 * planes,
        **dict.fromkeys(('quadrature', 'fractions', 'tail'), 1),
        **dict.fromkeys(('u', 'v', 'k1', 'k2', 'x', 'y', 'd1', 'd2', 'f1', 'f2'), planes),
        **dict.fromkeys(('cosine', 'sine', 'slopes'), 2 * planes),
    }
    own = np.dtype([(name, 'f8', (1, stages)) for name in nodes])
    kind = np.dtype(
        [
            ('piece', 'f8', (TERMS, SIZE)),
            *((name, 'f8', (count, stages)) for name, count in rows.items()),
            *([('nodes', own)] if nodes else []),
            ('end', PLANE, (planes,)),
            ('rotations', ROTATION, (2 * planes,)),
            ('matrix', 'f8', (unknowns * unknowns,)),
            ('right', 'f8', (unknowns,)),
        ]
    )
    size = kind.itemsize // 8
    raw = np.zeros(size + stages)
    first = -(raw.ctypes.data // raw.itemsize) % stages
    work = raw[first : first + size].view(kind).reshape(())
    constants = gauss(stages)
    work['coefficients'], work['expansion'] = constants.columns, constants.integral.T
    work['folded'][: stages // 2 + 1] = constants.folded
    work['quadrature'], work['fractions'] = constants.weights, constants.nodes
    work['tail'] = constants.projection[-1]
    work['rotations']['h'] = np.nan
    return work
