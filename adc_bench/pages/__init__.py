"""Pages that need nothing beside themselves, with tables and figures; `drawing` makes the figures."""

from adc_bench.pages.page import data_url, figure, filled, grid, report, table

__all__ = ["data_url", "figure", "filled", "grid", "report", "table"]
