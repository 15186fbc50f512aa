"""How good a detector is: average precision as COCO defines it, in all, by category, by light and in the tunnel."""

import contextlib
import io
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from adc_bench.detector.data import LabelledPictures
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Detections

SCORE_MIN = 0.01  # average precision needs the unlikely boxes too
RECALLS: NDArray[np.float64] = np.linspace(0, 1, 101)


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


class DetectionReport(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The score of all pictures, of each light level, and inside and outside the tunnel."""

    schema: str = "adc-bench/detection/1"
    overall: DetectionScore
    light: dict[str, DetectionScore]
    tunnel: dict[str, DetectionScore]


class Curve(NamedTuple):
    """Precision (101,) at `RECALLS`, at overlap 0.50."""

    precision: NDArray[np.float64]
    ap50: float


class Evaluation:
    """Truth and detections of the same pictures, in COCO's form, ready to be scored in whole or in part.

    Ignored labels are crowd regions of their category: what is found there counts neither for nor against.
    """

    def __init__(self, source: LabelledPictures, found: Sequence[Detections]) -> None:
        assert len(source) == len(found)
        self.source, self.found = source, found
        images = [{"id": int(image_id)} for image_id in source.image_ids]
        truth = [
            _annotation(image_id, label.category_id, label.box_px, iscrowd=int(label.ignore))
            for i, image_id in enumerate(source.image_ids)
            for label in source.annotations(i)
        ]
        answers = [
            _annotation(image_id, int(category), box, score=float(score))
            for image_id, answer in zip(source.image_ids, found, strict=True)
            for box, category, score in zip(answer.boxes_px, answer.category_ids, answer.scores, strict=True)
        ]
        self._truth, self._answers = _coco(images, truth), _coco(images, answers)

    def score(self, indices: Sequence[int] | None = None) -> DetectionScore:
        """Return the score of the pictures at `indices`, of all by default."""
        chosen = range(len(self.source)) if indices is None else indices
        precision, objects = self._precision(chosen), self._objects(chosen)
        categories = {
            name: CategoryScore(ap=_mean(precision[:, :, k]), ap50=_mean(precision[0, :, k]), objects=objects[name])
            for k, name in enumerate(CATEGORIES)
            if objects[name]
        }
        return DetectionScore(
            pictures=len(chosen),
            map=_mean([entry.ap for entry in categories.values()]),
            map50=_mean([entry.ap50 for entry in categories.values()]),
            categories=categories,
        )

    def report(self) -> DetectionReport:
        """Return the score of all pictures and of each circumstance that occurs."""
        groups: dict[str, dict[str, list[int]]] = {"light": {}, "tunnel": {}}
        for i in range(len(self.source)):
            conditions = self.source.conditions(i)
            groups["light"].setdefault(conditions.light_level, []).append(i)
            groups["tunnel"].setdefault("inside" if conditions.in_tunnel else "outside", []).append(i)
        parts = {
            kind: {name: self.score(members[name]) for name in sorted(members)} for kind, members in groups.items()
        }
        return DetectionReport(overall=self.score(), light=parts["light"], tunnel=parts["tunnel"])

    def curves(self) -> Mapping[str, Curve]:
        """Return the precision-recall curve of each category that has objects."""
        everything = range(len(self.source))
        precision, objects = self._precision(everything), self._objects(everything)
        return {
            name: Curve(precision[0, :, k], _mean(precision[0, :, k]))
            for k, name in enumerate(CATEGORIES)
            if objects[name]
        }

    def _precision(self, indices: Sequence[int]) -> NDArray[np.float64]:
        """Return precision (10 overlaps, 101 recalls, categories); -1 where a category has no objects."""
        with contextlib.redirect_stdout(io.StringIO()):  # pycocotools talks
            run = COCOeval(self._truth, self._answers, "bbox")
            run.params.imgIds = [int(self.source.image_ids[i]) for i in indices]
            run.evaluate()
            run.accumulate()
        precision: NDArray[np.float64] = run.eval["precision"][:, :, :, 0, -1]
        return precision

    def _objects(self, indices: Sequence[int]) -> dict[str, int]:
        counts = dict.fromkeys(CATEGORIES, 0)
        for i in indices:
            for label in self.source.annotations(i):
                counts[CATEGORIES[label.category_id - 1]] += not label.ignore
        return counts


def _annotation(image_id: int, category_id: int, box: Sequence[float], **more: float) -> dict[str, Any]:
    x0, y0, x1, y1 = (float(value) for value in box)
    size = {"bbox": [x0, y0, x1 - x0, y1 - y0], "area": (x1 - x0) * (y1 - y0)}
    return {"image_id": int(image_id), "category_id": category_id, "iscrowd": 0, **size, **more}


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


def _mean(values: Any) -> float:
    array = np.asarray(values, dtype=np.float64)
    return round(float(array.mean()), 6) if array.size else 0.0
