"""Looking for what is wrong with a dataset, picture by picture."""

import hashlib
import json
from collections import Counter
from collections.abc import Iterator

import numpy as np

from adc_bench.dataset.layout import COCO
from adc_bench.dataset.read import FrameDataset
from adc_bench.errors import InputError
from adc_bench.world.frame import BoxPx, Label

TOLERANCE = 1e-6


def find_problems(dataset: FrameDataset) -> Iterator[str]:
    """Yield a sentence for each fault: digests, pictures, boxes, poses, and COCO against the shards."""
    for entry in dataset.manifest.shards:
        if hashlib.sha256(dataset.store.read(entry.file)).hexdigest() != entry.sha256:
            yield f"{entry.file}: other bytes than were written"
    for i in range(len(dataset)):
        try:
            yield from _frame_problems(dataset, i)
        except InputError as error:
            yield f"frame {i}: {error.found}"
    yield from _coco_problems(dataset)


def _frame_problems(dataset: FrameDataset, i: int) -> Iterator[str]:
    dataset.picture(i)
    pose = dataset.pose_world_camera(i)
    rotation = pose[:3, :3]
    if not (np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) and np.linalg.det(rotation) > 0):
        yield f"frame {i}: the camera pose is no rotation"
    if not np.isfinite(pose).all():
        yield f"frame {i}: the camera pose is not finite"
    for label in dataset.annotations(i):
        for fault in _label_faults(label, dataset.width_px, dataset.height_px, len(dataset.categories)):
            yield f"frame {i}: {label.instance}: {fault}"


def _label_faults(label: Label, width_px: int, height_px: int, categories: int) -> Iterator[str]:
    if not 1 <= label.category_id <= categories:
        yield f"category {label.category_id} is unknown"
    for name, box in (("box", label.box_px), ("amodal box", label.amodal_box_px)):
        if not _inside(box, width_px, height_px):
            yield f"the {name} {box} is empty or leaves the picture"
    for name, share in (("visible fraction", label.visible_fraction), ("truncation", label.truncation)):
        if not -TOLERANCE <= share <= 1 + TOLERANCE:
            yield f"the {name} {share} lies outside 0..1"


def _inside(box: BoxPx, width_px: int, height_px: int) -> bool:
    x0, y0, x1, y1 = box
    low, high_x, high_y = -TOLERANCE, width_px + TOLERANCE, height_px + TOLERANCE
    return low <= x0 < x1 <= high_x and low <= y0 < y1 <= high_y


def _coco_problems(dataset: FrameDataset) -> Iterator[str]:
    try:
        document = json.loads(dataset.store.read(COCO))
        images = [image["id"] for image in document["images"]]
        boxes = Counter(annotation["image_id"] for annotation in document["annotations"])
    except (ValueError, KeyError, TypeError):
        yield f"{COCO}: not the COCO file that was written"
        return
    if images != list(dataset.image_ids):
        yield f"{COCO}: its images are not the dataset's frames"
    for i in dataset.image_ids:
        labels = len(dataset.annotations(i))
        if boxes[i] != labels:
            yield f"{COCO}: {boxes[i]} annotations for frame {i}, {labels} labels"
