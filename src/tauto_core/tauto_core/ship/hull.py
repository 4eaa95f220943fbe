"""Ship motions in waves from the hydrodynamic coefficients of a hull (hull.md).

`HullCoefficients` holds a panel method's result for a hull at rest: added mass, damping and the
exciting forces of waves. `Hull` adds the ship's weights and gives its six motions at any heading
and speed. `rate_by_place` returns their effect on the rate of a weight-driven clock.

Axes as in ship.md: x forward, y to port, z up, from amidships, the centreline and the waterline.
The six motions are surge, sway, heave [m], roll (starboard down), pitch (bow down) and yaw (bow to
port) [rad]. Waves run in the direction beta from the bow to port: 0 following seas, pi/2 beam
seas, pi head seas. The water is deep.
"""

from __future__ import annotations

import difflib
import math
import zipfile
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tauto_core.curves.numerics import hermite, spline, spline_slopes, trapezoid
from tauto_core.files import write_whole
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import ABSENT, Problem, TautoError, problems_where
from tauto_core.scene.times import DAY_S, STANDARD_GRAVITY

ComplexArray: TypeAlias = NDArray[np.complex128]

MOST_FROUDE = 0.25
"""Largest Froude number U/sqrt(g L) for the speed terms of strip theory."""
LEAST_ENCOUNTER = 0.2
"""Encounter frequency over wave frequency below which helm and sails hold the course."""
LENGTHS_M = (2.0, 400.0)
# Coupled motions of a symmetric hull: 1, 3, 5 and 2, 4, 6.
_PAIRS = np.add.outer(np.arange(6), np.arange(6)) % 2 == 0
_FORMAT = 1
_DAMAGED = (zipfile.BadZipFile, zlib.error)
# Most bytes of a hull's arrays, decompressed. A shipped hull has 30 kB.
_LARGEST = 2**26

SHAPES_FOLDER = Path(__file__).parent / 'hulls'


class HullError(TautoError):
    """A hull, or a use of one, that is refused; `key` is the wrong argument, for example
    `draught`.
    """

    exit_code = 2

    def __init__(self, key: str, value: object, problem: str, remedy: str) -> None:
        self.problem = Problem(key, value, problem, remedy)
        super().__init__(str(self.problem))


def refuse_where(*rows: tuple[object, str, object, str, str]) -> None:
    """Raise a `HullError` for the first row whose first item, a condition, holds."""
    for problem in problems_where(*rows):
        raise HullError(problem.key, problem.value, problem.problem, problem.remedy)


def check_proportions(length: float, beam: float, draught: float) -> None:
    """Refuse a length of the waterline, beam or draught without keel [m] outside this theory.

    Raises:
        HullError: a length outside `LENGTHS_M`, a beam outside a 20th to half of the length, or a
            draught outside a 20th of the beam to the beam.
    """
    low, high = LENGTHS_M
    refuse_where(
        (
            not low <= length <= high,
            'length',
            length,
            f'must be in [{low:g}, {high:g}] m',
            f'Give it in metres; did you mean {length / 10:g}?'
            if length > high
            else 'Give the length of the waterline in metres.',
        ),
        (
            not length / 20.0 <= beam <= length / 2.0,
            'beam',
            beam,
            f'must be between a 20th and half of the length, {length / 20:.3g} to '
            f'{length / 2:.3g} m',
            'Give the beam of the waterline in metres.',
        ),
        (
            draught > beam,
            'draught',
            draught,
            f'must not exceed the beam, {beam:g} m: the hull would be deeper than wide',
            'Give the draught of the hull without its keel.',
        ),
        (
            not draught >= beam / 20.0,  # nor NaN
            'draught',
            draught,
            f'must be at least a 20th of the beam, {beam / 20:.3g} m',
            'Give the draught in metres.',
        ),
    )


def check_froude(speed: float, length: float, gravity: float = STANDARD_GRAVITY) -> None:
    """Refuse a speed [m/s] below 0 or above a Froude number U/sqrt(g L) of `MOST_FROUDE`."""
    limit = MOST_FROUDE * math.sqrt(gravity * length)
    refuse_where(
        (
            not 0.0 <= speed <= limit,
            'speed',
            speed,
            f'must be in [0, {limit:.3g}] m/s for a hull of {length:g} m: strip theory holds up '
            f'to a Froude number of {MOST_FROUDE}',
            'Sail slower, or a longer hull.',
        )
    )


# -----------------------------------------------------------------------------
# The result of a panel method for a hull at rest.


@dataclass(frozen=True, eq=False)
class HullCoefficients:
    """Hydrostatics, added mass, damping and exciting forces of a hull at rest in deep water.

    The tables are dimensionless (Froude scaling), with L the length, g gravity and rho the density
    of the water: frequencies by sqrt(g/L), added mass by rho L^3, damping by rho L^3 sqrt(g/L),
    forces per wave amplitude by rho g L^2. Each index of a rotation adds a factor L. They hold for
    the same shape at any length, density and gravity.

    The exciting forces follow the panel program's convention: factors of exp(-i omega t) for the
    wave a exp(i k (x cos beta + y sin beta) - i omega t).

    Attributes:
        source: how the tables were made.
        length: L of the waterline [m].
        beam, draught: of the waterline, and without keel [m].
        volume: V, displaced [m3].
        buoyancy: x_B and z_B of the centre of buoyancy [m].
        waterplane_area: [m2].
        flotation: x_F of the centre of the waterplane [m].
        second_moments: of the waterplane about the x and the y axis, I_T and I_L [m4].
        frequency: increasing from 0, (n,).
        added_mass: symmetric, (n + 1, 6, 6), the last for an infinite frequency.
        damping: symmetric, (n, 6, 6).
        excitation: complex, (n, m, 6), for m headings that divide [0, pi] evenly.
    """

    name: str
    source: str
    length: float
    beam: float
    draught: float
    volume: float
    buoyancy: tuple[float, float]
    waterplane_area: float
    flotation: float
    second_moments: tuple[float, float]
    frequency: FloatArray = field(repr=False)
    added_mass: FloatArray = field(repr=False)
    damping: FloatArray = field(repr=False)
    excitation: ComplexArray = field(repr=False)

    def __post_init__(self) -> None:
        remedy = 'Make the table again with `tauto hull`.'
        frequency, excitation = self.frequency, self.excitation
        n, m = len(frequency), excitation.shape[1] if excitation.ndim == 3 else 0
        shapes = {'added_mass': (n + 1, 6, 6), 'damping': (n, 6, 6), 'excitation': (n, m, 6)}
        rises = n > 0 and frequency[0] == 0.0 and np.all(np.diff(frequency) > 0.0)
        tables = ('frequency', *shapes)
        refuse_where(
            *(
                (
                    getattr(self, key).shape != shape,
                    key,
                    getattr(self, key).shape,
                    f'must have the shape {shape} for {n} frequencies',
                    remedy,
                )
                for key, shape in shapes.items()
            ),
            (
                n < 8 or m < 7,
                'frequency',
                f'{n} by {m} headings',
                'at least 8 frequencies and 7 headings are needed',
                remedy,
            ),
            (not rises, 'frequency', ABSENT, 'must rise from 0', remedy),
            *(
                (
                    not np.all(np.isfinite(getattr(self, key))),
                    key,
                    ABSENT,
                    'must be finite',
                    remedy,
                )
                for key in tables
            ),
            *(
                (not getattr(self, key) > 0.0, key, getattr(self, key), 'must be above 0', remedy)
                for key in ('volume', 'waterplane_area')
            ),
            (
                not 0.05 < self.block <= 1.001,
                'volume',
                self.volume,
                f'makes a block coefficient of {self.block:.3g}, which must be in (0.05, 1]',
                remedy,
            ),
        )
        check_proportions(self.length, self.beam, self.draught)

    @cached_property
    def slopes(self) -> tuple[FloatArray, FloatArray]:
        """Slopes of the splines through added masses and dampings at the frequencies."""
        return (
            spline_slopes(self.frequency, self.added_mass[:-1]),
            spline_slopes(self.frequency, self.damping),
        )

    @property
    def block(self) -> float:
        """Block coefficient V/(L B T)."""
        return self.volume / (self.length * self.beam * self.draught)

    def scaled(self, length: float) -> HullCoefficients:
        """Return the same shape at another length [m], with the same tables."""
        check_proportions(length, *(length / self.length * x for x in (self.beam, self.draught)))
        s = length / self.length
        return replace(
            self,
            length=length,
            beam=s * self.beam,
            draught=s * self.draught,
            volume=s**3 * self.volume,
            buoyancy=(s * self.buoyancy[0], s * self.buoyancy[1]),
            waterplane_area=s**2 * self.waterplane_area,
            flotation=s * self.flotation,
            second_moments=(s**4 * self.second_moments[0], s**4 * self.second_moments[1]),
        )

    def radiated_damping(self) -> FloatArray:
        """Return the damping that follows from the exciting forces, (n, 6, 6).

        Haskind's relation (J. N. Newman, J. Ship Res. 6, 1962): B_jk = omega^3/(4 pi) times the
        integral of Re(F_j conj(F_k)) over all headings, in the units of the tables. The panel
        method computes `damping` from radiated waves alone, so the difference of the two measures
        the error of the tables.
        """
        spacing = np.pi / (self.excitation.shape[1] - 1)
        # the trapezoidal rule over a full turn: inner headings count twice, for both sides
        weight = np.full(self.excitation.shape[1], 2.0 * spacing)
        weight[[0, -1]] = spacing
        power = np.einsum('m,nmj,nmk->njk', weight, self.excitation, self.excitation.conj()).real
        scale = self.frequency**3 / (4.0 * np.pi)
        return np.asarray(np.where(_PAIRS, scale[:, None, None] * power, 0.0))

    def save(self, path: Path) -> None:
        """Write the coefficients to an .npz file, whole or not at all, in place of an old one.

        Raises:
            HullError: the file cannot be written.
        """
        content: dict[str, Any] = {
            'format': np.array(_FORMAT),
            'name': np.array(self.name),
            'source': np.array(self.source),
            'sizes': np.array(
                [
                    *(self.length, self.beam, self.draught, self.volume, *self.buoyancy),
                    *(self.waterplane_area, self.flotation, *self.second_moments),
                ]
            ),
            'frequency': self.frequency,
            'added_mass': self.added_mass.astype(np.float32),
            'damping': self.damping.astype(np.float32),
            'excitation': self.excitation.astype(np.complex64),
        }
        written = BytesIO()
        np.savez_compressed(written, **content)
        try:
            write_whole(path, written.getvalue())
        except OSError as error:
            problem = f'cannot be written: {error.strerror}'
            raise HullError('path', str(path), problem, 'Name another file.') from None


_MAKE_ONE = 'Make one with `tauto hull`.'


def hull_of_file(content: bytes, path: str) -> HullCoefficients:
    """Return the coefficients in the content of a file of `tauto hull`; `path` names it in errors.

    Raises:
        HullError: the content is not a hull's.
    """
    try:
        if sum(part.file_size for part in zipfile.ZipFile(BytesIO(content)).infolist()) > _LARGEST:
            raise ValueError
        with np.load(BytesIO(content), allow_pickle=False) as file:
            data = {name: file[name] for name in file.files}
    except (ValueError, EOFError, TypeError, AttributeError, RuntimeError, MemoryError, *_DAMAGED):
        problem = 'cannot be read: it is not an .npz file, or it is damaged'
        raise HullError('path', path, problem, _MAKE_ONE) from None
    wanted = ('format', 'name', 'source', 'sizes', 'frequency', 'added_mass', 'damping')
    missing = [name for name in (*wanted, 'excitation') if name not in data]
    if missing:
        raise HullError('path', path, f'lacks {", ".join(missing)}', _MAKE_ONE)
    if data['format'] != _FORMAT:
        problem = f'has the format {data["format"]}; this version reads {_FORMAT}'
        raise HullError('path', path, problem, _MAKE_ONE)
    try:
        length, beam, draught, volume, x, z, area, flotation, across, along = (
            float(size) for size in data['sizes']
        )
        return HullCoefficients(
            name=str(data['name']),
            source=str(data['source']),
            length=length,
            beam=beam,
            draught=draught,
            volume=volume,
            buoyancy=(x, z),
            waterplane_area=area,
            flotation=flotation,
            second_moments=(across, along),
            frequency=data['frequency'].astype(np.float64),
            added_mass=data['added_mass'].astype(np.float64),
            damping=data['damping'].astype(np.float64),
            excitation=data['excitation'].astype(np.complex128),
        )
    except (TypeError, ValueError):
        raise HullError('path', path, 'is not a hull', _MAKE_ONE) from None


# -----------------------------------------------------------------------------
# Shapes that come with the package.


@dataclass(frozen=True)
class Shape:
    """A parametric form with the proportions of a type of ship, not a real ship's lines.

    Half breadth y = B/2 (1 - |2x/L|^p) (1 - |z/T|^q), where Wigley's hull has p = q = 2. The
    coefficients of waterplane and midship section are p/(p + 1) and q/(q + 1).

    Attributes:
        length: L of the waterline [m].
        beam: B [m].
        draught: T, without keel [m].
        block: block coefficient C_B.
        waterplane: waterplane coefficient, at least C_B (`None`: sqrt(C_B)).
        about: the type of ship that it resembles.
    """

    length: float
    beam: float
    draught: float
    block: float
    waterplane: float | None = None
    about: str = ''

    def exponents(self) -> tuple[float, float]:
        """Return p and q.

        Raises:
            HullError: dimensions or coefficients out of range.
        """
        check_proportions(self.length, self.beam, self.draught)
        refuse_where(
            (
                not 0.3 <= self.block <= 0.96,
                'block',
                self.block,
                'must be in [0.3, 0.96]: a yacht without its keel has some 0.4, a ship of the '
                'line 0.6, a barge 0.9',
                'Give the volume displaced, divided by length, beam and draught.',
            )
        )
        across = math.sqrt(self.block) if self.waterplane is None else self.waterplane
        refuse_where(
            (
                not 1.02 * self.block <= across <= 0.99,
                'waterplane',
                across,
                f'must be in [{1.02 * self.block:.3g}, 0.99], above the block coefficient',
                'Leave it out: it is then the root of the block coefficient.',
            )
        )
        middle = self.block / across
        return across / (1.0 - across), middle / (1.0 - middle)


SHAPES: dict[str, Shape] = {
    # Length of the gundeck and beam of the Swan class of 1766 (96 ft 7 in, 26 ft 9 in, 300 tons
    # burthen, as encyclopaedias give them). Draught and coefficients are assumed.
    'sloop': Shape(29.4, 8.15, 3.4, 0.50, 0.78, 'a sloop of war of the 1760s'),
    # A two-decker of 60 guns such as the Deptford, which carried Harrison's watch to Jamaica in
    # 1761. All numbers are assumed for a ship of that size.
    'deptford': Shape(44.0, 12.6, 5.0, 0.59, None, "a ship of the Deptford's size, 1732"),
    # Granado, 1742: 91 ft on the main deck, 26 ft in the beam (Royal Museums Greenwich, model
    # SLR0331). Draught and coefficients are assumed: full, to carry mortars.
    'ketch': Shape(27.7, 7.95, 3.1, 0.56, 0.82, 'a bomb ketch of the 1740s'),
    # Proportions of a beamy cruiser-racer without its keel. All numbers are assumed.
    'yacht': Shape(10.0, 3.17, 0.794, 0.365, 0.69, 'a sailing yacht of the 1970s, without keel'),
}


def named_hull(name: str) -> HullCoefficients:
    """Return the coefficients of one of `SHAPES`.

    Raises:
        HullError: no such shape.
    """
    if name not in SHAPES:
        matches = difflib.get_close_matches(str(name), SHAPES, 1)
        meant = f' Did you mean {matches[0]}?' if matches else ''
        problem = f'must be one of {", ".join(SHAPES)}'
        raise HullError('shape', name, problem, f'Make others with `tauto hull`.{meant}')
    file = SHAPES_FOLDER / f'{name}.npz'
    return hull_of_file(file.read_bytes(), str(file))


# -----------------------------------------------------------------------------
# A ship: a hull and its weights.


@dataclass(frozen=True)
class ClockPlace:
    """A place in the ship [m]: forward of amidships, to port, up from the waterline."""

    forward: float = 0.0
    port: float = 0.0
    up: float = 0.0


@dataclass(frozen=True, eq=False)
class Response:
    """Steady ship motions per metre of wave amplitude, as factors of exp(i omega_e t).

    For the elevation a cos(omega t + eps) amidships, the factor H gives the motion a |H|
    cos(omega_e t + eps + arg H), as in `waves.Encounter.answer`.

    Attributes:
        omega: of the waves [rad/s], (n,).
        encounter: omega_e [rad/s], negative if the ship overtakes the waves, (n,).
        motions: surge, sway, heave [m/m], roll, pitch, yaw [rad/m], (n, 6).
        gravity: g [m/s2].
    """

    omega: FloatArray
    encounter: FloatArray
    motions: ComplexArray
    gravity: float

    def displacement(self, place: ClockPlace) -> ComplexArray:
        """Return the displacement at a place in level axes, (n, 3): X_1-3 + X_4-6 x r."""
        shift, turned = self.motions[:, :3], self.motions[:, 3:]
        return shift + np.cross(turned, [place.forward, place.port, place.up])

    def accelerations(self, place: ClockPlace) -> ComplexArray:
        """Return the accelerations at a place in level axes [m/s2 per m], (n, 3).

        Forward, to port and up, without gravity: -omega_e^2 times the displacement.
        """
        return -(self.encounter**2)[:, None] * self.displacement(place)

    def along_the_deck(self, place: ClockPlace) -> ComplexArray:
        """Return the specific force along a pitching deck [m/s2 per m], (n,): x'' - g theta_p."""
        return self.accelerations(place)[:, 0] - self.gravity * self.motions[:, 4]


@dataclass(frozen=True, eq=False)
class Hull:
    """A hull with the weights of a ship.

    Attributes:
        coefficients: of the hull, at the ship's length.
        roll_period: natural period of the roll [s].
        roll_damping_ratio: damping by bilges, keel and sails over critical damping, in
            addition to the waves.
        gravity: g [m/s2].
        k_xx: radius of gyration in roll about the centre of gravity [m] (`None`: 0.38 beam).
        k_yy: in pitch [m] (`None`: 0.25 length).
        k_zz: in yaw [m] (`None`: 0.25 length).
        centre_of_gravity: z_G over the waterline [m] (`None`: from the roll period).
    """

    coefficients: HullCoefficients
    roll_period: float
    roll_damping_ratio: float
    gravity: float = STANDARD_GRAVITY
    k_xx: float | None = None
    k_yy: float | None = None
    k_zz: float | None = None
    centre_of_gravity: float | None = None

    def __post_init__(self) -> None:
        length, beam = self.coefficients.length, self.coefficients.beam
        radii = (('k_xx', beam, 'beam'), ('k_yy', length, 'length'), ('k_zz', length, 'length'))
        refuse_where(
            (
                not 0.0 < self.roll_period < math.inf,
                'roll_period',
                self.roll_period,
                'must be above 0 s',
                'Give a positive number.',
            ),
            (
                not 0.0 <= self.roll_damping_ratio < 1.0,
                'roll_damping_ratio',
                self.roll_damping_ratio,
                'must be in [0, 1), 1 being critical',
                'A ship without sail has some 0.05 to 0.1.',
            ),
            *(
                (
                    getattr(self, key) is not None
                    and not 0.1 * size <= getattr(self, key) <= 0.6 * size,
                    key,
                    getattr(self, key),
                    f'must be in [{0.1 * size:.3g}, {0.6 * size:.3g}] m, 0.1 to 0.6 of the {base}',
                    f'Leave it out for the usual part of the {base}.',
                )
                for key, size, base in radii
            ),
        )
        low, high, z = -self.coefficients.draught - 0.5 * beam, beam, self.z_g
        is_given = self.centre_of_gravity is not None
        refuse_where(
            (
                not low <= z <= high,
                'centre_of_gravity' if is_given else 'roll_period',
                z if is_given else self.roll_period,
                f'puts the centre of gravity {z:.3g} m over the waterline, which must be in '
                f'[{low:.3g}, {high:.3g}] m'
                + ('' if is_given else f' (metacentric height {self.gm:.3g} m)'),
                'Give it in metres.' if is_given else self._usual_period(),
            )
        )

    def _usual_period(self) -> str:
        beam = self.coefficients.beam
        return f'A hull of {beam:.3g} m beam rolls in some {3.1 * math.sqrt(beam):.2g} s.'

    @property
    def _roll_rate(self) -> float:
        """Natural frequency of the roll in the units of the tables."""
        unit = math.sqrt(self.gravity / self.coefficients.length)
        return 2.0 * math.pi / self.roll_period / unit

    @cached_property
    def _rolled_mass(self) -> tuple[float, float, float]:
        """A44, A24 and A22 at the natural frequency, in the units of the tables."""
        a = _added_mass(self.coefficients, np.array([self._roll_rate]))[0]
        return float(a[3, 3]), float(a[1, 3]), float(a[1, 1])

    @property
    def z_g(self) -> float:
        """Height of the centre of gravity over the waterline [m].

        If it is not given, z_G = BM_T + z_B - GM with the GM that gives the roll its period, GM =
        (k_xx^2 + A44/(rho V)) omega_n^2/g with the added mass A44 about z_G.
        """
        if self.centre_of_gravity is not None:
            return self.centre_of_gravity
        hull = self.coefficients
        unit = hull.length
        volume = hull.volume / unit**3
        a44, a24, a22 = (a / volume for a in self._rolled_mass)
        c = self._roll_rate**2
        # c a22 z^2 + (1 + 2 c a24) z + c (k_xx^2 + a44) - metacentre = 0, in units of length
        middle = 1.0 + 2.0 * c * a24
        constant = c * ((self._k_xx / unit) ** 2 + a44) - self.metacentre / unit
        root = middle**2 - 4.0 * c * a22 * constant
        refuse_where(
            (
                root < 0.0 or middle <= 0.0,
                'roll_period',
                self.roll_period,
                'is too short: no centre of gravity gives this hull such a period',
                self._usual_period(),
            )
        )
        return -2.0 * constant / (middle + math.sqrt(root)) * unit

    @property
    def metacentre(self) -> float:
        """Height of the metacentre over the waterline [m], BM_T + z_B."""
        hull = self.coefficients
        return hull.second_moments[0] / hull.volume + hull.buoyancy[1]

    @property
    def gm(self) -> float:
        """Metacentric height that gives the roll its period [m]."""
        hull = self.coefficients
        return self._roll_rate**2 * self._roll_inertia() / hull.volume * hull.length**4

    def _roll_inertia(self) -> float:
        """Return I44 + A44 about the centre of gravity, in the units of the tables."""
        hull = self.coefficients
        a44, a24, a22 = self._rolled_mass
        z = self.z_g / hull.length
        own_inertia = hull.volume / hull.length**3 * (self._k_xx / hull.length) ** 2
        return own_inertia + a44 + 2.0 * z * a24 + z**2 * a22

    @property
    def _k_xx(self) -> float:
        return 0.38 * self.coefficients.beam if self.k_xx is None else self.k_xx

    @property
    def _k_zz(self) -> float:
        """In units of the length."""
        return 0.25 if self.k_zz is None else self.k_zz / self.coefficients.length

    def check_speed(self, speed: float) -> None:
        """Refuse a speed [m/s] as `check_froude` does."""
        check_froude(speed, self.coefficients.length, self.gravity)

    def check_place(self, place: ClockPlace) -> None:
        """Refuse a place outside the ship.

        Raises:
            HullError: outside length, beam or keel, or higher than the hull is long.
        """
        hull = self.coefficients
        limits = {
            'forward': (-0.5 * hull.length, 0.5 * hull.length),
            'port': (-0.5 * hull.beam, 0.5 * hull.beam),
            'up': (-hull.draught, hull.length),
        }
        refuse_where(
            *(
                (
                    not low <= getattr(place, key) <= high,
                    f'clock.{key}',
                    getattr(place, key),
                    f'must be in [{low:.3g}, {high:.3g}] m: the clock is outside the hull',
                    'Measure from amidships, the centreline and the waterline.',
                )
                for key, (low, high) in limits.items()
            )
        )

    def response(self, omega: FloatArray, heading: float, speed: float = 0.0) -> Response:
        """Return the ship's six motions in regular waves.

        [-w^2 (M + A) - i w B + C] X = F, with A and B at the encounter frequency w = omega_e and F
        at the wave's own, as for a ship at rest. Under way, A and B have the speed terms of strip
        theory (N. Salvesen, E. O. Tuck, O. Faltinsen, Ship motions and sea loads, Trans. SNAME 78,
        1970).

        If the ship runs with the waves, |omega_e| is near 0 and heave, roll and pitch are static.
        Surge, sway and yaw have no restoring force and would grow like 1/omega_e^2, but helm and
        sails hold the ship: below q = `LEAST_ENCOUNTER` omega their inertia is taken at q, and
        U/omega_e as U omega_e/q^2.

        Args:
            omega: of the waves [rad/s], > 0, (n,).
            heading: direction in which the waves run, from the bow to port [rad].
            speed: U of the ship [m/s].

        Raises:
            HullError: see `check_speed`.
        """
        self.check_speed(speed)
        hull = self.coefficients
        unit = math.sqrt(self.gravity / hull.length)
        wave = np.asarray(omega, np.float64) / unit
        froude = speed / math.sqrt(self.gravity * hull.length)
        met = wave - wave**2 * (froude * math.cos(heading))
        met_size = np.maximum(np.abs(met), LEAST_ENCOUNTER * wave)
        matrix = self._fluid(met, froude * met / met_size**2) + self._ship(met)
        mass = hull.volume / hull.length**3 * np.array([1.0, 1.0, self._k_zz**2])
        added = _added_mass(hull, np.abs(met))
        for j, own_mass in zip((0, 1, 5), mass, strict=True):
            total = own_mass + added[:, j, j]
            matrix[:, j, j] -= (met_size**2 - met**2) * total
        force = self._force(wave, heading)[:, :, None]
        motions = np.array(np.linalg.solve(matrix, force)[:, :, 0].conj(), np.complex128)
        motions[:, 3:] /= hull.length
        return Response(wave * unit, met * unit, motions, self.gravity)

    def _fluid(self, w: FloatArray, drift: FloatArray) -> ComplexArray:
        """Return -w^2 A - i w B with the speed terms for U/w, (n, 6, 6)."""
        hull = self.coefficients
        size = np.abs(w)
        matrix, rows = np.zeros((len(w), 6, 6), np.complex128), hull.frequency
        # damping falls as 1/omega^2 beyond the last row
        decay = np.maximum(size / rows[-1], 1.0) ** -2
        dampings = hermite(rows, hull.damping, hull.slopes[1], np.minimum(size, rows[-1]))
        masses, dampings = _added_mass(hull, size), dampings * decay[:, None, None]
        for j, k in zip(*np.nonzero(np.triu(_PAIRS)), strict=True):
            matrix[:, j, k] = -(w**2) * masses[:, j, k] - 1j * w * dampings[:, j, k]
            matrix[:, k, j] = matrix[:, j, k]
        matrix[:, 3, 3] -= (
            1j * w * (2.0 * self.roll_damping_ratio * self._roll_rate * self._roll_inertia())
        )
        if not np.any(drift):
            return matrix
        # Under way pitch adds the vertical velocity -U theta and yaw U psi athwart: with
        # kappa = i U/w, A35 = A35 - U/w^2 B33, B35 = B35 + U A33 and so on (the paper's table 1).
        kappa = 1j * drift[:, None]
        matrix[:, :, 4] += kappa * matrix[:, :, 2]
        matrix[:, :, 5] -= kappa * matrix[:, :, 1]
        matrix[:, 4, :] -= kappa * matrix[:, 2, :]
        matrix[:, 5, :] += kappa * matrix[:, 1, :]
        return matrix

    def _ship(self, w: FloatArray) -> ComplexArray:
        """Return -w^2 M + C of the rigid body and the hydrostatics, (n, 6, 6)."""
        hull, unit = self.coefficients, self.coefficients.length
        m = hull.volume / unit**3
        x, z = hull.buoyancy[0] / unit, self.z_g / unit
        k_yy = 0.25 if self.k_yy is None else self.k_yy / unit
        mass = np.diag(
            [
                *(1.0, 1.0, 1.0),
                (self._k_xx / unit) ** 2 + z**2,
                k_yy**2 + x**2 + z**2,
                self._k_zz**2 + x**2,
            ]
        )
        for j, k, moment in ((0, 4, z), (1, 3, -z), (1, 5, x), (2, 4, -x), (3, 5, -x * z)):
            mass[j, k] = mass[k, j] = moment
        stiffness = np.zeros((6, 6))
        area, across = hull.waterplane_area / unit**2, self.gm / unit
        along = hull.second_moments[1] / unit**4
        stiffness[2, 2] = area
        stiffness[2, 4] = stiffness[4, 2] = -area * hull.flotation / unit
        stiffness[3, 3] = m * across
        stiffness[4, 4] = along + m * (hull.buoyancy[1] / unit - z)
        return np.asarray(-(w**2)[:, None, None] * (m * mass) + stiffness, np.complex128)

    def _force(self, w: FloatArray, heading: float) -> ComplexArray:
        """Return the exciting forces at frequencies in the units of the tables, (n, 6).

        Between headings: sums of cosines (forces 1, 3, 5) or sines (2, 4, 6) through all of them.
        Between frequencies: a spline of (F - F_static)/omega^2, constant below the first row.
        Beyond the last row F falls as 1/omega^2, an upper bound for waves whose pressure reaches
        1/k down.
        """
        hull = self.coefficients
        unit = hull.length
        at_heading = np.empty((len(hull.frequency), 6), np.complex128)
        weights = _heading_weights(hull.excitation.shape[1], heading)
        at_heading[:, ::2] = np.einsum('m,nmj->nj', weights[0], hull.excitation[:, :, ::2])
        at_heading[:, 1::2] = np.einsum('m,nmj->nj', weights[1], hull.excitation[:, :, 1::2])
        static = np.zeros(6)
        static[2] = hull.waterplane_area / unit**2
        static[4] = -static[2] * hull.flotation / unit
        rows = hull.frequency[1:]
        end = rows[-1]
        clipped = np.clip(w, rows[0], end)
        tail = np.minimum(end / w, 1.0) ** 2
        force = np.empty((len(w), 6), np.complex128)
        ratio = (at_heading[1:] - static) / (rows**2)[:, None]
        parts = spline(rows, np.stack((ratio.real, ratio.imag), axis=1), clipped)
        for j in range(6):
            read = parts[:, 0, j] + 1j * parts[:, 1, j]
            force[:, j] = np.where(w > end, at_heading[-1, j] * tail, static[j] + read * w**2)
        return force


def _added_mass(hull: HullCoefficients, at: FloatArray) -> FloatArray:
    """Return the added masses, (n, 6, 6): splines that tend to their limits as 1/omega^2."""
    rows, limit = hull.frequency, hull.added_mass[-1]
    masses = hermite(rows, hull.added_mass[:-1], hull.slopes[0], np.minimum(at, rows[-1]))
    decay = np.maximum(at / rows[-1], 1.0) ** -2
    return np.asarray(limit + (masses - limit) * decay[:, None, None])


def _heading_weights(count: int, heading: float) -> tuple[FloatArray, FloatArray]:
    """Return the weights of the headings in the interpolating sums of cosines and of sines."""
    n = np.arange(count)
    at = np.pi * n / (count - 1)
    cosines = np.linalg.solve(np.cos(np.outer(at, n)).T, np.cos(n * heading))
    sines = np.zeros(count)
    inner = n[1:-1]
    sines[1:-1] = np.linalg.solve(np.sin(np.outer(at[1:-1], inner)).T, np.sin(inner * heading))
    return cosines, sines


# -----------------------------------------------------------------------------
# The rate of a weight-driven clock in a sea, by heading and place.


@dataclass(frozen=True)
class PlaceRate:
    """The effect of the accelerations at a place on the rate of a weight-driven clock [s/day].

    The mean of sqrt(|f|/g) to second order: heave loses <z''^2>/8g^2. Motion athwart gains
    <y''^2>/4g^2, and so does motion fore and aft if the thread may lean that way.

    Attributes:
        heading: of the waves [rad].
        place: of the clock.
        heave: part of the motion up and down.
        athwart: part of the motion to the sides.
        fore_and_aft: part of the motion fore and aft.
        along_the_deck: <(x'' - g theta_p)^2>/4g^2, the loss of a thread confined to a plane that
            pitches with the ship.
    """

    heading: float
    place: ClockPlace
    heave: float
    athwart: float
    fore_and_aft: float
    along_the_deck: float

    @property
    def kept_vertical(self) -> float:
        """Rate if gimbals keep the plane of the wheel vertical and the thread in it."""
        return self.heave + self.athwart

    @property
    def leaning_freely(self) -> float:
        """Rate if the thread leans fore and aft, too."""
        return self.heave + self.athwart + self.fore_and_aft

    @property
    def pitching(self) -> float:
        """Rate if the plane of the wheel pitches with the ship."""
        return self.leaning_freely - self.along_the_deck


def rate_by_place(
    hull: Hull,
    spectrum: Callable[[FloatArray], FloatArray],
    *,
    headings: Sequence[float],
    places: Iterable[ClockPlace],
    speed: float = 0.0,
    omega: FloatArray | None = None,
) -> list[PlaceRate]:
    """Return the rate of a weight-driven clock in a sea, for each heading and place.

    The static formula (hull.4), for waves slow compared with the clock's oscillation. Integrals
    run over the waves' own frequencies, with accelerations at omega_e.

    Args:
        hull: the ship.
        spectrum: S of the elevation [m2 s/rad] at frequencies [rad/s].
        headings: of the waves [rad].
        places: of the clock.
        speed: of the ship [m/s].
        omega: of the trapezoidal sums [rad/s] (`None`: 4000 values from 0.05 to 20 sqrt(g/L)).

    Raises:
        HullError: see `Hull.check_speed` and `Hull.check_place`.
    """
    if omega is None:
        omega = math.sqrt(hull.gravity / hull.coefficients.length) * np.geomspace(0.05, 20.0, 4000)
    density = spectrum(omega)
    scale = DAY_S / hull.gravity**2
    places = list(places)
    for place in places:
        hull.check_place(place)

    def mean_square(factor: ComplexArray) -> float:
        return trapezoid(density * np.abs(factor) ** 2, omega)

    rates = []
    for heading in headings:
        response = hull.response(omega, heading, speed)
        for place in places:
            x, y, z = response.accelerations(place).T
            rates.append(
                PlaceRate(
                    heading,
                    place,
                    heave=-scale / 8.0 * mean_square(z),
                    athwart=scale / 4.0 * mean_square(y),
                    fore_and_aft=scale / 4.0 * mean_square(x),
                    along_the_deck=scale / 4.0 * mean_square(response.along_the_deck(place)),
                )
            )
    return rates
