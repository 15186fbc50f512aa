"""Dataset files: what a split is, the folder's layout, writing, reading, checking and looking at it."""

from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.split import Split, load_split

__all__ = ["FrameDataset", "Split", "load_split"]
