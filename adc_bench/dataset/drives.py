"""Reading a dataset of drives: logs by drive, pictures by camera and time."""

import itertools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.drive_log import DriveLog, take_log
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.shard import open_shard
from adc_bench.errors import InputError
from adc_bench.world.scenario import Scenario


@dataclass(frozen=True, kw_only=True, eq=False)
class PictureTimes:
    """A camera's pictures of one drive, in order.

    Attributes:
        time_s: (n,) the middle of the exposure.
        arrival_time_s: (n,) when the camera delivered it.
        frame: (n,) the picture's number in `DriveDataset.frames`.
    """

    time_s: NDArray[np.float64]
    arrival_time_s: NDArray[np.float64]
    frame: NDArray[np.int64]


class DriveDataset:
    """A finished dataset of drives, read lazily. `frames` reads its pictures with their labels.

    Raises:
        InputError: as `FrameDataset`, or the dataset is one of frames.
        MachineError: as `FrameDataset`.
    """

    def __init__(self, root: Path | str) -> None:
        self.frames = FrameDataset(root)
        manifest = self.frames.manifest
        if manifest.kind != "drives":
            raise InputError(
                where=self.frames.store.path(""),
                found=f"a dataset of {manifest.kind}",
                wanted="a dataset of drives",
                todo="make one with: adc-bench render --kind drives --split NAME --out DIR",
            )
        self._starts = [0, *itertools.accumulate(entry.frames for entry in manifest.shards)]

    def __len__(self) -> int:
        return len(self.frames.manifest.shards)

    def drive(self, k: int) -> DriveLog:
        """Return the log of drive k: truth, commands, sensors, contacts.

        Raises:
            InputError: its file is damaged.
        """
        with open_shard(self.frames.store, self.frames.manifest.shards[k].file) as file:
            return take_log(file)

    def pictures(self, k: int, camera: str) -> PictureTimes:
        """Return when a camera took its pictures of drive k, and their numbers."""
        with open_shard(self.frames.store, self.frames.manifest.shards[k].file) as file:
            names = [name.decode() for name in file.attrs["cameras"]]
            rows = np.flatnonzero(file["camera_index"][:] == names.index(camera))
            time_s, arrival_time_s = file["pictures/time_s"][:], file["pictures/arrival_time_s"][:]
        return PictureTimes(time_s=time_s[rows], arrival_time_s=arrival_time_s[rows], frame=self._starts[k] + rows)

    def scenario(self, k: int) -> Scenario:
        """Return the arena of drive k, with the robot's nominal figures (`robot`) and its true ones (`robot_truth`)."""
        return self.frames.scenario(self._starts[k])
