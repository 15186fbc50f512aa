"""Random batches of pictures read from a dataset's HDF5 shards, beside a folder of the same JPEGs and the same loader.

Usage: python benchmarks/read.py [--data DIR] [--frames 1024] [--size 320x240] [--batches 32] [--repeats 9]

Without --data a dataset is rendered first. `bytes` reads files and decodes nothing; the others are torch's DataLoader
with batches of 32 decoded pictures. Shards and folder take turns, each time with other random indices; medians, and the
median of the pairs' ratios (above 1: the shards are faster). Cold: the files' pages are dropped from the cache before
each turn; names and folders stay in it, which is to the folder's advantage.
"""

import argparse
import os
import statistics
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from adc_bench.cli.render import parse_size
from adc_bench.dataset import FrameDataset, load_split
from adc_bench.generate import render_split
from adc_bench.world.picture import decode_picture

BATCH = 32
Read = Callable[[int], bytes]


class Pictures(Dataset[Tensor]):
    """Decoded pictures of whatever reads their bytes."""

    def __init__(self, read: Read, count: int) -> None:
        self._read, self._count = read, count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, i: int) -> Tensor:
        picture = decode_picture(self._read(i))
        assert picture is not None
        return torch.from_numpy(picture)


class Folder:
    """The same JPEGs, a file each."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def __call__(self, i: int) -> bytes:
        return (self._root / f"{i:06d}.jpg").read_bytes()


class Turns:
    """Batches of other indices at every turn, the same ones for both sides."""

    def __init__(self, count: int, batches: int) -> None:
        self._count, self._batches, self.turn = count, batches, 0

    def __iter__(self) -> Iterator[list[int]]:
        order = np.random.default_rng(self.turn).integers(self._count, size=(self._batches, BATCH))
        return iter(order.tolist())

    def __len__(self) -> int:
        return self._batches


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path)
    parser.add_argument("--frames", type=int, default=1024)
    parser.add_argument("--size", type=parse_size, default="320x240")
    parser.add_argument("--batches", type=int, default=32)
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as scratch:
        if options.data is None:
            options.data = Path(scratch) / "data"
            render_split(load_split("train"), options.data, count=options.frames, size_px=options.size, workers=2)
        dataset, folder = FrameDataset(options.data), Path(scratch) / "folder"
        folder.mkdir()
        for i in range(len(dataset)):
            (folder / f"{i:06d}.jpg").write_bytes(dataset.jpeg(i))
        mean_bytes = sum(path.stat().st_size for path in folder.iterdir()) / len(dataset)
        print(f"{len(dataset)} pictures of {dataset.width_px}x{dataset.height_px}, {mean_bytes:.0f} bytes each\n")
        print("| what | cache | shards pictures/s | folder pictures/s | shards / folder |")
        print("|---|---|---|---|---|")
        files = {"shards": sorted(Path(options.data).glob("*.h5")), "folder": sorted(folder.iterdir())}
        reads: dict[str, Read] = {"shards": dataset.jpeg, "folder": Folder(folder)}
        for cold in (False, True):
            for workers in (None, 0, 2):
                row = compare(reads, files, len(dataset), workers, options, cold)
                print(
                    f"| {'bytes' if workers is None else f'{workers} workers'} | {'cold' if cold else 'warm'} | {row}"
                )


def compare(
    reads: dict[str, Read],
    files: dict[str, Sequence[Path]],
    count: int,
    workers: int | None,
    options: argparse.Namespace,
    cold: bool,
) -> str:
    """Return a row of figures; the first turn of each side is not counted."""
    turns = {side: Turns(count, options.batches) for side in reads}
    runs = {side: epoch(reads[side], count, turns[side], workers) for side in reads}
    rates: dict[str, list[float]] = {side: [] for side in reads}
    for repeat in range(options.repeats + 1):
        for side in sorted(reads, reverse=bool(repeat % 2)):
            turns[side].turn = repeat
            if cold:
                drop(files[side])
            start_s = perf_counter()
            runs[side]()
            rates[side].append(options.batches * BATCH / (perf_counter() - start_s))
    kept = {side: rates[side][1:] for side in rates}
    ratio = statistics.median(a / b for a, b in zip(kept["shards"], kept["folder"], strict=True))
    medians = {side: statistics.median(values) for side, values in kept.items()}
    return f"{medians['shards']:.0f} | {medians['folder']:.0f} | {ratio:.2f} |"


def epoch(read: Read, count: int, turns: Turns, workers: int | None) -> Callable[[], None]:
    """Return what reads all batches of a turn."""
    if workers is None:
        return lambda: [read(i) for batch in turns for i in batch] and None
    loader: DataLoader[Tensor] = DataLoader(
        Pictures(read, count), batch_sampler=turns, num_workers=workers, persistent_workers=workers > 0
    )

    def run() -> None:
        for batch in loader:
            assert batch.dtype == torch.uint8

    return run


def drop(files: Sequence[Path]) -> None:
    """Forget the files' pages."""
    for path in files:
        descriptor = os.open(path, os.O_RDONLY)
        os.fsync(descriptor)  # only clean pages can be dropped
        os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
        os.close(descriptor)


if __name__ == "__main__":
    main()
