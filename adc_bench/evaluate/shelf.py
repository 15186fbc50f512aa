"""The file of pictures: mapped by the episode loop to write, and by the submission's process to read."""

import mmap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adc_bench.evaluate.protocol import PicturePlace
from adc_bench.world.sensors import SensorRig


class WrittenShelf:
    """The loop's side: a fixed place for each camera of the rig. Close it at the end."""

    def __init__(self, path: Path, rig: SensorRig) -> None:
        self._offsets: dict[str, int] = {}
        size = 0
        for mount in rig.cameras:
            self._offsets[mount.name] = size
            size += 3 * mount.width_px * mount.height_px
        with path.open("w+b") as file:
            file.truncate(size)
            self._map = mmap.mmap(file.fileno(), size)

    def put(self, camera: str, rgb: NDArray[np.uint8]) -> int:
        """Lay down a camera's picture in place of its last one; return its offset."""
        offset = self._offsets[camera]
        self._map[offset : offset + rgb.nbytes] = rgb.tobytes()
        return offset

    def close(self) -> None:
        """Unmap the file."""
        self._map.close()


class ReadShelf:
    """The submission's side."""

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            self._map = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)

    def take(self, place: PicturePlace) -> NDArray[np.uint8]:
        """Return a picture, (height, width, 3), as a copy: its place is written again once the answer is there."""
        shape = (place.height, place.width, 3)
        size = 3 * place.height * place.width
        return np.frombuffer(self._map, dtype=np.uint8, count=size, offset=place.offset).reshape(shape).copy()
