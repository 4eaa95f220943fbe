"""`tauto …`: the command line. Modules are imported when a command that needs them runs."""

import signal


def main() -> None:
    """Run `tauto` with the arguments of the process; never returns."""
    # until a command can catch it, Ctrl-C would print a traceback from any of the imports
    raises = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if raises:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from tauto_core.cli.app import run

    if raises:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()
