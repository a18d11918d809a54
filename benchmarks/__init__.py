"""Benchmarks: rates and times of this machine, as ratios within one run."""
