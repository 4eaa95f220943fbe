"""Errors can be sent between processes unchanged."""

import pickle

import pytest

from tauto_core.scene.errors import (
    ABSENT,
    Problem,
    PropagationError,
    SceneError,
    TautoError,
    UsageError,
)


@pytest.mark.parametrize(
    'error',
    [
        UsageError('no'),
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
    assert vars(again) == vars(error)
    if isinstance(again, SceneError):
        assert again.value is ABSENT
