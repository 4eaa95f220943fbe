"""What is measured: run time against error, stability, messages a second. Committed results."""
