"""Every claim of Euler's three papers, checked."""

from tauto_core.euler.edition import Claim, Paper, Verdict

__all__ = ['Claim', 'Paper', 'Verdict']
