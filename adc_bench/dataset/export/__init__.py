"""Datasets in the formats that other tools read. `dataset/export/run.py` says what an export's folder is."""

from adc_bench.dataset.export.run import FORMATS, Exported, FormatName, export_dataset

__all__ = ["FORMATS", "Exported", "FormatName", "export_dataset"]
