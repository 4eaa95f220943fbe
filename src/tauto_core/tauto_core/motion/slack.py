"""A slack thread (threads.4): the wheel goes free, the weight falls, the thread tautens.

With a slack thread only drag, escapement and case act on the wheel. Only the apparent gravity and
a spring act on the weight. When the weight has reached the length of the thread, the thread
tautens without rebound: wheel and weight then have one velocity along it, and the energy of their
relative motion is lost. threads.md has the equations.

This motion is a system of its own, which the driver of `stepping` moves until the thread is taut.
Its kernels are compiled when first needed. `collocation` and `real_threads` have the systems.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from tauto_core.kernels import entry, inlined
from tauto_core.machines import AnyMachine
from tauto_core.motion import stepping
from tauto_core.motion.events import is_due
from tauto_core.motion.forcing import Forcing, Motion, no_motion, since_start
from tauto_core.motion.gauss_step import MOST_POWERS, Omega, Work, make_work
from tauto_core.motion.lanes import SIZE
from tauto_core.motion.stepping import (
    NO_CONVERGENCE,
    OK,
    ROW,
    SLACK,
    TOLERANCE,
    Model,
    Spans,
    ahead,
    restore_record,
    state_of,
    state_type,
    tolerance_of,
    write_row,
)
from tauto_core.motion.system import (
    HEAT_POWERS,
    ForcingPieces,
    HeatTerms,
    Inputs,
    Instant,
    RunningState,
    SteppedRun,
    System,
    Tolerance,
    mode_of,
    outside_at,
    planes_of,
    set_piece,
)
from tauto_core.samples import FloatArray, State
from tauto_core.scene.errors import PropagationError

# Longest step of a slack motion, as the phase of the wheel's swing [rad]. The stage polynomials,
# of half the order of the step, give the time of tautening: hence the whole last coefficient
# counts as the error of such a step, and not its square.
_LONGEST_PHASE_RAD = 0.5

ROUNDING = 2e-14
"""Gap in the thread that counts as rounding, as a share of the planes' X [rad].

Otherwise a thread that lets go with almost no acceleration would be taut again at once.
"""


SHORTEST_RAD = 1e-3
"""Shortest time that counts as slack, as the phase of the wheel's swing [rad].

The force has a bend at which z̃ replaces z. A step may find the thread slack there some
microseconds early. It is then taut again at once, without loss of energy, until it does let go.
"""


@inlined
def rounding_of(x: float, height: float) -> float:
    """Return the gap that counts as rounding, from X of wheel and weight."""
    return ROUNDING * (1.0 + abs(x) + abs(height))


class Retension(NamedTuple):
    """The effect of the tautening thread.

    Attributes:
        rate: θ̇ afterwards [rad/s].
        speed: rate of the coordinate afterwards.
        lost: twice the energy lost over I [rad2/s2].
    """

    rate: float
    speed: float
    lost: float


class LooseSystem(System):
    """A system with a slack thread and a free wheel.

    `Instant.tension` is the gap in the thread, its length minus its way, in the unit of the
    planes.
    """

    def clear(self, square: float, omega: Omega, work: Work) -> bool:
        """Return False: passages are followed on the polynomials."""
        return False

    def let_go(self, taut: Any, omega: Omega, at: Inputs, now: Instant, free: Any) -> None:
        """Set the planes of `free` to the motion `now` of the taut system."""
        raise TypeError('this system has no thread to let go')

    def tauten(
        self, taut: Any, omega: Omega, taut_omega: Omega, at: Inputs, free: Any, state: Any
    ) -> Retension:
        """Set the planes of the taut `state` to the motion after the thread has tautened."""
        raise TypeError('this system has no thread to tauten')


# -----------------------------------------------------------------------------
# Letting go and tautening, at an instant.

COUNTED = 'side', 'direction', 'pallet', 'turns', 'beats', 'given', 'armed', 'held', 'held_angle'
"""Fields of the running state that pass to the slack motion, and back."""


@entry
def let_go(
    loose: LooseSystem,
    omega: Omega,
    taut: System,
    taut_omega: Omega,
    pieces: ForcingPieces,
    x: float,
    state: RunningState,
    free: RunningState,
    work: Work,
) -> None:
    """Let the thread go: set `free`, with the counts of `state`, at x of the first piece."""
    at = outside_at(set_piece(pieces, 0, True, work)[1], x, work)
    now = taut.instant(mode_of(state), taut_omega, planes_of(taut_omega, state.planes), at)
    loose.let_go(taut, omega, at, now, free)


@entry
def tauten(
    loose: LooseSystem,
    omega: Omega,
    taut: System,
    taut_omega: Omega,
    pieces: ForcingPieces,
    x: float,
    free: RunningState,
    state: RunningState,
    work: Work,
) -> float:
    """Tauten the thread: set `state`, with the counts of `free`, at x of the first piece.

    Returns twice the energy lost over I.
    """
    at = outside_at(set_piece(pieces, 0, True, work)[1], x, work)
    loose_instant = loose.instant(mode_of(free), omega, planes_of(omega, free.planes), at)
    impulse = loose.tauten(taut, omega, taut_omega, at, free, state)
    # θ, ϑ and the counts are continuous
    angle, q = loose_instant.angle, loose_instant.coordinate
    state.beats += ahead(q, loose_instant.speed, angle) - ahead(q, impulse.speed, angle)
    direction = 1 if impulse.rate > 0.0 else -1
    if impulse.rate == 0.0:
        if taut.sticks:
            taut.set_off(taut_omega, angle, at, state)
    elif direction != state.direction:
        state.direction = direction
        state.armed = is_due(taut, state, float(direction), angle)
    return impulse.lost


@entry
def write_one(
    system: System,
    omega: Omega,
    pieces: ForcingPieces,
    x: float,
    state: RunningState,
    work: Work,
    row: Any,
) -> None:
    """Write the row at x of the first piece."""
    at = outside_at(set_piece(pieces, 0, True, work)[1], x, work)
    write_row(SteppedRun(system, omega, Tolerance(0.0, 0.0, 0.0, 0.0, 0.0), state, work), at, row)


# -----------------------------------------------------------------------------
# Base class of the propagators of machines with a thread that may go slack.


class Tautening(NamedTuple):
    """A thread that has been slack.

    Attributes:
        time_s: end of the slack motion, from the start of the run [s].
        slack_s: its duration [s].
        lost_joule: energy lost as the thread tautened [J].
    """

    time_s: float
    slack_s: float
    lost_joule: float


# Share of the tolerance below which steps double, which increases their error by 2^8.
_COARSEN = 2.0**-9

IN_PLACE_S, MOST_IN_PLACE = 1e-9, 1000
"""A change of the thread within this time [s] stays in place, and the most of these in a row."""


class SlackThread(ABC):
    """A propagator that takes steps, of a machine with a thread that cannot push.

    Unless the machine stops with a slack thread, `advance` alternates between slack and taut
    motion. A derived class turns a machine into a system.

    Args:
        machine: the machine.
        planes: number of rotating planes.
        nodes: names of the system's rows at the nodes of a step.
        stages: stages of a step.
        tolerance: the accuracy of steps.
        columns: columns of `Work.piece`.
    """

    name = 'collocation'
    longest_step_s: float

    def __init__(
        self,
        machine: AnyMachine,
        planes: int,
        nodes: tuple[str, ...],
        stages: int,
        tolerance: Tolerance,
        columns: int = SIZE,
    ) -> None:
        self._inertia, self._release_angle = machine.inertia, machine.release_angle
        self.order = 2 * stages
        self._tolerance = tolerance
        self._state = np.zeros((), state_type(planes))
        self._work = make_work(planes, nodes, stages, columns)
        self._start_angle = 0.0
        self._goes_on = not machine.stops_when_slack
        self._slack_tolerance = tolerance_of(min(tolerance.step, TOLERANCE), 0.0, _COARSEN)
        self._slack_nodes, self._slack_columns = nodes, columns
        self._slack_state: NDArray[np.void] | None = None
        self._slack_work: NDArray[np.void] | None = None
        self._slack_since_s = 0.0
        self._is_slack = False
        self._tautened: list[Tautening] = []

    @abstractmethod
    def _model_of(self, forcing: Forcing) -> Model:
        """Return the system for the channels that the forcing has."""

    @abstractmethod
    def _phase(self, rows: NDArray[np.void]) -> tuple[FloatArray, FloatArray]:
        """Return the phase within a turn (`forcing.polar`) and its rate φ̇ [rad/s]."""

    @abstractmethod
    def _failure(self, code: int, time_s: float) -> PropagationError:
        """Return the error of a failed run."""

    @abstractmethod
    def _loose_model(self, taut: Model) -> Model | None:
        """Return the system with a slack thread, or `None` if the thread never lets go."""

    def tautened(self) -> list[Tautening]:
        """Return the tautenings since the last call."""
        tautenings, self._tautened = self._tautened, []
        return tautenings

    def _outside(self, forcing: Forcing) -> ForcingPieces:
        """Return the pieces of the forcing; ValueError if a channel has too many powers."""
        for name in ('neutral', 'tilt', 'gravity', 'lean'):
            channel = getattr(forcing, name)
            if channel is not None and channel.shape[1] > MOST_POWERS:
                raise ValueError(
                    f'Forcing.{name} has {channel.shape[1]} powers of x, at most {MOST_POWERS} '
                    'are taken. Divide its pieces'
                )
        return ForcingPieces(
            forcing.length_s, forcing.neutral, forcing.tilt, forcing.gravity, forcing.lean
        )

    def _released(self, forcing: Forcing) -> tuple[NDArray[np.void], float]:
        """Release the machine and return the row and the tension at the start."""
        self._is_slack, self._tautened = False, []
        row = np.empty(1, ROW)
        tension = stepping.release(
            *self._model_of(forcing),
            self._release_angle,
            self._outside(forcing),
            float(forcing.begin[0]),
            self._state,
            self._work,
            row.reshape(()),
        )
        self._start_angle = float(self._phase(row)[0][0])
        return row, tension

    def _run(
        self,
        forcing: Forcing,
        model: Model,
        tolerance: Tolerance,
        longest_s: float,
        state: NDArray[np.void] | None = None,
        work: NDArray[np.void] | None = None,
    ) -> tuple[NDArray[np.void], int, int, float]:
        """Advance a state, by default the propagator's; return logged rows, code, span and x."""
        rows = np.empty(int(np.count_nonzero(forcing.logged)), ROW)
        code, span, x = stepping.advance(
            *model,
            tolerance,
            longest_s,
            self._outside(forcing),
            Spans(forcing.begin, forcing.end, forcing.logged),
            self._state if state is None else state,
            self._work if work is None else work,
            rows,
        )
        if code != OK:
            rows = rows[: np.count_nonzero(forcing.logged[:span])]
        return rows, code, span, x

    def _motion(self, rows: NDArray[np.void]) -> Motion:
        turned, phase_rate = self._phase(rows)
        half_turns, fraction = since_start(rows['turns'], turned, self._start_angle)
        return Motion(
            angle=rows['angle'],
            rate=rows['rate'],
            torque=self._inertia * rows['torque'],
            half_turns=half_turns,
            fraction=fraction,
            phase_rate=phase_rate,
            beats=rows['beats'].copy(),
        )

    def advance(self, forcing: Forcing) -> Motion:
        """Advance over the spans and return the motion at their logged ends.

        Raises a PropagationError at the end of the range, without convergence, and with a slack
        thread if the machine stops with it.
        """
        parts: list[NDArray[np.void]] = []
        tail, stays, went_s = forcing, 0, -math.inf
        while len(tail.begin):
            model = self._model_of(tail)
            # compiled only if needed
            loose = self._loose_model(model) if self._is_slack else None
            if loose is not None:
                # it tautens with the code SLACK
                free, work = self._records(len(loose.omega))
                longest_s = min(_LONGEST_PHASE_RAD / loose.omega[0], self.longest_step_s)
                rows, code, k, x = SlackThread._run(
                    self, tail, loose, self._slack_tolerance, longest_s, free, work
                )
            else:
                rows, code, k, x = self._run(tail, model, self._tolerance, self.longest_step_s)
            parts.append(rows)
            if code == OK:
                break
            behind_s = (tail.end[k] - x) * tail.length_s[k]
            time_s = float(tail.end_ns[k] * 1e-9 - behind_s)
            stays = stays + 1 if time_s - went_s < IN_PLACE_S else 0
            went_s = time_s
            if code == SLACK and self._goes_on and loose is None:
                loose = self._loose_model(model)
            if code != SLACK or loose is None or stays > MOST_IN_PLACE:
                raise self._failure(NO_CONVERGENCE if stays > MOST_IN_PLACE else code, time_s)
            tail = tail.rest(k, x)
            self._change(tail, model, loose, time_s)
            if x >= tail.end[0]:
                # at the end of the span its row, if logged, is still missing
                row = np.empty(int(tail.logged[0]), ROW)
                if len(row):
                    free, work = self._records(len(loose.omega))
                    now, state = (loose, free) if self._is_slack else (model, self._state)
                    write_one(*now, self._outside(tail), x, state, work, row.reshape(()))
                parts.append(row)
                tail = tail.part(1)
        rows = np.concatenate(parts) if parts else np.empty(0, ROW)
        return self._motion(rows) if len(rows) else no_motion()

    def _change(self, forcing: Forcing, taut: Model, loose: Model, time_s: float) -> None:
        """Let the thread go slack or tauten at the beginning of the forcing."""
        free, work = self._records(len(loose.omega))
        pieces, x = self._outside(forcing), float(forcing.begin[0])
        source, target = (free, self._state) if self._is_slack else (self._state, free)
        for name in COUNTED:
            target[name] = source[name]
        if self._is_slack:
            lost = tauten(*loose, *taut, pieces, x, free, self._state, work)
            inertia, hot = self._inertia, pieces.hot
            if hot is not None:
                row, u = HEAT_POWERS * hot.interval[0], hot.begin[0] + hot.size[0] * x
                share = hot.terms[row : row + HEAT_POWERS, HeatTerms._fields.index('share')]
                inertia = float(inertia / polyval(u, share))
            joule = 0.5 * inertia * lost
            slack_s = time_s - self._slack_since_s
            if slack_s * taut.omega[0] > SHORTEST_RAD:
                self._tautened.append(Tautening(time_s, slack_s, joule))
        else:
            let_go(*loose, *taut, pieces, x, self._state, free, work)
            self._slack_since_s = time_s
        self._is_slack = not self._is_slack

    def _records(self, planes: int) -> tuple[NDArray[np.void], NDArray[np.void]]:
        """Return the running state of the slack motion and its workspace, made once."""
        if self._slack_state is None or self._slack_work is None:
            self._slack_state = np.zeros((), state_type(planes))
            self._slack_work = make_work(planes, self._slack_nodes, SIZE, self._slack_columns)
        return self._slack_state, self._slack_work

    def state(self) -> State:
        """Return the running state, with the state of the slack thread."""
        slack = {
            'is_slack': self._is_slack,
            'since_s': self._slack_since_s,
            'free': None if self._slack_state is None else state_of(self._slack_state),
        }
        start = {'start_angle': self._start_angle}
        return {**state_of(self._state), **start, 'slack': slack}

    def restore(self, state: State) -> None:
        """Continue from a saved state."""
        restore_record(self._state, state)
        self._start_angle = float(state['start_angle'])
        slack = state['slack']
        self._is_slack, self._slack_since_s = slack['is_slack'], slack['since_s']
        self._tautened, self._slack_state = [], None
        if slack['free'] is not None:
            restore_record(self._records(len(slack['free']['planes']))[0], slack['free'])
