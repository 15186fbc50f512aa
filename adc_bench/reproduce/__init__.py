"""The thesis' experiments, driven again: its tables and figures beside ours."""

from adc_bench.reproduce.run import reproduce
from adc_bench.reproduce.settings import Settings

__all__ = ["Settings", "reproduce"]
