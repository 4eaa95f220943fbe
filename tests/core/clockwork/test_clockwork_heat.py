"""The clock's stage with a machine that depends on the temperature of its box."""

from typing import Any

import numpy as np
import pytest

import tauto_core as tauto
from tauto_core.clockwork import LiveTrochlea, TrochleaStage
from tauto_core.clockwork.trochlea import nominal_period_s, on_first_day, stale_dial
from tauto_core.machines import compile_machine, steady_swing
from tauto_core.samples import (
    JOINT_STATES,
    READING,
    SHIP_IMU,
    SHIP_TEMPERATURE,
    Batches,
    TemperatureSamples,
)
from tauto_core.scene import Scene
from tauto_core.scene.errors import ABSENT, PropagationError
from tauto_core.ship.airs import BoxTemperature
from tauto_core.voyage import ShipSource

SEA: dict[str, Any] = {
    'duration': 120.0,
    'trochlea.material': 'brass',
    'trochlea.release_angle': 0.8,
    'drag': {'viscous': 1.25e-5, 'oil': 'olive'},
    'escapement': {'energy': 0.000123052},
    'ship': {
        'kind': 'components',
        'components': [{'amplitude': 0.1, 'period': 9.1, 'phase': 0.3}],
        'heave': [{'amplitude': 0.5, 'period': 7.3, 'phase': 0.3}],
    },
    'air': {'kind': 'constant', 'celsius': 15.0, 'diurnal': 10.0, 'box_hours': 0.02},
    'clock': ABSENT,
    'log.interval': 6.0,
}


def scene_of(**changes: Any) -> Scene:
    return tauto.load('involute_weight_at_sea', **SEA | changes)


HUNG = tauto.load('clock_own_cam_spring').suspension.model_dump()


def sailed(scene: Scene, chunk: int, *, apart: bool = False, anew: bool = False) -> np.ndarray:
    """Readings and angles of a stage that is fed in random chunks."""
    source, stage, said = ShipSource(scene, as_messages=anew), TrochleaStage(scene), []
    rng = np.random.default_rng(chunk)
    while batches := source.produce(int(rng.integers(1, 2 * chunk))):
        felt = {topic: batches[topic] for topic in stage.inputs if topic in batches}
        parts = [{topic: felt[topic]} for topic in felt] if apart else [felt]
        said += [stage.feed(part) for part in parts]
        if anew:
            state, stage = stage.state(), TrochleaStage(scene)
            stage.restore(state)
    said.append(stage.finish())
    rows = [
        (each[READING].time_ref_ns, each[JOINT_STATES].position[:, 0]) for each in said if each
    ]
    return np.array([np.concatenate(column) for column in zip(*rows, strict=True)])


@pytest.mark.parametrize(
    'keys', [{'suspension': HUNG}, {'trochlea.thread': {'kind': 'hanging', 'length': 1.5}}]
)
def test_any_split_of_motion_and_temperature_gives_the_same_bits(keys: dict[str, Any]) -> None:
    scene = scene_of(**keys)
    assert TrochleaStage(scene).inputs == (SHIP_IMU, SHIP_TEMPERATURE)
    whole = sailed(scene, 10_000)
    assert whole.shape[1] == scene.log_count
    np.testing.assert_array_equal(sailed(scene, 50, apart=True), whole)
    np.testing.assert_array_equal(sailed(scene, 333, anew=True), whole)


def test_oil_that_ages_without_air_needs_no_thermometer() -> None:
    drag = {'viscous': 1.25e-5, 'oil': 'olive', 'thickens_per_month': 10.0}
    aged = scene_of(air=ABSENT, drag=drag)
    assert TrochleaStage(aged).inputs == (SHIP_IMU,)
    fresh = scene_of(air=ABSENT)
    difference_ns = (sailed(aged, 100) - sailed(fresh, 5000))[0]
    # more drag, a narrower swing, a shorter period under a weight with inertia
    assert difference_ns[0] == 0.0
    assert 1.0 < difference_ns[-1] < 1e5


def test_materials_without_air_or_the_reverse_change_nothing() -> None:
    plain = {'trochlea.material': ABSENT, 'drag': {'viscous': 1.25e-5}}
    airy, neither = scene_of(**plain), scene_of(air=ABSENT, **plain)
    assert TrochleaStage(airy).inputs == (SHIP_IMU,)
    expected = sailed(neither, 5000)
    for scene in (scene_of(air=ABSENT), airy):
        np.testing.assert_array_equal(sailed(scene, 5000), expected)


def test_a_dial_is_regulated_at_the_steady_swing_of_its_start() -> None:
    scene = scene_of()
    machine = compile_machine(scene)
    first = float(BoxTemperature(scene).at(np.zeros(1, np.int64))[0])
    assert first < 10.0
    swing = steady_swing(machine.at_celsius(first))
    assert nominal_period_s(scene, machine) == swing.period
    # a free wheel has the swing of its release, a decaying one small swings
    ideal = tauto.load('measured', clock={})
    free = compile_machine(ideal)
    assert nominal_period_s(ideal, free) == free.period(1.0)
    dying = tauto.load('measured', clock={}, drag={'viscous': 1e-6})
    assert nominal_period_s(dying, compile_machine(dying)) == free.small_period
    stated = scene_of(clock={'nominal_period': 1.0})
    assert nominal_period_s(stated, machine) == 1.0
    # half a minute a day is a rate, two are another machine's period
    own_s = steady_swing(on_first_day(scene, machine)).period
    for off, said in ((0.5, 0), (-0.5, 0), (2.0, 1), (-2.0, 1)):
        period_s = own_s * (1.0 + off / 1440.0)
        found = stale_dial(scene_of(clock={'nominal_period': period_s}), machine)
        assert len(found) == said
        assert all(f'{period_s:.9g}' in each and f'{own_s:.9g}' in each for each in found)


def test_temperatures_off_the_grid_or_missing_are_refused() -> None:
    scene = scene_of()
    source = ShipSource(scene).produce(10_000)
    felt = source[SHIP_TEMPERATURE]
    assert isinstance(felt, TemperatureSamples)
    late = TemperatureSamples(felt.stamp_ns + 5, '', felt.temperature, felt.variance)
    stage = TrochleaStage(scene)
    stage.feed({SHIP_TEMPERATURE: felt})
    with pytest.raises(PropagationError, match='The next logged instant'):
        stage.feed({SHIP_TEMPERATURE: late})
    kelvin = TemperatureSamples(felt.stamp_ns, '', felt.temperature + 273.15, felt.variance)
    with pytest.raises(PropagationError, match='in °C'):
        TrochleaStage(scene).feed({SHIP_TEMPERATURE: kelvin})
    stage = TrochleaStage(scene)
    assert stage.feed({SHIP_IMU: source[SHIP_IMU]}) == {}
    with pytest.raises(PropagationError, match='ends before ship/imu'):
        stage.finish()


def live(scene: Scene, chunk: int, felt: TemperatureSamples | None, *, anew: bool = False) -> Any:
    """Readings of a clock on a live sensor, with the thermometer's samples up to each batch."""
    source, clock, said, heard = ShipSource(scene), LiveTrochlea(scene), [], -(2**63)
    while batches := source.produce(chunk):
        fed: Batches = {SHIP_IMU: batches[SHIP_IMU]}
        if felt is not None:
            until = int(batches[SHIP_IMU].stamp_ns[-1])
            new = (felt.stamp_ns > heard) & (felt.stamp_ns <= until)
            heard = until
            fed[SHIP_TEMPERATURE] = TemperatureSamples(
                felt.stamp_ns[new], '', felt.temperature[new], felt.variance[new]
            )
        said.append(clock.feed(fed))
        if anew:
            state, clock = clock.state(), LiveTrochlea(scene)
            clock.restore(state)
    said.append(clock.finish())
    return np.concatenate([each[READING].time_ref_ns for each in said if each])


def test_a_live_clock_does_not_wait_for_its_thermometer() -> None:
    """Without one it stays at its own temperature. With one any split is the same."""
    scene = scene_of(clock={'nominal_period': 1.0})
    assert LiveTrochlea(scene).inputs == (SHIP_IMU, SHIP_TEMPERATURE)
    silent = live(scene, 64, None)
    cold = live(scene_of(air=ABSENT, clock={'nominal_period': 1.0}), 64, None)
    # the same machine, once through the kernels of one that changes
    assert np.max(np.abs(silent - cold)) <= 1
    stamps = scene.starts_at_ns + np.array([-5, 13, 29, 60]) * 10**9
    felt = TemperatureSamples(stamps, '', np.array([25.0, 5.0, np.nan, 8.0]), np.zeros(4))
    warm = live(scene, 64, felt)
    assert len(warm) == len(silent)
    assert np.max(np.abs(warm - silent)) > 1000
    np.testing.assert_array_equal(live(scene, 7, felt), warm)
    np.testing.assert_array_equal(live(scene, 500, felt, anew=True), warm)
