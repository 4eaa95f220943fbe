"""What a scene would run: its machine, propagator, cost and accuracy, before it sails."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from tauto_core.machines import (
    AnyMachine,
    FluidPendulum,
    HangingMachine,
    LeverMachine,
    Machine,
    NoSteadySwing,
    rate_s_per_day,
    steady_swing,
)
from tauto_core.motion import propagator_name
from tauto_core.navigation.coefficient_runs import coefficients, fit, runs
from tauto_core.navigation.drift import dial_model
from tauto_core.readiness import check_scene, oddities
from tauto_core.scene import Scene
from tauto_core.scene.errors import TautoError
from tauto_core.voyage_cost import LONGEST_TRIAL_S, MEASURED_ON, RESOLUTION_S, forecast, tolerance
from tauto_core.what_runs import hangs, left_out, reason, resonances, thread, way

WALK_FACTOR = 5.0
"""Six runs of three hours give a random walk from few large changes, within such a factor: of the
shipped threads 25 and 2,500 s/day where many runs need 150 and 1,400.
"""


def scene_facts(scene: Scene, progress: Callable[[float], None] | None = None) -> dict[str, Any]:
    """Return what a scene would run, after every check that `tauto sail` makes before it starts.

    Args:
        scene: the scene.
        progress: called with the share done, from 0 to 1.

    Returns:
        The object of `tauto scene check --json`. `expected` has the figures of
        `voyage_cost.Forecast`; `steps_a_swing` and `tolerance` are None where the propagator takes
        no steps.

    Raises:
        SceneError: the scene cannot be run.
        MotionDataError: its measured motion cannot be used.
    """
    machine, motion = check_scene(scene)
    warnings = [
        *oddities(scene),
        *motion.warnings,
        *resonances(scene, machine),
        *_wandering(scene, machine),
    ]
    name = propagator_name(machine, still=scene.lies_still)
    expected = forecast(scene, machine, motion, progress)
    stepping = expected.steps_a_swing is not None
    return {
        'scene': scene.name,
        'duration_s': scene.duration,
        'propagator': name,
        'reason': reason(scene, machine, name),
        'left_out': left_out(scene, machine),
        'expected': {
            **asdict(expected),
            'tolerance': tolerance(scene) if stepping else None,
            'resolution_s': RESOLUTION_S,
            'longest_trial_s': LONGEST_TRIAL_S,
            'measured_on': MEASURED_ON,
        },
        'ship': scene.ship.kind,
        **({scene.ship.reported_as: motion.metadata} if scene.ship.reported_as else {}),
        'motion_samples': motion.total,
        'motion_step_s': scene.step_ns * 1e-9,
        'suspension': hangs(scene, machine),
        'thread': thread(scene, machine),
        'voyage': way(scene),
        'motion_kept': scene.keeps_motion,
        'logged_samples': scene.log_count,
        'log_interval_s': scene.log_interval_ns * 1e-9,
        'small_period_s': machine.small_period,
        'nominal_period_s': scene.clock.nominal_period or machine.small_period,
        **_regulator_facts(scene, machine),
        'steady_swing': _steady_swing(scene, machine),
        **({'covariates': _covariates(scene)} if scene.drift.covariates else {}),
        **({'warnings': warnings} if warnings else {}),
    }


def _regulator_facts(scene: Scene, machine: AnyMachine | FluidPendulum) -> dict[str, Any]:
    """Return curve, range and release of the regulator; a range is None if there is no limit."""
    if isinstance(machine, FluidPendulum):
        ends = machine.curve.ascent_cusp, machine.curve.descent_cusp
        return {
            'curve': None if scene.regulator is None else scene.regulator.curve,
            'curve_range_m': [None if math.isinf(end) else end for end in ends],
            'release_arc_m': machine.release_arc,
        }
    edge = machine.range_rad
    return {
        'cam': None if scene.trochlea is None else scene.trochlea.cam.kind,
        'cam_range_rad': None if math.isinf(edge) else edge,
        'release_angle_rad': machine.release_angle,
    }


def _steady_swing(scene: Scene, machine: AnyMachine | FluidPendulum) -> dict[str, Any] | None:
    """Return the swing in which the clock settles on land; None if there is no such swing.

    Returns:
        Amplitude [rad], period [s], rate and that of free swings of the same amplitude [s/day],
        time constant of the approach [s], None where the swing is steady from the start; or the
        reason `why` there is no steady swing.
    """
    if not isinstance(machine, Machine | LeverMachine):
        return None
    found = steady_swing(machine)
    if isinstance(found, NoSteadySwing):
        return {'why': found.why}
    nominal = scene.clock.nominal_period or machine.small_period
    settling = found.time_constant
    return {
        'amplitude_rad': found.amplitude,
        'period_s': found.period,
        'rate_s_per_day': rate_s_per_day(found.period, nominal),
        'free_rate_s_per_day': rate_s_per_day(found.free_period, nominal),
        'time_constant_s': settling if math.isfinite(settling) else None,
    }


def _wandering(scene: Scene, machine: AnyMachine | FluidPendulum) -> list[str]:
    """Return a warning where the sea makes the rate wander by more than the navigator expects.

    Only a thread that swings is tried, which nothing damps; a trial takes up to two seconds. One
    of a hung case takes ten, so that its warning says no figure.
    """
    if scene.lies_still or isinstance(machine, FluidPendulum):
        return []
    if not isinstance(machine, HangingMachine):
        expects = scene.drift.white_fm or scene.drift.random_walk_fm
        if scene.suspension is None or not machine.feels_gravity or expects:
            return []
        return [
            f'{scene.name}: drift.white_fm: nothing damps the swing of the case, and the rate of '
            'a weight wanders with it; the navigator expects that of the dial alone, so after a '
            'day his errors will be larger than he states. Write drift.white_fm, in s a day, or '
            'drift.random_walk_fm'
        ]
    try:
        found = fit(scene, ())
    except TautoError as error:
        # the trial sea may be higher than the scene's, which can be sailed
        return [
            f'{scene.name}: drift.random_walk_fm: whether the sea makes the rate walk at random '
            f'could not be tried: {error}'
        ]
    if found.is_expected(dial_model(scene), WALK_FACTOR):
        return []
    return [
        f'{scene.name}: drift.random_walk_fm: the sea swings the thread, and the rate of such a '
        f'clock walks at random, by at least about {found.advised:g} s/day in a day in trial '
        'runs; the navigator expects less, so his errors will be larger than he states. '
        f'Write drift.random_walk_fm: {found.advised:g}'
    ]


def _covariates(scene: Scene) -> dict[str, dict[str, Any]]:
    """Return the prior of the coefficient of each covariate.

    Returns:
        `value` and `sigma`; `at_periods`, the coefficient at each period of the waves [s] of the
        trial runs, None where the scene gives it.
    """
    tried = {found.name: found.at_periods for found in runs(scene)}
    return {
        name: {
            'value': value,
            'sigma': sigma,
            'at_periods': {str(period): k for period, k in tried[name].items()}
            if name in tried
            else None,
        }
        for name, value, sigma in coefficients(scene)
    }
