"""Labels, conditions and lane lines as columns of HDF5 groups, so that any reader of HDF5 gets plain arrays.

What varies in number is laid end to end, with an `offset` that says where each frame's (or line's) part begins:
frame k has the rows `offset[k]:offset[k + 1]`.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from adc_bench.world.frame import Conditions, Label, LaneLine

Columns = Mapping[str, NDArray[Any]]
ROWS_PER_CHUNK = 4096
COMPRESSED_FROM_BYTES = 4096

LABEL_COLUMNS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    "category_id": ("<i4", ()),
    "instance": ("S", ()),
    "box_px": ("<f8", (4,)),
    "amodal_box_px": ("<f8", (4,)),
    "amodal_box_whole_px": ("<f8", (4,)),
    "visible_px": ("<i4", ()),
    "visible_fraction": ("<f8", ()),
    "truncation": ("<f8", ()),
    "distance_m": ("<f8", ()),
    "pose_world_object": ("<f8", (7,)),
    "keypoints_px": ("<f8", (4, 3)),
    "ignore": ("?", ()),
}
CONDITION_COLUMNS: Mapping[str, tuple[str, tuple[int, ...]]] = {
    "scenario": ("S", ()),
    "look_id": ("S", ()),
    "light_level": ("S", ()),
    "illuminance_lux": ("<f8", ()),
    "exposure": ("<f8", ()),
    "shutter_s": ("<f8", ()),
    "blur_px": ("<f8", ()),
    "in_tunnel": ("?", ()),
}


def put_array(group: h5py.Group, name: str, values: NDArray[Any]) -> None:
    """Write an array in compressed chunks of whole rows; a small one as it is, which is read in half the time."""
    if values.nbytes > COMPRESSED_FROM_BYTES:
        chunk = (min(len(values), ROWS_PER_CHUNK), *values.shape[1:])
        group.create_dataset(name, data=values, chunks=chunk, compression="gzip", compression_opts=1, shuffle=True)
    else:
        group.create_dataset(name, data=values)


def put_blobs(group: h5py.Group, name: str, blobs: Sequence[bytes]) -> None:
    """Write pieces of bytes end to end as `name`, with `name`_offset (n + 1)."""
    group[name] = np.frombuffer(b"".join(blobs), dtype=np.uint8)
    group[f"{name}_offset"] = offsets([len(blob) for blob in blobs])


def take_blobs(group: h5py.Group, name: str) -> list[bytes]:
    """Return what `put_blobs` wrote."""
    data, offset = group[name][:].tobytes(), group[f"{name}_offset"][:]
    return [data[start:end] for start, end in itertools.pairwise(offset)]


def offsets(counts: Sequence[int]) -> NDArray[np.int64]:
    """Return where each part begins and the last one ends, (n + 1,)."""
    return np.cumsum([0, *counts], dtype=np.int64)


def put_conditions(group: h5py.Group, conditions: Sequence[Conditions]) -> None:
    """Write a column for each field, one row a frame."""
    for name, kind in CONDITION_COLUMNS.items():
        put_array(group, name, _column([getattr(row, name) for row in conditions], *kind))


def take_conditions(group: h5py.Group) -> Columns:
    """Return the columns."""
    return {name: group[name][:] for name in CONDITION_COLUMNS}


def conditions_at(columns: Columns, row: int) -> Conditions:
    """Return one frame's conditions."""
    return Conditions(**{name: _plain(columns[name][row]) for name in CONDITION_COLUMNS})


def put_labels(group: h5py.Group, labels: Sequence[Sequence[Label]]) -> None:
    """Write the labels of each frame: `offset`, a column for each field, and the masks."""
    flat = [label for of_frame in labels for label in of_frame]
    group["offset"] = offsets([len(of_frame) for of_frame in labels])
    for name, kind in LABEL_COLUMNS.items():
        put_array(group, name, _column([getattr(label, name) for label in flat], *kind))
    put_blobs(group, "mask_rle", [label.mask_rle for label in flat])


def take_labels(group: h5py.Group) -> Columns:
    """Return the columns, masks as an array of bytes objects."""
    columns = {name: group[name][:] for name in ("offset", *LABEL_COLUMNS)}
    masks = np.empty(len(columns["category_id"]), dtype=object)
    masks[:] = take_blobs(group, "mask_rle")
    return {**columns, "mask_rle": masks}


def labels_at(columns: Columns, row: int) -> tuple[Label, ...]:
    """Return one frame's labels."""
    start, end = columns["offset"][row : row + 2]
    names = (*LABEL_COLUMNS, "mask_rle")
    return tuple(Label(**{name: _field(name, columns[name][k]) for name in names}) for k in range(start, end))


def put_lane_lines(group: h5py.Group, lines: Sequence[Sequence[LaneLine]]) -> None:
    """Write the lane lines of each frame: `offset` and `name` of the lines, `point_offset` and the points' columns."""
    flat = [line for of_frame in lines for line in of_frame]
    group["offset"] = offsets([len(of_frame) for of_frame in lines])
    group["point_offset"] = offsets([len(line.visible) for line in flat])
    put_array(group, "name", _column([line.name for line in flat], "S", ()))
    put_array(group, "points_px", _joined([line.points_px for line in flat], "<f4", (2,)))
    put_array(group, "points_world", _joined([line.points_world for line in flat], "<f4", (2,)))
    put_array(group, "visible", _joined([line.visible for line in flat], "?", ()))


def take_lane_lines(group: h5py.Group) -> Columns:
    """Return the columns."""
    return {name: group[name][:] for name in ("offset", "point_offset", "name", "points_px", "points_world", "visible")}


def lane_lines_at(columns: Columns, row: int) -> tuple[LaneLine, ...]:
    """Return one frame's lane lines."""
    first, last = columns["offset"][row : row + 2]
    found = []
    for k in range(first, last):
        part = slice(*columns["point_offset"][k : k + 2])
        found.append(
            LaneLine(
                name=columns["name"][k].decode(),
                points_px=columns["points_px"][part],
                points_world=columns["points_world"][part],
                visible=columns["visible"][part],
            )
        )
    return tuple(found)


def _column(values: Sequence[Any], kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    if kind == "S":
        texts = [value.encode() for value in values]
        return np.array(texts, dtype=f"S{max(map(len, texts), default=1)}")
    return np.array(values, dtype=kind).reshape(-1, *shape)


def _joined(parts: Sequence[NDArray[Any]], kind: str, shape: tuple[int, ...]) -> NDArray[Any]:
    return np.concatenate([np.zeros((0, *shape), dtype=kind), *parts]).astype(kind)


def _field(name: str, value: Any) -> Any:
    if name == "keypoints_px":
        return tuple((float(u), float(v), int(seen)) for u, v, seen in value)
    return _plain(value)


def _plain(value: Any) -> Any:
    """Return a cell as the record's own type."""
    if isinstance(value, bytes):
        return value.decode() if isinstance(value, np.bytes_) else value
    if isinstance(value, np.ndarray):
        return tuple(value.tolist())
    return value.item()
