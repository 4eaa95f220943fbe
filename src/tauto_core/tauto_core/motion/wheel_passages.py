"""Passages of the trochlea through zero: which steps need a closer look, and that look.

`well`, `mode`, `place`, `floats` and `ints` are those of events.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from tauto_core.kernels import compiled, overload
from tauto_core.motion.events import BEATS, HELD_ANGLE, STATE, TURNS, mode_of
from tauto_core.motion.lanes import least, load
from tauto_core.motion.outside import X_ROW, Y_ROW, forcing_at, outside_at, set_piece
from tauto_core.motion.passages import angles_at, passages, settle, signs_at_nodes
from tauto_core.motion.turning import between, expand
from tauto_core.motion.wells import acceleration, lever_arm, mass_of

CLEAR = 2.0
"""Factor by which the square of the swing exceeds what would just keep it clear of the tilt."""


class Step(NamedTuple):
    """What tells the angles within a step of the swinging wheel."""

    well: Any
    mode: Any
    omega: Any
    place: Any
    floats: Any
    work: Any


class Ride(NamedTuple):
    """What tells the angles while friction holds the wheel."""

    angle: float
    place: Any
    work: Any


@overload(angles_at)
def _angles_at(watch: Any, xi: Any) -> Any:
    if getattr(watch, 'instance_class', None) is Step:

        def swinging(watch: Any, xi: Any) -> Any:
            well, mode, omega, place, floats, work = watch
            length, terms, x0, hx = place
            x, y = between(omega, 0, hx * length, xi, floats, work)
            at = forcing_at(terms, x0 + xi * hx, work)
            angle, v, rate, _, _, _ = acceleration(well, mode, x, omega[0] * y, at)
            return x, rate, angle, v

        return swinging
    if getattr(watch, 'instance_class', None) is Ride:

        def held(watch: Any, xi: Any) -> Any:
            tilt = outside_at(watch.place[1], watch.place[2] + xi * watch.place[3], watch.work)[1]
            return watch.angle - tilt[0], -tilt[1], watch.angle, 0.0

        return held
    return None


@compiled
def _bounds(channel: Any, k: int, per: float) -> tuple[float, float]:
    """Return bounds of a polynomial and of its slope, times `per`, over its piece; 0: absent."""
    if channel is None:
        return 0.0, 0.0
    value = slope = 0.0
    for j in range(channel.shape[1]):
        size = abs(channel[k, j])
        value += size
        slope += j * size
    return value, per * slope


@compiled
def clear_square(well: Any, omega: Any, forcing: Any, k: int) -> float:
    """Return what x² + y² exceeds where the swing is surely clear of the tilt, over piece k.

    While |ϑ| is less than the tilt's bound τ, and so θ may pass zero, the momentum must be more
    than what the line's motion makes of it: then ϑ and θ pass zero once each, the same way.
    With M the moment of inertia at ϑ = τ: x² ≤ M τ² there, and |y| > (M |τ̇| + |γ̇|)/ω is asked.
    """
    length, neutral, tilt, _ = forcing
    per = 1.0 / (length[k] * omega[0])
    reach, reach_rate = _bounds(tilt, k, per)
    _, line_rate = _bounds(neutral, k, per)
    mass = mass_of(well[0][0], lever_arm(well[1], 1.0, reach)[0])
    pushed = mass * reach_rate + line_rate
    return CLEAR * (mass * reach * reach + pushed * pushed)


@compiled
def swings_clear(clear: float, work: Any) -> bool:
    """Return whether the swing is clear of the tilt at all nodes of the step last collocated."""
    x, y = load(work, X_ROW), load(work, Y_ROW)
    return least(x * x + y * y) > clear


@compiled
def in_step(
    large: bool,
    before: float,
    stop: float,
    well: Any,
    mode: Any,
    omega: Any,
    piece: Any,
    place: Any,
    floats: Any,
    work: Any,
) -> tuple[int, int, bool, bool]:
    """Return what passes zero within the step last collocated, for `count`.

    Args:
        large: as `swings_clear` returns.
        before, stop: as in passages.
        piece: forcing, and which of its pieces the step lies in.
    """
    if large:
        return signs_at_nodes(X_ROW, floats[STATE] < 0.0, before, work)
    set_piece(piece[0], piece[1], True, work)
    expand(1, work)
    watch = Step(well, mode, omega, place, floats, work)
    return passages(watch, place[3] * place[0], before, stop, work)


@compiled
def in_ride(loose: float, place: Any, floats: Any, work: Any) -> tuple[int, int, bool, bool]:
    """Return what passes zero while friction holds the wheel, up to a fraction of the step."""
    watch = Ride(floats[HELD_ANGLE], place, work)
    return passages(watch, place[3] * place[0], loose, loose, work)


@compiled
def count(
    large: bool,
    found: Any,
    well: Any,
    omega: Any,
    terms: int,
    x: float,
    floats: Any,
    ints: Any,
    work: Any,
) -> None:
    """Count a step at whose end the state is, after what happens there, at x in its piece."""
    if large:
        turns, beats = settle(True, found, floats[STATE], 0.0, 0.0)
    else:
        at = forcing_at(terms, x, work)
        y = omega[0] * floats[STATE + 2]
        angle, _, rate, _, _, _ = acceleration(well, mode_of(ints), floats[STATE], y, at)
        turns, beats = settle(False, found, floats[STATE], rate, angle)
    ints[TURNS] += turns
    ints[BEATS] += beats
