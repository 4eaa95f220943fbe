"""The answer and its table: sides, signs, absent values, 80 columns; tables of text."""

from __future__ import annotations

from typing import Any

import pytest

from tauto_core.cli.tables import listed, table, voyage_table
from tauto_core.results import answer, belief_of

RESULT: dict[str, Any] = {
    'scene': 'h4',
    'duration_s': 7_000_000.0,
    'trochlea': {'period_s': 1.0},
    'clock': {'reading_s': 6_999_994.9, 'error_s': -5.1, 'rate_s_per_day': -0.0629},
    'drift': {'offset_s': -5.0, 'offset_sigma_s': 0.4}
    | {'rate_s_per_day': 0.25, 'rate_sigma_s_per_day': 0.01},
    'longitude': {
        'raw_error_arcmin': 1.275,
        'raw_error_nmi': 1.2126,
        'error_arcmin': -0.025,
        'error_nmi': -0.02378,
        'sigma_nmi': 0.0951,
        'at_s': 7_000_000.0,
        'unchecked_days': 7_000_000.0 / 86_400.0,
        'prize_pounds': 20000,
        'raw_prize_pounds': 15000,
        'landfalls': [],
        'projection': [],
    },
    'bag': 'bags/out/h4',
}


def rows(result: dict[str, Any]) -> dict[tuple[str, str], list[str]]:
    """Return the rows of the table: group and label to value and unit."""
    found, group = {}, ''
    for line in filter(str.strip, voyage_table(result).splitlines()):
        label, *cells = [part for part in line.strip().split('  ') if part.strip()]
        if line.startswith('  '):
            found[group, label] = [cell.strip() for cell in cells]
        elif not cells:
            group = label
    return found


def test_the_sentence_comes_first_and_names_the_sides() -> None:
    assert answer(RESULT) == (
        'After 81 days unchecked the dial puts the ship 1.21 nmi east of its true place; '
        'rated and corrected, 0.024 ± 0.095 nmi west. That is within 30 nmi, worth £20,000 by the '
        'Act of 1714.'
    )
    title, *lines = voyage_table(RESULT).partition('\n\n')[0].splitlines()
    assert title == 'h4: 81 days'
    assert ' '.join(lines) == answer(RESULT)


def test_a_side_is_named_once_and_zero_has_none() -> None:
    same = {**RESULT['longitude'], 'error_nmi': 1234.0, 'sigma_nmi': 97.0}
    said = answer({'longitude': same})
    assert 'rated and corrected, 1,234 ± 97 nmi. That is beyond 60 nmi, worth nothing by' in said
    none = {**RESULT['longitude'], 'raw_error_nmi': -0.0, 'error_nmi': 1e-9}
    assert 'puts the ship within 0.01 nmi of its true place' in answer({'longitude': none})
    assert 'rated and corrected, 0.000 ± 0.095 nmi. That' in answer({'longitude': none})
    untried = {**RESULT['longitude'], 'prize_pounds': None}
    assert answer({'longitude': untried}).endswith('0.024 ± 0.095 nmi west.')


def test_the_answer_names_the_navigators_sigma_and_its_failure() -> None:
    longitude, assumes = RESULT['longitude'], 'the rate found in port to last'
    whose = f"The ± is the navigator's, who expects {assumes}."
    held = belief_of(longitude, assumes)
    assert held['belief'] == whose
    assert answer({'longitude': longitude | held}).endswith(f'by the Act of 1714. {whose}')
    assert held['model_holds']
    assert held['error_sigmas'] == 0.02378 / 0.0951
    # the landfall on the way refutes him, although the end does not
    madeira = {'at_s': 2_592_000.0, 'error_nmi': -695.45, 'sigma_nmi': 0.15}
    broken = belief_of({**longitude, 'landfalls': [madeira]}, assumes)
    assert not broken['model_holds']
    assert broken['error_sigmas'] == 695.45 / 0.15
    said = broken['belief'].removeprefix(f'{whose} His model does not hold: ')
    assert said.startswith('the error was 4,600 of his standard deviations after 30 days. ')
    assert all(f'({key})' in said for key in ('drift.covariates', 'drift.random_walk_fm'))
    # five of them are no refutation, and the rate equation is no remedy to who has it
    five = belief_of({**longitude, 'error_nmi': 5.0, 'sigma_nmi': 1.0}, assumes)
    assert five['model_holds']
    equation = belief_of({**longitude, 'sigma_nmi': 1e-3}, 'the rate to follow')
    assert 'covariates' not in equation['belief']


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'unchecked_days': 5.0, 'at_s': 864_000.0}, 'After 10 days, the last 5 days unchecked,'),
        ({'unchecked_days': 0.0}, 'After 81 days, checked to the end, the dial'),
        ({'unchecked_days': 0.0, 'at_s': 0.0}, 'At the start the dial'),
    ],
)
def test_the_sentence_says_how_long_the_clock_was_alone(
    changes: dict[str, float], words: str
) -> None:
    assert answer({'longitude': {**RESULT['longitude'], **changes}}).startswith(words)


def test_what_tells_no_longitude_says_so() -> None:
    assert answer({}).startswith('The longitude is not known')
    trochlea = {'period_s': 1.0, 'stopped_s': 90.0, 'stopped_why': 'its swing had died away'}
    stopped = {**RESULT, 'trochlea': trochlea}
    assert answer(stopped).startswith('The clock stopped after 90 seconds')


def test_figures_are_signed_and_have_their_units_apart() -> None:
    found = rows(RESULT)
    assert found['clock', 'error of the dial'] == ['−5.10', 's']
    assert found['longitude, error', 'by the dial'] == ['+1.21', 'nmi']
    assert found['longitude, error', 'corrected'] == ['−0.024 ± 0.095', 'nmi']
    drift = 'drift, estimated ± its standard deviation'
    assert found[drift, 'offset'] == ['−5.00 ± 0.40', 's']
    assert found[drift, 'rate'] == ['+0.250 ± 0.010', 's/day']
    assert not any(label.startswith('error of') for group, label in found if group == drift)
    assert voyage_table(RESULT).count('Signs: ') == 1


def test_the_estimate_is_compared_with_the_truth_in_its_row() -> None:
    """The mean of the run, since the filter was reopened, or of the voyage with covariates."""
    drift = 'drift, estimated ± its standard deviation'
    wrong = {**RESULT['drift'], 'offset_error_sigmas': 0.25, 'rate_error_sigmas': -31.29}
    wrong |= {'rate_compared_from_s': 0.0, 'rate_compared_s_per_day': 0.5629}
    reopened = {**wrong, 'rate_compared_from_s': 36.2 * 86_400.0}
    mean = {**reopened, 'mean_rate_s_per_day': 1.0, 'mean_rate_sigma_s_per_day': 0.1}
    cases = {'mean of the run': wrong, 'mean after 36.2 days': reopened}
    for name, estimate in {**cases, 'mean of the voyage': mean}.items():
        found = rows({**RESULT, 'drift': estimate})
        assert found[drift, 'error of the offset'] == ['+0.25', 'σ']
        assert found[drift, f'error of the rate, {name}'] == ['−31', 'σ']


def test_the_worst_error_names_the_time_in_which_it_is_the_worst() -> None:
    """The clock is rated in port, and was further off before."""
    worst = {'worst_since_s': 300.0, 'worst_error_nmi': 0.1209, 'worst_at_s': 324.0}
    worst |= {'worst_raw_error_nmi': 0.0992, 'worst_raw_at_s': 592.0}
    group = 'longitude, error'
    found = rows({'longitude': {**RESULT['longitude'], **worst}})
    assert found[group, 'worst after 5 minutes, corrected, at 5.4 minutes'] == ['0.12', 'nmi']
    assert found[group, 'worst after 5 minutes, by the dial, at 9.87 minutes'] == ['0.10', 'nmi']
    found = rows({'longitude': {**RESULT['longitude'], **worst, 'worst_since_s': 0.0}})
    assert (group, 'worst of the run, corrected, at 5.4 minutes') in found


def test_a_trial_is_paid_at_each_landfall() -> None:
    jamaica = {**RESULT['longitude'], 'at_s': 95.0 * 86_400.0}
    madeira = {**jamaica, 'at_s': 50.0 * 86_400.0, 'raw_prize_pounds': 0}
    lisbon = {**jamaica, 'at_s': 9.0 * 86_400.0, 'prize_pounds': None, 'raw_prize_pounds': None}
    found = rows({'longitude': {**jamaica, 'landfalls': [lisbon, madeira, jamaica]}})
    verdict = {name: cells for (group, name), cells in found.items() if 'Act' in group}
    assert verdict == {
        'landfall after 50 days, corrected': ['20,000', '£'],
        'landfall after 50 days, by the dial': ['0', '£'],
        'landfall after 95 days, corrected': ['20,000', '£'],
        'landfall after 95 days, by the dial': ['15,000', '£'],
    }


def test_a_voyage_too_short_for_the_act_is_projected() -> None:
    ahead = {'days': 42.0, 'raw_error_nmi': 468.4, 'raw_sigma_nmi': 323.0}
    ahead |= {'error_nmi': -12.3, 'sigma_nmi': 97.1}
    short = {**RESULT['longitude'], 'prize_pounds': None, 'projection': [ahead]}
    text = voyage_table({'longitude': short})
    assert '£' not in text
    assert 'none: unchecked for less than six weeks' in text
    found = rows({'longitude': short})
    verdict = 'verdict of the Act of 1714'
    assert found[verdict, 'projected to 42 days unchecked, corrected'] == ['−12 ± 97', 'nmi']
    by_the_dial = 'projected to 42 days unchecked, by the dial'
    assert found[verdict, by_the_dial] == ['+470 ± 320', 'nmi']
    ahead.update(raw_error_nmi=None, raw_sigma_nmi=None)
    short['not_projected'] = f'the dial cannot be projected: {"it never forgets, " * 9}and wanders'
    without = voyage_table({'longitude': short})
    assert by_the_dial not in without
    assert short['not_projected'] in ' '.join(without.split())
    figures = [line for line in without.splitlines() if line.endswith(' nmi')]
    assert max(map(len, figures)) < 70  # the sentence does not push them to the right


def test_no_row_wraps_at_80_columns_nor_the_path_of_the_bag() -> None:
    long = 'x' * 300
    counts = {'/a/rather/long/namespace/trochlea/joint_states': 8_208_061}
    clock = {'error_s': -123_456.789, 'rate_s_per_day': -1.234567e-9}
    wide = {**RESULT, 'bag': long, 'counts': counts, 'clock': clock}
    text = voyage_table(wide)
    assert f'Bag: {long}' in text
    labels = [line for line in text.splitlines() if line.startswith('  ') and line.strip()]
    assert len(labels) == len(rows(wide))
    assert max(map(len, labels)) <= 80


def test_absent_sections_give_no_rows() -> None:
    text = voyage_table({'scene': 'x', 'clock': {}, 'drift': None})
    assert 'clock\n' not in text
    assert 'drift' not in text


def test_labels_stand_to_the_left_and_figures_to_the_right() -> None:
    columns = [('place', str), ('off\nby, nmi', lambda name: f'{len(name)}.5')]
    text = table('landfalls', columns, ['Portsmouth', 'Rio'], 'a remark')
    assert text.splitlines() == [
        'landfalls',
        '                off',
        'place       by, nmi',
        '─' * 19,
        'Portsmouth     10.5',
        'Rio             3.5',
        'a remark',
    ]


def test_texts_wrap_beside_their_labels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('COLUMNS', '50')
    text = listed([('ship', 'word ' * 20), ('', ''), ('sea', 'a\nb')])
    lines = text.splitlines()
    assert max(map(len, lines)) <= 50
    assert [line[:6].strip() for line in lines] == ['ship', '', '', '', 'sea', '']
    assert lines[-2:] == ['sea   a', '      b']
