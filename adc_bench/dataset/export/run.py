"""Exporting: the folder is claimed, written, and marked whole at last by `export.toml`.

`export.toml` names the format and the datasets inside. An export that was cut off is written again from its start, to
the same bytes, by the same command; a folder of anything else is refused.
"""

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import msgspec

from adc_bench.dataset.export import coco, kitti, tum, webdataset, yolo
from adc_bench.dataset.export.format import Format
from adc_bench.dataset.layout import MANIFEST, to_toml
from adc_bench.dataset.read import FrameDataset
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError, UsageError
from adc_bench.world.records import parse_record

MARK = "export.toml"
FormatName = Literal["coco", "yolo", "webdataset", "tum", "kitti"]
FORMATS: dict[str, Format] = {
    "coco": coco.FORMAT,
    "yolo": yolo.FORMAT,
    "webdataset": webdataset.FORMAT,
    "tum": tum.FORMAT,
    "kitti": kitti.FORMAT,
}
assert tuple(FORMATS) == get_args(FormatName)
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")


class Part(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A dataset in an export: the split's name in it, the dataset's digest and pictures, whether all is written."""

    split: str
    dataset_sha256: str
    pictures: int
    whole: bool


class Mark(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`export.toml`."""

    format: FormatName
    parts: tuple[Part, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Exported:
    """What was written: pictures, the split's name in the export, and what the user should know."""

    pictures: int
    split: str
    notes: tuple[str, ...]


def export_dataset(
    dataset: FrameDataset,
    format_name: FormatName,
    out: Path | str,
    *,
    split: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Exported:
    """Write the dataset into a folder or at an fsspec address; `split` is its name there (its own if None).

    `progress` is told how many pictures are done, and how many there are.

    Raises:
        UsageError: the format has no place for a split of this name.
        InputError: the folder holds something else or cannot be written, or the dataset is damaged.
    """
    kind, store = FORMATS[format_name], Store(out)
    name = _checked(format_name, split or dataset.manifest.split.name)
    digest = hashlib.sha256(dataset.store.read(MANIFEST)).hexdigest()
    part = Part(split=name, dataset_sha256=digest, pictures=len(dataset), whole=False)
    with store.locked():
        others = _others(store, format_name, part)
        store.sweep()
        store.write(MARK, to_toml(_mark(format_name, [*others, part])))
        for done in kind.write(dataset, name, store):
            if progress:
                progress(done, len(dataset))
        notes = kind.finish(store, [name, *(other.split for other in others if other.whole)])
        store.write(MARK, to_toml(_mark(format_name, [*others, msgspec.structs.replace(part, whole=True)])))
    return Exported(pictures=len(dataset), split=name, notes=notes)


def _checked(format_name: str, split: str) -> str:
    allowed = FORMATS[format_name].splits
    if (allowed and split not in allowed) or not NAME.fullmatch(split):
        raise UsageError(
            where=f"the split {split!r}",
            found=f"a name that {format_name} has no place for",
            wanted=f"one of {', '.join(allowed)}" if allowed else "letters, figures, - and _",
            todo=f"say what it is to be there: --as {(allowed or ('train',))[0]}",
        )
    return split


def _mark(format_name: FormatName, parts: list[Part]) -> Mark:
    return Mark(format=format_name, parts=tuple(sorted(parts, key=lambda part: part.split)))


def _others(store: Store, format_name: FormatName, part: Part) -> list[Part]:
    """Return what else the folder holds.

    Raises:
        InputError: it is not an export that this part may go into.
    """
    if not store.exists(MARK):
        if store.names():
            raise _occupied(store, "a folder with other files", "an empty or new folder")
        return []
    mark = parse_record(store.read(MARK), store.path(MARK), Mark)
    if mark.format != format_name:
        raise _occupied(store, f"an export as {mark.format}", format_name)
    for found in mark.parts:
        same = found.split == part.split
        if same and found.dataset_sha256 != part.dataset_sha256:
            raise _occupied(store, f"another dataset's export as {part.split}", "the export of this dataset")
        if not same and not FORMATS[format_name].joins:
            raise _occupied(store, f"the export of {found.split}", f"one dataset a folder as {format_name}")
    return [found for found in mark.parts if found.split != part.split]


def _occupied(store: Store, found: str, wanted: str) -> InputError:
    return InputError(where=store.path(""), found=found, wanted=wanted, todo="choose another folder")
