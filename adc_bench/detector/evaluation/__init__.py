"""What a detector is worth: average precision, corners in the picture and on the floor, mistakes, calibration."""

from adc_bench.detector.evaluation.evaluation import DetectionReport, EvaluatedWeights, Evaluation
from adc_bench.detector.evaluation.score import DetectionScore

__all__ = ["DetectionReport", "DetectionScore", "EvaluatedWeights", "Evaluation"]
