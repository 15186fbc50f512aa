"""Trajectories in the TUM format: the dataset's own files, `<camera>.tum` of frames or `drive-<number>.tum` of drives.

A line is time, x y z in metres and the quaternion x y z w; of frames, which are independent pictures, the frame's
number stands in place of time.
"""

from collections.abc import Iterator

from adc_bench.dataset.export.format import Format
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store


def trajectories(dataset: FrameDataset) -> Iterator[tuple[str, bytes]]:
    """Yield the name and the TUM file of each trajectory that holds any pose."""
    for file in dataset.store.names("poses/*.tum"):
        data = dataset.store.read(file)
        if any(not line.startswith(b"#") for line in data.splitlines()):
            yield file.removeprefix("poses/").removesuffix(".tum"), data


def write(dataset: FrameDataset, _: str, out: Store) -> Iterator[int]:
    """Write a file for each trajectory."""
    for name, data in trajectories(dataset):
        out.write(f"{name}.tum", data)
    yield len(dataset)


FORMAT = Format(write=write)
