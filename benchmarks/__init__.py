"""Benchmarks: ratios against what people use today, all measured in one run.  `python -m benchmarks [name ...]`."""
