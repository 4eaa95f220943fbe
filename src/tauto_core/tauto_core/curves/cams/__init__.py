"""The kinds of cam, one module each; every module here is a kind."""
