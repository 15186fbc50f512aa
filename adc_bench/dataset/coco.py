"""The annotations as COCO JSON, made shard by shard.

Beside COCO's fields an image has camera, scenario, look_id, light_level, illuminance_lux, exposure, shutter_s, blur_px
and in_tunnel, of a drive also time_s, the middle of its exposure; an annotation has amodal_bbox (clipped to the
picture), amodal_bbox_whole, visible_px, visible_fraction, truncation, distance_m, instance, and the object's pose seen
from the world and from the camera (x, y, z, quaternion x, y, z, w). Boxes are x, y, width, height. An ignore region has
iscrowd 1. Pixels are rounded to 1/1000, metres, quaternions and shares to 1e-6.
"""

from collections.abc import Callable, Iterator
from typing import Any, BinaryIO

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adc_bench.dataset.layout import Manifest
from adc_bench.dataset.shard import Shard
from adc_bench.dataset.store import Writing
from adc_bench.world.categories import CATEGORY_ID

Record = dict[str, Any]
Array = NDArray[np.float64]
FileName = Callable[[int], str]
WITHOUT_KEYPOINTS = ("box", "cone")
CROSSWALK_CORNERS = ("minus_x_minus_y", "plus_x_minus_y", "plus_x_plus_y", "minus_x_plus_y")
BOARD_CORNERS = ("top_left", "top_right", "bottom_right", "bottom_left")
OUTLINE = ((1, 2), (2, 3), (3, 4), (4, 1))
PIXEL_DIGITS, DIGITS = 3, 6
COPY_BYTES = 2**20


class CocoWriter:
    """Writes `instances.json` shard by shard: memory holds one shard's records, whatever the number of frames.

    Images go to `out` at once, annotations wait in `scratch`, a file to write and read again, until `close`.
    """

    def __init__(self, out: Writing, scratch: BinaryIO, manifest: Manifest) -> None:
        self._out, self._scratch = out, scratch
        self._size_px = manifest.cameras[0].width_px, manifest.cameras[0].height_px
        self._images = self._annotations = 0
        info = {
            "description": f"adc-bench split {manifest.split.name}",
            "version": manifest.software["adc_bench"],
        }
        out.write(b'{"info":' + msgspec.json.encode(info) + b',"licenses":[],"categories":')
        out.write(msgspec.json.encode(categories()) + b',"images":[')

    def add(self, shard: Shard, first: int, file_name: FileName) -> None:
        """Add a shard whose first picture has the id `first`; `file_name(row)` names its pictures."""
        images = [msgspec.json.encode(image) for image in image_records(shard, first, file_name, self._size_px)]
        records = annotation_records(shard, first, self._annotations + 1, self._size_px)
        annotations = [msgspec.json.encode(record) for record in records]
        self._out.write(_listed(images, self._images))
        self._scratch.write(_listed(annotations, self._annotations))
        self._images += len(images)
        self._annotations += len(annotations)

    def close(self) -> None:
        """Write what is left."""
        self._out.write(b'],"annotations":[')
        self._scratch.seek(0)
        while piece := self._scratch.read(COPY_BYTES):
            self._out.write(piece)
        self._out.write(b"]}\n")


def categories() -> list[Record]:
    """Return COCO's list of categories; those with corners have keypoints and a skeleton."""
    return [
        {"id": id_, "name": name, "supercategory": name.split("_")[0], **_skeleton(name)}
        for name, id_ in CATEGORY_ID.items()
    ]


def _skeleton(name: str) -> Record:
    if name in WITHOUT_KEYPOINTS:
        return {}
    return {"keypoints": CROSSWALK_CORNERS if name == "crosswalk" else BOARD_CORNERS, "skeleton": OUTLINE}


def image_records(shard: Shard, first: int, file_name: FileName, size_px: tuple[int, int]) -> Iterator[Record]:
    """Yield the image record of each picture in a shard; ids count from `first`."""
    for row, camera in enumerate(shard.cameras):
        yield {
            "id": first + row,
            "file_name": file_name(row),
            "width": size_px[0],
            "height": size_px[1],
            "camera": camera,
            **({} if shard.picture_time_s is None else {"time_s": float(shard.picture_time_s[row])}),
            **msgspec.to_builtins(shard.conditions(row)),
        }


def annotation_records(shard: Shard, first: int, number: int, size_px: tuple[int, int]) -> Iterator[Record]:
    """Yield the record of each label in a shard; image ids count from `first`, annotation ids from `number`."""
    columns = shard.label_columns
    rows = np.repeat(np.arange(len(shard)), np.diff(columns["offset"]))
    width_px, height_px = size_px
    fields = {
        "image_id": first + rows,
        "category_id": columns["category_id"],
        "bbox": _xywh(columns["box_px"]),
        "area": columns["visible_px"],
        "iscrowd": columns["ignore"].astype(int),
        "keypoints": _keypoints(columns["keypoints_px"]),
        "num_keypoints": np.count_nonzero(columns["keypoints_px"][:, :, 2], axis=1),
        "amodal_bbox": _xywh(columns["amodal_box_px"]),
        "amodal_bbox_whole": _xywh(columns["amodal_box_whole_px"]),
        "visible_px": columns["visible_px"],
        "visible_fraction": columns["visible_fraction"].round(DIGITS),
        "truncation": columns["truncation"].round(DIGITS),
        "distance_m": columns["distance_m"].round(DIGITS),
        "pose_world_object": columns["pose_world_object"].round(DIGITS),
        "pose_camera_object": _from_camera(shard.pose_world_camera[rows], columns["pose_world_object"]).round(DIGITS),
        "instance": columns["instance"].astype(str),
    }
    for k, values in enumerate(zip(*(values.tolist() for values in fields.values()), strict=True)):
        mask = {"size": (height_px, width_px), "counts": columns["mask_rle"][k].decode()}
        yield {"id": number + k, **dict(zip(fields, values, strict=True)), "segmentation": mask}


def _listed(records: list[bytes], before: int) -> bytes:
    """Return records as the next part of a JSON list that already has `before` of them."""
    return (b",\n" if before and records else b"") + b",\n".join(records)


def _xywh(boxes: Array) -> Array:
    xywh: Array = np.hstack([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]]).round(PIXEL_DIGITS) + 0.0
    return xywh


def _keypoints(keypoints: Array) -> NDArray[np.object_]:
    """Return COCO's triplets u, v, visibility (n, 12), the last a whole number; 0, 0, 0 for those outside."""
    triplets = np.where(keypoints[:, :, 2:] > 0, keypoints, 0.0).round(PIXEL_DIGITS).astype(object)
    triplets[:, :, 2] = keypoints[:, :, 2].astype(int)
    flat: NDArray[np.object_] = triplets.reshape(-1, 12)
    return flat


def _from_camera(pose_world_camera: Array, pose_world_object: Array) -> Array:
    """Return object poses (n, 7) as seen from cameras (n, 4, 4)."""
    if not len(pose_world_object):
        return np.zeros((0, 7))
    camera_world = Rotation.from_matrix(pose_world_camera[:, :3, :3]).inv()
    position = camera_world.apply(pose_world_object[:, :3] - pose_world_camera[:, :3, 3])
    rotation = camera_world * Rotation.from_quat(pose_world_object[:, 3:])
    figures: Array = np.hstack([position, rotation.as_quat(canonical=True)])
    return figures
