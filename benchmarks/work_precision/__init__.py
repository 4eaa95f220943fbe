"""Run time against error, beside the programs that others would use.

    python -m benchmarks.work_precision [--quick] [--problem A,B] [--peers NAME,…]

`problems` says what is solved, `references` where it truly ends; `equations` is what the peers
share, `peers` the programs. `runner` runs them, `ratios` compares, `table`, `figure` and `readme`
show the result. Libraries of the peers: `benchmarks/requirements.txt`.
"""
