"""Many voyages of one scene with different random numbers: how often is the longitude found?"""

from tauto_core.fleets.answers import Answers, answers
from tauto_core.fleets.figure import draw
from tauto_core.fleets.plan import Plan, as_draws, read_draws
from tauto_core.fleets.sailing import Fleet, FleetError, sail_fleet, schema

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
