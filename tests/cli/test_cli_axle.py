"""`tauto axle`, and commands on a scene with a body on an axle."""

from __future__ import annotations

import json
import math

import pytest
from command_line import invoke, run

BODY = ('axle', '--depth', '0.3', '--gyration-radius', '0.15')


def refused(*arguments: str) -> str:
    result = invoke(*arguments)
    assert result.exit_code != 0
    return f'{result.stderr} {result.exception}'


def test_lengths_are_those_of_the_paper() -> None:
    """§42: e = 0.1 m gives h, h′ = 0.4586475752, 0.0163524248 m (50-digit arithmetic)."""
    hollow = ('--support', 'concave', '--support-radius', '0.12', '--axle-radius', '0.02')
    found = json.loads(run(*BODY, *hollow, '--push-spin', '0.02', '--json'))
    assert found['h_m'] == pytest.approx(0.4586475752, abs=5e-11)
    assert found['h_prime_m'] == pytest.approx(0.0163524248, abs=5e-11)
    assert len(found['rows']) == 21
    # by the old names, too
    assert (found['b_m'], found['b_prime_m']) == (found['h_m'], found['h_prime_m'])
    lines = run(*BODY, *hollow, '--push-spin', '0.02').splitlines()
    assert lines[0].split() == ['h', '0.458647575', 'm']
    assert len(lines) == 6 + 1 + 21


def test_friction_gives_the_length_that_experience_shows() -> None:
    """§40: on a smooth plane k²/c; rolling (k² + (c − b)²)/c, near the length on a knife-edge."""
    smooth = json.loads(run(*BODY, '--release-tilt', '0.1', '--json'))
    assert (smooth['h_m'], smooth['h_prime_m']) == (None, pytest.approx(0.15**2 / 0.3))
    asked = ('--axle-radius', '0.02', '--contact', 'rolling', '--push-spin', '1', '--json')
    rolling = json.loads(run(*BODY, *asked))
    assert rolling['length_m'] == pytest.approx((0.15**2 + 0.28**2) / 0.3)


def test_a_body_that_falls_is_followed_until_it_lifts_off() -> None:
    convex = ('--support', 'convex', '--support-radius', '0.2', '--push-spin', '0.02')
    found = json.loads(run(*BODY, *convex, '--json'))
    assert found['h_prime_m'] < 0.0
    assert found['h_prime_period_s'] is None
    assert 'lifted off' in found['ends_why']
    assert len(found['rows']) == math.floor(found['ends_s'] / 0.1) + 1


@pytest.mark.parametrize(
    ('arguments', 'said'),
    [
        ('', '--release-tilt: leaves the body at rest'),
        ('--support bowl', "--support = 'bowl'"),
        ('--support convex', '--support-radius: is missing'),
        ('--contact coulomb --push-spin 1', '--friction: is missing'),
        ('--support cradle --push-spin 1', '--axle-radius: is the radius of the rockers'),
        ('--push-spin 1 --every 1e-9', '--every = 1e-09: makes more than 10000 rows'),
        ('--push-spin 1 --gravity 0', '--gravity = 0.0: must be above 0'),
        (
            '--support concave --support-radius 0.01 --axle-radius 0.02 --push-spin 1',
            'must be larger than the radius of the axle',
        ),
    ],
)
def test_what_makes_no_body_is_refused(arguments: str, said: str) -> None:
    assert said in refused(*BODY, *arguments.split())


def test_a_scene_is_checked_and_its_isochronism_told() -> None:
    """A thin axle that rolls swings as a circular pendulum, 1 + A²/16, nearly."""
    told = run('scene', 'check', 'axle_at_sea')
    assert 'concave, rolling' in told
    asked = ('isochronism', 'axle_at_sea', '--amplitudes', '0.1,0.3', '--json')
    short, long = (row['period_s'] for row in json.loads(run(*asked))['rows'])
    ratio = (long / short - 1.0) / (0.3**2 - 0.1**2)
    assert ratio == pytest.approx(1.0 / 16.0, rel=0.15)
    smooth = ('--set', 'regulator.contact=smooth')
    assert 'two modes' in refused('isochronism', 'axle_at_sea', '--amplitudes', '1', *smooth)


def test_a_scene_in_which_the_body_falls_is_refused() -> None:
    falls = ('--set', 'regulator.support=convex', '--set', 'regulator.contact=smooth')
    said = refused('scene', 'check', 'axle_at_sea', *falls)
    assert 'regulator.support' in said
    assert 'falls from its support' in said


def test_a_cradle_with_a_high_centre_of_gravity_tips() -> None:
    """On a plane it falls like φ cosh t√(g c/k²) (§38, 49), at first."""
    body = '--support cradle --depth -0.1 --gyration-radius 0.3 --axle-radius 0.5'
    start = '--release-tilt 1e-4 --duration 0.5'
    told = json.loads(run(*f'axle {body} {start} --json'.split()))
    growth = math.sqrt(9.80665 * 0.1) / 0.3
    for row in told['rows']:
        assert row['phi_rad'] == pytest.approx(1e-4 * math.cosh(growth * row['time_s']), rel=1e-5)
