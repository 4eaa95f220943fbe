"""heyoka in the best formulation that was found for each problem.

At sea (c, d, e) the waves are not summed in every step. Instead, pieces of a length are fitted to
them (`sea_pieces`, within the run time), and each coefficient is a state of a chain, which
Taylor's method continues at the cost of one multiplication per order. A sine, or Horner's rule in
the time with the coefficients as parameters, would cost convolutions. The chains are scaled down,
so that the wheel alone determines the step. The loop over pieces is compiled and calls heyoka's
compiled step by its address, as a program in C++ would; from Python each piece costs 3 us more.
Impulses are found on the step's own Taylor polynomials, which costs less than heyoka's events.

On land b runs in a time tau with dt = (1 + eps x^2) dtau, in which its equation is a polynomial
(Duffing's), with E the energy over I at release and w the frequency of small swings:

    x' = u,   u' = (2 eps E - w^2) x - 2 eps w^2 x^3,
    t = (1 + eps/2) tau + p,   p' = eps (x^2 - 1/2),

and f in its momenta, whose steps are longer. The integrator still has to solve the equation of
motion itself. The forced swing of a piece in closed form, or the superposition of several pieces
side by side, would not be its work. Several ships side by side are in `heyoka_batch`.
"""

from __future__ import annotations

import time
from importlib.metadata import files, version
from typing import Any

import numpy as np

from benchmarks.work_precision.equations.sea import stretches
from benchmarks.work_precision.equations.states import library, mass_ratio, start, vertical, wheel
from benchmarks.work_precision.peer import Outcome
from benchmarks.work_precision.problems import (
    CaseProblem,
    HungCase,
    Numbers,
    Problem,
    Sea,
    WheelProblem,
)
from tauto_core.scene.errors import PropagationError, UsageError

NAME = 'heyoka_tuned'
STRETCH_S = 3600.0
SCALE = 2.0**-20

_PIECES = {
    'c': {
        '0.5 s 8 points': ('1e-11', '3e-12', '1e-12', '3e-13'),
        '0.75 s 10 points': ('1e-12', '3e-13'),
        '1 s 12 points': ('1e-12', '3e-13', '1e-13', '1e-14'),
        '1 s 14 points': ('1e-15', '1e-18'),
    },
    'd': {
        '1 s 8 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 10 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 12 points': ('1e-18', '1e-24', '1e-30'),
        '2 s 14 points': ('1e-24', '1e-30'),
        '3 s 18 points': ('1e-24',),
    },
    'e': {
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


class HeyokaTuned:
    """heyoka on polynomials of the sea, in a stretched time or in momenta.

    Settings are tolerances, at sea with the length of a piece and the number of its points.
    """

    name = NAME

    def __init__(self) -> None:
        library(NAME, 'heyoka', 'heyoka')

    def version(self) -> str:
        """Return the version of the library."""
        return version('heyoka')

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
                f"{NAME}: problem {problem.key!r} has no better formulation. Choose 'heyoka'"
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
        from benchmarks.work_precision.equations.sea_pieces import SeaPieces

        self._numbers, self._advance = numbers, advance_pieces
        self._pieces = SeaPieces(numbers, sea, length_s, points, SCALE)
        chains = self._pieces.channels * points
        self._state = np.concatenate([start_of(numbers), np.zeros(chains)])
        integrator = integrator_of(numbers, self._pieces, tolerance)
        self._engine, self._step = compiled_step(integrator)
        self._taylor = np.zeros((2 + chains, integrator.order + 1))
        self._side = 1.0 if numbers.impulse_energy else 0.0
        twice = 2.0 * numbers.impulse_energy / numbers.inertia
        self._kick = float(mass_ratio(numbers)), twice, SCALE, 2.0 / length_s
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
        if self._numbers.mass:
            return wheel(self._numbers, time_s, *self._state[:2])
        at = vertical(self._numbers, time_s)
        return self._state[0] - at.roll, self._state[1] - at.roll_rate


def start_of(numbers: Numbers) -> tuple[Any, Any]:
    """Return x and u, or psi and psi', of the wheel released at rest in its case."""
    if numbers.mass:
        return start(numbers)
    at = vertical(numbers, 0.0)
    return numbers.release_angle + at.roll, at.roll_rate


def integrator_of(numbers: Numbers, pieces: Any, tolerance: float, ships: int = 1) -> Any:
    """Return an integrator with the state (x, u), or (psi, psi'), and the chains.

    Args:
        numbers: of the problem.
        pieces: the polynomials of the sea.
        tolerance: of heyoka.
        ships: more than one: the integrator of a batch, a ship a lane.
    """
    hy, n = library(NAME, 'heyoka', 'heyoka'), pieces.points
    per_half, back, inertia = 2.0 / pieces.length_s, 1.0 / SCALE, numbers.inertia
    x, u = hy.make_vars('x', 'u')
    chains = [[hy.expression(f'z{m}_{j}') for j in range(n)] for m in range(pieces.channels)]
    turning = [
        (chain[j], per_half * (j + 1) * chain[j + 1] if j + 1 < n else hy.expression(0.0))
        for chain in chains
        for j in range(n)
    ]
    if numbers.mass:
        eps, pull = float(mass_ratio(numbers)), numbers.lever_rate * numbers.mass / inertia
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


def _until(integrator: Any, end: float) -> None:
    outcome = integrator.propagate_until(end)[0]
    if outcome != library(NAME, 'heyoka', 'heyoka').taylor_outcome.time_limit:
        raise PropagationError(
            f'heyoka stopped with {outcome}. Choose a coarser tolerance.', float(integrator.time)
        )


class _Stretched:
    """The weight on land in the time tau."""

    def __init__(self, problem: WheelProblem, tolerance: float) -> None:
        hy, numbers = library(NAME, 'heyoka', 'heyoka'), problem.numbers
        self._eps = float(mass_ratio(numbers))
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
        hy, (e, c, k, g) = (
            library(NAME, 'heyoka', 'heyoka'),
            (case.e, case.c, case.k, case.gravity),
        )
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
