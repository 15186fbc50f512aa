"""Writing a dataset folder: begin it, add shards in any order, finish it."""

import hashlib
from collections import Counter
from collections.abc import Sequence

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
)
from adc_bench.dataset.read import load_manifest
from adc_bench.dataset.shard import Shard
from adc_bench.dataset.split import Split
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError
from adc_bench.world.categories import CATEGORIES


def begin(store: Store, plan: Manifest, *, overwrite: bool = False) -> None:
    """Make the folder ready for the plan's shards; shards that an earlier run of the same plan finished stay.

    Raises:
        InputError: the folder holds another run (unless `overwrite`, which deletes it) or something else, or it
            cannot be written.
    """
    if store.exists(MANIFEST) and overwrite:
        _clear(store)
    elif store.exists(MANIFEST):
        _check_same(store, load_manifest(store).plan, plan)
        return
    elif store.names():
        raise _occupied(store, "a folder with other files", "an empty or new folder")
    try:
        store.write(MANIFEST, to_toml(plan))
    except OSError as error:
        raise InputError(
            where=store.path(""), found=f"{error.strerror}", wanted="a folder to write to", todo="choose another folder"
        ) from None


def sweep(store: Store) -> None:
    """Delete what a run that was cut off had half written."""
    for name in store.names("**/*.tmp"):
        store.delete(name)


def missing_shards(store: Store, plan: Manifest) -> list[int]:
    """Return the numbers of the shards that are still to be made."""
    return [number for number in range(plan.shard_count) if not store.exists(shard_name(number))]


def finish(store: Store, plan: Manifest) -> Summary:
    """Write annotations, poses, card and at last the full `dataset.toml`, from the shards alone.

    Raises:
        InputError: a shard is missing or damaged.
    """
    shards = [Shard(store, shard_name(n), len(plan.shard_frames(n))) for n in range(plan.shard_count)]
    entries = [_entry(store, n, len(shard)) for n, shard in enumerate(shards)]
    summary = _summary(shards, sum(entry.size_bytes for entry in entries))
    manifest = msgspec.structs.replace(plan, summary=summary, shards=tuple(entries))
    store.write(COCO, coco_json(manifest, shards))
    for mount in plan.cameras:
        store.write(poses_name(mount.name), tum_lines(mount.name, shards))
    store.write(CARD, card(manifest, summary).encode())
    store.write(MANIFEST, to_toml(manifest))
    return summary


def _entry(store: Store, number: int, frames: int) -> ShardEntry:
    data = store.read(shard_name(number))
    digest = hashlib.sha256(data).hexdigest()
    return ShardEntry(file=shard_name(number), frames=frames, size_bytes=len(data), sha256=digest)


def _summary(shards: Sequence[Shard], size_bytes: int) -> Summary:
    conditions = [shard.conditions(row) for shard in shards for row in range(len(shard))]
    labels = [label for shard in shards for row in range(len(shard)) for label in shard.labels(row)]
    boxes = Counter(CATEGORIES[label.category_id - 1] for label in labels if not label.ignore)
    return Summary(
        frames=len(conditions),
        scenarios=len({condition.scenario for condition in conditions}),
        size_bytes=size_bytes,
        tunnel_frames=sum(condition.in_tunnel for condition in conditions),
        ignored=sum(label.ignore for label in labels),
        cameras=_sorted(Counter(name for shard in shards for name in shard.cameras)),
        light_levels=_sorted(Counter(condition.light_level for condition in conditions)),
        boxes={name: boxes[name] for name in CATEGORIES if boxes[name]},
    )


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))


def _clear(store: Store) -> None:
    """Delete a dataset's own files and nothing else; `dataset.toml` goes last, so that a cut here can be repeated."""
    for name in [*store.names("shard-*.h5"), *store.names("poses/*.tum"), COCO, CARD, MANIFEST]:
        store.delete(name)


def _check_same(store: Store, found: Manifest, wanted: Manifest) -> None:
    for field in msgspec.structs.fields(Manifest):
        old, new = getattr(found, field.name), getattr(wanted, field.name)
        if old != new:
            raise _occupied(store, f"a dataset of another run: {field.name} = {_brief(old)}", _brief(new))


def _brief(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(f"{mount.name} {mount.width_px}x{mount.height_px}" for mount in value)
    if isinstance(value, Split):
        return f"{value.name} (sha256 {value.sha256[:12]})"
    return str(value)


def _occupied(store: Store, found: str, wanted: str) -> InputError:
    return InputError(
        where=store.path(""),
        found=found,
        wanted=wanted,
        todo="choose another folder, or replace a dataset with --overwrite",
    )
