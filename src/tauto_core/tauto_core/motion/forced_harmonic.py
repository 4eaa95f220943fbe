"""The wheel in a linear well on a moving ship or with viscous drag: exact steps of `linear`.

Such are Euler's second cam drawn by a force, a spring's own cam, and any linear lever arm t = t'ϑ
under a constant pull F whose neutral line is the case's. With α_c the tilt of the case, the
absolute angle ψ = θ + α_c and viscous drag c₁, (E2.1) becomes

    ψ̈ + 2δψ̇ + ω₀²ψ = ω₀²α_c + 2δα̇_c,    2δ = c₁/I,    ω₀² = F t'/I,

that is ż = (iω − δ) z + ω₀²u + 2δu̇ with u = α_c, z = ψ̇ + δψ + iωψ and ω² = ω₀² − δ² > 0.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
from numpy.polynomial import Polynomial

from tauto_core.machines import Machine
from tauto_core.motion.forcing import Forcing, Motion, Polynomials, no_motion
from tauto_core.motion.harmonic import frequency
from tauto_core.motion.limits import edge_reached, released_beyond
from tauto_core.motion.linear import Path, Spans, oscillator, propagate
from tauto_core.motion.linear_passages import OK, TOUCHING, WHEEL, Well, count_passages
from tauto_core.motion.phase import DIGITS, phase_rate, since_start, within_turn
from tauto_core.motion.responses import U_BEND, Law, Shape, U, responses, sorted_out
from tauto_core.samples import FloatArray, IntArray, State

NAME = 'forced_harmonic'


class ForcedHarmonic:
    """Propagator of a linear well whose neutral line is the case's, underdamped."""

    name = NAME

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        delta = 0.5 * (machine.drag.viscous if machine.drag else 0.0) / machine.inertia
        with localcontext() as context:
            context.prec = DIGITS
            exact = (frequency(machine) ** 2 - Decimal(delta) ** 2).sqrt()
        of, omega0 = oscillator(exact, delta), machine.frequency
        self._well = Well(of, omega0, machine.cam.range_rad)
        self._law = Law(of.omega, delta, omega0 * omega0, 2.0 * delta)
        self._wheel = np.zeros((), WHEEL)
        self._time_ns = 0
        self._start_angle = 0.0

    def release(self, forcing: Forcing) -> Motion:
        """Release the wheel at rest in the case at the beginning of the first span.

        Raises:
            PropagationError: a release beyond the cam.
        """
        machine, of = self._machine, self._well.of
        angle = machine.release_angle
        if not abs(angle) <= machine.cam.range_rad:
            raise released_beyond(machine, angle)
        # the window of a run's first piece lies on one side, so that coefficients determine it
        u = _polynomials(forcing)
        line = Polynomial([0.0] if u is None else u.fitted[0])
        x, per_s = forcing.begin[0], 1.0 / forcing.length_s[0]
        tilt, rate, acceleration = (line.deriv(n)(x) * per_s**n for n in range(3))
        psi = angle + tilt
        self._wheel = np.zeros((), WHEEL)
        self._wheel['re'], self._wheel['im'] = rate + of.delta * psi, of.omega * psi
        at = self._with_acceleration(*(np.array([each]) for each in (angle, 0.0, acceleration)))
        self._wheel['angle'], self._wheel['bend'], self._time_ns = angle, at[2][0], 0
        self._start_angle = float(within_turn(machine, *at)[0])
        return self._motion(*at, np.zeros((1, 3), np.int64))

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans; return the motion at their logged ends.

        Raises:
            PropagationError: the edge of the cam.
        """
        spans = self._spans(forcing)
        path = propagate(self._well.of, spans, self._wheel)
        counts = np.empty((np.count_nonzero(forcing.logged), 3), np.int64)
        code, k, at = count_passages(
            self._well, spans, _step_s(forcing), path, forcing.logged, self._wheel, counts
        )
        if code != OK:
            left = (1.0 - at) * (forcing.end[k] - forcing.begin[k]) * forcing.length_s[k]
            raise edge_reached(self._machine, float(forcing.end_ns[k] * 1e-9 - left))
        self._time_ns = int(forcing.end_ns[-1])
        if not len(counts):
            return no_motion()
        angle, rate, acceleration = self._swing(path, np.flatnonzero(forcing.logged))
        return self._motion(angle, rate, acceleration, counts)

    def _spans(self, forcing: Forcing) -> Spans:
        """Return the spans with the constants of their shapes."""
        window, neutral = forcing.window, forcing.neutral
        sampled = (
            np.zeros(len(forcing.end), np.bool_) if window is None else window.line.first >= 0
        )
        shape, kinds = sorted_out(forcing.length_s, forcing.begin, forcing.end, sampled)
        nodes = () if window is None else window.nodes
        width = 2 * len(nodes) if window else 0 if neutral is None else neutral.shape[1]
        shapes = [Shape(long, begin, end, bool(by)) for long, begin, end, by in kinds]
        made = responses(self._law, shapes, nodes, width)
        return Spans(self._time_ns, forcing.end_ns, shape, made, _polynomials(forcing))

    def _swing(self, path: Path, which: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return θ, θ̇ and θ̈ at the ends of some spans."""
        of, (re, im), ends = self._well.of, path.z(which), path.span[which]
        tilt, tilt_rate, tilt_acceleration = ends[:, U : U_BEND + 1].T
        psi = im / of.omega
        rate = re - of.delta * psi - tilt_rate
        return self._with_acceleration(psi - tilt, rate, tilt_acceleration)

    def _with_acceleration(
        self, angle: FloatArray, rate: FloatArray, tilt_acceleration: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return θ, θ̇ and θ̈ = −α̈_c − 2δθ̇ − ω₀²θ."""
        drag = 2.0 * self._well.of.delta * rate
        return angle, rate, -tilt_acceleration - drag - self._law.per_value * angle

    def _motion(
        self, angle: FloatArray, rate: FloatArray, acceleration: FloatArray, counts: IntArray
    ) -> Motion:
        """Return the motion from θ, θ̇, θ̈ and the counts of `count_passages`."""
        machine, touches = self._machine, counts[:, 2]
        # rounding decides on the direction of a wheel that all but rests in the middle
        counted = np.where(touches == 0, angle, TOUCHING * touches)
        within = within_turn(machine, counted, np.where(touches == 0, rate, 0.0), acceleration)
        half_turns, fraction = since_start(counts[:, 0], within, self._start_angle)
        return Motion(
            angle=angle,
            rate=rate,
            torque=-machine.inertia * self._law.per_value * angle,
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=phase_rate(machine, angle, rate, acceleration),
            beats=counts[:, 1].copy(),
        )

    def state(self) -> State:
        """Return Y, θ, θ̇, θ̈, the counts, their time, and the phase within a turn at the start."""
        return {
            'wheel': self._wheel.copy(),
            'time_ns': self._time_ns,
            'start_angle': self._start_angle,
        }

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        self._wheel = state['wheel'].copy()
        self._time_ns, self._start_angle = state['time_ns'], state['start_angle']


def _polynomials(forcing: Forcing) -> Polynomials | None:
    """Return α_c over each span; None if it does not move."""
    window, neutral = forcing.window, forcing.neutral
    if window is not None:
        return window.line
    if neutral is None:
        return None
    return Polynomials(np.empty(0), np.empty(0), -1 - np.arange(len(neutral)), neutral)


def _step_s(forcing: Forcing) -> float:
    """Return the time between the samples of a window [s]; 1 where there are none."""
    window = forcing.window
    sampled = np.zeros(1, np.bool_) if window is None else window.line.first >= 0
    if window is None or not sampled.any():
        return 1.0
    length_s = float(forcing.length_s[np.argmax(sampled)])
    return (window.nodes[1] - window.nodes[0]) * length_s
