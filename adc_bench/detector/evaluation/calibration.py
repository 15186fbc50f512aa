"""Whether a score of 0.8 is right eight times of ten."""

import itertools

import msgspec
import numpy as np

from adc_bench.detector.evaluation.matching import Matches
from adc_bench.detector.evaluation.spread import rounded

EDGES = tuple(round(0.1 * k, 1) for k in range(1, 11))  # below 0.1 is what nobody would believe


class CalibrationBin(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The detections with scores from `low` up to `high`: how many, their mean score, the share that are right."""

    low: float
    high: float
    count: int
    mean_score: float | None
    right: float | None


class Calibration(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Bins, and the expected calibration error: the mean, over detections, of the gap between a bin's mean score and
    the share that are right (Naeini et al., "Obtaining Well Calibrated Probabilities Using Bayesian Binning", 2015).
    """

    bins: list[CalibrationBin]
    expected_error: float | None


def calibration(matches: Matches) -> Calibration:
    """Return the calibration of the detections that count, at a score of 0.1 or above."""
    scores = matches.scores[matches.counted].astype(np.float64)
    right = matches.label[matches.counted] >= 0
    places = np.minimum(np.searchsorted(EDGES, scores, side="right") - 1, len(EDGES) - 2)
    bins = []
    for k, (low, high) in enumerate(itertools.pairwise(EDGES)):
        here = places == k
        mean_score, hits = (rounded(scores[here].mean()), rounded(right[here].mean())) if here.any() else (None, None)
        bins.append(CalibrationBin(low=low, high=high, count=int(here.sum()), mean_score=mean_score, right=hits))
    total = sum(each.count for each in bins)
    gaps = [each.count * abs((each.mean_score or 0) - (each.right or 0)) for each in bins]
    return Calibration(bins=bins, expected_error=rounded(sum(gaps) / total) if total else None)
