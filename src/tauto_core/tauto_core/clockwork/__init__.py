"""The clock: phase of the regulator, beats, what the dial reads."""

from __future__ import annotations

from tauto_core.clockwork.reading import dial_ns
from tauto_core.clockwork.trochlea import TrochleaStage

__all__ = ['TrochleaStage', 'dial_ns']
