"""Many voyages of one scene, each with its own chance: how often is the longitude found?"""

from tauto_core.fleet.answers import Answers, answers
from tauto_core.fleet.draws import as_draws, read_draws
from tauto_core.fleet.figure import draw
from tauto_core.fleet.plan import Plan
from tauto_core.fleet.sailing import Fleet, sail_fleet
from tauto_core.fleet.store import FleetError, schema

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
