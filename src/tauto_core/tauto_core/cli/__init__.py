"""`tauto …`: the command line. Modules are imported when a command needs them."""

import signal


def main() -> None:
    """Run `tauto` with the arguments of the process; never returns."""
    # Ctrl-C during the imports would print a traceback
    raises = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if raises:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from tauto_core.cli.app import run

    if raises:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()
