"""A dataset's pictures, changed for training; what becomes of each depends on seed, epoch and index alone."""

import numpy as np
from numpy.typing import NDArray
from pycocotools import mask as rle

from adc_bench.detector.data import LabelledPictures
from adc_bench.detector.training.augment import AugmentConfig, augment
from adc_bench.detector.training.example import DIRECTIONS, Cutting, Example, outline
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.corners_seen import keypoints_as_seen
from adc_bench.world.frame import Label
from adc_bench.world.streams import stream


class TrainingPictures:
    """Changed pictures by epoch and index. Pictures with their truth stay in memory, up to `cache_bytes`."""

    def __init__(self, source: LabelledPictures, config: AugmentConfig, seed: int, cache_bytes: int = 2**30) -> None:
        self.source, self.config, self.seed, self.cache_bytes = source, config, seed, cache_bytes
        self.empty = [i for i in range(len(source)) if not source.annotations(i)]
        self._signs = _signs_by_category(source)
        self._cache: dict[int, Example] = {}
        self._cached_bytes = 0

    def __len__(self) -> int:
        return len(self.source)

    def changed(self, epoch: int, index: int, *, plain: bool) -> Example:
        """Return what an epoch makes of a picture; `plain` without mosaic."""
        return augment(
            self.config, self._held(index), self, stream(self.seed, "augment", epoch, index), with_mosaic=not plain
        )

    def example(self, rng: np.random.Generator, /) -> Example:
        """Return any picture."""
        return self._held(int(rng.integers(len(self))))

    def sign(self, rng: np.random.Generator, /) -> Cutting | None:
        """Return a sign of any picture, every category as likely as every other; None if there are none."""
        if not self._signs:
            return None
        of_category = self._signs[int(rng.integers(len(self._signs)))]
        index, row = of_category[int(rng.integers(len(of_category)))]
        whole = self._held(index)
        x0, y0, x1, y1 = np.rint(whole.boxes[row]).astype(int)
        keypoints, corner = whole.keypoints[row].copy(), np.array([x0, y0], np.float32)
        keypoints[:, :2] -= corner * (keypoints[:, 2:] > 0)
        return Cutting(whole.rgb[y0:y1, x0:x1], int(whole.classes[row]), whole.outlines[row] - corner, keypoints)

    def _held(self, index: int) -> Example:
        if index in self._cache:
            return self._cache[index]
        example = load_example(self.source, index)
        size = sum(part.nbytes for part in example)
        if self._cached_bytes + size <= self.cache_bytes:
            self._cache[index] = example
            self._cached_bytes += size
        return example


def load_example(source: LabelledPictures, index: int) -> Example:
    """Return a picture with its truth, as it is."""
    rgb, labels = source.picture(index), source.annotations(index)
    return Example(
        rgb,
        np.array([_outline(label, rgb) for label in labels], np.float32).reshape(-1, DIRECTIONS.shape[1], 2),
        np.array([label.category_id - 1 for label in labels], np.int64),
        np.array([label.ignore for label in labels], np.bool_),
        keypoints_as_seen(labels, towards_plus_x=source.pose_world_camera(index)[0, 2] > 0),
    )


def _outline(label: Label, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    return outline(rle.decode({"size": rgb.shape[:2], "counts": label.mask_rle}))


def _signs_by_category(source: LabelledPictures) -> list[list[tuple[int, int]]]:
    """Return, for each category that has any, its signs worth pasting: their pictures' indices, their rows there."""
    found: dict[int, list[tuple[int, int]]] = {}
    for index in range(len(source)):
        for row, label in enumerate(source.annotations(index)):
            if _worth_pasting(label):
                found.setdefault(label.category_id, []).append((index, row))
    return [found[category_id] for category_id in sorted(found)]


def _worth_pasting(label: Label) -> bool:
    """Whether a label is a sign that can be seen whole and near enough to be shrunk."""
    is_sign = CATEGORIES[label.category_id - 1].startswith(("panel_", "sign_"))
    whole = not label.ignore and label.visible_fraction > 0.95 and label.truncation < 0.05
    return is_sign and whole and label.box_px[2] - label.box_px[0] >= 16
