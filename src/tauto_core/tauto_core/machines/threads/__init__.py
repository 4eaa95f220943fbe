"""The kinds of thread, one module each; every module here is a kind."""
