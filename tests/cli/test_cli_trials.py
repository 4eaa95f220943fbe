"""`tauto fleet --logs`: the passages of a log-book, as text and JSON, and refusals."""

import json
import re

import pytest
from command_line import invoke
from trial_examples import CLOCK, LOG, OTHER, write_log

from tauto_core.cli.tables import trial_tables
from tauto_core.ensembles.trials import ClockAnswers, Part, Prize, TrialAnswers, WayAnswers

LIGHT = ['--set', 'log.interval=600', '--set', 'ship.rate=8', '--jobs', '1']


def run(*arguments):
    return invoke('fleet', CLOCK, *LIGHT, *arguments)


def answers():
    sums = ((30.0, 20_000), (40.0, 15_000), (60.0, 10_000))
    prizes = [Prize(limit, pounds, 9, 0.9, 0.6, 0.98) for limit, pounds in sums]
    parts = [Part('Indian Ocean', 10, [9, 9, 9], 12.0)]
    way = WayAnswers(prizes, [1.0, 2.0, 3.0, 4.0, 5.0], parts, parts)
    ways = {'raw': way, 'corrected': way, 'sensed': way}
    clock = ClockAnswers('the_clock', 'clock.yaml', {}, 0, ways)
    return TrialAnswers('log.csv', 12, 10, [clock], [], [])


def test_the_answer_says_on_how_many_passages_she_would_have_won():
    found = answers().answer
    assert found.startswith('On 9 of 10 passages of six weeks and more the_clock would have')
    assert '90 % (60–98 %)' in found
    tables = list(trial_tables(answers()))
    heads = tables[0].splitlines()[1]
    assert re.split(' {2,}', heads) == ['clock', '30 nmi', '40 nmi', '60 nmi']
    assert len(tables) == 4


def test_short_passages_sail_beside_another_clock(tmp_path):
    path = write_log(tmp_path)
    asked = ['--logs', path, '--days', '0..', '--harbour-days', '0.5', '--sample', '1']
    asked += ['--duration', '60000']
    chart = tmp_path / 'trial.svg'
    found = run(*asked, '--compare', OTHER, '--plot', str(chart), '--json')
    assert found.exit_code == 0, found.stderr
    told = json.loads(found.stdout)
    assert (told['passages'], told['judged']) == (1, 0)
    assert [each['clock'] for each in told['clocks']] == [CLOCK, OTHER]
    assert [each['passage'] for each in told['voyages']] == ['17700101-1'] * 2
    assert told['voyages'][0]['ship'] == 'La Une'
    # 45° N 9.5° W is 184 km from Punta Candieira, 43.71° N 8.05° W
    assert told['voyages'][0]['ends'].startswith('at sea, 185 km from the coast')
    assert chart.read_text().startswith('<?xml')
    # in words there is no verdict, and why the other clock has no sensors
    assert f'{OTHER}: is not tried with thermometer and IMU: no rate equation' in found.stderr
    words = run(*asked).stdout.replace('\n', ' ')
    assert 'none of six weeks' in words
    assert 'the last entry of 1 passage is at sea, more than 30 km' in words


def test_wrong_passages_are_left_out_and_told(tmp_path):
    path = write_log(tmp_path, LOG.replace('270,9.3', '270,93').replace('150,4.6', '150,46'))
    asked = ['--logs', path, '--days', '0..', '--harbour-days', '0.5', '--duration', '60000']
    said = '2 passages cannot be sailed. Correct them, or leave them out with --skip-wrong.'
    assert said in run(*asked).stderr
    found = run(*asked, '--skip-wrong', '--json')
    assert found.exit_code == 0, found.stderr
    told = json.loads(found.stdout)
    assert told['passages'] == 1
    assert [each['passage'] for each in told['left_out']] == ['17700101-1', '17910701-3']
    for each in told['left_out']:
        assert f'left out: {each["problem"]}' in found.stderr
        assert 'row 1 (line ' in each['problem']


@pytest.mark.parametrize(
    ('asked', 'said'),
    [
        (['--skip-wrong'], '--skip-wrong: needs --logs'),
        (['--days', '42..'], '--days 42..: needs --logs'),
        (['--logs', 'LOG', '--ships', '3'], '--ships 3: does not go with --logs'),
        (['--logs', 'LOG', '--days', 'long'], "--days = 'long': must be a number [d]"),
        (['--logs', 'LOG', '--days', '50..40'], '--days 50..40: must be a range'),
        (['--logs', 'LOG'], 'none of its 3 passages matches'),
        (['--logs', 'absent.csv'], '--logs absent.csv: '),
        (['--logs', 'LOG', '--days', '0..', '--harbour-days', '-1'], 'harbour_days'),
    ],
)
def test_what_is_wrong_is_named(tmp_path, asked, said):
    path = write_log(tmp_path)
    found = run(*[path if each == 'LOG' else each for each in asked])
    assert found.exit_code == 2, found.output
    assert said in found.stderr.replace('\n', ' ')
    assert 'Traceback' not in found.stderr
