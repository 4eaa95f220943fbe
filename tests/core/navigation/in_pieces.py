"""The same samples in random batches."""

from itertools import pairwise

from hypothesis import strategies as st

from tauto_core.samples import take


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
