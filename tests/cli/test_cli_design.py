"""`tauto design`."""

import json
import math
import re

import numpy as np
import pytest
from command_line import invoke, refused, run

import tauto_core as tauto


def facts(*arguments):
    return json.loads(run('design', *arguments, '--json'))


def test_paragraph_20_in_scruples():
    """Q = 100 P and a pendulum of 3166 scruples: 63.32, printed 63."""
    euler = ('--disc-is-base', '--disc-weight', '100paris_pound', '--pull', '1paris_pound')
    lines = run('design', *euler, '--pendulum', '3166 scruple').splitlines()
    table = {' '.join(line.split()[:-2]): line.split()[-2:] for line in lines}
    assert table['base radius'] == ['63.32', 'scruple']
    assert table['disc weight'] == ['100', 'paris_pound']
    # with 63 the pendulum would be 3150
    back = facts(*euler, '--base-radius', '63scruple')
    assert back['pendulum_m'] == pytest.approx(3150 * 0.31385e-3, rel=1e-12)
    old = invoke('design', *euler, '--length-unit=scruple')
    assert (old.exit_code, '--length-unit: write the unit' in old.stderr) == (2, True)


KEYS = {
    'disc-weight': 'disc_weight_n',
    'disc-radius': 'disc_radius_m',
    'pull': 'pull_n',
    'base-radius': 'base_radius_m',
    'period': 'period_s',
}


@pytest.mark.parametrize('is_base', [False, True])
def test_a_disc_and_what_it_lacks(is_base):
    """L = Q a²/(2 P r) (XXI), solved for each letter; a = r if the disc is the base."""
    q, p, r, g = 3.0, 0.2, 0.01, 9.81
    a = r if is_base else 0.04
    length = q * a * a / (2 * p * r)
    whole = {'disc-weight': q, 'disc-radius': a, 'pull': p, 'base-radius': r}
    whole['period'] = math.tau * math.sqrt(length / g)
    if is_base:
        del whole['disc-radius']
    for name, value in whole.items():
        given = (f'--{other}={size!r}' for other, size in whole.items() if other != name)
        found = facts(*given, '--gravity', g, *['--disc-is-base'] * is_base)
        assert found[KEYS[name]] == pytest.approx(value, rel=1e-14)
        assert found['pendulum_m'] == pytest.approx(length, rel=1e-14)
        assert found['inertia_kg_m2'] == pytest.approx(q * a * a / (2 * g), rel=1e-13)
        assert found['disc_radius_m'] == (found['base_radius_m'] if is_base else pytest.approx(a))


def test_the_design_is_a_scene_that_keeps_its_period(tmp_path):
    """The toy of 50 g: isochronous without the inertia of the weight, and never replaced."""
    file, toy = tmp_path / 'toy.yaml', ('--period', 2, '--inertia', 9.6e-5, '--pull', '50 g')
    said = run('design', *toy, '-o', file)
    assert 'base radius    0.00193233 m' in said
    found = tauto.isochronism(file, [0.2, 1.0])
    np.testing.assert_allclose(found.period_s, 2.0, rtol=1e-12)
    before = file.read_bytes()
    assert 'exists, and is not replaced' in refused('design', *toy, '-o', file)
    assert file.read_bytes() == before
    # the cam for the weight, as the file's remark has it
    text = re.sub(r'\n  (cam|power):\n(    .*\n)+', '\n', file.read_text())
    text += ''.join(re.findall(r'^#( +(?:cam|power).*\n)', text, re.MULTILINE)).replace(
        '   ', '  '
    )
    (tmp_path / 'heavy.yaml').write_text(text)
    heavy = tauto.isochronism(tmp_path / 'heavy.yaml', [0.2, 1.0])
    np.testing.assert_allclose(heavy.period_s, 2.0, rtol=1e-9)
