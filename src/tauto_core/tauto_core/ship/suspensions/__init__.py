"""The kinds of suspension, one module each; every module here is a kind."""
