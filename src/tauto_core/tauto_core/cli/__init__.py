"""`tauto …`: the command line. What a command needs is imported when it runs."""

from tauto_core.cli.app import main

__all__ = ['main']
