"""The programs that take part, one module each; `registry` lists them by name."""
