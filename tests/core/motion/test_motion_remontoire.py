"""A train that runs down, and the remontoire that isolates the wheel from it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from motion_cases import INERTIA, LEVER_RATE, OMEGA, arc, run, scene_of, weight_of

from tauto_core.samples import JOINT_STATES, PHASE
from tauto_core.scene import SceneError

RELEASE = 1.0
VISCOUS = 2e-5
ENERGY = 0.5 * math.pi * VISCOUS * OMEGA
"""Of an impulse at the middle that keeps up a swing of 1 rad against the drag."""
TRAIN = {'fall': 0.6, 'impulses': 12}
SWINGS = 30
CHEEK = {'cam': arc(0.02, LEVER_RATE), 'thread': {'kind': 'vertical'}}


def clock(escapement: dict[str, Any], **sections: Any):
    duration = round(SWINGS * math.tau / OMEGA, 1)
    return scene_of(
        escapement={'energy': ENERGY, **escapement},
        drag={'viscous': VISCOUS},
        duration=duration,
        log={'interval': 0.1},
        drift={'observation_interval': duration},
        **sections,
    )


def exact(times, strength):
    """Return θ of a linear well with viscous drag and impulses at the middle, in closed form.

    θ̈ + 2δθ̇ + ω²θ = 0: passages of the middle are π/ω_d apart, and from one to the next the speed
    falls by exp(−δπ/ω_d); an impulse adds 2 E/I to its square.
    """
    delta = 0.5 * VISCOUS / INERTIA
    damped = math.sqrt(OMEGA**2 - delta**2)
    first = (0.5 * math.pi + math.asin(delta / OMEGA)) / damped
    speed = RELEASE * OMEGA * math.exp(-delta * first)
    half, sign = math.pi / damped, -1.0
    before = RELEASE * np.exp(-delta * times)
    angle = before * (np.cos(damped * times) + delta / damped * np.sin(damped * times))
    for k in range(4 * SWINGS):
        start = first + k * half
        speed = math.sqrt(speed**2 + 2.0 * ENERGY * strength(k) / INERTIA)
        now = (times >= start) & (times < start + half)
        since = times[now] - start
        angle[now] = sign * speed / damped * np.exp(-delta * since) * np.sin(damped * since)
        speed, sign = speed * math.exp(-delta * half), -sign
    return angle


def angles(scene) -> np.ndarray:
    return run(scene)[JOINT_STATES].position[:, 0]


def of_train(k: int) -> float:
    return 1.0 + 0.6 * (0.5 - (k % 12 + 0.5) / 12)


@pytest.mark.parametrize(
    ('escapement', 'strength'),
    [
        ({}, lambda _: 1.0),
        ({'train': TRAIN}, of_train),
        ({'kind': 'remontoire', 'remontoire': {'impulses': 5}}, lambda _: 1.0),
        (
            {'kind': 'remontoire', 'remontoire': {'impulses': 5, 'fall': 0.1}},
            lambda k: 1.0 + 0.1 * (0.5 - (k % 5 + 0.5) / 5),
        ),
    ],
    ids=['the same', 'a train that runs down', 'remontoire', 'remontoire that falls off'],
)
def test_impulses_against_the_closed_form(escapement, strength):
    scene = clock(escapement)
    times = 0.1 * np.arange(scene.log_count)
    np.testing.assert_allclose(angles(scene), exact(times, strength), rtol=0.0, atol=2e-12)


def test_whatever_the_train_a_remontoire_gives_the_same_bits():
    """The plain escapement's train shows in every swing; behind a remontoire it does not."""
    small = {'kind': 'remontoire', 'remontoire': {'impulses': 5, 'fall': 0.1}}
    train = {'energy': 3.0 * ENERGY, 'impulses': 12}
    still, falling = (
        angles(clock({**small, 'train': {**train, 'fall': fall}})) for fall in (0.0, 0.6)
    )
    np.testing.assert_array_equal(still, falling)
    plain, driven = (angles(clock(more)) for more in ({}, {'train': TRAIN}))
    assert np.max(np.abs(plain - driven)) > 1e-3


def test_a_remontoire_isolates_a_cheek_from_a_declining_train():
    """A cheek turns swings that grow and fall into gains and losses; Euler's cam does not."""

    def shift(escapement: dict[str, Any], **more: Any) -> float:
        """Return how far the phase is from that of impulses that are all the same [rad]."""
        found, even = (run(clock(each, **more))[PHASE] for each in (escapement, {}))
        return float(np.max(np.abs(found.position[:, 0] - even.position[:, 0])))

    train = {'fall': 0.9, 'impulses': 60}
    small = {'impulses': 5, 'fall': 0.1}
    remontoire = {'kind': 'remontoire', 'remontoire': small}
    cheek = shift({'train': train}, trochlea=CHEEK)
    assert cheek > 0.01
    assert shift(remontoire, trochlea=CHEEK) < 0.1 * cheek
    assert shift({'train': train}) < 0.1 * cheek


def test_a_train_too_weak_to_rewind_is_refused_with_the_least():
    small = {'kind': 'remontoire', 'remontoire': {'impulses': 5}}
    train = {'impulses': 12, 'fall': 0.5}
    with pytest.raises(SceneError, match=r'the clock stops there\. Use at least') as caught:
        clock({**small, 'train': {**train, 'energy': 1.2 * ENERGY}})
    assert caught.value.key == 'escapement.train.energy'
    least = float(str(caught.value).rpartition('Use at least ')[2].split()[0])
    assert least == pytest.approx(ENERGY / 0.75, rel=1e-5)
    clock({**small, 'train': {**train, 'energy': 1.0001 * least}})


def test_a_swinging_thread_refuses_impulses_that_weaken():
    hanging = weight_of(0.2, LEVER_RATE, thread={'kind': 'hanging', 'length': 0.5})
    clock({}, trochlea=hanging)
    with pytest.raises(SceneError, match=r'escapement\.kind = .impulse.: with impulses that weak'):
        clock({'train': TRAIN}, trochlea=hanging)
