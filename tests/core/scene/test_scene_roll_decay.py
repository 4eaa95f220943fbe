"""Period and damping of the roll from decay tests: exact decays, and measured ones."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tauto_core.scene import SceneError, load_scene
from tauto_core.scene.tables import data_path
from tauto_core.ship.sea_files import fit_decay, released

MEASURED = 'shipped:kvlcc2_rolldecay/roll_{}.csv'
SEA = {'spectrum': 'jonswap', 'significant_wave_height': 2.0, 'peak_period': 9.0}


def decay(t: np.ndarray, period: float, zeta: float) -> np.ndarray:
    w = 2.0 * math.pi / period
    turned = w * math.sqrt(1.0 - zeta**2) * t
    return 0.01 + 0.2 * np.exp(-zeta * w * t) * np.cos(turned + 0.4)


def ship(**test: object) -> dict[str, object]:
    columns = {'time_column': 't_model_s', 'roll_column': 'phi_rad', 'model_scale': 68.0}
    roll = {'decay': {**columns, **test}, 'slope_coefficient': 0.7}
    return {'kind': 'sea', 'sea': SEA, 'roll': roll}


@pytest.mark.parametrize('zeta', [0.001, 0.01, 0.05, 0.2, 0.6])
def test_a_linear_decay_is_found_to_rounding(zeta: float) -> None:
    t = np.arange(0.0, 40.0, 0.05)
    fit = fit_decay(t, decay(t, 9.0, zeta))
    assert fit.natural_period == pytest.approx(9.0, rel=1e-13)
    assert fit.damping_ratio == pytest.approx(zeta, rel=1e-12)
    assert fit.residual < 1e-15


def test_noise_is_covered_by_the_errors_stated() -> None:
    """White noise is better than the errors assume: one value a half cycle, not one a sample."""
    t = np.arange(0.0, 60.0, 0.05)
    noise = np.random.Generator(np.random.PCG64(4)).normal(0.0, 0.002, len(t))
    fit = fit_decay(t, decay(t, 9.0, 0.02) + noise)
    assert fit.residual == pytest.approx(0.002, rel=0.1)
    assert abs(fit.damping_ratio - 0.02) < fit.damping_sigma < 0.003
    assert abs(fit.natural_period - 9.0) < fit.period_sigma < 0.1


# Published beside the data: 0.0078-0.0085 at rest, 0.0141 at 15.5 knots, by the decrement of the
# first three recorded peaks, and damped periods of 21.0 to 21.4 s over the whole tests; the first
# cycles are the shortest.
@pytest.mark.parametrize(
    ('run', 'low', 'high'),
    [('21337', 0.0078, 0.0085), ('21338', 0.0078, 0.0085), ('21340', 0.0135, 0.0145)],
)
def test_the_tanker_has_the_published_damping(run: str, low: float, high: float) -> None:
    scene = load_scene('ideal', ship=ship(path=MEASURED.format(run)))
    assert low <= scene.ship.roll.damping_ratio <= high
    assert scene.ship.roll.natural_period == pytest.approx(20.9, abs=0.05)
    assert scene.ship.roll.fitted_to.startswith(MEASURED.format(run) + ': 3 cycles')


def test_damping_falls_with_the_angle() -> None:
    early, late = (
        load_scene('ideal', ship=ship(path=MEASURED.format('21338'), cycles=cycles)).ship.roll
        for cycles in (3, 15)
    )
    assert late.damping_ratio < 0.85 * early.damping_ratio
    assert late.natural_period > early.natural_period


def test_the_period_of_a_model_is_scaled_by_the_root_of_the_length() -> None:
    path = MEASURED.format('21340')
    model, full = (
        load_scene('ideal', ship=ship(path=path, model_scale=scale)).ship.roll
        for scale in (1.0, 68.0)
    )
    assert full.natural_period == pytest.approx(math.sqrt(68.0) * model.natural_period, rel=1e-15)
    assert full.damping_ratio == model.damping_ratio


def test_a_held_ship_is_not_fitted() -> None:
    """Before the release the ship lies heeled, disturbed; the fit begins after it."""
    t = np.arange(0.0, 90.0, 0.05)
    free = decay(t, 9.0, 0.03)
    roll = np.concatenate([0.25 + 0.004 * np.sin(1.7 * t[:100]), free])
    time, part = released('x', 0.05 * np.arange(len(roll)), roll, 4)
    assert time[-1] - time[0] == pytest.approx(4 * 9.0, abs=0.3)
    assert fit_decay(time, part).damping_ratio == pytest.approx(0.03, rel=1e-10)


def written(tmp_path: Path, text: str) -> str:
    file = tmp_path / 'decay.csv'
    file.write_text(text)
    return str(file)


def measured() -> str:
    return data_path(MEASURED.format('21340')).read_text()


def test_bad_tests_are_refused(tmp_path: Path) -> None:
    lines = measured().splitlines()
    swapped = '\n'.join([*lines[:4], lines[5], lines[4], *lines[6:]])
    still = '\n'.join([lines[0], *(f'{i},0.01' for i in range(50))])
    cases = {
        swapped: r'decay\.csv: line 6, t_model_s = 22\.8.*later than the time before',
        '\n'.join([*lines[:9], '22.9,nan']): r'line 10, phi_rad = .nan.*not a finite number',
        '\n'.join([*lines[:9], '22.9']): r'line 10: has 1 cells, the header 2',
        still: r'cycles = 3: is more than the test holds: 0 whole cycles',
        '\n'.join(lines[:1]): 'holds no rows',
        '': r'line 1, column t_model_s: is missing',
    }
    for text, message in cases.items():
        with pytest.raises(SceneError, match=message):
            load_scene('ideal', ship=ship(path=written(tmp_path, text)))


def test_bad_keys_are_refused() -> None:
    path = MEASURED.format('21340')
    cases: dict[str, dict[str, Any]] = {
        r'ship\.roll\.decay\.cycles = 0': {'cycles': 0},
        r'cycles = 400: is more than the test holds: 16 whole cycles': {'cycles': 400},
        r'time_column = .phi_rad.: has no known unit; it must end in _s': {
            'time_column': 'phi_rad'
        },
        r'ship\.roll\.decay\.model_scale = -1': {'model_scale': -1.0},
        r'ship\.roll\.decay\.path.*no such file': {'path': 'shipped:kvlcc2_rolldecay/none.csv'},
        r'ship\.roll\.decay\.cycle = 3.*Did you mean `cycles`': {'cycle': 3},
    }
    for message, keys in cases.items():
        with pytest.raises(SceneError, match=message):
            load_scene('ideal', ship=ship(**{'path': path, **keys}))
