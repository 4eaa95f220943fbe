"""Errors can be sent between processes unchanged, and each face spells their arguments."""

import pickle

import pytest

from tauto_core.cli.terminal import option
from tauto_core.scene.errors import (
    ABSENT,
    Argument,
    ArgumentText,
    Problem,
    PropagationError,
    SceneError,
    TautoError,
    UsageError,
    spelled,
)


@pytest.mark.parametrize(
    'error',
    [
        UsageError('no'),
        UsageError(Argument('out', 'a'), ': is a file'),
        PropagationError('the thread is slack', 1.5),
        SceneError(
            'f', 'a.b', ABSENT, 'is missing', 'Add it.', further=[Problem('c', 1, 'p', 'r')]
        ),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_is_the_same_in_another_process(error: TautoError) -> None:
    error.add_note('noted')
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert spelled(again.message, option) == spelled(error.message, option)
    assert vars(again) == vars(error)
    if isinstance(again, SceneError):
        assert again.value is ABSENT


def test_each_face_spells_arguments_in_its_own_way() -> None:
    cases = {
        Argument('ship_of'): ('ship_of=', '--ship-of'),
        Argument('jobs', 1): ('jobs=1', '--jobs 1'),
        Argument('anyway', value=True): ('anyway=True', '--anyway'),
        Argument('reach_rad', '2.0 rad', spaced=True): (
            'reach_rad = 2.0 rad',
            '--reach = 2.0 rad',
        ),
        Argument('roll_deg', 5): ('roll_deg=5', '--roll 5'),
    }
    for argument, (python, line) in cases.items():
        assert (str(argument), option(argument)) == (python, line)
    inner = UsageError('Say ', Argument('anyway', value=True), '.')
    outer = ArgumentText('twice: ', inner.message, ' Or leave out ', Argument('out'))
    assert outer == 'twice: Say anyway=True. Or leave out out='
    assert spelled(outer, option) == 'twice: Say --anyway. Or leave out --out'
    wrong = SceneError('f', 'a.b', 1, 'is wrong', outer, further=[Problem('', ABSENT, 'p', 'R.')])
    assert str(wrong) == f'f: a.b = 1: is wrong. {outer}\nf: p. R.'
    assert '--anyway. Or leave out --out\nf: p. R.' in spelled(wrong.message, option)
