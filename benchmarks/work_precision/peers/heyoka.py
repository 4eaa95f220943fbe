"""heyoka, in three forms: as its documentation writes a problem, tuned, and many at once."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import files, version
from typing import Any

import numpy as np
from numba import njit

from benchmarks.work_precision.equations.sea import (
    SeaPieces,
    end_of,
    mass_ratio,
    pieces_start,
    pieces_wheel,
    start,
    start_of,
    stretches,
    vertical,
    wheel,
)
from benchmarks.work_precision.peer import MissingPeerError, Outcome
from benchmarks.work_precision.problems import (
    CaseProblem,
    HungCase,
    Numbers,
    Problem,
    Sea,
    WheelProblem,
)
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import PropagationError, UsageError


def library(peer: str = 'heyoka') -> Any:
    """Return heyoka's module.

    Raises:
        MissingPeerError: it is not installed.
    """
    try:
        import heyoka
    except ModuleNotFoundError as error:
        raise MissingPeerError(peer, 'heyoka') from error
    return heyoka


class _OfHeyoka:
    """What the three forms share."""

    name: str

    def __init__(self) -> None:
        library(self.name)

    def version(self) -> str:
        """Return the version of the library."""
        return version('heyoka')


def _until(integrator: Any, end_s: float) -> None:
    outcome = integrator.propagate_until(end_s)[0]
    if outcome != library().taylor_outcome.time_limit:
        raise PropagationError(
            f'heyoka stopped with {outcome}. Choose a coarser tolerance.', float(integrator.time)
        )


# -----------------------------------------------------------------------------
# heyoka: Taylor integration of arbitrary order, compiled by LLVM.
#
# Used at its fastest, as tried on problems c, d and e. Without events, every component of the sea
# is a pair of states (a omega cos, a omega sin) that turn into each other, which costs half of
# what sines of hy.time do. With events (e) a step costs by the number of states, and in double
# precision sines of hy.time are the cheaper way. Roll and its second derivative are integrated
# from the sums that serve their derivatives too; no compact mode, which takes several times as
# long; fast_math. The case (f) has no sea; sin and cos of an angle are computed together.
# `high_accuracy` sums the Taylor series with compensation; it is a setting of its own, without
# fast_math. heyoka keeps compiled code on disk, so that `compile_s` is small from the second run
# on.

COMPENSATED = 'compensated'

_LINEAR = ('1e-9', '1e-12', '1e-15', '1e-18', '1e-21', '1e-24', '1e-30')
_TOLERANCES = {
    'a': _LINEAR,
    'b': ('1e-9', '1e-12', '1e-13', '1e-14', '1e-15', '1e-16', '1e-18'),
    'c': ('1e-9', '1e-11', '1e-12', '3e-13', '1e-13', '1e-15', '1e-18'),
    'd': _LINEAR,
    'e': ('1e-6', '1e-8', '3e-9', '1e-9', '3e-10', '1e-12', '1e-15'),
    'f': ('1e-9', '1e-12', '1e-13', '3e-14', '1e-14', '3e-15', '1e-15', '1e-18'),
}
"""A linear wheel's steps grow with the order that a tolerance asks for, far below rounding."""

_X, _U, _THETA, _ROLL, _ROLL_2 = range(5)
_STATES = 5


class Heyoka(_OfHeyoka):
    """heyoka's adaptive Taylor integrator in double precision; settings are tolerances."""

    name = 'heyoka'

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances, coarse to fine; closer where the error passes what is compared."""
        return (*_TOLERANCES[problem.key], f'1e-18 {COMPENSATED}')

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem at the tolerance that `setting` says.

        Raises:
            PropagationError: heyoka stopped before the end.
        """
        began = time.perf_counter()
        tolerance, *words = setting.split()
        compensated = COMPENSATED in words
        options = {
            'tol': float(tolerance),
            'high_accuracy': compensated,
            'fast_math': not compensated,
        }
        if isinstance(problem, CaseProblem):
            integrator = _case_integrator(problem, options)
        else:
            integrator = _integrator(problem.numbers, options)
        ready = time.perf_counter()
        _until(integrator, duration_s)
        run_s = time.perf_counter() - ready
        angle, rate = end_of(problem, duration_s, integrator.state)
        return Outcome(duration_s, angle, rate, run_s, ready - began)


def _case_integrator(problem: CaseProblem, options: dict[str, Any]) -> Any:
    """Return an integrator with the state (theta, phi, theta', phi') of the case."""
    from benchmarks.work_precision.equations.case_kernels import bends

    hy, case = library(), problem.numbers
    theta, phi, theta_rate, phi_rate = hy.make_vars('theta', 'phi', 'theta_rate', 'phi_rate')
    delta = phi - theta
    theta_bend, phi_bend = bends(
        (case.e, case.c, case.k, case.gravity),
        (theta_rate, phi_rate),
        (hy.sin(theta), hy.cos(theta)),
        (hy.sin(delta), hy.cos(delta)),
    )
    equations = [(theta, theta_rate), (phi, phi_rate)]
    equations += [(theta_rate, theta_bend), (phi_rate, phi_bend)]
    return hy.taylor_adaptive(equations, np.array(start_of(problem)), **options)


def _integrator(numbers: Numbers, options: dict[str, Any]) -> Any:
    """Return an integrator with the state (x, u, theta, roll, roll'', cosines, sines)."""
    hy = library()
    x, u, theta, roll, second = hy.make_vars('x', 'u', 'theta', 'roll', 'second')
    pairs, first, third, turning = _turning(hy, numbers)
    gravity, lean_rate = _vertical(hy, numbers, (roll, first, second, third))
    eps, inertia, lever = mass_ratio(numbers), numbers.inertia, numbers.lever_rate
    pull = (lever * numbers.force / inertia) + (lever * numbers.mass / inertia) * gravity
    speed = u - lean_rate - first
    torque = -pull * x
    if numbers.mass:
        speed = speed / (1.0 + eps * x * x)
        torque = x * (eps * speed * speed - pull)
    if numbers.viscous:
        torque = torque - (numbers.viscous / inertia) * (speed + lean_rate)
    equations = [(x, speed), (u, torque), (theta, speed + lean_rate)]
    equations += [(roll, first), (second, third), *pairs]
    if numbers.impulse_energy:
        options['t_events'] = [hy.t_event(theta, callback=_impulse(numbers))]
    state = np.concatenate([_start(numbers), turning])
    return hy.taylor_adaptive(equations, state, **options)


def _start(numbers: Numbers) -> FloatArray:
    second, sea = 0.0, numbers.sea
    if sea is not None:
        second = -np.sum(sea.amplitude * sea.omega**2 * np.cos(sea.phase))
    roll = vertical(numbers, 0.0).roll
    return np.array([*start(numbers), numbers.release_angle, roll, second])


def _turning(hy: Any, numbers: Numbers) -> tuple[list[tuple[Any, Any]], Any, Any, FloatArray]:
    """Return the pairs' equations, roll', roll''' as sums, and the pairs at the start.

    There are none with impulses.
    """
    sea, turning = numbers.sea, np.empty(0)
    equations: list[tuple[Any, Any]] = []
    if sea is None:
        return equations, hy.expression(0.0), hy.expression(0.0), turning
    omega, phase, scale = sea.omega, sea.phase, sea.amplitude * sea.omega
    indices = range(len(omega))
    if numbers.impulse_energy:
        sine = [scale[i] * hy.sin(omega[i] * hy.time + phase[i]) for i in indices]
    else:
        cosine = [hy.expression(f'c{i}') for i in indices]
        sine = [hy.expression(f's{i}') for i in indices]
        equations = [(cosine[i], -omega[i] * sine[i]) for i in indices]
        equations += [(sine[i], omega[i] * cosine[i]) for i in indices]
        turning = np.concatenate([scale * np.cos(phase), scale * np.sin(phase)])
    third = hy.sum([omega[i] ** 2 * sine[i] for i in indices])
    return equations, -hy.sum(sine), third, turning


def _vertical(hy: Any, numbers: Numbers, roll: tuple[Any, Any, Any, Any]) -> tuple[Any, Any]:
    """Return g_eff and the lean's rate as expressions of roll and its derivatives."""
    if numbers.sea is None or not (numbers.mass or numbers.follows_vertical):
        return hy.expression(numbers.gravity), hy.expression(0.0)
    angle, first, second, third = roll
    height, g = numbers.sea.height, numbers.gravity
    sine, cosine = hy.sin(angle), hy.cos(angle)
    across = height * second - g * sine
    along = g * cosine - height * first * first
    square = across * across + along * along
    if not numbers.follows_vertical:
        return hy.sqrt(square), hy.expression(0.0)
    across_rate = height * third - g * cosine * first
    along_rate = -first * (g * sine + 2 * height * second)
    return hy.sqrt(square), (across_rate * along - across * along_rate) / square


def _impulse(numbers: Numbers) -> Callable[[Any, int], bool]:
    """Return the callback that raises the kinetic energy where theta passes zero.

    v becomes sqrt(v^2 + 2 E/M) in the direction of the motion, M = I (1 + eps x^2); u gains
    (1 + eps x^2) times what v gains.
    """
    eps, gravity, follows = mass_ratio(numbers), numbers.gravity, numbers.follows_vertical
    twice = 2.0 * numbers.impulse_energy / numbers.inertia
    height, (scale, omega, phase) = 0.0, np.empty((3, 0))
    if (sea := numbers.sea) is not None:
        height, scale, omega, phase = sea.height, sea.amplitude * sea.omega, sea.omega, sea.phase

    def kick(state: Any, now: Any) -> None:
        sines = scale * np.sin(omega * now + phase)
        first, third = -sines.sum(), (omega * omega * sines).sum()
        roll, second = state[_ROLL], state[_ROLL_2]
        sine, cosine = np.sin(roll), np.cos(roll)
        across = height * second - gravity * sine
        along = gravity * cosine - height * first * first
        turned = (height * third - gravity * cosine * first) * along
        turned += across * first * (gravity * sine + 2 * height * second)
        lean_rate = turned / (across * across + along * along) if follows else 0 * first
        load = 1 + eps * state[_X] * state[_X]
        speed = (state[_U] - lean_rate - first) / load + lean_rate
        faster = np.sqrt(speed * speed + twice / load)
        state[_U] += load * ((faster if speed > 0 else -faster) - speed)

    compiled: Any = njit(kick)
    compiled(np.ones(_STATES), 0.0)

    def met(integrator: Any, _direction: int) -> bool:
        compiled(integrator.state, integrator.time)
        return True

    return met


# -----------------------------------------------------------------------------
# heyoka in the best formulation that was found for each problem.
#
# At sea (c, d, e) the waves are not summed in every step. Instead, pieces of a length are fitted
# to them (`SeaPieces`, within the run time), and each coefficient is a state of a chain, which
# Taylor's method continues at the cost of one multiplication per order. A sine, or Horner's rule
# in the time with the coefficients as parameters, would cost convolutions. The chains are scaled
# down, so that the wheel alone determines the step. The loop over pieces is compiled and calls
# heyoka's compiled step by its address, as a program in C++ would; from Python each piece costs 3
# us more. Impulses are found on the step's own Taylor polynomials, which costs less than heyoka's
# events.
#
# On land b runs in a time tau with dt = (1 + eps x^2) dtau, in which its equation is a polynomial
# (Duffing's), with E the energy over I at release and w the frequency of small swings:
#
#     x' = u,   u' = (2 eps E - w^2) x - 2 eps w^2 x^3,
#     t = (1 + eps/2) tau + p,   p' = eps (x^2 - 1/2),
#
# and f in its momenta, whose steps are longer. The integrator still has to solve the equation of
# motion itself. The forced swing of a piece in closed form, or the superposition of several pieces
# side by side, would not be its work. Several ships side by side are in `heyoka_batch`.

TUNED = 'heyoka_tuned'
STRETCH_S = 3600.0
SCALE = 2.0**-20

_PIECES = {
    'c': {
        '0.5 s 5 points': ('1e-5', '1e-7'),
        '1 s 6 points': ('1e-5', '1e-7'),
        '1 s 8 points': ('1e-7', '1e-9'),
        '0.5 s 8 points': ('1e-11', '3e-12', '1e-12', '3e-13'),
        '0.75 s 10 points': ('1e-12', '3e-13'),
        '1 s 12 points': ('1e-12', '3e-13', '1e-13', '1e-14'),
        '1 s 14 points': ('1e-15', '1e-18'),
    },
    'd': {
        '2 s 6 points': ('1e-9', '1e-18', '1e-30'),
        '3 s 8 points': ('1e-9', '1e-18', '1e-30'),
        '1 s 8 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 10 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 12 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 14 points': ('1e-24', '1e-30'),
        '3 s 18 points': ('1e-24',),
    },
    'e': {
        '0.5 s 4 points': ('1e-5', '1e-7'),
        '0.5 s 5 points': ('1e-5', '1e-7'),
        '1 s 6 points': ('1e-5', '1e-7'),
        '0.5 s 6 points': ('1e-8', '3e-9', '1e-9'),
        '0.5 s 7 points': ('3e-9', '1e-9', '3e-10', '1e-10'),
        '1 s 9 points': ('1e-8', '3e-9', '1e-9'),
        '1 s 10 points': ('1e-9', '3e-10', '1e-10'),
        '1 s 14 points': ('1e-12', '1e-15'),
    },
}
_ELSEWHERE = {
    'b': ('1e-12', '1e-13', '1e-14', '1e-15', '1e-16', '1e-18'),
    'f': ('1e-13', '1e-14', '1e-15', '3e-16', '1e-16', '1e-17'),
}


class HeyokaTuned(_OfHeyoka):
    """heyoka on polynomials of the sea, in a stretched time or in momenta.

    Settings are tolerances, at sea with the length of a piece and the number of its points.
    """

    name = TUNED

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances; none for a, whose best formulation is the plain one."""
        return settings_at_sea(problem.key) or _ELSEWHERE.get(problem.key, ())

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem.

        Raises:
            UsageError: problem a.
            PropagationError: heyoka stopped before the end.
        """
        if not self.settings(problem):
            raise UsageError(
                f"{TUNED}: problem {problem.key!r} has no better formulation. Choose 'heyoka'"
            )
        began = time.perf_counter()
        run = _run_of(problem, setting)
        ready = time.perf_counter()
        for begin_s, length_s in stretches(duration_s, STRETCH_S):
            run.advance(begin_s, length_s)
        run_s = time.perf_counter() - ready
        angle, rate = run.end(duration_s)
        return Outcome(duration_s, float(angle), float(rate), run_s, ready - began)


def settings_at_sea(key: str) -> tuple[str, ...]:
    """Return tolerances with the length of a piece and its points; none on land."""
    return tuple(
        f'{each} {piece}' for piece, some in _PIECES.get(key, {}).items() for each in some
    )


def piece_of(setting: str) -> tuple[float, float, int]:
    """Return tolerance, length of a piece [s] and number of points of a setting at sea."""
    tolerance, length_s, _, points, _ = setting.split()
    return float(tolerance), float(length_s), int(points)


def _run_of(problem: Problem, setting: str) -> _Pieces | _Stretched | _Momenta:
    if isinstance(problem, CaseProblem):
        return _Momenta(problem.numbers, float(setting))
    if problem.numbers.sea is None:
        return _Stretched(problem, float(setting))
    return _Pieces(problem.numbers, problem.numbers.sea, *piece_of(setting))


class _Pieces:
    """The wheel at sea, piece by piece."""

    def __init__(
        self, numbers: Numbers, sea: Sea, tolerance: float, length_s: float, points: int
    ) -> None:
        from benchmarks.work_precision.equations.piece_kernels import advance_pieces

        self._numbers, self._advance = numbers, advance_pieces
        self._pieces = SeaPieces(numbers, sea, length_s, points, SCALE)
        chains = self._pieces.channels * points
        self._state = np.concatenate([pieces_start(numbers), np.zeros(chains)])
        integrator = integrator_of(numbers, self._pieces, tolerance)
        self._engine, self._step = compiled_step(integrator)
        self._taylor = np.zeros((2 + chains, integrator.order + 1))
        self._side = 1.0 if numbers.impulse_energy else 0.0
        twice = 2.0 * numbers.impulse_energy / numbers.inertia
        self._kick = mass_ratio(numbers), twice, SCALE, 2.0 / length_s
        # compiles, or loads what was compiled
        first = self._state.copy()
        self.advance(0.0, 1e-9)
        self._state = first

    def advance(self, begin_s: float, length_s: float) -> None:
        for left_s, chains in self._pieces.blocks(begin_s, length_s):
            self._side = self._advance(
                self._step,
                self._state,
                chains,
                self._pieces.length_s,
                left_s,
                self._side,
                self._taylor,
                self._kick,
            )

    def end(self, time_s: float) -> tuple[Any, Any]:
        return pieces_wheel(self._numbers, time_s, *self._state[:2])


def integrator_of(numbers: Numbers, pieces: Any, tolerance: float, ships: int = 1) -> Any:
    """Return an integrator with the state (x, u), or (psi, psi'), and the chains.

    Args:
        numbers: of the problem.
        pieces: the polynomials of the sea.
        tolerance: of heyoka.
        ships: more than one: the integrator of a batch, a ship a lane.
    """
    hy, n = library(), pieces.points
    per_half, back, inertia = 2.0 / pieces.length_s, 1.0 / SCALE, numbers.inertia
    x, u = hy.make_vars('x', 'u')
    chains = [[hy.expression(f'z{m}_{j}') for j in range(n)] for m in range(pieces.channels)]
    turning = [
        (chain[j], per_half * (j + 1) * chain[j + 1] if j + 1 < n else hy.expression(0.0))
        for chain in chains
        for j in range(n)
    ]
    if numbers.mass:
        eps, pull = mass_ratio(numbers), numbers.lever_rate * numbers.mass / inertia
        speed = (u - back * chains[0][0]) / (1.0 + eps * x * x)
        torque = x * (eps * speed * speed - pull * back * chains[1][0])
        if numbers.viscous:
            lean_rate = per_half * back * chains[2][1]
            torque = torque - numbers.viscous / inertia * (speed + lean_rate)
        wheel_equations = [(x, speed), (u, torque)]
    else:
        pull = numbers.force * numbers.lever_rate / inertia
        wheel_equations = [(x, u), (u, pull * back * chains[0][0] - pull * x)]
    states = 2 + n * pieces.channels
    if ships > 1:
        start = np.zeros((states, ships))
        return hy.taylor_adaptive_batch(
            wheel_equations + turning, start, tol=tolerance, fast_math=True
        )
    return hy.taylor_adaptive(
        wheel_equations + turning, np.zeros(states), tol=tolerance, fast_math=True
    )


def compiled_step(integrator: Any) -> tuple[Any, int]:
    """Return what keeps heyoka's compiled step in memory, and the step's address.

    It takes pointers to the state, parameters, time, the longest step, which it replaces by the
    step taken, and Taylor coefficients or none.
    """
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    # a batch takes its powers from the vector library that heyoka's wheel brings
    for file in files('heyoka') or ():
        if file.name.startswith('libsleef'):
            llvm.load_library_permanently(str(file.locate()))
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(''), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(integrator.llvm_state.object_code))
    engine.finalize_object()
    return engine, engine.get_function_address('step')


class _Stretched:
    """The weight on land in the time tau."""

    def __init__(self, problem: WheelProblem, tolerance: float) -> None:
        hy, numbers = library(), problem.numbers
        self._eps = mass_ratio(numbers)
        square, angle = numbers.frequency**2, numbers.release_angle
        x, u, p = hy.make_vars('x', 'u', 'p')
        energy = 0.5 * square * angle**2
        bend = x * ((2.0 * self._eps * energy - square) - (2.0 * self._eps * square) * (x * x))
        self._integrator = hy.taylor_adaptive(
            [(x, u), (u, bend), (p, self._eps * (x * x) - 0.5 * self._eps)],
            np.array([angle, 0.0, 0.0]),
            tol=tolerance,
            fast_math=True,
        )

    def advance(self, begin_s: float, length_s: float) -> None:
        """Advance to within a step of the end of the stretch."""
        _until(self._integrator, self._tau(begin_s + length_s))

    def _tau(self, time_s: float) -> float:
        lack = float(time_s - self._integrator.state[2])
        return lack / (1.0 + 0.5 * self._eps)

    def end(self, time_s: float) -> tuple[Any, Any]:
        """Meet the end, where p is found together with tau."""
        for _ in range(8):
            _until(self._integrator, self._tau(time_s))
        x, u, _ = self._integrator.state
        return x, u / (1.0 + self._eps * x * x)


class _Momenta:
    """The case: theta, phi and the momenta e theta' + c cos(delta) phi' and that of phi."""

    def __init__(self, case: HungCase, tolerance: float) -> None:
        hy, e, c, k, g = library(), case.e, case.c, case.k, case.gravity
        self._case = case
        theta, phi, y, z = hy.make_vars('theta', 'phi', 'y', 'z')
        sine, cosine = hy.sin(phi - theta), hy.cos(phi - theta)
        phi_rate = (z - c * cosine * y) / (k * k + (c * sine) * (c * sine))
        theta_rate = (y - c * cosine * phi_rate) / e
        coupling = e * c * (theta_rate * phi_rate) * sine
        equations = [(theta, theta_rate), (phi, phi_rate)]
        equations += [(y, coupling / e - g * hy.sin(theta))]
        equations += [(z, -coupling - c * g * hy.sin(phi))]
        angle = case.release_angle
        self._integrator = hy.taylor_adaptive(
            equations, np.array([angle, angle, 0.0, 0.0]), tol=tolerance, fast_math=True
        )

    def advance(self, begin_s: float, length_s: float) -> None:
        _until(self._integrator, begin_s + length_s)

    def end(self, _time_s: float) -> tuple[Any, Any]:
        theta, phi, y, z = self._integrator.state
        c, k = self._case.c, self._case.k
        wide = c * np.sin(phi - theta)
        return phi, (z - c * np.cos(phi - theta) * y) / (k * k + wide * wide)


# -----------------------------------------------------------------------------
# heyoka on several ships at once: the lanes of a vector instruction carry a ship each.
#
# `tauto fleet` and `tauto compare` sail many ships, and for those heyoka's batches are its best
# formulation. Eight ships with eight seas (the first is that of the problem, so that its reference
# holds; the others have its waves at other phases) advance by one compiled step, each with its own
# step size, its own polynomials of the sea and its own impulses. The equations and the fitted
# pieces are those of `heyoka_tuned`. The time that is reported is that of a ship.

BATCH = 'heyoka_batch'
SHIPS = 8
"""Lanes of eight doubles: 512 bits; on processors with 256 heyoka splits them."""


class HeyokaBatch(_OfHeyoka):
    """heyoka's batch integrator on polynomials of the sea, a ship a lane.

    Settings are those of `heyoka_tuned` at sea.
    """

    name = BATCH

    def settings(self, problem: Problem) -> tuple[str, ...]:
        """Return tolerances with pieces for c and e; none for what is not an ensemble at sea."""
        return settings_at_sea(problem.key) if problem.key in 'ce' else ()

    def solve(self, problem: Problem, setting: str, duration_s: float) -> Outcome:
        """Solve the problem, and it in seven other seas.

        Raises:
            UsageError: a problem other than c and e.
        """
        if not isinstance(problem, WheelProblem) or not self.settings(problem):
            raise UsageError(
                f"{BATCH}: problem {problem.key!r} has no ensemble. Choose 'c' or 'e'"
            )
        began = time.perf_counter()
        fleet = _Fleet(problem.numbers, *piece_of(setting))
        ready = time.perf_counter()
        for begin_s, length_s in stretches(duration_s, STRETCH_S):
            fleet.advance(begin_s, length_s)
        run_s = time.perf_counter() - ready
        angle, rate = wheel(problem.numbers, duration_s, *fleet.state[:2, 0])
        return Outcome(duration_s, float(angle), float(rate), run_s / SHIPS, ready - began)


def eight_seas(numbers: Numbers) -> list[Numbers]:
    """Return the problem's numbers in its own sea, and in seven of other phases."""
    assert numbers.sea is not None
    rng = np.random.default_rng(8)
    others = [
        replace(numbers.sea, phase=rng.uniform(0.0, 2.0 * np.pi, len(numbers.sea.phase)))
        for _ in range(SHIPS - 1)
    ]
    return [replace(numbers, sea=sea) for sea in (numbers.sea, *others)]


class _Fleet:
    """Eight wheels at sea, piece by piece."""

    def __init__(self, numbers: Numbers, tolerance: float, length_s: float, points: int) -> None:
        from benchmarks.work_precision.equations.piece_kernels import advance_batch

        self._advance = advance_batch
        own = eight_seas(numbers)
        self._pieces = [
            SeaPieces(each, each.sea, length_s, points, SCALE) for each in own if each.sea
        ]
        chains = self._pieces[0].channels * points
        starts = np.array([pieces_start(each) for each in own]).T
        self.state: FloatArray = np.concatenate([starts, np.zeros((chains, SHIPS))])
        integrator = integrator_of(numbers, self._pieces[0], tolerance, SHIPS)
        self._engine, self._step = compiled_step(integrator)
        self._taylor = np.zeros((2 + chains, integrator.order + 1, SHIPS))
        self._sides = np.full(SHIPS, 1.0 if numbers.impulse_energy else 0.0)
        twice = 2.0 * numbers.impulse_energy / numbers.inertia
        self._kick = mass_ratio(numbers), twice, SCALE, 2.0 / length_s
        # compiles, or loads what was compiled
        first = self.state.copy()
        self.advance(0.0, 1e-9)
        self.state[:] = first

    def advance(self, begin_s: float, length_s: float) -> None:
        """Advance all ships over a stretch."""
        blocks = (each.blocks(begin_s, length_s) for each in self._pieces)
        for found in zip(*blocks, strict=True):
            chains = np.stack([chain for _, chain in found], axis=-1)
            self._advance(
                self._step,
                self.state,
                chains,
                self._pieces[0].length_s,
                found[0][0],
                self._sides,
                self._taylor,
                self._kick,
            )
