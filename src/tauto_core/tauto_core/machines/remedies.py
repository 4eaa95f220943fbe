"""The nearest machine that works, where one does not: words for errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from tauto_core.curves import Hole, SpringCorrected, WeightCorrected
from tauto_core.curves.nearest import nearest, nearest_if_any
from tauto_core.machines.hanging import LEAST_FREE, HangingMachine
from tauto_core.machines.lever import LeverMachine
from tauto_core.machines.lever_corrected import CorrectedLeverGeometry
from tauto_core.machines.lever_geometry import LeverGeometry
from tauto_core.machines.trochlea import Machine


def wider_range(machine: Machine | LeverMachine | HangingMachine, amplitude: float) -> str:
    """Return how a machine would hold an amplitude beyond its range, as the end of a sentence.

    Args:
        machine: whose range is too small.
        amplitude: what the cam should feel [rad], > 0.
    """
    match machine:
        case LeverMachine(geometry=LeverGeometry() as geometry):
            return _of_lever(machine, geometry, amplitude)
        case LeverMachine(geometry=CorrectedLeverGeometry() as geometry):
            return _of_corrected_lever(machine, geometry, amplitude)
        case HangingMachine():
            return _of_hanging(machine, amplitude)
        case Machine(cam=WeightCorrected() as cam):
            return _of_weight(cam, machine, amplitude)
        case Machine(cam=Hole() | SpringCorrected() as cam):
            return _farther(float(replace(cam, distance=math.inf).lever_arm(amplitude)))
        case _:
            return ' or give the cam a wider range'


def resolvable(
    machine: Machine | LeverMachine, resolved: Callable[[Machine | LeverMachine], bool]
) -> str:
    """Return the nearest machines whose motion is resolved, empty where none is near.

    Args:
        machine: whose motion is not.
        resolved: of a machine whose range holds its release.
    """

    def released(angle: float) -> bool:
        return resolved(replace(machine, release_angle=angle))

    release = ('a release_angle of at most', 'rad', abs(machine.release_angle), 0.5, released)
    if not isinstance(machine, LeverMachine):
        return _that_work(release)
    lever = machine

    def heavier(inertia: float) -> bool:
        geometry = lever.geometry
        if isinstance(geometry, CorrectedLeverGeometry):
            geometry = replace(geometry, inertia=inertia)
        tried = replace(lever, inertia=inertia, geometry=geometry)
        return abs(tried.release_angle) <= tried.range_rad and resolved(tried)

    inertia = ('an inertia of the wheel of at least', 'kg m2', lever.inertia, 2.0, heavier)
    return _that_work(inertia, release)


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


def _of_hanging(machine: HangingMachine, amplitude: float) -> str:
    wound = 0.5 * amplitude * amplitude / (1.0 - LEAST_FREE)

    def holds(length: float, radius: float) -> bool:
        return replace(machine, length=length, base_radius=radius).range_rad >= amplitude

    length = nearest(
        0.5 * wound * machine.base_radius, 2.0, lambda value: holds(value, machine.base_radius)
    )
    radius = nearest(2.0 * machine.length / wound, 0.5, lambda value: holds(machine.length, value))
    return (
        f', or use a thread of at least {length:.4g} m or a base_radius of at most {radius:.4g} m'
    )


def _of_lever(machine: LeverMachine, geometry: LeverGeometry, amplitude: float) -> str:
    """A smaller cam winds up less; a longer lever or thread may do."""

    def holds(**change: float) -> bool:
        return replace(machine, geometry=replace(geometry, **change)).range_rad >= amplitude

    return _choices(
        (
            'a base_radius of at most',
            'm',
            geometry.base_radius,
            0.5,
            lambda to: holds(base_radius=to),
        ),
        ('a lever arm of at least', 'm', geometry.arm, 2.0, lambda to: holds(arm=to)),
        ('a thread of at least', 'm', geometry.length, 2.0, lambda to: holds(length=to)),
    )


def _of_corrected_lever(
    machine: LeverMachine, geometry: CorrectedLeverGeometry, amplitude: float
) -> str:
    """A heavier weight needs a smaller cam, a longer period likewise."""

    def holds(*, mass: float = machine.mass, period: float = machine.small_period) -> bool:
        heavier = replace(machine, mass=mass)
        wider = replace(
            geometry,
            frequency=math.tau / period,
            weight_torque=heavier.weight_torque,
            turned_inertia=heavier.turned_inertia,
        )
        return replace(heavier, geometry=wider).range_rad >= amplitude

    return _choices(
        ('a weight of at least', 'kg', machine.mass, 2.0, lambda to: holds(mass=to)),
        ('a period of at least', 's', machine.small_period, 2.0, lambda to: holds(period=to)),
    )


def _choices(*choices: tuple[str, str, float, float, Callable[[float], bool]]) -> str:
    """Return those remedies that work, as the end of a sentence."""
    found = _that_work(*choices)
    return f', or use {found}' if found else ''


def _that_work(*choices: tuple[str, str, float, float, Callable[[float], bool]]) -> str:
    """Return those remedies that work: each as words, unit, value, direction and test."""
    tried = (
        (words, unit, nearest_if_any(value, factor, works))
        for words, unit, value, factor, works in choices
    )
    return ' or '.join(
        f'{words} {found:.4g} {unit}' for words, unit, found in tried if found is not None
    )
