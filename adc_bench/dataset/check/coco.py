"""`annotations/instances.json` against the shards, record by record: memory does not grow with the dataset."""

import itertools
from collections import Counter
from collections.abc import Iterator
from typing import BinaryIO

import msgspec
import numpy as np

from adc_bench.dataset.columns import Columns
from adc_bench.dataset.layout import COCO
from adc_bench.dataset.read import FrameDataset

IMAGES, ANNOTATIONS, END = b'"images":[', b'],"annotations":[', b"]}"
NEAR_PX = 1e-3  # the file's own rounding


class _Image(msgspec.Struct, frozen=True):
    id: int


class _Annotation(msgspec.Struct, frozen=True):
    image_id: int
    category_id: int
    bbox: tuple[float, float, float, float]


def coco_faults(dataset: FrameDataset) -> Iterator[str]:
    """Yield where the COCO file differs from the shards: its images, and each one's categories and boxes.

    Raises:
        InputError: a shard cannot be read.
    """
    if not dataset.store.exists(COCO):
        return  # a dataset of drives has none
    try:
        with dataset.store.open(COCO) as stream:
            yield from _differences(dataset, stream)
    except (msgspec.MsgspecError, ValueError) as error:
        yield f"{COCO}: not the COCO file that was written: {error}"


def _differences(dataset: FrameDataset, stream: BinaryIO) -> Iterator[str]:
    records = _records(stream)
    ids = (msgspec.json.decode(text, type=_Image).id for text in itertools.takewhile(bool, records))
    if any(found != wanted for found, wanted in itertools.zip_longest(ids, dataset.image_ids)):
        yield f"{COCO}: its images are not the dataset's frames"
        return
    annotations = (msgspec.json.decode(text, type=_Annotation) for text in records)
    waiting = next(annotations, None)
    for start, shard in dataset.shards():
        part: list[_Annotation] = []
        while waiting is not None and waiting.image_id < start + len(shard):
            part.append(waiting)
            waiting = next(annotations, None)
        yield from _shard_differences(start, shard.label_columns, part)
    if waiting is not None:
        yield f"{COCO}: annotations of an image {waiting.image_id} that is none of the dataset's"


def _records(stream: BinaryIO) -> Iterator[bytes]:
    """Yield the images' records, nothing (b""), and the annotations' records: each begins a line of its own."""
    _, found, line = stream.readline().partition(IMAGES)
    if not found:
        raise ValueError("no list of images in its first line")
    rest = itertools.chain([line], stream)
    for line in rest:
        image, found, annotation = line.rstrip(b",\n").partition(ANNOTATIONS)
        yield from [image] if image else []
        if found:
            break
    else:
        raise ValueError("no list of annotations")
    yield b""
    for line in itertools.chain([annotation], rest):
        record = line.rstrip(b",\n")
        yield from [part] if (part := record.removesuffix(END)) else []
        if part != record:
            return
    raise ValueError("cut off")


def _shard_differences(start: int, columns: Columns, part: list[_Annotation]) -> Iterator[str]:
    counts = np.diff(columns["offset"])
    found = Counter(annotation.image_id for annotation in part)
    wrong = [row for row, count in enumerate(counts.tolist()) if found[start + row] != count]
    for row in wrong:
        yield f"{COCO}: {found[start + row]} annotations for frame {start + row}, {counts[row]} labels in its shard"
    if wrong or not part:
        return
    box = columns["box_px"]
    labels = np.column_stack([columns["category_id"], box[:, :2], box[:, 2:] - box[:, :2]])
    table = np.array([(annotation.category_id, *annotation.bbox) for annotation in part])
    rows = np.repeat(np.arange(len(counts)), counts)
    for row in dict.fromkeys(rows[~(np.abs(table - labels) <= NEAR_PX).all(axis=1)].tolist()):
        yield f"{COCO}: frame {start + row}: other categories or boxes than in its shard"
