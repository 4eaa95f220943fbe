"""Benchmarks: run time against error, stability, messages per second; with committed results."""
