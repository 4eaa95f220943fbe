"""The effect of heat on a machine: its parameters at a temperature, over the given ones.

With Δ = T − T₀ the wheel's lengths grow by λ = 1 + αΔ, the cam's by λ_c = 1 + α_cΔ, springs change
by 1 + βΔ, and oil thins. Lever arm t and lift h of the cam stay as they are, and the parameters
that multiply them take λ_c (heat.2). A machine at T has the same equations with other parameters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeAlias

import numpy as np
from pydantic import Field, Strict

from tauto_core.curves.materials import named
from tauto_core.samples import FloatArray
from tauto_core.scene.sections import Number, Section
from tauto_core.scene.times import DAY_S

MONTH_S = 365.25 / 12.0 * DAY_S
"""A month: a twelfth of a Julian year."""

COLDEST, HOTTEST = -40.0, 60.0
"""Limits of temperatures in a scene [°C]."""

# -----------------------------------------------------------------------------
# Oil: the fall of its viscosity with temperature.


class Oil(Section):
    """An oil by a number."""

    thins_per_kelvin: Annotated[float, Strict(), Field(ge=0.0, le=0.2)] = Field(
        description='k of the viscosity η ∝ exp(−kΔ), 0 to 0.2 [1/K]'
    )


class OilTable(NamedTuple):
    """Viscosity [mPa s] at three temperatures [°C], rising."""

    celsius: tuple[float, float, float]
    viscosity: tuple[float, float, float]


# Hodgman (ed.), CRC Handbook of Chemistry and Physics, viscosity of miscellaneous liquids.
OILS = {
    'castor': OilTable((10.0, 20.0, 40.0), (2420.0, 986.0, 231.0)),
    'olive': OilTable((10.0, 40.0, 70.0), (138.0, 36.3, 12.4)),
    'sperm': OilTable((15.6, 37.8, 100.0), (42.0, 18.5, 4.6)),
}


if TYPE_CHECKING:
    NamedOil: TypeAlias = str | Oil
else:
    NamedOil = named('oil', Oil, OILS, 'thins_per_kelvin')


class Thinning(NamedTuple):
    """ln η/η₀ = −kΔ/(1 + Δ/D), Δ = T − T₀: Vogel's law, or with 1/D = 0 the exponential.

    Attributes:
        rate: k [1/K].
        per_kelvin: 1/D [1/K].
    """

    rate: float = 0.0
    per_kelvin: float = 0.0

    def exponent(self, delta: FloatArray) -> FloatArray:
        """Return ln η/η₀ at Δ [K]."""
        return -self.rate * delta / (1.0 + self.per_kelvin * delta)


NOT_AT_ALL = Thinning()


def thinning(oil: str | Oil | None, at_celsius: float) -> Thinning:
    """Return the thinning of an oil from a temperature on.

    A table gives Vogel's law ln η = A + B/(T − C) through its three points, with k = B/D² and
    D = T₀ − C (H. Vogel, Phys. Z. 22 (1921) 645).
    """
    if oil is None:
        return NOT_AT_ALL
    if isinstance(oil, Oil):
        return Thinning(oil.thins_per_kelvin)
    (low, middle, high), (thick, medium, thin) = OILS[oil]
    fall, further = math.log(thick / medium), math.log(medium / thin)
    ratio = fall * (high - middle) / (further * (middle - low))
    pole = (ratio * low - high) / (ratio - 1.0)
    b = fall * (low - pole) * (middle - pole) / (middle - low)
    reach = at_celsius - pole
    return Thinning(b / (reach * reach), 1.0 / reach)


# -----------------------------------------------------------------------------
# Compensation.


class Compensation(Section):
    """A compensation as in chronometers, which removes a linear rate and leaves a quadratic one.

    It multiplies the torque of the thread by (1 + y/86400)², with the rate
    y = −takes (T − T₀) + leaves ((T − middle)² − (T₀ − middle)²) [s/day].
    """

    takes: Number = Field(
        description='change of rate with temperature that is removed [s/day/K], negative for a '
        'machine that loses in the heat'
    )
    leaves: Number = Field(
        default=0.0,
        description='middle-temperature error that is left [s/day/K2], negative if the clock '
        'loses on both sides of the middle',
    )
    middle: Number | None = Field(
        default=None,
        description='middle of that error [°C], trochlea.at_celsius when left out',
    )


# -----------------------------------------------------------------------------
# The parameters of a machine.


class HeatFactors(NamedTuple):
    """Factors of a machine's parameters: numbers or arrays.

    Attributes:
        inertia: factor of I, λ².
        carried: factor of the mass that moves with the thread, λ_c².
        weight: factor of the mass that pulls, cλ_c with c of the compensation.
        force: factor of a constant force, c(1 + βΔ)λ_c.
        stiffness: factor of a spring, c(1 + βΔ)λ_c².
        viscous: factor of c₁, by the oil.
    """

    inertia: Any
    carried: Any
    weight: Any
    force: Any
    stiffness: Any
    viscous: Any


@dataclass(frozen=True)
class Heat:
    """The change of a machine with temperature and age, by default no change.

    Attributes:
        at_celsius: T₀, the temperature for which its parameters hold [°C].
        wheel, cam: α and α_c, linear expansions [1/K].
        force: β of its spring or force [1/K].
        oil: thinning of its oil.
        thickening: growth of ln c₁ with time [1/s].
        takes, leaves, middle: as in `Compensation`.
        varies: whether the temperature changes. If not, it is always `at_celsius`.
    """

    at_celsius: float = 20.0
    wheel: float = 0.0
    cam: float = 0.0
    force: float = 0.0
    oil: Thinning = NOT_AT_ALL
    thickening: float = 0.0
    takes: float = 0.0
    leaves: float = 0.0
    middle: float = 20.0
    varies: bool = True

    @property
    def acts(self) -> bool:
        """Whether any parameter changes during the run."""
        return self.thickening > 0.0 or (self.varies and self.feels_temperature)

    @property
    def feels_temperature(self) -> bool:
        """Whether any parameter changes with temperature."""
        effects = self.wheel, self.cam, self.force, self.oil.rate, self.takes, self.leaves
        return any(effects)

    @property
    def keeps_shape(self) -> bool:
        """Whether cam and wheel grow alike, which keeps M(ϑ)/I."""
        return self.wheel == self.cam

    def factors(self, celsius: FloatArray, time_s: FloatArray) -> HeatFactors:
        """Return the factors at temperatures [°C] and times since the start [s]."""
        delta = celsius - self.at_celsius
        wheel, cam = 1.0 + self.wheel * delta, 1.0 + self.cam * delta
        offset, base = celsius - self.middle, self.at_celsius - self.middle
        rate = self.leaves * (offset * offset - base * base) - self.takes * delta
        pace = 1.0 + rate / DAY_S
        pulled = pace * pace * cam
        force = pulled * (1.0 + self.force * delta)
        exponent = np.asarray(self.oil.exponent(delta) + self.thickening * time_s)
        # NumPy's exponential depends on the place in the array
        viscous = np.reshape(
            [math.exp(power) for power in exponent.ravel().tolist()], exponent.shape
        )
        return HeatFactors(wheel * wheel, cam * cam, pulled, force, force * cam, viscous)

    def inertia_growth(self, celsius: FloatArray, per_s: FloatArray) -> FloatArray:
        """Return İ/I [1/s] at temperatures [°C] with the rates of change [K/s]."""
        return 2.0 * self.wheel * per_s / (1.0 + self.wheel * (celsius - self.at_celsius))


NO_HEAT = Heat()
"""A machine that does not change."""
