"""Pictures with their truth, as batches; their order and changes depend on seed, epoch and index alone."""

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from adc_bench.detector.augment import AugmentConfig, augment
from adc_bench.detector.paste import Cutting, Example
from adc_bench.detector.prepare import prepare
from adc_bench.detector.targets import Truth
from adc_bench.geometry import Pose2
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.frame import Conditions, Label
from adc_bench.world.sensors import CameraMount
from adc_bench.world.streams import stream

Key = tuple[int, int]  # epoch, index
Batch = tuple[Tensor, list[Truth]]  # prepared pictures (n, 3, h, w)


class LabelledPictures(Protocol):
    """What the detector needs of a dataset."""

    @property
    def image_ids(self) -> Sequence[int]:
        """The pictures' ids, one each."""
        ...

    def __len__(self) -> int: ...

    def picture(self, index: int, /) -> NDArray[np.uint8]:
        """Return the picture (h, w, 3)."""
        ...

    def annotations(self, index: int, /) -> Sequence[Label]:
        """Return what is to be seen on it."""
        ...

    def conditions(self, index: int, /) -> Conditions:
        """Return how it was taken."""
        ...

    def pose_world_camera(self, index: int, /) -> NDArray[np.float64]:
        """Return where the camera was, (4, 4)."""
        ...

    def pose_world_robot(self, index: int, /) -> Pose2:
        """Return where the robot stood."""
        ...

    def mount(self, index: int, /) -> CameraMount:
        """Return the camera, as it is said to sit on the robot."""
        ...


def truth_arrays(labels: Sequence[Label]) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.bool_]]:
    """Return boxes (m, 4) xyxy px, classes (m,) counted from 0, ignored (m,)."""
    boxes = np.array([label.box_px for label in labels], dtype=np.float32).reshape(-1, 4)
    classes = np.array([label.category_id - 1 for label in labels], dtype=np.int64)
    return boxes, classes, np.array([label.ignore for label in labels], dtype=np.bool_)


def keypoints_as_seen(labels: Sequence[Label], pose_world_camera: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return keypoints (m, 4, 3): u, v px and the state, from the top left clockwise as the camera, whose pose is
    (4, 4), sees them.

    A picture of the crosswalk alone does not say from which side of the course it is seen, so that its corners are
    told by near and far, left and right: of the order (-x -y, +x -y, +x +y, -x +y), far is +x for who looks towards +x.
    """
    keypoints = np.array([label.keypoints_px for label in labels], dtype=np.float32).reshape(-1, 4, 3)
    order = [2, 1, 0, 3] if pose_world_camera[0, 2] > 0 else [0, 3, 2, 1]
    crosswalks = [label.category_id == CATEGORY_ID["crosswalk"] for label in labels]
    keypoints[crosswalks] = keypoints[crosswalks][:, order]
    return keypoints


class TrainingPictures(Dataset[Example]):
    """Changed pictures, keyed by (epoch, index). Decoded pictures stay in memory up to `cache_bytes`."""

    def __init__(self, source: LabelledPictures, config: AugmentConfig, seed: int, cache_bytes: int = 2**30) -> None:
        self.source, self.config, self.seed, self.cache_bytes = source, config, seed, cache_bytes
        self._signs = _signs_by_category(source)
        self._cache: dict[int, NDArray[np.uint8]] = {}

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, key: Key) -> Example:
        epoch, index = key
        labels = self.source.annotations(index)
        keypoints = keypoints_as_seen(labels, self.source.pose_world_camera(index))
        example = Example(self._picture(index), *truth_arrays(labels), keypoints)
        rng = stream(self.seed, "augment", epoch, index)
        count = 2 if self._signs else 0
        return augment(self.config, example, [self._cut_sign(rng) for _ in range(count)], rng)

    def _cut_sign(self, rng: np.random.Generator) -> Cutting:
        """Return a sign of another picture, every category as likely as every other."""
        of_category = self._signs[int(rng.integers(len(self._signs)))]
        index, sign = of_category[int(rng.integers(len(of_category)))]
        x0, y0, x1, y1 = (round(value) for value in sign.box_px)
        keypoints = np.array(sign.keypoints_px, np.float32)
        keypoints[:, :2] -= (x0, y0)
        return Cutting(self._picture(index)[y0:y1, x0:x1], sign.category_id - 1, keypoints)

    def _picture(self, index: int) -> NDArray[np.uint8]:
        if index in self._cache:
            return self._cache[index]
        rgb = self.source.picture(index)
        if (len(self._cache) + 1) * rgb.nbytes <= self.cache_bytes:
            self._cache[index] = rgb
        return rgb


def epoch_order(pictures: TrainingPictures, epoch: int, empty_share: float) -> list[int]:
    """Return the indices of one epoch, shuffled: every picture with an object or a region to ignore, and `empty_share`
    of the others, other ones each epoch.
    """
    rng = stream(pictures.seed, "order", epoch)
    empty = [i for i in range(len(pictures)) if not pictures.source.annotations(i)]
    left_out = set(rng.permutation(empty)[round(empty_share * len(empty)) :].tolist())
    return [int(i) for i in rng.permutation(len(pictures)) if i not in left_out]


def epoch_batches(
    pictures: TrainingPictures, *, batch: int, epoch: int, empty_share: float = 1.0, workers: int = 0
) -> Iterator[Batch]:
    """Yield one epoch's batches, the same ones with any number of worker processes; the last may be smaller."""
    order = epoch_order(pictures, epoch, empty_share)
    keys = [[(epoch, i) for i in order[k : k + batch]] for k in range(0, len(order), batch)]
    loader: DataLoader[Example] = DataLoader(
        pictures,
        batch_sampler=keys,
        collate_fn=collate,
        num_workers=workers,
    )
    yield from loader


def collate(examples: Sequence[Example]) -> Batch:
    """Return pictures, prepared for the network (n, 3, h, w), and their truths."""
    pictures = torch.from_numpy(np.stack([prepare(np.ascontiguousarray(example.rgb)) for example in examples]))
    truths = [
        Truth(*(torch.from_numpy(part) for part in (e.boxes, e.classes, e.ignored, e.keypoints))) for e in examples
    ]
    return pictures, truths


def _signs_by_category(source: LabelledPictures) -> list[list[tuple[int, Label]]]:
    """Return, for each category that has any, its signs worth pasting and the indices of their pictures."""
    found: dict[int, list[tuple[int, Label]]] = {}
    for index in range(len(source)):
        for label in source.annotations(index):
            if _worth_pasting(label):
                found.setdefault(label.category_id, []).append((index, label))
    return [found[category_id] for category_id in sorted(found)]


def _worth_pasting(label: Label) -> bool:
    """Whether a label is a sign that can be seen whole and near enough to be shrunk."""
    is_sign = CATEGORIES[label.category_id - 1].startswith(("panel_", "sign_"))
    whole = not label.ignore and label.visible_fraction > 0.95 and label.truncation < 0.05
    return is_sign and whole and label.box_px[2] - label.box_px[0] >= 16
