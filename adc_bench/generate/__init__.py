"""Scenarios x renderer -> dataset: a split rendered into shards, each an idempotent task."""

from adc_bench.generate.progress import Progress
from adc_bench.generate.run import render_split

__all__ = ["Progress", "render_split"]
