"""Writing a dataset folder: begin it, add shards in any order, finish it."""

import hashlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import msgspec

from adc_bench.dataset.card import card
from adc_bench.dataset.coco import coco_json, tum_lines
from adc_bench.dataset.layout import (
    CARD,
    COCO,
    MANIFEST,
    Manifest,
    ShardEntry,
    Summary,
    poses_name,
    shard_name,
    to_toml,
    write_file,
)
from adc_bench.dataset.read import load_manifest
from adc_bench.dataset.shard import Shard
from adc_bench.dataset.split import Split
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES


def begin(root: Path, plan: Manifest, *, overwrite: bool = False) -> None:
    """Make the folder ready for the plan's shards; shards that an earlier run of the same plan finished stay.

    Raises:
        InputError: the folder holds another run (unless `overwrite`, which deletes it) or something else, or it
            cannot be written.
    """
    if root.exists() and not root.is_dir():
        raise _occupied(root, "a file", "an empty or new folder")
    if (root / MANIFEST).is_file() and overwrite:
        _clear(root)
    elif (root / MANIFEST).is_file():
        _check_same(root, load_manifest(root).plan, plan)
        return
    elif root.is_dir() and any(root.iterdir()):
        raise _occupied(root, "a folder with other files", "an empty or new folder")
    try:
        write_file(root / MANIFEST, to_toml(plan))
    except OSError as error:
        raise InputError(
            where=str(root), found=f"{error.strerror}", wanted="a folder to write to", todo="choose another folder"
        ) from None


def sweep(root: Path) -> None:
    """Delete what a run that was cut off had half written."""
    for pattern in ("*.tmp", "annotations/*.tmp", "poses/*.tmp"):
        for path in root.glob(pattern):
            path.unlink()


def missing_shards(root: Path, plan: Manifest) -> list[int]:
    """Return the numbers of the shards that are still to be made."""
    return [number for number in range(plan.shard_count) if not (root / shard_name(number)).is_file()]


def finish(root: Path, plan: Manifest) -> Summary:
    """Write annotations, poses, card and at last the full `dataset.toml`, from the shards alone.

    Raises:
        InputError: a shard is missing or damaged.
    """
    shards = [Shard(root / shard_name(n), len(plan.shard_frames(n))) for n in range(plan.shard_count)]
    entries = [_entry(root, n, len(shard.records)) for n, shard in enumerate(shards)]
    summary = _summary(shards, sum(entry.size_bytes for entry in entries))
    manifest = msgspec.structs.replace(plan, summary=summary, shards=tuple(entries))
    write_file(root / COCO, coco_json(manifest, shards))
    for mount in plan.cameras:
        write_file(root / poses_name(mount.name), tum_lines(mount.name, shards))
    write_file(root / CARD, card(manifest, summary).encode())
    write_file(root / MANIFEST, to_toml(manifest))
    return summary


def _entry(root: Path, number: int, frames: int) -> ShardEntry:
    data = (root / shard_name(number)).read_bytes()
    digest = hashlib.sha256(data).hexdigest()
    return ShardEntry(file=shard_name(number), frames=frames, size_bytes=len(data), sha256=digest)


def _summary(shards: Sequence[Shard], size_bytes: int) -> Summary:
    records = [record for shard in shards for record in shard.records]
    labels = [label for record in records for label in record.labels]
    boxes = Counter(CATEGORIES[label.category_id - 1] for label in labels if not label.ignore)
    return Summary(
        frames=len(records),
        scenarios=len({record.conditions.scenario for record in records}),
        size_bytes=size_bytes,
        tunnel_frames=sum(record.conditions.in_tunnel for record in records),
        ignored=sum(label.ignore for label in labels),
        cameras=_sorted(Counter(name for shard in shards for name in shard.cameras)),
        light_levels=_sorted(Counter(record.conditions.light_level for record in records)),
        boxes={name: boxes[name] for name in CATEGORIES if boxes[name]},
    )


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))


def _clear(root: Path) -> None:
    """Delete a dataset's own files and nothing else; `dataset.toml` goes last, so that a cut here can be repeated."""
    for path in [*root.glob("shard-*.h5"), *root.glob("poses/*.tum"), root / COCO, root / CARD]:
        path.unlink(missing_ok=True)
    (root / MANIFEST).unlink()


def _check_same(root: Path, found: Manifest, wanted: Manifest) -> None:
    for field in msgspec.structs.fields(Manifest):
        old, new = getattr(found, field.name), getattr(wanted, field.name)
        if old != new:
            raise _occupied(root, f"a dataset of another run: {field.name} = {_brief(old)}", _brief(new))


def _brief(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{mount.name} {mount.width_px}x{mount.height_px}" for mount in value)
    if isinstance(value, Split):
        return f"{value.name} (sha256 {value.sha256[:12]})"
    return str(value)


def _occupied(root: Path, found: str, wanted: str) -> InputError:
    return InputError(
        where=str(root), found=found, wanted=wanted, todo="choose another folder, or replace a dataset with --overwrite"
    )
