"""From serialised messages to samples; invalid messages are counted and ignored.

Anybody may publish anything on a topic. A message that cannot be decoded, belongs to another
frame, or has wrong names or NaN neither ends a node nor hides its neighbours. The fate of a
message does not depend on the others that came with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import cast

import numpy as np

from tauto_core import samples as s
from tauto_core.bags import decode
from tauto_core.navigation import ESTIMATE_NAMES
from tauto_core.samples import (
    FixSamples,
    ImuSamples,
    JointSamples,
    Samples,
    TextSamples,
    TimeSamples,
)
from tauto_core.scene.errors import BagError

NAMES = {s.ESTIMATE: ESTIMATE_NAMES}
"""Names with which a topic's scalars must begin; for other topics the first message decides."""


class Intake:
    """Decodes the messages of one topic.

    Args:
        topic: of the table.
        note: called with a reason and its description, once for each message that is ignored.
    """

    def __init__(self, topic: str, note: Callable[[str, str], None]) -> None:
        self._topic, self._note = topic, note
        self._kind: tuple[str, tuple[str, ...], tuple[int, ...]] | None = None
        self._required = NAMES.get(topic)

    def samples(self, payloads: Sequence[bytes]) -> tuple[Samples | None, list[bytes]]:
        """Return the samples of the usable messages, None if there are none, and these messages.

        Messages without a header are stamped 0.
        """
        try:
            whole = self._decoded(payloads)
            if self._is_good(whole):
                return whole, list(payloads)
        except BagError:
            pass
        good = [(one, payload) for payload in payloads if (one := self._one(payload)) is not None]
        if not good:
            return None, []
        return s.join([cast(TimeSamples, one) for one, _ in good]), [raw for _, raw in good]

    def _decoded(self, payloads: Sequence[bytes]) -> Samples:
        samples = decode(self._topic, payloads, np.zeros(len(payloads), np.int64))
        if s.count(samples) != len(payloads):
            raise BagError(f'{self._topic}: {len(payloads)} messages, other samples')
        return samples

    def _one(self, payload: bytes) -> Samples | None:
        try:
            sample = self._decoded([payload])
        except BagError as error:
            self._note('undecodable', f'a message is left aside: {error}')
            return None
        if self._is_good(sample):
            return sample
        reason, words = self._fault(sample)
        self._note(reason, f'a message is left aside: {words}')
        return None

    def _is_good(self, samples: Samples) -> bool:
        return not any(self._fault(samples))

    def _fault(self, samples: Samples) -> tuple[str, str]:
        """Return what is wrong with samples, in a word and in full; empty where nothing is."""
        if isinstance(samples, TextSamples | s.PlanarImu):
            return '', ''
        return next(self._faults(samples), ('', ''))

    def _faults(
        self, samples: ImuSamples | JointSamples | TimeSamples | FixSamples
    ) -> Iterator[tuple[str, str]]:
        if samples.stamp_ns.min() < 0:
            yield 'out_of_range', f'stamped {samples.stamp_ns.min() * 1e-9:.6g} s, before 0'
        names: tuple[str, ...] = ()
        widths: tuple[int, ...] = ()
        if isinstance(samples, JointSamples):
            names = samples.name
            numbers = (samples.position, samples.velocity, samples.effort)
            widths = tuple(number.shape[1] for number in numbers)
            if not all(np.isfinite(number).all() for number in numbers):
                yield 'not_finite', 'one of its numbers is none'
        if self._required is not None and names[: len(self._required)] != self._required:
            yield 'other_names', f'names {names}, which do not begin with {self._required}'
        if self._kind is None:
            self._kind = samples.frame_id, names, widths
        frame, first_names, first_widths = self._kind
        if frame != samples.frame_id:
            yield 'other_frame', f'frame {samples.frame_id!r}, not {frame!r} as before'
        if first_names != names:
            yield 'other_names', f'names {names}, not {first_names} as before'
        if first_widths != widths:
            yield 'other_widths', f'arrays of {widths} numbers, not {first_widths} as before'
