"""adc-bench: dataset and benchmark generator for small-scale autonomous driving."""

__version__ = "0.1.0"
