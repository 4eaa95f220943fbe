"""Every claim of Euler's three papers, checked."""

from tauto_core.euler.claim import Claim, Paper, Verdict

__all__ = ['Claim', 'Paper', 'Verdict']
