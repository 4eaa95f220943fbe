"""Mechanics: the trochlea as a mechanism, its period, its design.

The body in a fluid, which few scenes use, is imported at its first use.
"""

from typing import TYPE_CHECKING

from tauto_core.curves.numerics import QuadratureError
from tauto_core.first_use import loaded_from
from tauto_core.machines.axle_pendulum import AxleClock
from tauto_core.machines.compiling import (
    AnyMachine,
    compile_machine,
    compile_trochlea,
    free_swings,
    isochronism,
)
from tauto_core.machines.parts import Isochronism, OtherRegulator, rate_s_per_day
from tauto_core.machines.steady_swing import NoSteadySwing, SteadySwing, steady_swing
from tauto_core.machines.threads.hanging import HangingMachine
from tauto_core.machines.threads.lever import LeverMachine
from tauto_core.machines.trochlea import Machine, SlackThreadError

if TYPE_CHECKING:
    from tauto_core.machines.fluid_pendulum import FluidPendulum, descent_isochronism

__all__ = [
    'AnyMachine',
    'AxleClock',
    'FluidPendulum',
    'HangingMachine',
    'Isochronism',
    'LeverMachine',
    'Machine',
    'NoSteadySwing',
    'OtherRegulator',
    'QuadratureError',
    'SlackThreadError',
    'SteadySwing',
    'compile_machine',
    'compile_trochlea',
    'descent_isochronism',
    'free_swings',
    'isochronism',
    'rate_s_per_day',
    'steady_swing',
]

__getattr__ = loaded_from(
    __name__, {'FluidPendulum': 'fluid_pendulum', 'descent_isochronism': 'fluid_pendulum'}
)
