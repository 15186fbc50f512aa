"""The annotations as COCO JSON, and the true camera poses in the TUM trajectory format."""

from collections.abc import Iterator, Sequence

import msgspec

from adc_bench.dataset.layout import Manifest
from adc_bench.dataset.shard import Shard
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.frame import BoxPx, Label


def coco_json(manifest: Manifest, shards: Sequence[Shard]) -> bytes:
    """Return `instances.json`. An image's id is its frame index; an ignore region has iscrowd 1.

    Beside COCO's fields an image has camera, scenario, light_level and in_tunnel; an annotation has amodal_bbox,
    visible_px, visible_fraction, truncation, distance_m and instance. `bbox` and `amodal_bbox` are x, y, width, height.
    """
    images: list[dict[str, object]] = []
    annotations: list[dict[str, object]] = []
    for number, shard in enumerate(shards):
        for row, index in enumerate(shard.frame_index.tolist()):
            images.append(_image(manifest, number, row, shard))
            labels = shard.labels(row)
            annotations += [_annotation(len(annotations) + k, index, lb) for k, lb in enumerate(labels, start=1)]
    categories = [{"id": id_, "name": name, "supercategory": name.split("_")[0]} for name, id_ in CATEGORY_ID.items()]
    document = {
        "info": {"description": f"adc-bench split {manifest.split.name}", "version": manifest.software["adc_bench"]},
        "licenses": [],
        "images": images,
        "annotations": annotations,
        "categories": categories,
    }
    return msgspec.json.encode(document)


def _image(manifest: Manifest, number: int, row: int, shard: Shard) -> dict[str, object]:
    conditions = shard.conditions(row)
    return {
        "id": int(shard.frame_index[row]),
        "file_name": f"{manifest.shards[number].file}#{row}",
        "width": manifest.cameras[0].width_px,
        "height": manifest.cameras[0].height_px,
        "camera": shard.cameras[row],
        "scenario": conditions.scenario,
        "light_level": conditions.light_level,
        "in_tunnel": conditions.in_tunnel,
    }


def _annotation(number: int, image: int, label: Label) -> dict[str, object]:
    box = _xywh(label.box_px)
    return {
        "id": number,
        "image_id": image,
        "category_id": label.category_id,
        "bbox": box,
        "area": box[2] * box[3],
        "iscrowd": int(label.ignore),
        "amodal_bbox": _xywh(label.amodal_box_px),
        "visible_px": label.visible_px,
        "visible_fraction": label.visible_fraction,
        "truncation": label.truncation,
        "distance_m": label.distance_m,
        "instance": label.instance,
    }


def _xywh(box: BoxPx) -> tuple[float, float, float, float]:
    return box[0], box[1], box[2] - box[0], box[3] - box[1]


def tum_lines(camera: str, shards: Sequence[Shard]) -> bytes:
    """Return the camera's poses in the world, a line a frame: frame index, x y z in metres, quaternion x y z w."""
    lines = ["# frame_index tx_m ty_m tz_m qx qy qz qw  (camera x right, y down, z forward, in the world)"]
    lines += _tum_rows(camera, shards)
    return ("\n".join(lines) + "\n").encode()


def _tum_rows(camera: str, shards: Sequence[Shard]) -> Iterator[str]:
    for shard in shards:
        for row, name in enumerate(shard.cameras):
            if name == camera:
                matrix = shard.pose_world_camera[row]
                numbers = Pose3(rotation=matrix[:3, :3], translation_m=matrix[:3, 3]).figures()
                yield f"{shard.frame_index[row]} " + " ".join(f"{value:.9f}" for value in numbers)
