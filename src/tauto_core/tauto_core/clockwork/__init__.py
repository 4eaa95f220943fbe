"""The clock: phase of the regulator, beats, reading of the dial."""

from __future__ import annotations

from tauto_core.clockwork.dial import DialSetting, dial_ns
from tauto_core.clockwork.live import LiveTrochlea
from tauto_core.clockwork.trochlea import SwingTally, TrochleaStage

__all__ = ['DialSetting', 'LiveTrochlea', 'SwingTally', 'TrochleaStage', 'dial_ns']
