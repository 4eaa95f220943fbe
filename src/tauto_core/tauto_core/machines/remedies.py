"""The nearest machine that works, where one does not: words for errors."""

from __future__ import annotations

import math
from dataclasses import replace

from tauto_core.curves import Hole, SpringCorrected, WeightCorrected
from tauto_core.curves.nearest import nearest
from tauto_core.machines.trochlea import Machine


def wider_range(machine: Machine) -> str:
    """Return how the cam of a machine would hold its release, as the end of a sentence."""
    cam, amplitude = machine.cam, abs(machine.release_angle)
    if isinstance(cam, WeightCorrected):
        return _of_weight(cam, machine, amplitude)
    if isinstance(cam, Hole | SpringCorrected):
        return _farther(float(replace(cam, distance=math.inf).lever_arm(amplitude)))
    return ' or give the cam a wider range'


def _farther(arm: float) -> str:
    return f', or move the hole to at least {arm:.6g} m from the axle'


def _of_weight(cam: WeightCorrected, machine: Machine, amplitude: float) -> str:
    """A heavier weight needs shorter lever arms, a longer period likewise."""

    def heavier(mass: float) -> bool:
        share = mass / machine.carried_mass
        wider = replace(cam, rate=cam.rate / share, mass_ratio=cam.mass_ratio * share)
        return wider.range_rad >= amplitude

    def slower(period: float) -> bool:
        share = period / machine.small_period
        return replace(cam, rate=cam.rate / (share * share)).range_rad >= amplitude

    mass = nearest(machine.carried_mass, 2.0, heavier)
    period = nearest(machine.small_period, 2.0, slower)
    hanging = replace(cam, distance=math.inf)
    reachable = hanging.range_rad >= amplitude
    farther = _farther(float(hanging.lever_arm(amplitude))) if reachable else ''
    return (
        f', or use a weight of at least {mass:.4g} kg (this one is too light for the period, or '
        f'the wheel too heavy), or a period of at least {period:.4g} s{farther}'
    )
