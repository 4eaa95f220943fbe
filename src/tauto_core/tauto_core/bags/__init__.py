"""Bags: the topic table, CDR payloads, reading and writing MCAP.

The check of bags is loaded at its first use.
"""

from typing import TYPE_CHECKING

from tauto_core.bags.codec import decode, decode_as, encode, header_stamp_ns
from tauto_core.bags.read import Bag, Message, read_bag
from tauto_core.bags.table import TOPICS, Topic, offered_qos
from tauto_core.bags.write import BagWriter, check_folder
from tauto_core.first_use import loaded_from

if TYPE_CHECKING:
    from tauto_core.bags.check import BagReport, Recovered, check_bag, recover_bag

__all__ = [
    'TOPICS',
    'Bag',
    'BagReport',
    'BagWriter',
    'Message',
    'Recovered',
    'Topic',
    'check_bag',
    'check_folder',
    'decode',
    'decode_as',
    'encode',
    'header_stamp_ns',
    'offered_qos',
    'read_bag',
    'recover_bag',
]

_OF_THE_CHECK = ('Recovered', 'BagReport', 'check_bag', 'recover_bag')

__getattr__ = loaded_from(__name__, dict.fromkeys(_OF_THE_CHECK, 'check'))
