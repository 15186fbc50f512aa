"""WebDataset: `<split>-<number>.tar` for each shard of the dataset, so a drive's pictures stand in one, in order.

A sample is `<split>_<number>.jpg` as delivered and `<split>_<number>.json`: the picture's COCO record with its
conditions, `annotations` (COCO's, see `dataset/coco.py`), `lane_lines`, and the poses `pose_world_camera` (x, y, z,
quaternion x, y, z, w) and `pose_world_robot` (x, y, yaw). Equal datasets give equal tar files: no times, no owners.
"""

import io
import tarfile
from collections.abc import Iterator
from functools import partial
from typing import Any

import msgspec

from adc_bench.dataset.coco import annotation_records, image_records
from adc_bench.dataset.export.format import Format, picture_file
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.shard import Shard
from adc_bench.dataset.store import Store
from adc_bench.dataset.tum import pose_figures
from adc_bench.world.frame import LaneLine


def write(dataset: FrameDataset, split: str, out: Store) -> Iterator[int]:
    """Write the tar files; yield how many pictures are done."""
    for number, (first, shard) in enumerate(dataset.shards()):
        out.write(f"{split}-{number:06d}.tar", _tar(dataset, split, first, shard))
        yield first + len(shard)


def _tar(dataset: FrameDataset, split: str, first: int, shard: Shard) -> bytes:
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as tar:
        for i, record in enumerate(_records(dataset, split, first, shard), start=first):
            name = record["file_name"]
            _add(tar, name, dataset.jpeg(i))
            _add(tar, name.rpartition(".")[0] + ".json", msgspec.json.encode(record))
    return file.getvalue()


def _records(dataset: FrameDataset, split: str, first: int, shard: Shard) -> Iterator[dict[str, Any]]:
    size_px = dataset.width_px, dataset.height_px
    of_image: dict[int, list[dict[str, Any]]] = {first + row: [] for row in range(len(shard))}
    for annotation in annotation_records(shard, first, 1, size_px):
        of_image[annotation["image_id"]].append(annotation)
    poses = pose_figures(shard.pose_world_camera)
    for row, record in enumerate(image_records(shard, first, partial(_file_name, dataset, split, first), size_px)):
        yield {
            **record,
            "pose_world_camera": poses[row].tolist(),
            "pose_world_robot": shard.pose_world_robot[row].tolist(),
            "annotations": of_image[record["id"]],
            "lane_lines": [_line_record(line) for line in shard.lane_lines(row)],
        }


def _line_record(line: LaneLine) -> dict[str, Any]:
    arrays = {"points_px": line.points_px, "points_world": line.points_world, "visible": line.visible}
    return {"name": line.name, **{name: array.tolist() for name, array in arrays.items()}}


def _file_name(dataset: FrameDataset, split: str, first: int, row: int) -> str:
    return f"{split}_{picture_file(dataset, first + row)}"


def _add(tar: tarfile.TarFile, name: str, data: bytes) -> None:
    entry = tarfile.TarInfo(name)  # of nobody, at the epoch
    entry.size = len(data)
    tar.addfile(entry, io.BytesIO(data))


FORMAT = Format(write=write, joins=True)
