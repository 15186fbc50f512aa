"""One shard: its bytes, its pictures, its labels and poses."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from adc_bench.dataset.check.columns import label_faults
from adc_bench.dataset.check.drives import drive_faults
from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.check.fingerprints import WORDS, Prints, fingerprint
from adc_bench.dataset.check.poses import pose_faults
from adc_bench.dataset.check.rederive import Rederivation
from adc_bench.dataset.drive_log import take_log
from adc_bench.dataset.layout import Manifest, ShardEntry
from adc_bench.dataset.shard import Shard, open_shard
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError
from adc_bench.world.picture import decode_picture


@dataclass(kw_only=True)
class ShardReport:
    """What was found in a shard: faults, the pictures' fingerprints (n, 4), the seeds of its scenarios, and how many
    labels there are and how many were derived again.
    """

    faults: list[Fault] = field(default_factory=list)
    prints: Prints = field(default_factory=lambda: np.zeros((0, WORDS), dtype=np.uint64))
    seeds: set[int] = field(default_factory=set)
    labels: int = 0
    compared: int = 0


def check_shard(store: Store, manifest: Manifest, entry: ShardEntry, sample: frozenset[int]) -> ShardReport:
    """Return what is wrong with a shard; the labels of the rows in `sample` are derived again."""
    report = ShardReport()
    if store.sha256(entry.file) != entry.sha256:
        report.faults.append(Fault(None, "other bytes than were written"))
    try:
        shard = Shard(store, entry.file, entry.frames)
        report.seeds = {scenario.seed for scenario in shard.scenarios.values()}
        report.labels = len(shard.label_columns["category_id"])
        report.faults += _inside_faults(shard, manifest)
        report.prints = _look_at_pictures(shard, manifest, report.faults)
        if manifest.kind == "drives":
            with open_shard(store, entry.file) as file:
                report.faults += drive_faults(take_log(file), shard)
        again = Rederivation(shard, moving=manifest.kind == "drives")
        report.faults += [fault for row in sorted(sample) for fault in again.faults(row)]
        report.compared = again.compared
    except InputError as error:
        report.faults.append(Fault(None, error.found))
    return report


def look_over(store: Store, manifest: Manifest, entry: ShardEntry) -> ShardReport:
    """Return a shard's fingerprints and seeds alone.

    Raises:
        InputError: it cannot be read.
    """
    shard, report = Shard(store, entry.file, entry.frames), ShardReport()
    report.prints = _look_at_pictures(shard, manifest, report.faults)
    report.seeds = {scenario.seed for scenario in shard.scenarios.values()}
    return report


def _inside_faults(shard: Shard, manifest: Manifest) -> Iterator[Fault]:
    mount = manifest.cameras[0]
    yield from label_faults(shard.label_columns, (mount.width_px, mount.height_px))
    yield from pose_faults(shard, manifest.kind)


def _look_at_pictures(shard: Shard, manifest: Manifest, faults: list[Fault]) -> Prints:
    """Decode every picture; return the fingerprints, zeros for what is no picture."""
    mount = manifest.cameras[0]
    prints = np.zeros((len(shard), WORDS), dtype=np.uint64)
    for row in range(len(shard)):
        picture = decode_picture(shard.jpeg(row))
        if picture is None:
            faults.append(Fault(row, "its picture cannot be decoded"))
        elif picture.shape != (mount.height_px, mount.width_px, 3):
            faults.append(Fault(row, f"its picture is {picture.shape[1]}x{picture.shape[0]}"))
        else:
            prints[row] = fingerprint(picture)
    return prints
