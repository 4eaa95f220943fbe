"""MuJoCo: fixed steps of a simulator of bodies with joints.

Problems a and d are a hinge and a spring, which its models can express: the wheel is a hinge, the
thread a fixed tendon with a spring from the wheel to the case. The roll is present at every stage
of a step: each component of the sea is a slide of its own, so heavy (1e9 kg) that the wheel does
not move it, which swings freely at the component's frequency; the tendon adds them up. A roll
prescribed from outside (mocap, control) would be constant during a step and reduce the order.
Three slides share a body, which makes a step cheapest.

The case (f) is one body with two hinges: about the bearing's centre, and about the axle's centre
that the first one carries. Their angles are theta and phi - theta; the link needs no mass.

The weight-driven involute (b, c, e) cannot be expressed. Its varying inertia m b^2 x^2 would need
an equality constraint between wheel and weight, which MuJoCo enforces only softly, and the
thread's apparent vertical and the impulses have no counterpart in its models.
"""

from __future__ import annotations

import math
import time
from importlib.metadata import version
from typing import Any

import numpy as np

from benchmarks.work_precision.equations.sea import angular_frequency, library
from benchmarks.work_precision.equations.sea import vertical as vertical_at
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import CaseProblem, HungCase, Numbers, Problem
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError, UsageError

NAME = 'mujoco'
SEA_MASS = 1e9
"""Mass on a component's slide [kg]; the wheel moves it by 1e-12 of its swing."""


class Mujoco:
    """MuJoCo's steppers; a setting is the integrator and the longest step in seconds."""

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'mujoco', 'mujoco')

    def version(self) -> str:
        """Return the version of the library."""
        return version('mujoco')

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return integrators and steps, coarse to fine; none for the weight-driven machine."""
        if isinstance(problem, CaseProblem):
            return tuple(f'RK4 {step}' for step in ('5e-3', '2e-3', '1e-3', '5e-4', '2e-4'))
        numbers = problem.numbers
        if numbers.mass or numbers.impulse_energy or numbers.follows_vertical:
            return ()
        implicit = tuple(f'{name} {step}' for name in _IMPLICIT for step in ('1e-2', '1e-3'))
        return (*implicit, *(f'RK4 {step}' for step in ('2e-2', '1e-2', '5e-3', '2e-3', '1e-3')))

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem in equal steps not longer than `setting` says.

        Raises:
            UsageError: a problem that MuJoCo's models cannot express.
            PropagationError: MuJoCo warned of a bad state.
        """
        if not self.settings(problem):
            raise UsageError(
                f'mujoco: problem {problem.key!r} is beyond its models, which hold the linear '
                "wheel and the case only. Choose 'a', 'd' or 'f'."
            )
        mujoco = library(NAME, 'mujoco', 'mujoco')
        began = time.perf_counter()
        integrator, step = setting.split()
        steps = math.ceil(duration_s / float(step))
        if isinstance(problem, CaseProblem):
            model, data = _case_model(mujoco, problem.numbers, integrator)
        else:
            model, data = _model(mujoco, problem.numbers, integrator)
        model.opt.timestep = duration_s / steps
        ready = time.perf_counter()
        mujoco.mj_step(model, data, nstep=steps)
        run_s = time.perf_counter() - ready
        if any(warning.number for warning in data.warning) or not np.isfinite(data.qpos[0]):
            raise PropagationError(
                f'mujoco reported a bad state with steps of {step} s. Choose shorter steps.',
                float(data.time),
            )
        angle, rate = _end(problem, duration_s, data)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


_IMPLICIT = ('implicit', 'implicitfast')


def _end(problem: Problem, time_s: float, data: Any) -> tuple[float, float]:
    """Return the angle [rad] and rate [rad/s] that are compared: theta of the wheel or phi."""
    if isinstance(problem, CaseProblem):
        return float(data.qpos.sum()), float(data.qvel.sum())
    at = vertical_at(problem.numbers, time_s)
    return float(data.qpos[0] - at.roll), float(data.qvel[0] - at.roll_rate)


def _case_model(mujoco: Any, case: HungCase, integrator: str) -> tuple[Any, Any]:
    """Return MuJoCo's model of the case and its data at the start."""
    inertia = case.k**2
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option integrator="{integrator}" gravity="0 0 {-case.gravity!r}">'
        '<flag contact="disable" constraint="disable"/></option>'
        '<worldbody><body>'
        f'<joint type="hinge" axis="1 0 0" pos="0 0 {case.e!r}"/>'
        '<joint type="hinge" axis="1 0 0"/>'
        f'<inertial pos="0 0 {-case.c!r}" mass="1" '
        f'diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
        '</body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[:] = case.release_angle, 0.0
    return model, data


def _model(mujoco: Any, numbers: Numbers, integrator: str) -> tuple[Any, Any]:
    """Return MuJoCo's model and its data at the start."""
    amplitude, omega, phase = _components(numbers)
    at = vertical_at(numbers, 0.0)
    model = mujoco.MjModel.from_xml_string(_xml(numbers, integrator, amplitude, omega))
    data = mujoco.MjData(model)
    data.qpos[:] = [numbers.release_angle + at.roll, *np.cos(phase)]
    data.qvel[:] = [at.roll_rate, *(-omega * np.sin(phase))]
    return model, data


def _components(numbers: Numbers) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return amplitude, frequency and phase of the sea; empty on land."""
    if numbers.sea is None:
        return np.empty(0), np.empty(0), np.empty(0)
    return numbers.sea.amplitude, angular_frequency(numbers.sea), numbers.sea.phase


def _xml(numbers: Numbers, integrator: str, amplitude: FloatArray, omega: FloatArray) -> str:
    inertia, stiffness = numbers.inertia, numbers.lever_rate * numbers.force
    wheel = (
        '<body><joint name="wheel" type="hinge" axis="1 0 0"/>'
        f'<inertial pos="0 0 0" mass="1" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'
        '</body>'
    )
    waves = [_slides(first, omega[first : first + 3]) for first in range(0, len(omega), 3)]
    links = [f'<joint joint="wave{i}" coef="{float(-a)!r}"/>' for i, a in enumerate(amplitude)]
    return (
        f'<mujoco><option integrator="{integrator}" gravity="0 0 0">'
        '<flag contact="disable" constraint="disable"/></option>'
        f'<worldbody>{wheel}{"".join(waves)}</worldbody>'
        f'<tendon><fixed stiffness="{stiffness!r}" damping="{numbers.viscous!r}" springlength="0">'
        f'<joint joint="wheel" coef="1"/>{"".join(links)}</fixed></tendon></mujoco>'
    )


def _slides(first: int, omega: FloatArray) -> str:
    """Return a body with a slide a component, at right angles so that they do not couple."""
    axes = ('1 0 0', '0 1 0', '0 0 1')
    joints = [
        f'<joint name="wave{first + i}" type="slide" axis="{axes[i]}" '
        f'stiffness="{SEA_MASS * float(w) ** 2!r}"/>'
        for i, w in enumerate(omega)
    ]
    return (
        f'<body>{"".join(joints)}<inertial pos="0 0 0" mass="{SEA_MASS!r}" '
        'diaginertia="1 1 1"/></body>'
    )
