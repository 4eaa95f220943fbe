"""Samples of a clock, the same samples in random batches, and the exact step of a clock."""

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import expm

from tauto_core.samples import TimeSamples, same, take


def times(stamps_s, errors_s=0.0):
    """Return readings or observations with these errors."""
    stamps = np.asarray(np.rint(np.asarray(stamps_s) * 1e9), np.int64)
    errors = np.asarray(np.rint(np.broadcast_to(errors_s, stamps.shape) * 1e9), np.int64)
    return TimeSamples(stamps, '', stamps + errors, same('port', len(stamps)))


def van_loan(tau, model):
    """Transition and process noise of a clock from one matrix exponential (Van Loan 1978)."""
    a = np.diag([1.0, 1.0], 1)
    w = np.diag([model.white_fm_s, model.random_walk_fm_per_s, 0.0])
    big = np.zeros((6, 6))
    big[:3, :3], big[:3, 3:], big[3:, 3:] = -a, w, a.T
    blocks = expm(big * tau)
    f = blocks[3:, 3:].T
    return f, f @ blocks[:3, 3:]


def split(samples, cuts):
    edges = [0, *sorted(cuts), len(samples.stamp_ns)]
    return [take(samples, slice(a, b)) for a, b in pairwise(edges)]


@st.composite
def feeds(draw, topics):
    """The topics in random pieces, each in its order, interleaved at random."""
    queues = {
        topic: split(samples, draw(st.lists(st.integers(0, len(samples.stamp_ns)), max_size=8)))
        for topic, samples in topics.items()
    }
    order = draw(st.permutations([t for t, parts in queues.items() for _ in parts]))
    return [{topic: queues[topic].pop(0)} for topic in order]


def integrated(make, topic, samples, stamps, cuts, resumed):
    """Return the integrals of a source that is fed in pieces and restored after one of them."""
    source, said = make(), []
    for k, piece in enumerate(split(samples, cuts)):
        source.feed({topic: piece})
        reached = np.searchsorted(stamps, source.reached_ns, 'right')
        said.append(source.at(stamps[:reached]))
        stamps = stamps[reached:]
        if k == resumed:
            state, source = source.state(), make()
            source.restore(state)
    assert not any(source.health().values())
    return np.concatenate(said)
