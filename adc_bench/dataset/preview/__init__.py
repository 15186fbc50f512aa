"""`dataset preview`: a contact sheet, and a page to leaf through."""

from adc_bench.dataset.preview.page import FRAMES, page_of
from adc_bench.dataset.preview.sheet import contact_sheet

__all__ = ["FRAMES", "contact_sheet", "page_of"]
