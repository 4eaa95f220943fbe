"""The plain escapement: the same impulse each beat."""

from __future__ import annotations

from typing import Literal

from tauto_core.machines.escapement import EscapementKind


class Escapement(EscapementKind):
    """Impulse once a beat, at angle · sgn θ̇ (positive: after the middle)."""

    rank = 1

    kind: Literal['impulse'] = 'impulse'


KIND = Escapement
