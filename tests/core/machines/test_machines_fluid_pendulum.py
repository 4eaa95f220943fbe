"""A body on a curve in a fluid as the regulator of a scene."""

import math

import numpy as np
import pytest

from tauto_core.checks.readiness import check_scene
from tauto_core.machines import compile_machine, descent_isochronism
from tauto_core.machines.fluid_pendulum import FluidPendulum
from tauto_core.scene import SceneError, load_scene
from tauto_core.scene.errors import UsageError


def oil(**changes):
    return load_scene(
        'globe_in_oil', **{f'regulator.{key}': each for key, each in changes.items()}
    )


def machine(**changes):
    return compile_machine(oil(**changes))


def test_the_shipped_globe_falls_in_equal_times():
    euler, cycloid = machine(), machine(curve='cycloid')
    arcs = [1e-6, 0.01, 0.1, 0.2, 0.4, 0.6]
    times = descent_isochronism(euler, arcs).descent_s
    assert max(times) / min(times) - 1.0 < 1e-12
    assert times[0] == pytest.approx(0.25 * euler.small_period, rel=1e-14)
    times = descent_isochronism(cycloid, arcs).descent_s
    assert np.all(np.diff(times) > 0.0)
    # 8 per cent from 40 cm, as the scene says
    assert times[4] / times[0] - 1.0 == pytest.approx(0.08, abs=0.005)


@pytest.mark.parametrize('curve', ['euler', 'cycloid', 'symmetric'])
def test_period_and_rate_of_swings_to_and_fro(curve):
    """The coefficients of (κS)² are 5/24, 1/6 and 0. The next order is (κS)³."""
    found = machine(curve=curve)
    kappa = found.curve.kappa
    coefficient = {'euler': 5 / 24, 'cycloid': 1 / 6, 'symmetric': 0.0}[curve]
    amplitude = 0.01 / kappa
    swing = descent_isochronism(found, [amplitude])
    excess = swing.period_s[0] / found.small_period - 1.0
    assert excess == pytest.approx(coefficient * 1e-4, abs=2e-6)
    assert swing.rate_s_per_day[0] == pytest.approx(
        -86_400.0 * excess / (1.0 + excess), rel=1e-9, abs=1e-9
    )
    assert found.period(0.0) == found.small_period
    back = found.period(-amplitude)
    assert back / found.small_period - 1.0 == pytest.approx(coefficient * 1e-4, abs=2e-6)


def test_added_mass_and_shape_reach_the_curve():
    assert machine(added_mass=0.5).curve.kappa < machine().curve.kappa
    assert machine(body='cylinder').curve.kappa == pytest.approx(machine().curve.kappa * 4.0 / 3.0)


@pytest.mark.parametrize(
    ('amplitudes', 'said'),
    [([], 'none given'), ([0.0], '> 0'), ([0.7], '0.65'), ([math.nan], 'nan')],
)
def test_amplitudes_out_of_range_are_refused(amplitudes, said):
    with pytest.raises(UsageError, match=said):
        descent_isochronism(machine(), amplitudes)


def test_a_dial_out_of_range_names_the_regulator():
    with pytest.raises(SceneError, match='Check the units in regulator') as refused:
        check_scene(oil(pendulum_length=1e20))
    assert refused.value.key == 'regulator'


def test_the_machine_of_a_scene_with_a_regulator_is_the_body():
    assert isinstance(machine(), FluidPendulum)
    weight = 6900.0 * math.pi / 6.0 * 0.05**3 * 9.80665
    assert machine().weight == pytest.approx(weight, rel=1e-14)
