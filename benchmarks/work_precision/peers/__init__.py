"""The programs that take part, one module each; `peer` lists them by name."""
