"""The card's picture: some pictures from all over a dataset, with their boxes."""

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import Manifest
from adc_bench.dataset.preview.sheet import draw_labels
from adc_bench.dataset.shard import Shard
from adc_bench.dataset.store import Store
from adc_bench.world.picture import decode_picture

COLUMNS, ROWS = 4, 2
JPEG_QUALITY = 85


def strip(store: Store, manifest: Manifest) -> bytes:
    """Return a JPEG of eight pictures, cameras in turn, from shards evenly spread; of each shard those with the most
    boxes. Equal shards give equal bytes.

    Raises:
        InputError: a shard is damaged.
    """
    cells = COLUMNS * ROWS
    numbers = [cell * len(manifest.shards) // cells for cell in range(cells)]
    shards = {number: Shard(store, manifest.shards[number].file, manifest.shards[number].frames) for number in numbers}
    ranked = {
        (number, mount.name): _most_boxes_first(shard, mount.name)
        for number, shard in shards.items()
        for mount in manifest.cameras
    }
    mount = manifest.cameras[0]
    canvas = np.zeros((ROWS, COLUMNS, mount.height_px, mount.width_px, 3), dtype=np.uint8)
    for cell, number in enumerate(numbers):
        rows = ranked[number, manifest.cameras[cell % len(manifest.cameras)].name]
        if rows:
            _draw(canvas[cell // COLUMNS, cell % COLUMNS], shards[number], rows.pop(0))
    sheet = canvas.swapaxes(1, 2).reshape(ROWS * mount.height_px, COLUMNS * mount.width_px, 3)
    _, data = cv2.imencode(".jpg", cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return data.tobytes()


def _most_boxes_first(shard: Shard, camera: str) -> list[int]:
    """Return the rows of a camera's pictures."""
    columns = shard.label_columns
    before = np.concatenate([[0], np.cumsum(~columns["ignore"].astype(bool))])
    boxes = np.diff(before[columns["offset"]])
    rows = [row for row, name in enumerate(shard.cameras) if name == camera]
    return sorted(rows, key=lambda row: (-int(boxes[row]), row))


def _draw(place: NDArray[np.uint8], shard: Shard, row: int) -> None:
    """Draw a picture in its place; a broken one leaves it black, for `dataset check` to tell of."""
    picture = decode_picture(shard.jpeg(row))
    if picture is not None and picture.shape == place.shape:
        place[...] = draw_labels(picture, [label for label in shard.labels(row) if not label.ignore])
