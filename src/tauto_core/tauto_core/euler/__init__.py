"""The results of Euler's three papers and the faults of their texts, checked."""

from tauto_core.euler.edition import Claim, Paper, Verdict

__all__ = ['Claim', 'Paper', 'Verdict']
