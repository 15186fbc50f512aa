"""The detector: a small anchor-free network that finds crosswalk and signs; the only room that knows torch."""

from adc_bench.detector.predict import Detector
from adc_bench.detector.weights import shipped_weights

__all__ = ["Detector", "shipped_weights"]
