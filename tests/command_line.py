"""Commands of Tauto in this process, as from a command line."""

from typer.testing import CliRunner, Result

from tauto_core.cli.app import app


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def run(*arguments: object) -> str:
    """Return what a command prints that succeeds."""
    result = invoke(*arguments)
    assert result.exit_code == 0, result.stderr
    return result.stdout


def refused(*arguments: object) -> str:
    """Return what a command says that refuses its arguments and prints nothing."""
    result = invoke(*arguments)
    assert (result.exit_code, result.stdout) == (2, ''), result.output
    return result.stderr
