"""How many crosswalks a detector finds on pictures that show none, by the score from which it is believed.

Usage: adc-bench render --split negatives --out build/negatives
       python benchmarks/false_crosswalks.py --data build/negatives [--weights FILE] [--pictures 2000]

Of the pictures without a single pixel of a crosswalk the first 2,000 are taken. On the others, the share of the
crosswalks 0.5 to 4 m away that are found says what the same threshold costs.
"""

import argparse
from itertools import islice
from pathlib import Path

import numpy as np

from adc_bench.dataset import FrameDataset
from adc_bench.detector import Detector, shipped_weights
from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluation.matching import Matches, match
from adc_bench.detector.evaluation.operating import CROSSWALK, CROSSWALK_RANGE_M, recall_of

THRESHOLDS = (0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--weights", type=Path, default=shipped_weights())
    parser.add_argument("--pictures", type=int, default=2000)
    options = parser.parse_args()
    source = FrameDataset(options.data)
    shown = [any(label.category_id == CROSSWALK for label in source.annotations(i)) for i in range(len(source))]
    without = list(islice((i for i, has_one in enumerate(shown) if not has_one), options.pictures))
    with_one = [i for i, has_one in enumerate(shown) if has_one]
    negatives, positives = (answers(options.weights, source, indices) for indices in (without, with_one))
    low, high = CROSSWALK_RANGE_M
    near = [label.category_id == CROSSWALK and low <= label.distance_m <= high for label in positives.labels]
    false = negatives.scores[negatives.category_ids == CROSSWALK]
    print(f"{len(without)} pictures without a crosswalk; the surest false one has {false.max(initial=0):.3f}")
    print("| believed from | false crosswalks | found of those near |\n|---|---|---|")
    for threshold in THRESHOLDS:
        recall = recall_of(positives, threshold, np.array(near))
        print(f"| {threshold:g} | {(false >= threshold).sum()} | {recall.found} of {recall.objects} |")


def answers(weights: Path, source: FrameDataset, indices: list[int]) -> Matches:
    detector = Detector.load(weights, config=DecodeConfig(score_min=min(THRESHOLDS)))
    return match([source.annotations(i) for i in indices], [detector(source.picture(i)) for i in indices])


if __name__ == "__main__":
    main()
