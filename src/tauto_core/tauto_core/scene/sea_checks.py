"""Rules that tie the keys of a ship in a sea together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from tauto_core.scene.errors import ABSENT, Problem

if TYPE_CHECKING:
    from tauto_core.scene.ships import Rao, Sea, SeaShip, SpectrumTable


def sea_problems(ship: SeaShip) -> Iterator[Problem]:
    """Yield everything that is wrong between the keys of a ship in a sea."""
    if ship.sea.spectrum == 'table':
        yield from _table(ship.sea)
    else:
        yield from _parametric(ship.sea, ship.rate)
    yield from _response(ship)
    if ship.rao is not None:
        yield from _operator(ship.rao, heave=ship.heave)


def sampled(key: str, period: float, rate_hz: float) -> Iterator[Problem]:
    """Yield a problem where a wave is too short to be sampled."""
    if period * rate_hz <= 2.0:
        yield Problem(
            key,
            period,
            f'is not longer than two steps ({2.0 / rate_hz:.6g} s): ship.rate {rate_hz!r} Hz '
            'cannot sample it',
            'Give a longer period or a higher ship.rate.',
        )


def _parametric(sea: Sea, rate_hz: float) -> Iterator[Problem]:
    yield from sampled('ship.sea.peak_period', sea.peak_period, rate_hz)
    if sea.spectrum == 'bretschneider' and 'gamma' in sea.model_fields_set:
        yield Problem(
            'ship.sea.gamma',
            sea.gamma,
            'does not go with spectrum bretschneider, which has no peak enhancement',
            'Leave it out, or use spectrum jonswap.',
        )


def _table(sea: SpectrumTable) -> Iterator[Problem]:
    yield from _rising('ship.sea.frequency', sea.frequency, 'Hz')
    yield from _as_many('ship.sea.energy_density', sea.energy_density, len(sea.frequency))
    if not any(sea.energy_density):
        yield Problem(
            'ship.sea.energy_density',
            ABSENT,
            'is 0 m2/Hz at all frequencies: the spectrum is empty',
            'Choose another spectrum, or ship kind still for a calm.',
        )


def _response(ship: SeaShip) -> Iterator[Problem]:
    if ship.roll is None and ship.rao is None:
        yield Problem(
            'ship.roll',
            ABSENT,
            'is missing, and there is no rao in its place',
            'Write `roll: …`, mapping: natural_period, damping_ratio, slope_coefficient; or '
            '`rao: …`, mapping: path, heading.',
        )
    if ship.roll is not None and ship.rao is not None:
        yield Problem(
            'ship.rao',
            ABSENT,
            'does not go with ship.roll: the roll follows from one of them',
            'Leave one of them out.',
        )
    if ship.heading is not None and ship.rao is not None:
        yield Problem(
            'ship.heading',
            ship.heading,
            'does not go with ship.rao, which has its own heading',
            'Give it as ship.rao.heading.',
        )


def _operator(rao: Rao, *, heave: bool) -> Iterator[Problem]:
    yield from _rising('ship.rao.angular_frequency', rao.angular_frequency, 'rad/s')
    parts = {
        'roll_real': rao.roll_real,
        'roll_imaginary': rao.roll_imaginary,
        'heave_real': rao.heave_real,
        'heave_imaginary': rao.heave_imaginary,
    }
    for name, values in parts.items():
        if values is not None:
            yield from _as_many(f'ship.rao.{name}', values, len(rao.angular_frequency))
    if heave and (rao.heave_real is None or rao.heave_imaginary is None):
        yield Problem(
            'ship.heave',
            True,
            'asks for heave, which the operator does not have',
            'Give an operator with the columns heave_re and heave_im, or leave heave out.',
        )


def _rising(key: str, values: Sequence[float], unit: str) -> Iterator[Problem]:
    if len(values) < 2:
        yield Problem(key, list(values), 'has less than 2 values', 'Give more frequencies.')
    for index, (before, after) in enumerate(pairwise(values), start=1):
        if not after > before:
            yield Problem(
                f'{key}[{index}]',
                after,
                f'must be greater than the one before, {before!r} {unit}',
                'Sort them, and drop what is double.',
            )
            return


def _as_many(key: str, values: Sequence[float], wanted: int) -> Iterator[Problem]:
    if len(values) != wanted:
        yield Problem(
            key,
            ABSENT,
            f'has {len(values)} values for {wanted} frequencies',
            'Give one for each frequency.',
        )
