"""Packs: the same messages come out, and anything else is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from std_msgs.msg import UInt8MultiArray

from tauto_nodes.simulation.credits import MOST_BYTES, ForeignMessageError, pack, unpack

KEY = b'known to the nodes of the graph alone'


@given(st.lists(st.binary(max_size=300), max_size=50), st.integers(0, 2**63))
def test_what_is_packed_comes_out(payloads: list[bytes], sent: int) -> None:
    packs = [unpack(KEY, 'scene', octets) for octets in pack(KEY, 'scene', payloads, sent)]
    assert [one for _, messages in packs for one in messages] == payloads
    assert [before for before, _ in packs[:1]] == [sent] * bool(payloads)


def test_packs_fit_a_datagram_unless_a_message_does_not() -> None:
    sizes = [len(octets) for octets in pack(KEY, 'scene', [bytes(1000)] * 200)]
    assert len(sizes) == 4
    assert max(sizes) < 65_000
    big = bytes(2 * MOST_BYTES)
    packs = [unpack(KEY, 'scene', octets) for octets in pack(KEY, 'scene', [b'a', big, b'b'], 7)]
    assert packs == [(7, [b'a']), (8, [big]), (9, [b'b'])]


def test_a_pack_is_a_message_with_or_without_padding() -> None:
    (octets,) = pack(KEY, 'scene', [b'abc', b'de'])
    message = deserialize_message(octets, UInt8MultiArray)
    assert bytes(message.data).endswith(b'abcde')
    assert unpack(KEY, 'scene', octets + bytes(3)) == (0, [b'abc', b'de'])


@pytest.mark.parametrize('cut', [0, 4, 15, 19, 27, 35, -1])
def test_what_is_cut_short_is_refused(cut: int) -> None:
    (octets,) = pack(KEY, 'scene', [b'abc', b'de'])
    with pytest.raises(ForeignMessageError, match='no pack of this graph'):
        unpack(KEY, 'scene', octets[:cut])


def test_a_pack_of_another_key_topic_or_bit_is_refused() -> None:
    (octets,) = pack(KEY, 'scene', [b'abc', b'de'])
    changed = [
        octets[:at] + bytes([octets[at] ^ 1]) + octets[at + 1 :] for at in range(16, len(octets))
    ]
    for key, topic, each in [(b'', 'scene', octets), (KEY, 'ship/imu', octets)] + [
        (KEY, 'scene', each) for each in changed
    ]:
        with pytest.raises(ForeignMessageError):
            unpack(key, topic, each)
