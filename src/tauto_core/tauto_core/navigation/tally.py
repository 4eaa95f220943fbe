"""The verdict on a whole voyage, from the contents of the topics alone."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from tauto_core.navigation.longitude import ERROR_NAMES, column
from tauto_core.navigation.ordering import BEFORE_ALL
from tauto_core.navigation.prize import LEAST_UNCHECKED_DAYS, prize_pounds, required_rate_s_per_day
from tauto_core.samples import (
    NS_PER_S,
    SECONDS_PER_DAY,
    FixSamples,
    FloatArray,
    IntArray,
    JointSamples,
    TimeSamples,
    count,
)
from tauto_core.ship.observations import LANDFALL, LUNAR

_JUDGED = ('raw_error_nmi', 'error_nmi')

Row: TypeAlias = tuple[int, FloatArray]


class _Moment(NamedTuple):
    distance_nmi: float
    stamp_ns: int


class _RowsBefore:
    """The last row of a topic, and the last one before each of several instants."""

    def __init__(self) -> None:
        self.last: Row | None = None
        self.before: dict[int, Row | None] = {}

    def mark(self, instant_ns: int) -> None:
        """Keep the last row before an instant; it is unknown if later rows have come already."""
        came = self.last is not None and self.last[0] >= instant_ns
        self.before[instant_ns] = None if came else self.last

    def feed(self, stamp_ns: IntArray, rows: FloatArray) -> None:
        """Take the next rows, (n, m), n > 0."""
        for instant in self.before:
            place = int(np.searchsorted(stamp_ns, instant))
            if place:
                self.before[instant] = (int(stamp_ns[place - 1]), rows[place - 1].copy())
        self.last = (int(stamp_ns[-1]), rows[-1].copy())


class LongitudeTally:
    """Error of the longitude at landfalls, at the end and at its worst, over all batches.

    A landfall is judged by the last sample before its observation, which shows what the clock said
    before it was checked. The worst error is sought after the last observation in port, since
    before that the clock was being rated. Lunar distances are not checks: a voyage is unchecked
    between places whose longitude is known. Feed observations no later than the errors that
    include them.
    """

    def __init__(self) -> None:
        self._errors, self._latitudes = _RowsBefore(), _RowsBefore()
        self._first_ns = 0
        self._worst: dict[str, _Moment] = {}
        self._in_port_ns = BEFORE_ALL
        self._checked_before: dict[int, int | None] = {}
        self._last_checked: int | None = None

    def observe(self, observations: TimeSamples) -> None:
        """Take the next batch of `clock/observation`."""
        marks = zip(observations.stamp_ns.tolist(), observations.source.tolist(), strict=True)
        for stamp, source in marks:
            if source == LANDFALL:
                self._checked_before[stamp] = self._last_checked
                self._errors.mark(stamp)
                self._latitudes.mark(stamp)
            elif source == LUNAR:
                continue  # the longitude is not known there
            else:
                self._in_port_ns = stamp
                self._worst = {}
            self._last_checked = stamp

    def place(self, fixes: FixSamples) -> None:
        """Take the next batch of `longitude/fix`, which has the latitude."""
        if count(fixes):
            self._latitudes.feed(fixes.stamp_ns, fixes.latitude[:, None])

    def feed(self, errors: JointSamples) -> None:
        """Take the next batch of `longitude/error`.

        Raises:
            EstimationError: one of `ERROR_NAMES` is missing.
        """
        columns = {name: column(errors, name) for name in ERROR_NAMES}
        if not count(errors):
            return
        if self._errors.last is None:
            self._first_ns = int(errors.stamp_ns[0])
        self._errors.feed(errors.stamp_ns, np.column_stack(list(columns.values())))
        left_port = int(np.searchsorted(errors.stamp_ns, self._in_port_ns))
        if left_port < count(errors):
            for name in _JUDGED:
                self._seek_worst(name, columns[name][left_port:], errors.stamp_ns[left_port:])

    def _seek_worst(self, name: str, errors_nmi: FloatArray, stamp_ns: IntArray) -> None:
        sizes = np.abs(errors_nmi)
        place = int(sizes.argmax())
        known = self._worst.get(name)
        if known is None or sizes[place] > known.distance_nmi:
            self._worst[name] = _Moment(float(sizes[place]), int(stamp_ns[place]))

    def result(self) -> dict[str, Any] | None:
        """Return the verdict, None if no error came. Times are from the first error [s].

        Keys: those of each of the `landfalls`, at the last of them, or at the last sample where
        there is none; `landfalls`, a list; `worst_error_nmi` (magnitude), `worst_at_s`,
        `worst_prize_pounds` of the corrected clock, and `worst_raw_…` of the dial, since
        `worst_since_s`, the last observation in port; 0 where there is none.

        A landfall has `at_s`; `latitude_deg`, None where unknown; `ERROR_NAMES`; `unchecked_days`
        since the observation before it, or since the dial was set at the first reading;
        `prize_pounds` for the corrected distance, as the Act judges it, `raw_prize_pounds`, and
        `required_rate_s_per_day` for £20,000 after so long. These three, and the prizes for the
        worst errors, are None where less than `LEAST_UNCHECKED_DAYS` were unchecked, since no such
        voyage qualifies.
        """
        if self._errors.last is None:
            return None
        landfalls = [
            self._verdict(row, self._latitudes.before[mark], self._checked_before[mark])
            for mark, row in self._errors.before.items()
            if row is not None
        ]
        at_end = self._verdict(self._errors.last, self._latitudes.last, self._last_checked)
        stamp, values = self._errors.last
        last = dict(zip(ERROR_NAMES, values.tolist(), strict=True))
        raw, corrected = (
            self._worst.get(name, _Moment(abs(last[name]), stamp)) for name in _JUDGED
        )
        judged = landfalls[-1] if landfalls else at_end
        tried = judged['prize_pounds'] is not None
        return {
            **judged,
            'landfalls': landfalls,
            'worst_since_s': self._time_s(min(max(self._in_port_ns, self._first_ns), stamp)),
            'worst_error_nmi': corrected.distance_nmi,
            'worst_at_s': self._time_s(corrected.stamp_ns),
            'worst_prize_pounds': prize_pounds(corrected.distance_nmi) if tried else None,
            'worst_raw_error_nmi': raw.distance_nmi,
            'worst_raw_at_s': self._time_s(raw.stamp_ns),
            'worst_raw_prize_pounds': prize_pounds(raw.distance_nmi) if tried else None,
        }

    def _verdict(self, row: Row, latitude: Row | None, checked_ns: int | None) -> dict[str, Any]:
        stamp, values = row
        errors = dict(zip(ERROR_NAMES, values.tolist(), strict=True))
        since = self._first_ns if checked_ns is None else checked_ns
        days = max(stamp - since, 0) / NS_PER_S / SECONDS_PER_DAY
        tried = days >= LEAST_UNCHECKED_DAYS
        degrees = None if latitude is None else float(latitude[1][0])
        required = None
        if tried and degrees is not None:
            required = required_rate_s_per_day(days, degrees)
        return {
            'at_s': self._time_s(stamp),
            'latitude_deg': degrees,
            **errors,
            'unchecked_days': days,
            'prize_pounds': prize_pounds(abs(errors['error_nmi'])) if tried else None,
            'raw_prize_pounds': prize_pounds(abs(errors['raw_error_nmi'])) if tried else None,
            'required_rate_s_per_day': required,
        }

    def _time_s(self, stamp: int) -> float:
        return (stamp - self._first_ns) / NS_PER_S
