"""Mechanics: the trochlea as a mechanism, its period, its design."""

from tauto_core.machines.compiling import compile_machine
from tauto_core.machines.isochronism import (
    Isochronism,
    IsochronismRow,
    isochronism,
    rate_s_per_day,
)
from tauto_core.machines.quadrature import QuadratureError
from tauto_core.machines.trochlea import Machine, SlackThreadError

__all__ = [
    'Isochronism',
    'IsochronismRow',
    'Machine',
    'QuadratureError',
    'SlackThreadError',
    'compile_machine',
    'isochronism',
    'rate_s_per_day',
]
