"""The kinds of weather, one module each; every module here is a kind."""
