"""The clock: phase of the regulator, beats, reading of the dial.

The regulator of a live graph, which no voyage here needs, is loaded at its first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tauto_core.clockwork.trochlea import DialSetting, SwingTally, TrochleaStage, dial_ns
from tauto_core.first_use import loaded_from

if TYPE_CHECKING:
    from tauto_core.clockwork.live import LiveTrochlea

__all__ = ['DialSetting', 'LiveTrochlea', 'SwingTally', 'TrochleaStage', 'dial_ns']

__getattr__ = loaded_from(__name__, {'LiveTrochlea': 'live'})
