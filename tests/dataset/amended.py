"""A dataset whose files were changed, and whose manifest agrees: so that only `dataset check` can tell."""

import hashlib
from collections.abc import Callable
from pathlib import Path

import h5py
import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import Manifest, to_toml
from adc_bench.world.records import load_record


def agree(folder: Path) -> None:
    """Let the manifest say of every file what it now is."""
    manifest = load_record(folder / "dataset.toml", Manifest)
    shards = tuple(_entry(folder, entry) for entry in manifest.shards)
    files = tuple(_entry(folder, entry) for entry in manifest.files)
    (folder / "dataset.toml").write_bytes(to_toml(msgspec.structs.replace(manifest, shards=shards, files=files)))


def _entry(folder, entry):
    data = (folder / entry.file).read_bytes()
    return msgspec.structs.replace(entry, size_bytes=len(data), sha256=hashlib.sha256(data).hexdigest())


def amend(folder: Path, name: str, change: Callable[[NDArray], None], shard: int = 0) -> None:
    """Change one array of a shard in place."""
    with h5py.File(folder / f"shard-{shard:05d}.h5", "r+") as file:
        values = np.array(file[name][:])
        change(values)
        file[name][...] = values
    agree(folder)
