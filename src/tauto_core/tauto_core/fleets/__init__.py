"""Many voyages of one scene with different random numbers: how often is the longitude found?"""

from tauto_core.fleets.answers import Answers, answers
from tauto_core.fleets.draws import as_draws, read_draws
from tauto_core.fleets.figure import draw
from tauto_core.fleets.plan import Plan
from tauto_core.fleets.sailing import Fleet, sail_fleet
from tauto_core.fleets.store import FleetError, schema

__all__ = [
    'Answers',
    'Fleet',
    'FleetError',
    'Plan',
    'answers',
    'as_draws',
    'draw',
    'read_draws',
    'sail_fleet',
    'schema',
]
