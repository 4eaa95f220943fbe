"""The prediction of events, on a swing in closed form: θ = A sin ωt."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tauto_core.kernels import entry
from tauto_core.motion.events import back_to, lay_out, phase_to


@entry
def foretold(way, x, y, reach):
    return phase_to(way, x, y, reach)


@entry
def back(late, bend, omega):
    return back_to(late, bend, omega)


@entry
def laid_out(left, per_s, longest_s, ahead_s, level):
    return lay_out(left, per_s, longest_s, ahead_s, level)


@pytest.mark.parametrize('way', [1.0, -1.0])
@pytest.mark.parametrize('reach', [-0.9, 0.0, 0.4])
@pytest.mark.parametrize('phase', np.linspace(-3.0, 3.0, 13))
def test_the_phase_to_an_angle_is_of_its_first_rise(way, reach, phase):
    size = 1.1
    ahead = foretold(way, size * math.sin(phase), size * math.cos(phase), reach)
    assert 0.0 < ahead <= math.tau
    assert way * size * math.sin(phase + ahead) == pytest.approx(reach, abs=1e-14)
    assert way * math.cos(phase + ahead) > 0.0
    # no earlier: the swing is at one phase of a turn there
    assert foretold(way, 0.3 * math.sin(phase), 0.3 * math.cos(phase), reach) == (
        math.inf if reach else pytest.approx(ahead)
    )


@pytest.mark.parametrize('passed', [0.4, -0.3])
def test_back_to_a_passage_errs_by_the_fourth_power(passed):
    """The value A(sin ωt − sin φ) t seconds after it was zero: halved, the error falls 16-fold."""
    omega, errors = 5.0, []
    for angle in (0.02, 0.01):
        now = math.asin(passed) + angle
        rate = omega * math.cos(now)
        late, bend = (math.sin(now) - passed) / rate, -(omega**2) * math.sin(now) / rate
        errors.append(abs(omega * back(late, bend, omega) - angle))
    assert errors[0] < 1e-7
    assert 14.0 < errors[0] / errors[1] < 18.0


def test_a_stretch_of_equal_steps_ends_at_the_event_or_span():
    assert laid_out(1.0, 0.5, 10.0, math.inf, 0) == (1.0, 1)
    assert laid_out(1.0, 0.5, 0.3, math.inf, 0) == (1.0, 7)
    assert laid_out(1.0, 0.5, 0.3, 0.5, 0) == (0.25, 2)
    # up to a twentieth of a step more is taken at one go
    assert laid_out(1.0, 0.5, 0.3, 0.314, 0)[1] == 1
    assert laid_out(1.0, 0.5, 0.3, 0.316, 0)[1] == 2
    assert laid_out(1.0, 0.5, 0.3, 0.5, 3) == (0.25, 16)
