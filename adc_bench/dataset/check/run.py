"""Looking for what is wrong with a dataset: shard by shard, then what holds for all of it, then against others."""

import contextlib
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import msgspec
import numpy as np

from adc_bench.dataset.check.coco import coco_faults
from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.check.fingerprints import Prints, near_pairs
from adc_bench.dataset.check.shard import ShardReport, check_shard, look_over
from adc_bench.dataset.layout import ShardEntry
from adc_bench.dataset.read import FrameDataset
from adc_bench.errors import InputError
from adc_bench.world.streams import stream

SAMPLE = 200


class Looked(msgspec.Struct, kw_only=True):
    """How much was looked at: frames, labels, and labels derived again."""

    frames: int = 0
    labels: int = 0
    derived_again: int = 0


def find_problems(
    dataset: FrameDataset,
    against: Sequence[FrameDataset] = (),
    *,
    sample: int = SAMPLE,
    looked: Looked | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Iterator[str]:
    """Yield a sentence for each problem of a dataset as it is found, with its place.

    Args:
        dataset: the dataset to be checked.
        against: others, with which it should share neither seeds nor pictures.
        sample: of so many frames, drawn at random but equally each time, the labels are derived again.
        looked: filled with how much was looked at, if given.
        progress: told shards done and shards in all.
    """
    yield from _Check(dataset, against, sample, looked or Looked()).problems(progress)


class _Check:
    def __init__(self, dataset: FrameDataset, against: Sequence[FrameDataset], sample: int, looked: Looked) -> None:
        self._dataset, self._against, self._looked = dataset, against, looked
        self._sample = _sampled_rows(dataset, sample)

    def problems(self, progress: Callable[[int, int], None]) -> Iterator[str]:
        sets = (self._dataset, *self._against)
        total, done = sum(len(dataset.manifest.shards) for dataset in sets), 0
        prints: list[Prints] = []
        seeds: list[set[int]] = []
        for dataset in sets:
            parts, own = [], set[int]()
            for entry, report in self._reports(dataset):
                if dataset is self._dataset:
                    yield from self._told(entry, report)
                parts.append(report.prints)
                own |= report.seeds
                done += 1
                progress(done, total)
            prints.append(np.concatenate(parts))
            seeds.append(own)
        yield from self._file_faults()
        yield from self._shared(prints, seeds)

    def _reports(self, dataset: FrameDataset) -> Iterator[tuple[ShardEntry, ShardReport]]:
        """Read the shards in threads: reading, decoding and digests leave Python's lock."""
        store, manifest = dataset.store, dataset.manifest
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            if dataset is self._dataset:
                reports = pool.map(partial(check_shard, store, manifest), manifest.shards, self._sample)
            else:
                reports = pool.map(partial(look_over, store, manifest), manifest.shards)
            yield from zip(manifest.shards, reports, strict=True)

    def _told(self, entry: ShardEntry, report: ShardReport) -> Iterator[str]:
        self._looked.frames += entry.frames
        self._looked.labels += report.labels
        self._looked.derived_again += report.compared
        for fault in report.faults:
            yield _sentence(entry.file, fault)

    def _file_faults(self) -> Iterator[str]:
        """Check annotations and poses: digests, and COCO against the shards (which can be read, or were told of)."""
        store = self._dataset.store
        for entry in self._dataset.manifest.files:
            if store.sha256(entry.file) != entry.sha256:
                yield f"{entry.file}: other bytes than were written"
        with contextlib.suppress(InputError):
            yield from coco_faults(self._dataset)

    def _shared(self, prints: list[Prints], seeds: list[set[int]]) -> Iterator[str]:
        """Yield what the dataset has twice (drives may stand still), or shares with one of the others."""
        if self._dataset.manifest.kind == "frames":
            for i, j in near_pairs(prints[0]):
                yield f"{self._place(i)} and {self._place(j)}: nearly the same picture"
        for other, other_prints, other_seeds in zip(self._against, prints[1:], seeds[1:], strict=True):
            root = other.store.path("")
            if both := len(seeds[0] & other_seeds):
                yield f"{root}: {both} of its scenarios have seeds of this dataset's"
            for i, j in near_pairs(prints[0], other_prints):
                yield f"{self._place(i)}: nearly the same picture as {root} frame {j}"

    def _place(self, i: int) -> str:
        return f"{self._dataset.file(i)} frame {i}"


def _sampled_rows(dataset: FrameDataset, sample: int) -> list[frozenset[int]]:
    """Return the rows of each shard whose labels are derived again: the same for the same dataset."""
    ends = np.cumsum([entry.frames for entry in dataset.manifest.shards])
    rng = stream(dataset.manifest.split.seed_first, "check")
    chosen = rng.choice(len(dataset), size=min(sample, len(dataset)), replace=False)
    number = np.searchsorted(ends, chosen, side="right")
    starts = np.concatenate([[0], ends[:-1]])
    rows: list[set[int]] = [set() for _ in ends]
    for n, i in zip(number.tolist(), chosen.tolist(), strict=True):
        rows[n].add(i - int(starts[n]))
    return [frozenset(part) for part in rows]


def _sentence(file: str, fault: Fault) -> str:
    place = file if fault.row is None else f"{file}#{fault.row}"
    return f"{place}: {fault.text}"
