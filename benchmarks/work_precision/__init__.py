"""Run time against error, compared with other programs for the same equations.

    python -m benchmarks.work_precision [--quick] [--problem A,B] [--peers NAME,…]

`problems` defines what is solved, and `references` the true end of it. `equations` is shared by
the peers, `peers` has the programs. `runner` runs them, `ratios` compares, `table`, `figure` and
`page` show the result. Libraries of the peers: `benchmarks/requirements.txt`.
"""
