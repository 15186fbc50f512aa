"""What a driver gets who believes every detection above one score: what is found, what is missed, what is invented."""

from collections import Counter
from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.evaluation.matching import Matches
from adc_bench.detector.evaluation.spread import share
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID

CROSSWALK = CATEGORY_ID["crosswalk"]
CROSSWALK_RANGE_M = (0.5, 4.0)
DARKEST = "dark"
STEPS: NDArray[np.float64] = np.round(np.arange(0.05, 0.96, 0.05), 2)


class Recall(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many of the objects are found; None of none."""

    objects: int
    found: int
    recall: float | None


class OperatingPoint(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """At one threshold, over all categories.

    Attributes:
        threshold: of the score, from which on a detection is believed.
        threshold_by_rule: what `choose_threshold` says on these pictures.
        precision: share of the detections that are right (None without any), regions to ignore left out.
        recall: share of the objects found.
        empty_pictures: pictures without any label, ignore regions neither.
        invented_on_empty: the detections there, by category.
        pictures_without_crosswalk: pictures of which no pixel is a crosswalk's.
        false_crosswalks: crosswalks found there.
        crosswalk_recall: of the crosswalks 0.5 to 4 m from the camera: all, those seen from within a tunnel, and those
            under the darkest light.
    """

    threshold: float
    threshold_by_rule: float
    precision: float | None
    recall: float | None
    empty_pictures: int
    invented_on_empty: dict[str, int]
    pictures_without_crosswalk: int
    false_crosswalks: int
    crosswalk_recall: dict[str, Recall]


def operating_point(source: LabelledPictures, matches: Matches, threshold: float) -> OperatingPoint:
    """Return what a threshold leads to."""
    labels = [source.annotations(i) for i in range(len(source))]
    empty = np.array([len(of_picture) == 0 for of_picture in labels], np.bool_)
    without = pictures_without(matches, CROSSWALK)
    shown = matches.scores >= threshold
    right = int((shown & (matches.label >= 0)).sum())
    invented = Counter(CATEGORIES[k - 1] for k in matches.category_ids[shown & empty[matches.picture]].tolist())
    return OperatingPoint(
        threshold=threshold,
        threshold_by_rule=choose_threshold(matches),
        precision=share(right, right + matches.wrong(threshold).sum()),
        recall=share(right, matches.asked.sum()),
        empty_pictures=int(empty.sum()),
        invented_on_empty={name: invented[name] for name in CATEGORIES if invented[name]},
        pictures_without_crosswalk=int(without.sum()),
        false_crosswalks=int((false_scores(matches, CROSSWALK) >= threshold).sum()),
        crosswalk_recall=_crosswalk_recall(source, matches, threshold),
    )


def choose_threshold(matches: Matches) -> float:
    """Return, of the thresholds 0.05, 0.10 ... 0.95, the one with the best F1 over all categories; or, if at that one a
    crosswalk is found on a picture that shows none, the least one above at which none is: a landmark that is not there
    throws the driver off the road, one that is missed is seen again in the next picture.
    """
    f1 = np.array([_f1(matches, float(step)) for step in STEPS])
    invented = false_scores(matches, CROSSWALK).max(initial=0)
    fitting = [float(step) for step in STEPS[int(f1.argmax()) :] if step > invented]
    return fitting[0] if fitting else float(STEPS[-1])


def pictures_without(matches: Matches, category_id: int) -> NDArray[np.bool_]:
    """Return (n,) which pictures show nothing of a category, ignore regions neither."""
    showing = [
        picture
        for picture, label in zip(matches.label_picture, matches.labels, strict=True)
        if label.category_id == category_id
    ]
    without = np.ones(matches.pictures, np.bool_)
    without[np.array(showing, np.int64)] = False
    return without


def false_scores(matches: Matches, category_id: int) -> NDArray[np.float32]:
    """Return the scores of a category's detections on pictures that show nothing of it."""
    without = pictures_without(matches, category_id)
    scores: NDArray[np.float32] = matches.scores[
        (matches.category_ids == category_id) & without[matches.picture].astype(np.bool_)
    ]
    return scores


def recall_of(matches: Matches, threshold: float, rows: Sequence[bool] | NDArray[np.bool_]) -> Recall:
    """Return the recall of some labels, those to ignore left out."""
    asked = matches.asked & np.asarray(rows, np.bool_)
    found = int((asked & (matches.found_score() >= threshold)).sum())
    return Recall(objects=int(asked.sum()), found=found, recall=share(found, asked.sum()))


def _f1(matches: Matches, threshold: float) -> float:
    right = int((matches.asked & (matches.found_score() >= threshold)).sum())
    wrong, missed = int(matches.wrong(threshold).sum()), int(matches.asked.sum()) - right
    return 2 * right / max(2 * right + wrong + missed, 1)


def _crosswalk_recall(source: LabelledPictures, matches: Matches, threshold: float) -> dict[str, Recall]:
    low, high = CROSSWALK_RANGE_M
    near = np.array(
        [label.category_id == CROSSWALK and low <= label.distance_m <= high for label in matches.labels], np.bool_
    )
    conditions = [source.conditions(i) for i in range(len(source))]
    tunnel = np.array([each.in_tunnel for each in conditions], np.bool_)[matches.label_picture]
    darkest = np.array([each.light_level == DARKEST for each in conditions], np.bool_)[matches.label_picture]
    rows = {"all": near, "tunnel": near & tunnel, "darkest light": near & darkest}
    return {name: recall_of(matches, threshold, chosen) for name, chosen in rows.items()}
