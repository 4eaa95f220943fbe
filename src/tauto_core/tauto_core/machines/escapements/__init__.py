"""The kinds of escapement, one module each; every module here is a kind."""
