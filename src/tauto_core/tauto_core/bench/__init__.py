"""The benchmark: run time against error, beside the programs that others would use."""

from tauto_core.bench.figure import draw
from tauto_core.bench.passage import passage, two_at_once
from tauto_core.bench.peer import MissingPeerError, Outcome, Peer
from tauto_core.bench.peers import PEERS, make_peers
from tauto_core.bench.problems import Numbers, Problem, Sea, problems
from tauto_core.bench.ratios import FAMILIES, best_ratio, ratio, targets
from tauto_core.bench.references import reference, references
from tauto_core.bench.runner import Row, bench
from tauto_core.figure_file import check_plot

__all__ = [
    'FAMILIES',
    'PEERS',
    'MissingPeerError',
    'Numbers',
    'Outcome',
    'Peer',
    'Problem',
    'Row',
    'Sea',
    'bench',
    'best_ratio',
    'check_plot',
    'draw',
    'make_peers',
    'passage',
    'problems',
    'ratio',
    'reference',
    'references',
    'targets',
    'two_at_once',
]
