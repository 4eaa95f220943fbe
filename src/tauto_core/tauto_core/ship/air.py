"""The air on the voyage, and the temperature in the box of the clock (theory/air.md).

The temperature of the air is a mean that is linear in time between knots, and a daily swing about
it. The box follows the air as a body of one time constant, in closed form between the knots.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Annotated, Protocol

import numpy as np
from pydantic import Field, Strict

from tauto_core.samples import FloatArray, IntArray
from tauto_core.scene.errors import Problem
from tauto_core.scene.sections import Kind
from tauto_core.scene.times import DAY_S, NS_PER_S, nanoseconds
from tauto_core.ship.motion_kind import Surroundings
from tauto_core.ship.passage import Passage

FOLDER = 'tauto_core.ship.airs'

COLDEST, WARMEST = -60.0, 60.0
"""Temperatures of air at sea level, with room to spare [°C]."""

KELVIN_FROM = 200.0
"""A number from here on is not a temperature in °C, but may be one in kelvin."""

AIR_KNOT_S = 600
"""Time between the knots under way where longitude or latitude matter [s]; between them the mean
and the local time are linear.
"""

_Hour = Annotated[float, Strict(), Field(ge=0.0, le=24.0)]
_BoxHours = Annotated[float, Strict(), Field(gt=0.0, le=1000.0)]
_Diurnal = Annotated[float, Strict(), Field(ge=0.0, le=30.0)]


class AirKind(Kind):
    """The air: its daily swing, and the box in which the clock stands.

    Each kind has a mean temperature that is linear in time between knots.
    """

    diurnal: _Diurnal = Field(
        default=0.0,
        description='half of the difference between the warmest and the coldest hour of a day, '
        '0 to 30 [K]',
    )
    warmest_hour: _Hour = Field(
        default=12.0,
        description="hour of the day that is warmest, 0 to 24, by the Sun at the ship's "
        'longitude: 12 is noon',
    )
    box_hours: _BoxHours = Field(
        default=6.0,
        description="time constant with which the clock's box follows the air, more than 0, at "
        'most 1000 [h]',
    )

    def knots(self, scene: AirySurroundings) -> tuple[IntArray, FloatArray]:
        """Return times from the start of the scene [ns], and the mean of the air then [°C].

        The mean is linear between the times, and constant before the first and after the last.
        """
        raise NotImplementedError

    def problems(self, scene: AirySurroundings) -> Iterator[Problem]:
        """Yield its problems in a scene."""
        raise NotImplementedError


class AirySurroundings(Surroundings, Protocol):
    """The parts of a scene on which the temperature of the box depends."""

    @property
    def air(self) -> AirKind | None:
        """The air; None: no temperature is simulated."""
        ...

    @property
    def starts_at(self) -> float:
        """Stamp of the first sample [s]; stamp 0 is midnight at Greenwich."""
        ...


def knots_between(first_ns: int, last_ns: int, scene: AirySurroundings) -> IntArray:
    """Return times every `AIR_KNOT_S`, some beyond the end of the scene but none after `last_ns`.

    So the temperature of an instant does not depend on the duration.
    """
    step = AIR_KNOT_S * NS_PER_S
    needed = scene.duration_ns + 2 * scene.log_interval_ns + 2 * step
    return np.arange(first_ns, min(last_ns, needed), step, dtype=np.int64)


def implausible_celsius(key: str, celsius: float) -> Iterator[Problem]:
    """Yield a problem for a temperature [°C] that air cannot have."""
    if not COLDEST <= celsius <= WARMEST:
        said = f'must lie between {COLDEST:g} and {WARMEST:g} °C'
        yield Problem(key, celsius, said, in_celsius(celsius))


def in_celsius(value: float) -> str:
    """Return the advice for a number that is not a temperature of air in °C."""
    if value < KELVIN_FROM:
        return 'Give it in degrees Celsius.'
    return f'Write {value - 273.15:.4g} if {value:g} is in kelvin.'


# -----------------------------------------------------------------------------
# The box: τ dB/dt = A − B, for A = a + b s + D cos(φ + ω s) between two knots.


class BoxTemperature:
    """Temperature in the box of the clock, at the logged instants of a scene with `air`.

    Between two knots the air is a + b s + D cos(φ + ω s), s after the first of them; then the box
    has the temperature (G2.3 in air.md)

        a + b (s − τ) + D (cos x + ω τ sin x)/(1 + ω² τ²) + c exp(−s/τ), x = φ + ω s.

    c makes it continuous. Before the first knot the mean is constant, and the box has settled.

    Raises:
        SceneError: a route that cannot be sailed, as `Passage` says.
    """

    def __init__(self, scene: AirySurroundings) -> None:
        air = scene.air
        assert air is not None
        self._interval_ns = scene.log_interval_ns
        at_ns, means = air.knots(scene)
        passage = None if scene.voyage is None else Passage(scene, scene.voyage)
        knots = [np.zeros(1, np.int64), at_ns]
        if air.diurnal and passage is not None:
            # the longitude sets the hour of noon
            knots.append(knots_between(passage.sails_ns, passage.arrives_ns, scene))
            knots.append(np.array(passage.places_ns, np.int64))
        knots_ns = np.unique(np.concatenate(knots))
        self._knots_ns = knots_ns

        self._lag_s = air.box_hours * 3600.0
        self._mean = np.interp(knots_ns / NS_PER_S, at_ns / NS_PER_S, means)
        steps = np.append(np.diff(knots_ns) / NS_PER_S, math.inf)
        self._slope = np.append(np.diff(self._mean), 0.0) / steps
        east = np.zeros(len(knots_ns))
        if passage is not None:
            east = np.radians(passage.places(knots_ns)[1])
        turned = np.append(np.diff(east), 0.0)
        turned -= math.tau * np.round(turned / math.tau)
        self._pace = math.tau / DAY_S + turned / steps
        since_midnight = (
            (nanoseconds(scene.starts_at) + knots_ns) % round(DAY_S * NS_PER_S) / NS_PER_S
        )
        self._phase = math.tau * (since_midnight / DAY_S - air.warmest_hour / 24.0) + east
        self._swing = air.diurnal / (1.0 + np.square(self._pace * self._lag_s))

        # settled before the first knot, then continuous at each
        self._rest = np.zeros(len(knots_ns))
        which = np.arange(len(knots_ns))
        forced = self._forced(which, np.zeros(len(knots_ns))).tolist()
        reached = self._forced(which[:-1], steps[:-1]).tolist()
        kept = _each(math.exp, -steps[:-1] / self._lag_s).tolist()
        rest = self._slope[0] * self._lag_s
        for index in which.tolist():
            self._rest[index] = rest
            if index < len(reached):
                rest = reached[index] + rest * kept[index] - forced[index + 1]

    def at(self, k: IntArray) -> FloatArray:
        """Return the temperature [°C] at `starts_at` + k log intervals, k ≥ 0, (n,).

        Each value depends on the scene and its own k alone.
        """
        time_ns = k * self._interval_ns
        which = np.searchsorted(self._knots_ns, time_ns, 'right') - 1
        since = (time_ns - self._knots_ns[which]) / NS_PER_S
        fading = _each(math.exp, -since / self._lag_s)
        found = self._forced(which, since) + self._rest[which] * fading
        return np.asarray(found)

    def _forced(self, which: IntArray, since: FloatArray) -> FloatArray:
        """Return the part without c at times after some knots [s]."""
        steady = self._mean[which] + self._slope[which] * (since - self._lag_s)
        if not self._swing.any():
            return np.asarray(steady)
        pace = self._pace[which]
        angle = self._phase[which] + pace * since
        lagging = _each(math.cos, angle) + pace * self._lag_s * _each(math.sin, angle)
        return np.asarray(steady + self._swing[which] * lagging)


def _each(function: Callable[[float], float], values: FloatArray) -> FloatArray:
    """Return a function of each number: those of NumPy depend on the place in the array."""
    return np.fromiter(map(function, values.tolist()), np.float64, len(values))
