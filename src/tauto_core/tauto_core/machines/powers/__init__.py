"""The kinds of power that pulls the thread, one module each; every module here is a kind."""
