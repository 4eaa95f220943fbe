"""A cam measured on a real piece: smoothed within its tolerance, or refused."""

import numpy as np
import pytest

from tauto_core.curves import Involute, SpringCorrected
from tauto_core.curves.cams.table import MeasuredCam, smoothed
from tauto_core.machines.powers import ForcePower
from tauto_core.machines.sections import Trochlea
from tauto_core.machines.threads import HoleThread, VerticalThread
from tauto_core.scene import SceneError

RADIUS, RANGE = 0.01, 3.0
TOLERANCE = 2e-5
INVOLUTE = Involute(RADIUS)


def measured(rows=40, error=TOLERANCE, law=INVOLUTE, seed=1726):
    """Return angles, arms with errors spread evenly up to ±error, and the errors."""
    angles = np.linspace(0.0, RANGE, rows + 1)[1:]
    errors = error * np.random.default_rng(seed).uniform(-1.0, 1.0, rows)
    return angles, law.lever_arm(angles) + errors


def write(path, angles, arms):
    rows = (f'{a!r},{t!r}' for a, t in zip(angles.tolist(), arms.tolist(), strict=True))
    path.write_text('\n'.join(['angle_rad,lever_arm_m', *rows]))
    return path


def trochlea(path, tolerance, thread=None):
    return Trochlea(
        inertia=4e-4,
        cam=MeasuredCam(path=str(path), tolerance=tolerance),
        thread=thread or VerticalThread(),
        power=ForcePower(force=2.0),
        release_angle=1.0,
    )


@pytest.mark.parametrize('law', [INVOLUTE, SpringCorrected(0.012, 3.0)], ids=['linear', 'bent'])
@pytest.mark.parametrize('tolerance', [2.0 * TOLERANCE, 10.0 * TOLERANCE])
def test_no_point_is_farther_off_than_the_tolerance(law, tolerance, tmp_path):
    angles, arms = measured(law=law)
    cam = trochlea(write(tmp_path / 'cam.csv', angles, arms), tolerance).made_cam(9.81)
    assert np.max(np.abs(cam.lever_arm(angles) - arms)) <= tolerance
    assert cam.range_rad == RANGE
    # odd, and smooth through rest
    np.testing.assert_array_equal(cam.lever_arm(-angles), -cam.lever_arm(angles))


def test_errors_within_the_tolerance_are_smoothed_away(tmp_path):
    """The smoothed lever arm is nearer to the true one than the points are, with few pieces."""
    angles, arms = measured()
    cam = trochlea(write(tmp_path / 'cam.csv', angles, arms), TOLERANCE).made_cam(9.81)
    between = np.linspace(0.1, RANGE, 500)
    assert np.max(np.abs(cam.lever_arm(between) - RADIUS * between)) < TOLERANCE
    error = np.sqrt(np.mean((cam.lever_arm(angles) - RADIUS * angles) ** 2))
    assert error < 0.5 * np.sqrt(np.mean((arms - RADIUS * angles) ** 2))
    assert len(cam.law.knots) - 1 < len(angles) // 4


def test_without_errors_the_law_itself_is_found():
    """A curved law is met to the tolerance everywhere, and not only at the points."""
    law = SpringCorrected(0.012, 3.0)
    angles, arms = measured(error=0.0, law=law)
    found = smoothed(angles, arms, 1e-9)
    pieces = np.searchsorted(found.knots, angles, side='left') - 1
    x = angles - found.knots[pieces]
    values = np.sum(found.coefficients[pieces] * x[:, None] ** np.arange(6), axis=1)
    assert np.max(np.abs(values - arms)) <= 1e-9


def test_a_tolerance_below_the_errors_is_refused(tmp_path):
    """A curve that follows the errors too closely has a hollow, which the thread would bridge."""
    file = write(tmp_path / 'cam.csv', *measured(error=1e-4))
    with pytest.raises(SceneError, match=r'hollow.*Use a larger tolerance'):
        trochlea(file, 1e-6).made_cam(9.81)
    assert trochlea(file, 3e-4).made_cam(9.81).range_rad == RANGE


@pytest.mark.parametrize(
    ('edit', 'tolerance', 'said'),
    [
        (lambda a, t: (a[:5], t[:5]), TOLERANCE, 'at least 6 rows'),
        (lambda a, t: (a[::-1], t), TOLERANCE, 'must be greater than the angle before'),
        (lambda a, t: (a - 1.0, t), TOLERANCE, 'one cheek, at angles greater than 0'),
        (lambda a, t: (a, -t), TOLERANCE, 'must be > 0'),
        (lambda a, t: (np.linspace(a[0], 3.0, 501), np.full(501, t[0])), TOLERANCE,
         'more than 500 points'),
        (lambda a, t: (a, t), 0.02, 'at most half of the longest lever arm'),
    ],
)  # fmt: skip
def test_points_that_are_no_cheek_are_refused(edit, tolerance, said, tmp_path):
    with pytest.raises(SceneError, match=said):
        trochlea(write(tmp_path / 'cam.csv', *edit(*measured())), tolerance).made_cam(9.81)


def test_a_hole_nearer_than_the_longest_arm_is_refused(tmp_path):
    file = write(tmp_path / 'cam.csv', *measured())
    assert trochlea(file, TOLERANCE, HoleThread(distance=0.05)).made_cam(9.81).distance == 0.05
    with pytest.raises(SceneError, match='longer than the hole is away'):
        trochlea(file, TOLERANCE, HoleThread(distance=0.02)).made_cam(9.81)
