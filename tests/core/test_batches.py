"""Each element of a batch is computed by itself: other elements never change its bits.

Public methods of cams, curves and machines that take arrays are found by their annotations, so a
new one is tested as well, or fails for want of a range of its argument. Cutting a voyage into
other chunks must not change a bit.
"""

import inspect
import math
from dataclasses import fields
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tauto_core.curves import (
    CircularArc,
    FluidTautochrone,
    Hole,
    Involute,
    SpringCorrected,
    Table,
    TableLever,
    WeightCorrected,
    fluid,
    numerics,
)
from tauto_core.curves.cams.lever_corrected import CorrectedLeverGeometry
from tauto_core.curves.cams.synthesised import PowerTrain, synthesise, synthesised_cam
from tauto_core.curves.fluid import ActaCurve, Cycloid, SymmetricCurve
from tauto_core.curves.lever_geometry import LeverGeometry
from tauto_core.curves.numerics import gauss_sums, integrate
from tauto_core.machines import (
    HangingMachine,
    LeverMachine,
    Machine,
    axle_pendulum,
    fluid_pendulum,
)
from tauto_core.machines.axle_pendulum import AxlePendulum, AxleState, SupportMotion
from tauto_core.machines.compiling import swing_energy
from tauto_core.machines.half_swings import BothWays
from tauto_core.motion import axle
from tauto_core.motion.closed_forms import ActionAngle, Harmonic
from tauto_core.motion.wells import angles_of
from tauto_core.navigation.drift import observed_phases
from tauto_core.navigation.kalman import ClockModel, Estimate, predict, prior
from tauto_core.ship.passage import wrap

INERTIA, OMEGA = 4e-4, math.pi
PULL = 0.05 * 9.81
QUINTIC = TableLever(
    np.array([0.0, 1.0, 2.0]),
    np.array([[0, 0.01, 0, 0.001, 0, 1e-4], [0.0111, 0.0135, 0.004, 0.002, 5e-4, -1e-4]]),
    np.array([0.0, 0.01 / 2 + 0.001 / 4 + 1e-4 / 6]),
)
TRAIN = PowerTrain(
    pull=lambda y: PULL + 20.0 * y,
    place=lambda v: 2 * v / (PULL + np.sqrt(PULL * PULL + 40.0 * v)),
    mass=lambda y: np.full_like(y, 0.05),
)
ENDLESS = PowerTrain(TRAIN.pull, TRAIN.place, np.zeros_like)
RATE = INERTIA * OMEGA**2 / PULL
CAMS = {
    'involute': Involute(0.01),
    'hole': Hole(0.01, 0.08),
    'circular arc': CircularArc(0.02, 0.01),
    'weight': WeightCorrected(RATE, 0.05 / INERTIA),
    'weight through a hole': WeightCorrected(RATE, 0.05 / INERTIA, 0.03),
    'spring': SpringCorrected(RATE, 25.0),
    'spring through a hole': SpringCorrected(RATE, 25.0, 0.05),
    'table': Table('quintic', QUINTIC),
    'table through a hole': Table('quintic', QUINTIC, 0.08),
    'fitted': synthesised_cam(synthesise(INERTIA, OMEGA, TRAIN), edge=2.0),
}
CURVES = {
    'euler': FluidTautochrone(0.3, 0.9, 1.0),
    'euler, no ascent cusp': FluidTautochrone(2.0, 0.9, 1.0),
    'euler, friction': FluidTautochrone(0.3, 0.9, 1.0, 0.1),
    'euler, no fluid': FluidTautochrone(0.0, 0.9, 1.0),
    'cycloid': Cycloid(0.3, 0.9, 1.0),
    'symmetric': SymmetricCurve(0.3, 0.9, 1.0),
    'acta': ActaCurve(0.3, 0.9, 1.0, 0.5),
}
INVOLUTE_LEVER = LeverGeometry(0.02, 0.1, 0.3)
CORRECTED_LEVER = CorrectedLeverGeometry(
    INERTIA, 4.0, 0.05 * 9.81 * 0.15, 0.05 * 0.15**2, 0.1, 0.3
)


def trochlea(cam, mass=0.0, stiffness=0.0):
    """A machine with a weight or spring on the cam."""
    weighted = bool(mass)
    return Machine(
        INERTIA, mass, mass, 0.0 if weighted else PULL, stiffness, 9.81, cam, weighted, None, None,
        1.0,
    )  # fmt: skip


MACHINES = {
    'force on an involute': trochlea(CAMS['involute']),
    'weight on an involute': trochlea(CAMS['involute'], mass=0.05),
    'weight on a circular arc': trochlea(CAMS['circular arc'], mass=0.05),
    'weight on its own cam': trochlea(CAMS['weight'], mass=0.05),
    'weight on a table': trochlea(CAMS['table'], mass=0.05),
    'spring on a hole': trochlea(CAMS['hole'], stiffness=10.0),
    'spring on its own cam': trochlea(CAMS['spring'], stiffness=25.0 * PULL),
    'lever': LeverMachine(INERTIA, 0.05, 0.15, 0.0, INVOLUTE_LEVER, 9.81, None, None, 1.0),
    'lever of its own cam': LeverMachine(
        INERTIA, 0.05, 0.15, 0.0, CORRECTED_LEVER, 9.81, None, None, 1.0
    ),
    'hanging thread': HangingMachine(INERTIA, 0.05, 0.01, 1.0, 9.81, None, None, 1.0),
}

ARRAYS = {'ArrayLike', 'ArrayLike | None', 'FloatArray', 'Angles', 'np.ndarray'}
SCALARS_TOO = {'ArrayLike', 'ArrayLike | None'}


class Law:
    """A function of arrays, the ranges of its arguments, and whether it takes numbers as well."""

    def __init__(self, function, *ranges, numbers=False):
        self.function, self.ranges, self.numbers = function, ranges, numbers


def laws_of(thing, ranges):
    """Return every public method of arrays alone, with the ranges of its parameters by name."""
    found = {}
    for name, method in inspect.getmembers(type(thing), inspect.isfunction):
        takes = {p.name: p.annotation for p in inspect.signature(method).parameters.values()}
        takes.pop('self', None)
        if name.startswith('_') or not takes or not set(takes.values()) <= ARRAYS:
            continue
        wide = [ranges[parameter] for parameter in takes]
        numbers = set(takes.values()) <= SCALARS_TOO
        found[name] = Law(getattr(thing, name), *wide, numbers=numbers)
    return found


def of_cam(cam):
    reach = min(cam.range_rad, 8.0)
    return laws_of(
        cam,
        {
            'angle': (-reach, reach),
            'lift': (0.0, float(cam.lift(reach))),
            'slope': (0.0, 50.0),
            'roll_angle': (-8.0, 8.0),
            'lever_arm': (-0.08, 0.08),
        },
    )


def of_curve(curve):
    arcs = max(curve.ascent_cusp, -5.0), min(curve.descent_cusp, 5.0)
    laws = laws_of(curve, {'arc': arcs})
    for function in (fluid.coordinates, fluid.radius_of_curvature):
        laws[function.__name__] = Law(partial(function, curve), arcs, numbers=True)
    if isinstance(curve, FluidTautochrone):
        low = float(curve.height(curve.lowest_arc))
        for branch in ('descent', 'ascent'):
            back = partial(curve.arc_of_height, branch=branch)
            laws[f'arc_of_height, {branch}'] = Law(back, (low, low + 1.0), numbers=True)
    return laws


def of_machine(machine):
    reach, few, many = min(machine.range_rad, 2.0), (-0.3, 0.3), (-3.0, 3.0)
    ranges = {
        'angle': (-reach, reach),
        'lift': (0.0, 0.05),
        'apparent_gravity': (9.0, 10.5),
        'potential': (0.0, 0.01),
        'psi': (0.5, 1.0),
        'beta': few,
        'delta': few,
        'lean': few,
        'u': (0.2, 1.2),
        'psi_rate': many,
        'delta_rate': many,
    }
    laws = {'swing_energy': Law(partial(swing_energy, machine), (-reach, reach), many)}
    if isinstance(machine, HangingMachine):
        return laws | laws_of(machine, ranges)
    laws['swing'] = Law(partial(machine.swing, 1.0), (1e-3, 0.5 * math.pi))
    if isinstance(machine, LeverMachine):
        ranges |= {'tau': machine.geometry.edges, 'theta': machine.sides}
        return laws | laws_of(machine, ranges) | laws_of(machine.geometry, ranges)
    arc = float(machine.arc(reach))
    laws |= laws_of(machine, ranges | {'arc': (-arc, arc)})
    if not machine.is_harmonic:
        del laws['angle_of_arc']
    return laws


def of_synthesis(train):
    made = synthesise(INERTIA, OMEGA, train)
    arcs, angles = min(made.arc_range, 1.0), min(made.angle_range, 50.0)
    return laws_of(made, {'arc': (0.0, arcs), 'angle': (0.0, angles)})


def of_fluids():
    kappa, curve = 0.3, CURVES['euler']
    ways = BothWays(CURVES['symmetric'], 9.81, 0.0, 0.8)

    def along(pick, time):
        return ways.place(0.1 + 0.7 * pick, time)

    back = partial(fluid_pendulum.reverse_half_swing, kappa, 3.0)
    return {
        'harmonic_of_arc': Law(
            partial(fluid_pendulum.harmonic_of_arc, kappa), (-2.0, 2.0), numbers=True
        ),
        'arc_of_harmonic': Law(
            partial(fluid_pendulum.arc_of_harmonic, kappa), (-2.0, 2.0), numbers=True
        ),
        'velocity_height': Law(
            lambda s: fluid_pendulum.velocity_height(curve, s, 0.1), (-0.4, 0.4), numbers=True
        ),
        'forward': Law(
            partial(fluid_pendulum.euler_half_swing, curve, 9.81),
            (0.01, 0.79),
            (0.0, 1.0),
            numbers=True,
        ),
        'backward': Law(back, (0.01, 20.0), (0.0, 1.0), numbers=True),
        'by series': Law(along, (0.0, 1.0), (0.0, 1.0)),
        'duration_excess': Law(
            partial(fluid_pendulum.duration_excess, kappa), (1e-3, 9.0), numbers=True
        ),
        'end_arc': Law(partial(fluid_pendulum.end_arc, kappa), (1e-3, 9.0), numbers=True),
        'quarter_period': Law(fluid_pendulum.quarter_period, (1e-9, 1.0)),
        'jacobi_amplitude': Law(fluid_pendulum.jacobi_amplitude, (0.0, 1.5), (1e-9, 1.0)),
    }


def of_axle():
    body, few = AxlePendulum(1 / 0.015, 0.1, 0.05, 9.81), (-0.3, 0.3)

    def shaken(s, phi, s1, phi1, turn, turn_rate):
        state, support = AxleState(s, phi, s1, phi1), SupportMotion(turn, turn_rate, 0.1, 0.2, 0.3)
        return tuple(axle.forces(body, state, support))

    def small(time):
        start = AxleState(0.1, 0.1, 0.0, 0.0)
        return tuple(axle_pendulum.small_motion(body, start, time))

    return {
        'forces': Law(shaken, few, few, few, few, few, few, numbers=True),
        'small_motion': Law(small, (0.0, 100.0), numbers=True),
    }  # fmt: skip


def of_numerics():
    def wave(x):
        return np.sqrt(x) * np.sin(9.0 * x)

    laws = {
        name: Law(function, (-0.9, 3.0))
        for name, function in inspect.getmembers(numerics, inspect.isfunction)
        if name.endswith(('_defect', '_mean'))
    }
    return laws | {
        'integrate': Law(
            lambda low, wide: integrate(wave, low, low + wide), (0.0, 1.0), (1e-3, 5.0)
        ),
        'gauss': Law(partial(gauss_sums, np.exp), (-1.0, 1.0), (0.0, 3.0)),
        'angles_of': Law(lambda s: angles_of(s, 0.7), (-20.0, 20.0)),
    }


def of_motion(propagator):
    def motion(time):
        found = propagator.motion_at(time.astype(np.int64))
        return tuple(getattr(found, field.name) for field in fields(found))

    return {'motion_at': Law(motion, (0.0, 1e16))}


def of_navigation():
    model = ClockModel(0.5, 1e-4, states=3)
    stamps = np.arange(0, 9 * 86_400, 3600) * 10**9
    shown = stamps + (1e9 * np.cos(stamps)).astype(np.int64)

    def ahead(time):
        now = Estimate(*(value + 0.0 * time for value in prior(model)))
        return tuple(predict(now, time, model))

    def phases(at, error):
        at = at.astype(np.int64)
        return observed_phases(stamps, shown, at, at + (1e9 * error).astype(np.int64))

    return {
        'observed_phases': Law(phases, (0.0, 7e14), (-1.0, 1.0)),
        'wrap': Law(wrap, (-540.0, 540.0)),
        'predict': Law(ahead, (0.0, 1e7), numbers=True),
    }


WELLS = ('weight on an involute', 'weight on a circular arc', 'weight on a table')
IDEAL = ('force on an involute', 'weight on its own cam')
MAKERS = {
    **{f'cam: {name}': partial(of_cam, cam) for name, cam in CAMS.items()},
    **{f'curve: {name}': partial(of_curve, curve) for name, curve in CURVES.items()},
    **{f'machine: {name}': partial(of_machine, machine) for name, machine in MACHINES.items()},
    **{f'action-angle: {n}': lambda n=n: of_motion(ActionAngle(MACHINES[n])) for n in WELLS},
    **{f'harmonic: {n}': lambda n=n: of_motion(Harmonic(MACHINES[n])) for n in IDEAL},
    'synthesis: heavy train': partial(of_synthesis, TRAIN),
    'synthesis: endless train': partial(of_synthesis, ENDLESS),
    'swings in a fluid': of_fluids,
    'axle': of_axle,
    'numerics': of_numerics,
    'navigation': of_navigation,
}


def bits(found):
    """Return the result of a function as integers, one row for each element."""
    parts = found if isinstance(found, tuple) else (found,)
    return np.stack([np.ravel(np.asarray(part, np.float64)).view(np.int64) for part in parts], 1)


shares = st.floats(0.0, 1.0) | st.sampled_from([0.0, 1e-9, 1e-3, 0.5, 1.0])
MOST_ARGUMENTS = 6


@pytest.mark.parametrize('maker', MAKERS.values(), ids=MAKERS)
def test_a_batch_is_as_many_batches_of_one(maker):
    laws = maker()

    @settings(max_examples=2, deadline=None)
    @given(st.lists(st.tuples(*[shares] * MOST_ARGUMENTS), min_size=6, max_size=11))
    def each_by_itself(rows):
        for name, law in laws.items():
            wide = zip(law.ranges, np.array(rows).T, strict=False)
            columns = [np.clip(low + (high - low) * p, low, high) for (low, high), p in wide]
            whole = bits(law.function(*columns))
            for i, expected in enumerate(whole):
                one = bits(law.function(*(column[i : i + 1] for column in columns)))
                np.testing.assert_array_equal(one[0], expected, name)
                if law.numbers:
                    number = bits(law.function(*(float(column[i]) for column in columns)))
                    np.testing.assert_array_equal(number[0], expected, name)
            # as a part of every third, backwards, of a larger array
            apart = bits(law.function(*(np.repeat(column, 3)[::-3] for column in columns)))
            np.testing.assert_array_equal(apart, whole[::-1], name)

    each_by_itself()
