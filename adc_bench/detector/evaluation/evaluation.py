"""All that is measured of a detector on labelled pictures, as one record."""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial

import msgspec
import numpy as np

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluation.calibration import Calibration, calibration
from adc_bench.detector.evaluation.circumstances import Bands, bands_of, box_side_px, groups_of
from adc_bench.detector.evaluation.corners import CornerScore, FoundCorners, corner_scores, crosswalks, found_corners
from adc_bench.detector.evaluation.floor import FloorErrors, FloorScore, floor_errors, floor_scores
from adc_bench.detector.evaluation.matching import Matches, match
from adc_bench.detector.evaluation.operating import OperatingPoint, Recall, operating_point, recall_of
from adc_bench.detector.evaluation.score import CocoScorer, Curve, DetectionScore
from adc_bench.world.frame import Detections

THRESHOLD = DecodeConfig().score_min  # what the driver believes


class CircumstanceScore(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Average precision, and the recall at the operating threshold."""

    score: DetectionScore
    recall: Recall


Parts = dict[str, CircumstanceScore]


class DetectionReport(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The score of all pictures, that of each circumstance (`circumstances.py`), what the operating threshold leads to,
    the corners of crosswalks, panels and signs in the picture, those of the crosswalk on the floor, by range, and the
    calibration of the scores.
    """

    schema: str = "adc-bench/detection/2"
    overall: DetectionScore
    circumstances: dict[str, Parts]
    operating: OperatingPoint
    corners: dict[str, CornerScore]
    floor: dict[str, FloorScore]
    calibration: Calibration


class EvaluatedWeights(DetectionReport, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What `evaluate detector` writes: the report, and of what it is, as digests of the weights file, of the dataset's
    split and of its shards.
    """

    weights_sha256: str
    split: str
    split_sha256: str
    shards_sha256: str


class Evaluation:
    """Truth and detections (decoded `TO_BE_SCORED`) of the same pictures, and what is measured of them."""

    def __init__(self, source: LabelledPictures, found: Sequence[Detections], threshold: float = THRESHOLD) -> None:
        assert len(source) == len(found)
        self.source, self.found, self.threshold = source, found, threshold
        self._labels = [source.annotations(i) for i in range(len(source))]
        self._scorer = CocoScorer(source.image_ids, self._labels, found)

    @cached_property
    def matches(self) -> Matches:
        """Which detection is of which object."""
        return match(self._labels, self.found)

    @cached_property
    def corners(self) -> FoundCorners:
        """The corners of the objects found at the threshold."""
        return found_corners(self.source, self.matches, self.threshold)

    @cached_property
    def floor(self) -> FloorErrors:
        """The errors of the crosswalk's corners on the floor."""
        return floor_errors(self.source, self.matches, crosswalks(self.matches, self.corners))

    def score(self) -> DetectionScore:
        """Return the score of all pictures."""
        return self._scorer.score()

    def curves(self) -> Mapping[str, Curve]:
        """Return the precision-recall curve of each category that has objects."""
        return self._scorer.curves()

    def report(self, told: Callable[[int], None] = lambda done: None) -> DetectionReport:
        """Return all that is measured; `told` hears how many of the `CIRCUMSTANCES` are done."""
        circumstances = {}
        for done, (kind, score) in enumerate(self._by_circumstance().items(), start=1):
            circumstances[kind] = score()
            told(done)
        return DetectionReport(
            overall=self.score(),
            circumstances=circumstances,
            operating=operating_point(self.source, self.matches, self.threshold),
            corners=corner_scores(self.matches, self.corners),
            floor=floor_scores(self.floor),
            calibration=calibration(self.matches),
        )

    def _by_circumstance(self) -> dict[str, Callable[[], Parts]]:
        groups, bands = groups_of(self.source), bands_of(self.source.mount(0).width_px)
        of_pictures = {kind: partial(self._in_groups, members) for kind, members in groups.items()}
        of_objects = {kind: partial(self._in_bands, kind, of_kind) for kind, of_kind in bands.items()}
        return {**of_pictures, **of_objects}

    def _in_groups(self, members: Mapping[str, Sequence[int]]) -> Parts:
        return {
            name: CircumstanceScore(
                score=self._scorer.score(indices),
                recall=recall_of(self.matches, self.threshold, np.isin(self.matches.label_picture, indices)),
            )
            for name, indices in members.items()
        }

    def _in_bands(self, kind: str, bands: Bands) -> Parts:
        of_label = np.array([bands.of_label(label) for label in self.matches.labels])
        of_found = np.array([box_side_px(box) for box in self.matches.boxes_px]) if kind == "size" else np.nan
        scores = self._scorer.score_bands(bands.bands, of_label, of_found)
        return {
            name: CircumstanceScore(
                score=score,
                recall=recall_of(self.matches, self.threshold, (low <= of_label) & (of_label <= high)),
            )
            for name, (low, high), score in zip(bands.names, bands.bands, scores, strict=True)
            if any(entry.objects for entry in score.categories.values())
        }
