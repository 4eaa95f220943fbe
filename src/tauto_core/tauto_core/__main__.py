"""`python -m tauto_core …` is `tauto …`."""

from tauto_core.cli import main

main()
