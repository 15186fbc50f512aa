"""`dataset stats`: what a dataset holds, as text, as a picture, as a page."""

from adc_bench.dataset.stats.collect import Statistics, statistics_of
from adc_bench.dataset.stats.page import page_of
from adc_bench.dataset.stats.picture import picture_of
from adc_bench.dataset.stats.text import headline, text_of

__all__ = ["Statistics", "headline", "page_of", "picture_of", "statistics_of", "text_of"]
