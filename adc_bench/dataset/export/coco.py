"""COCO: `images/<number>.jpg` as delivered, and `annotations/instances.json` with names that lie in `images/`.

The annotations are those of the dataset (see `dataset/coco.py`): boxes, masks and keypoints in one file, image ids the
pictures' numbers, regions to ignore with iscrowd 1.
"""

from collections.abc import Iterator
from functools import partial

from adc_bench.dataset.coco import CocoWriter
from adc_bench.dataset.export.format import Format, picture_file, write_pictures
from adc_bench.dataset.layout import COCO
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store


def write(dataset: FrameDataset, _: str, out: Store) -> Iterator[int]:
    """Write pictures, then annotations; yield how many are done."""
    yield from write_pictures(dataset, out, lambda i: {f"images/{picture_file(dataset, i)}": dataset.jpeg(i)})
    with out.writing(COCO) as document, out.scratch() as scratch:
        writer = CocoWriter(document, scratch, dataset.manifest)
        for first, shard in dataset.shards():
            writer.add(shard, first, partial(_file_name, dataset, first))
        writer.close()


def _file_name(dataset: FrameDataset, first: int, row: int) -> str:
    return picture_file(dataset, first + row)


FORMAT = Format(write=write)
