"""The programs that take part, a module each; `registry` knows them by name."""
