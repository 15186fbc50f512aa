"""Training pictures in batches: their order depends on seed and epoch alone, so that a run goes on in mid-epoch."""

import itertools
from collections.abc import Generator, Iterator, Sequence
from typing import NamedTuple

import torch
from torch import Tensor
from torch.utils.data import DataLoader, Dataset

from adc_bench.detector.prepare import prepare
from adc_bench.detector.training.example import Example
from adc_bench.detector.training.pictures import TrainingPictures
from adc_bench.detector.training.targets import Truth
from adc_bench.errors import AdcBenchError
from adc_bench.world.streams import stream

Key = tuple[int, list[int]]  # an epoch and indices


class Batch(NamedTuple):
    """Pictures, prepared for the network (n, 3, h, w), their truths, and their positions in the dataset."""

    pictures: Tensor
    truths: list[Truth]
    indices: list[int]


class BatchConfig(NamedTuple):
    """How pictures are shared out: `batch` at a time among `processes`, of which this is number `rank`; of those
    without an object `empty_share` in each epoch; epochs from `plain_from` on are without mosaics.
    """

    batch: int
    empty_share: float = 1.0
    plain_from: int = 0
    rank: int = 0
    processes: int = 1
    workers: int = 0


class _Refused(NamedTuple):
    """An error that came up in a worker process: exceptions themselves do not survive the way back."""

    kind: type[AdcBenchError]
    where: str
    found: str
    wanted: str
    todo: str


class _Batches(Dataset[Batch | _Refused]):
    """Batches by epoch and the indices in them, as torch's loader wants them."""

    def __init__(self, pictures: TrainingPictures, plain_from: int) -> None:
        self.pictures, self.plain_from = pictures, plain_from

    def __getitem__(self, key: Key) -> Batch | _Refused:
        epoch, indices = key
        plain = epoch >= self.plain_from
        try:
            return collate([self.pictures.changed(epoch, i, plain=plain) for i in indices], indices)
        except AdcBenchError as error:
            return _Refused(type(error), error.where, error.found, error.wanted, error.todo)


def epoch_order(pictures: TrainingPictures, config: BatchConfig, epoch: int) -> list[int]:
    """Return which pictures an epoch shows, in which order: all with an object, and a share of those without."""
    rng = stream(pictures.seed, "order", epoch)
    kept = round(config.empty_share * len(pictures.empty))
    left_out = set(rng.permutation(pictures.empty)[kept:].tolist())
    return [i for i in rng.permutation(len(pictures)).tolist() if i not in left_out]


def steps_per_epoch(pictures: TrainingPictures, config: BatchConfig) -> int:
    """Return the number of batches in an epoch, the same for each."""
    return -(-len(epoch_order(pictures, config, 0)) // config.batch)


def run_batches(
    pictures: TrainingPictures, config: BatchConfig, epochs: int, first: int = 0
) -> Generator[Batch, None, None]:
    """Yield this process' share of a run's batches from number `first` on, the same with any number of workers.

    Raises:
        InputError: a picture is damaged.
    """
    loader = DataLoader(
        _Batches(pictures, config.plain_from),
        batch_size=None,
        sampler=itertools.islice(_keys(pictures, config, epochs), first, None),
        collate_fn=_as_it_is,
        num_workers=config.workers,
    )
    for batch in loader:
        if isinstance(batch, _Refused):
            raise batch.kind(where=batch.where, found=batch.found, wanted=batch.wanted, todo=batch.todo)
        yield batch


def _keys(pictures: TrainingPictures, config: BatchConfig, epochs: int) -> Iterator[Key]:
    """Yield the epoch and this process' indices for each batch of a run.

    An epoch's last batch may be smaller; a process that would get nothing of it takes its first picture.
    """
    for epoch in range(epochs):
        order = epoch_order(pictures, config, epoch)
        for k in range(0, len(order), config.batch):
            indices = order[k : k + config.batch]
            yield epoch, indices[config.rank :: config.processes] or indices[:1]


def collate(examples: Sequence[Example], indices: list[int]) -> Batch:
    """Return examples as a batch."""
    pictures = torch.from_numpy(prepare([example.rgb for example in examples]))
    truths = [
        Truth(*(torch.from_numpy(part) for part in (e.boxes, e.classes, e.ignored, e.keypoints))) for e in examples
    ]
    return Batch(pictures, truths, indices)


def _as_it_is(batch: object) -> object:
    return batch
