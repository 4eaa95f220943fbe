"""A body that swings to and fro on a curve in a fluid, paper B's body, as a regulator.

Euler, *Curva tautochrona in fluido* (1729). On his curve every half swing down the branch of
descent takes π√(f/g), and one in the other direction takes longer. On a symmetric curve both take
the same time.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tauto_core.curves.descent_curve import Cycloid, DescentCurve, Mirrored, SymmetricCurve
from tauto_core.curves.fluid_tautochrone import FluidTautochrone
from tauto_core.machines.descent import arc_of_harmonic, harmonic_of_arc
from tauto_core.machines.half_swing import descent_time, half_swing
from tauto_core.machines.isochronism import SwingTable, rate_s_per_day
from tauto_core.machines.reverse_swing import duration_excess, end_arc
from tauto_core.samples import FloatArray
from tauto_core.scene.errors import UsageError

Curve: TypeAlias = FluidTautochrone | Cycloid | SymmetricCurve

CURVES: dict[str, type[FluidTautochrone] | type[Cycloid] | type[SymmetricCurve]] = {
    'euler': FluidTautochrone,
    'cycloid': Cycloid,
    'symmetric': SymmetricCurve,
}


@dataclass(frozen=True, eq=False)
class DescentIsochronism(SwingTable):
    """Descent, period and rate of a body in a fluid at several amplitudes; `str` gives a table.

    Attributes:
        nominal_period_s: time by which the dial advances in a full swing [s].
        amplitude_m: arc of the release on the branch of descent, (n,) [m].
        descent_s: time from there to the lowest point, (n,) [s].
        period_s: time to the other side and back, (n,) [s].
        rate_s_per_day: what the clock gains a day, (n,) [s/day]; fast is positive.
    """

    amplitude_m: FloatArray
    descent_s: FloatArray
    period_s: FloatArray
    rate_s_per_day: FloatArray


@dataclass(frozen=True)
class FluidPendulum:
    """A body on a curve in a fluid, as numbers.

    Attributes:
        curve: the curve, with κ and γ of the body in the fluid, and the pendulum length f.
        weight: weight of the body less that of the fluid displaced, in vacuum's gravity [N].
        gravity: g [m/s2].
        release_arc: arc of the release at rest [m], < 0 on the branch of ascent.
    """

    curve: Curve
    weight: float
    gravity: float
    release_arc: float

    # attributes that the clockwork asks of every machine; the fluid does not move
    follows_apparent_vertical = False
    feels_gravity = False
    drag = None
    escapement = None

    @property
    def frequency(self) -> float:
        """Angular frequency of small swings, ω = √(g/f) [rad/s]."""
        return math.sqrt(self.gravity / self.curve.pendulum_length)

    @property
    def small_period(self) -> float:
        """Period of small swings, 2π/ω [s]."""
        return math.tau / self.frequency

    @property
    def is_euler(self) -> bool:
        """Whether the curve is Euler's, on which half swings have closed forms."""
        return isinstance(self.curve, FluidTautochrone)

    def branch(self, start: float) -> DescentCurve:
        """Return the curve as seen by a half swing that starts at an arc of this sign."""
        return self.curve if start > 0.0 else Mirrored(self.curve)

    def swing(self, start: float) -> tuple[float, float]:
        """Return duration over π/ω, less 1, and end [m] of the half swing from rest at an arc [m].

        Raises:
            DescentError: a start beyond the cusp.
            QuadratureError: resistance too strong for the series.
        """
        kappa = self.curve.kappa
        if not self.is_euler:
            found = half_swing(self.branch(start), self.gravity, abs(start))
            return found.duration * self.frequency / math.pi - 1.0, -math.copysign(
                found.arc, start
            )
        if start > 0.0:
            return 0.0, float(arc_of_harmonic(kappa, -harmonic_of_arc(kappa, start)))
        return float(duration_excess(kappa, -start)), float(end_arc(kappa, -start))

    def period(self, amplitude: float) -> float:
        """Return the duration of a swing from rest to the other side and back [s].

        Args:
            amplitude: arc of the release [m], its sign the branch; 0 gives the limit 2π/ω.

        Raises:
            DescentError: an amplitude beyond the cusp.
        """
        if amplitude == 0.0:
            return self.small_period
        there, end = self.swing(amplitude)
        back, _ = self.swing(end)
        return self.small_period * (1.0 + 0.5 * (there + back))


def descent_isochronism(
    machine: FluidPendulum, amplitudes: Iterable[float], nominal_period_s: float | None = None
) -> DescentIsochronism:
    """Return descent time, period and rate at several amplitudes.

    The descent is integrated, even where it is constant on Euler's curve.

    Args:
        machine: the body on its curve.
        amplitudes: arcs on the branch of descent [m], each > 0 and within the cusp.
        nominal_period_s: time by which the dial advances in a full swing; the small-amplitude
            period when left out.

    Raises:
        UsageError: no amplitude, or one out of range, before anything is computed.
    """
    asked = [float(amplitude) for amplitude in amplitudes]
    edge = machine.curve.descent_cusp
    if not asked:
        raise UsageError('amplitudes: none given; give at least one, in metres of arc')
    for amplitude in asked:
        if not 0.0 < amplitude <= edge:
            raise UsageError(
                f'amplitude {amplitude!r} m: must be > 0 and at most the arc of the cusp, '
                f'{edge!r} m; give another'
            )
    nominal = machine.small_period if nominal_period_s is None else nominal_period_s
    descent = [descent_time(machine.curve, machine.gravity, amplitude) for amplitude in asked]
    period = [machine.period(amplitude) for amplitude in asked]
    rate = [rate_s_per_day(each, nominal) for each in period]
    return DescentIsochronism(nominal, *map(np.array, (asked, descent, period, rate)))
