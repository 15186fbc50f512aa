"""`dataset check`: everything that can be found wrong with a dataset by reading it."""

from adc_bench.dataset.check.run import SAMPLE, Looked, find_problems

__all__ = ["SAMPLE", "Looked", "find_problems"]
