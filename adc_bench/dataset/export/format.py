"""What a format is: how a dataset is written in it. One module each makes one `Format`."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store

PICTURES_PER_BATCH = 64
ROLES = ("train", "val", "test")


def _nothing(_: Store, __: Sequence[str]) -> tuple[str, ...]:
    return ()


@dataclass(frozen=True, kw_only=True)
class Format:
    """How a dataset is written in a format.

    Attributes:
        write: write the dataset, under a split's name, into a folder; yields how many pictures are done.
        finish: write what speaks of all splits in the folder, given their names; returns what the user should know.
        splits: the names that a split may have; any if empty.
        joins: whether several splits may stand side by side in a folder.
    """

    write: Callable[[FrameDataset, str, Store], Iterator[int]]
    finish: Callable[[Store, Sequence[str]], tuple[str, ...]] = _nothing
    splits: tuple[str, ...] = ()
    joins: bool = False


def picture_file(dataset: FrameDataset, i: int) -> str:
    """Return a picture's file name: its number, six figures or more; png from cameras that lose nothing."""
    ending = "png" if dataset.manifest.cameras[0].imaging.jpeg_quality is None else "jpg"
    return f"{i:06d}.{ending}"


def write_pictures(dataset: FrameDataset, out: Store, files: Callable[[int], Mapping[str, bytes]]) -> Iterator[int]:
    """Write the small files that belong to each picture, some pictures at a time; yield how many are done."""
    for first in range(0, len(dataset), PICTURES_PER_BATCH):
        end = min(first + PICTURES_PER_BATCH, len(dataset))
        out.write_many({name: data for i in range(first, end) for name, data in files(i).items()})
        yield end
