"""Mechanics: the trochlea as a mechanism, its period, its design.

The thread that swings and the body in a fluid, which few scenes have, are loaded at first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tauto_core.machines.compiling import (
    AnyMachine,
    compile_ideal,
    compile_machine,
    compile_trochlea,
)
from tauto_core.machines.isochronism import (
    Isochronism,
    IsochronismRow,
    isochronism,
    rate_s_per_day,
)
from tauto_core.machines.lever import LeverMachine
from tauto_core.machines.quadrature import QuadratureError
from tauto_core.machines.regulator import Regulator
from tauto_core.machines.steady_swing import NoSteadySwing, SteadySwing, steady_swing
from tauto_core.machines.trochlea import Machine, SlackThreadError

if TYPE_CHECKING:
    from tauto_core.machines.fluid_pendulum import FluidPendulum, descent_isochronism
    from tauto_core.machines.hanging import HangingMachine

__all__ = [
    'AnyMachine',
    'FluidPendulum',
    'HangingMachine',
    'Isochronism',
    'IsochronismRow',
    'LeverMachine',
    'Machine',
    'NoSteadySwing',
    'QuadratureError',
    'Regulator',
    'SlackThreadError',
    'SteadySwing',
    'compile_ideal',
    'compile_machine',
    'compile_trochlea',
    'descent_isochronism',
    'isochronism',
    'rate_s_per_day',
    'steady_swing',
]

_LATER = {
    'FluidPendulum': 'fluid_pendulum',
    'HangingMachine': 'hanging',
    'descent_isochronism': 'fluid_pendulum',
}


def __getattr__(name: str) -> Any:
    """Return one of those from the module that defines it."""
    if name not in _LATER:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    found = getattr(import_module(f'{__name__}.{_LATER[name]}'), name)
    globals()[name] = found
    return found
