"""The kinds of ship's motion, one module each; every module here is a kind."""
