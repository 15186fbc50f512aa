"""Average precision as COCO defines it: pycocotools over all pictures, some of them, or the objects of a band."""

import contextlib
import io
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from adc_bench.detector.evaluation.spread import rounded
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Detections, Label

RECALLS: NDArray[np.float64] = np.linspace(0, 1, 101)
EVERYTHING = ((0.0, np.inf),)
Band = tuple[float, float]


class CategoryScore(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One category: average precision over overlaps 0.50 to 0.95 and at 0.50, and how many objects there were."""

    ap: float
    ap50: float
    objects: int


class DetectionScore(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Means over the categories that have objects in these pictures (0 where none has), and each of those."""

    pictures: int
    map: float
    map50: float
    categories: dict[str, CategoryScore]


class Curve(NamedTuple):
    """Precision (101,) at `RECALLS`, at overlap 0.50."""

    precision: NDArray[np.float64]
    ap50: float


class CocoScorer:
    """Truth and detections of the same pictures in COCO's form.

    Ignored labels are crowd regions of their category: what is found there counts neither for nor against. COCO scores
    a range of areas by ignoring the objects outside it; here the range may be one of any `quantity` of the objects.
    """

    def __init__(
        self,
        image_ids: Sequence[int],
        labels: Sequence[Sequence[Label]],
        found: Sequence[Detections],
    ) -> None:
        self.image_ids = [int(image_id) for image_id in image_ids]
        images = [{"id": image_id} for image_id in self.image_ids]
        truth = [
            _annotation(image_id, label.category_id, label.box_px, iscrowd=int(label.ignore))
            for image_id, of_picture in zip(self.image_ids, labels, strict=True)
            for label in of_picture
        ]
        answers = [
            _annotation(image_id, int(category), box, score=float(score))
            for image_id, answer in zip(self.image_ids, found, strict=True)
            for box, category, score in zip(answer.boxes_px, answer.category_ids, answer.scores, strict=True)
        ]
        self._truth, self._answers = _coco(images, truth), _coco(images, answers)

    def score(self, indices: Sequence[int] | None = None) -> DetectionScore:
        """Return the score of the pictures at `indices`, of all by default."""
        return self._scores(EVERYTHING, range(len(self.image_ids)) if indices is None else indices)[0]

    def score_bands(
        self, bands: Sequence[Band], truth_quantity: ArrayLike, found_quantity: ArrayLike = np.nan
    ) -> list[DetectionScore]:
        """Return a score for each band of a quantity, given for every label and every detection in their order.

        Objects outside the band are ignored, with what was found of them. A detection of nothing at all counts against
        the band that its quantity lies in, against every band if that is not known (nan).
        """
        self._measure(self._truth, truth_quantity)
        self._measure(self._answers, found_quantity)
        return self._scores(bands, range(len(self.image_ids)))

    def curves(self) -> Mapping[str, Curve]:
        """Return the precision-recall curve of each category that has objects."""
        precision, objects = self._evaluate(EVERYTHING, range(len(self.image_ids)))
        return {
            name: Curve(precision[0, :, k, 0], rounded(precision[0, :, k, 0].mean()))
            for k, name in enumerate(CATEGORIES)
            if objects[0][name]
        }

    def _scores(self, bands: Sequence[Band], indices: Sequence[int]) -> list[DetectionScore]:
        precision, objects = self._evaluate(bands, indices)
        return [_score(precision[..., k], counts, len(indices)) for k, counts in enumerate(objects)]

    def _evaluate(
        self, bands: Sequence[Band], indices: Sequence[int]
    ) -> tuple[NDArray[np.float64], list[dict[str, int]]]:
        """Return precision (10 overlaps, 101 recalls, categories, bands), -1 where a category has no objects, and the
        numbers of objects in each band.
        """
        with contextlib.redirect_stdout(io.StringIO()):  # pycocotools talks
            run = COCOeval(self._truth, self._answers, "bbox")
            run.params.imgIds = [self.image_ids[i] for i in indices]
            run.params.areaRng, run.params.areaRngLbl = [list(band) for band in bands], [str(band) for band in bands]
            run.params.maxDets = [100]
            run.evaluate()
            run.accumulate()
        chosen = set(run.params.imgIds)
        counts = [dict.fromkeys(CATEGORIES, 0) for _ in bands]
        for entry in self._truth.dataset["annotations"]:
            for count, (low, high) in zip(counts, bands, strict=True):
                asked = not entry["iscrowd"] and entry["image_id"] in chosen and low <= entry["area"] <= high
                count[CATEGORIES[entry["category_id"] - 1]] += asked
        precision: NDArray[np.float64] = run.eval["precision"][..., 0]
        return precision, counts

    @staticmethod
    def _measure(coco: COCO, quantity: ArrayLike) -> None:
        entries = coco.dataset["annotations"]
        for entry, value in zip(entries, np.broadcast_to(quantity, len(entries)), strict=True):
            entry["area"] = float(value)  # COCOeval compares it with `areaRng`, and nothing else


def _score(precision: NDArray[np.float64], objects: Mapping[str, int], pictures: int) -> DetectionScore:
    categories = {
        name: CategoryScore(
            ap=rounded(precision[:, :, k].mean()), ap50=rounded(precision[0, :, k].mean()), objects=objects[name]
        )
        for k, name in enumerate(CATEGORIES)
        if objects[name]
    }
    return DetectionScore(
        pictures=pictures,
        map=rounded(np.mean([entry.ap for entry in categories.values()] or [0.0])),
        map50=rounded(np.mean([entry.ap50 for entry in categories.values()] or [0.0])),
        categories=categories,
    )


def _annotation(image_id: int, category_id: int, box: Sequence[float], **more: float) -> dict[str, Any]:
    x0, y0, x1, y1 = (float(value) for value in box)
    size = {"bbox": [x0, y0, x1 - x0, y1 - y0], "area": 1.0}
    return {"image_id": image_id, "category_id": category_id, "iscrowd": 0, **size, **more}


def _coco(images: Sequence[Mapping[str, Any]], annotations: Sequence[Mapping[str, Any]]) -> COCO:
    coco = COCO()
    coco.dataset = {
        "images": list(images),
        "annotations": [{"id": k, **entry} for k, entry in enumerate(annotations, start=1)],
        "categories": [{"id": k, "name": name} for k, name in enumerate(CATEGORIES, start=1)],
    }
    with contextlib.redirect_stdout(io.StringIO()):
        coco.createIndex()
    return coco
