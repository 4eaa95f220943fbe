"""Commands are built one at a time, and the shell still completes them all."""

import pytest
from typer.testing import CliRunner

from tauto_core.cli.app import Registered, app


def test_one_command_is_built_without_the_others():
    def sound() -> None:
        """Do no harm."""

    def unsound(number: int | str) -> None:
        """Take a parameter that no command line has."""

    commands = Registered({'sound': sound, 'unsound': unsound})
    assert list(commands) == ['sound', 'unsound']
    assert commands['sound'] is commands['sound']
    assert 'sound' in commands
    with pytest.raises(AssertionError, match='Union'):
        commands['unsound']
    assert commands.get('silent') is None


@pytest.mark.parametrize(
    ('words', 'completed'),
    [('tauto sc', {'scene', 'scenes'}), ('tauto scene c', {'check'}), ('tauto g', {'graph'})],
)
def test_the_shell_completes_commands(words, completed):
    environment = {
        '_TAUTO_COMPLETE': 'complete_bash',
        'COMP_WORDS': words,
        'COMP_CWORD': str(len(words.split()) - 1),
    }
    said = CliRunner().invoke(app, [], prog_name='tauto', env=environment)
    assert set(said.stdout.split()) == completed
