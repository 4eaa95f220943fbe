"""Packs: the same messages come out, and anything else is refused."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from std_msgs.msg import UInt8MultiArray

from tauto_nodes import NodesError
from tauto_nodes.simulation.credits import MOST_BYTES, pack, unpack


@given(st.lists(st.binary(max_size=300), max_size=50))
def test_what_is_packed_comes_out(payloads: list[bytes]) -> None:
    assert [one for octets in pack(payloads) for one in unpack('scene', octets)] == payloads


def test_packs_fit_a_datagram_unless_a_message_does_not() -> None:
    sizes = [len(octets) for octets in pack([bytes(1000)] * 200)]
    assert len(sizes) == 4
    assert max(sizes) < 65_000
    big = bytes(2 * MOST_BYTES)
    assert [unpack('scene', octets) for octets in pack([b'a', big, b'b'])] == [
        [b'a'],
        [big],
        [b'b'],
    ]


def test_a_pack_is_a_message_of_its_type_and_padding_does_no_harm() -> None:
    (octets,) = pack([b'abc', b'de'])
    message = deserialize_message(octets, UInt8MultiArray)
    assert bytes(message.data).endswith(b'abcde')
    assert unpack('scene', octets + bytes(3)) == [b'abc', b'de']


@pytest.mark.parametrize('cut', [0, 4, 15, 19, 27, 35, -1])
def test_what_is_cut_short_is_refused(cut: int) -> None:
    (octets,) = pack([b'abc', b'de'])
    with pytest.raises(NodesError, match='_tauto/pack/scene: '):
        unpack('scene', octets[:cut])


def test_packs_of_another_run_hold_nothing_for_us() -> None:
    (octets,) = pack([b'abc', b'de'], run=1_700_000_000_000_000_000)
    assert unpack('scene', octets) == []
    assert unpack('scene', octets, 1_700_000_000_000_000_000) == [b'abc', b'de']


def test_random_octets_are_refused_or_hold_no_more_than_they_are() -> None:
    with pytest.raises(NodesError):
        unpack('scene', b'\xff' * 64, 2**64 - 1)
