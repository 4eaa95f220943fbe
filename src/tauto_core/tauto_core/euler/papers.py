"""The papers, in their order, and all their claims."""

from __future__ import annotations

from importlib import import_module

from tauto_core.euler.claim import Claim

PAPERS = ('tauto_core.euler.fluid_1729',)
"""Modules with a function `claims() -> list[Claim]`, in the order of the papers."""


def all_claims() -> list[Claim]:
    """Return the claims of all papers, in the order of paper and paragraph."""
    found: list[Claim] = []
    for name in PAPERS:
        found += import_module(name).claims()
    return found
