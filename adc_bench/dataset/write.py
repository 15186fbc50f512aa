"""Writing a dataset folder: begin it, add shards in any order, finish it."""

from contextlib import ExitStack

import msgspec

from adc_bench.dataset.card import card
from adc_bench.dataset.coco import CocoWriter
from adc_bench.dataset.layout import (
    CARD,
    CARD_PICTURE,
    COCO,
    MANIFEST,
    RECEIPTS,
    FileEntry,
    Manifest,
    Summary,
    drive_poses_name,
    poses_name,
    shard_name,
    to_toml,
)
from adc_bench.dataset.preview.strip import strip
from adc_bench.dataset.read import load_manifest
from adc_bench.dataset.receipts import finished_shards, is_whole
from adc_bench.dataset.shard import Shard, damaged
from adc_bench.dataset.split import Split
from adc_bench.dataset.store import Store, Writing
from adc_bench.dataset.tally import Tally
from adc_bench.dataset.tum import CAMERA_HEADER, camera_rows, drive_text
from adc_bench.errors import InputError
from adc_bench.world.sensors import CameraMount


def begin(store: Store, plan: Manifest, *, overwrite: bool = False) -> None:
    """Make the folder ready for the plan's shards; shards that an earlier run of the same plan finished stay.

    Raises:
        InputError: the folder holds another run (unless `overwrite`, which deletes it) or something else, its
            `dataset.toml` is broken.
        MachineError: the disk is full, writing is forbidden, or an object store does not answer.
    """
    if store.exists(MANIFEST) and overwrite:
        _clear(store)
    elif store.exists(MANIFEST):
        _check_same(store, load_manifest(store).plan, plan)
        return
    elif not store.is_empty():
        raise _occupied(store, "a folder with other files", "an empty or new folder")
    store.write(MANIFEST, to_toml(plan))


def sweep(store: Store) -> None:
    """Delete what a run that was cut off had half written."""
    store.sweep()


def missing_shards(store: Store, plan: Manifest) -> list[int]:
    """Return the numbers of the shards that are still to be made, or to be made again (see `receipts.py`)."""
    found = finished_shards(store, plan, load_manifest(store))
    # Reading all from an object store would cost more than its own checks of what it keeps.
    kept = {number for number, entry in found.items() if not store.is_local or is_whole(store, entry)}
    return [number for number in range(plan.shard_count) if number not in kept]


def finish(store: Store, plan: Manifest) -> Summary:
    """Write annotations, poses, card and at last the full `dataset.toml`, from the shards alone; return the counts.

    Memory holds one shard at a time. A dataset that is finished already, and whole, is left as it is.

    Raises:
        InputError: a shard is missing or damaged.
        MachineError: the disk is full, writing is forbidden, or an object store does not answer.
    """
    stored = load_manifest(store)
    found = finished_shards(store, plan, stored)
    for number in range(plan.shard_count):
        if number not in found:
            raise damaged(store.path(shard_name(number)), "no such file, or not as it was written")
    shards = tuple(found[number] for number in range(plan.shard_count))
    whole = store.exists(CARD) and all(is_whole(store, file) for file in stored.files)
    if stored.summary is None or stored.shards != shards or not whole:
        stored = _described(store, msgspec.structs.replace(plan.plan, shards=shards))
        store.write(MANIFEST, to_toml(stored))
    store.delete_folder(RECEIPTS)
    assert stored.summary is not None
    return stored.summary


def _described(store: Store, manifest: Manifest) -> Manifest:
    """Write all that is made from the shards but `dataset.toml`; return what that is to say."""
    tally = Tally()
    describe = _describe_drives if manifest.kind == "drives" else _describe_frames
    files = describe(store, manifest, tally)
    summary = tally.summary(manifest.kind, sum(entry.size_bytes for entry in manifest.shards))
    store.write(CARD, card(manifest, summary).encode())
    with store.writing(CARD_PICTURE) as picture:
        picture.write(strip(store, manifest))
    return msgspec.structs.replace(manifest, summary=summary, files=(*files, _entry(CARD_PICTURE, picture)))


def _describe_frames(store: Store, manifest: Manifest, tally: Tally) -> tuple[FileEntry, ...]:
    with ExitStack() as stack:
        poses = {mount.name: stack.enter_context(store.writing(poses_name(mount.name))) for mount in manifest.cameras}
        files = {poses_name(name): out for name, out in poses.items()}
        coco = None
        if manifest.has_coco:
            files = {COCO: stack.enter_context(store.writing(COCO)), **files}
            coco = CocoWriter(files[COCO], stack.enter_context(store.scratch()), manifest)
        for out in poses.values():
            out.write(CAMERA_HEADER.encode())
        for number, entry in enumerate(manifest.shards):
            shard = _frames_shard(store, manifest, number)
            tally.add(shard)
            for name, out in poses.items():
                out.write(camera_rows(shard, name).encode())
            if coco:
                coco.add(shard, int(shard.frame_index[0]), f"{entry.file}#{{}}".format)
        if coco:
            coco.close()
    return tuple(_entry(name, out) for name, out in files.items())


def _describe_drives(store: Store, manifest: Manifest, tally: Tally) -> tuple[FileEntry, ...]:
    files = []
    for number, entry in enumerate(manifest.shards):
        shard = Shard(store, entry.file, entry.frames)
        tally.add_drive(shard)
        with store.writing(drive_poses_name(number)) as out:
            out.write(drive_text(*shard.truth()).encode())
        files.append(_entry(drive_poses_name(number), out))
    return tuple(files)


def _frames_shard(store: Store, manifest: Manifest, number: int) -> Shard:
    """Return a shard of frames; it has to hold just the frames that the plan puts there."""
    entry, wanted = manifest.shards[number], manifest.shard_frames(number)
    shard = Shard(store, entry.file, len(wanted))
    if shard.frame_index.tolist() != list(wanted):
        found = f"frames from {shard.frame_index[0]}"
        raise damaged(store.path(entry.file), found, f"the frames {wanted[0]} to {wanted[-1]}")
    return shard


def _entry(name: str, out: Writing) -> FileEntry:
    return FileEntry(file=name, size_bytes=out.size_bytes, sha256=out.sha256)


def _clear(store: Store) -> None:
    """Delete a dataset's own files and nothing else; `dataset.toml` goes last, so that a cut here can be repeated."""
    store.delete_folder(RECEIPTS)
    for name in [*store.names("shard-*.h5"), *store.names("poses/*.tum"), COCO, CARD_PICTURE, CARD, MANIFEST]:
        store.delete(name)


def _check_same(store: Store, found: Manifest, wanted: Manifest) -> None:
    for field in msgspec.structs.fields(Manifest):
        old, new = getattr(found, field.name), getattr(wanted, field.name)
        if old != new:
            raise _occupied(store, f"a dataset of another run: {field.name} = {_brief(old)}", _brief(new))


def _brief(value: object) -> str:
    if isinstance(value, tuple):
        return ", ".join(_brief(item) for item in value) or "none"
    if isinstance(value, CameraMount):
        return f"{value.name} {value.width_px}x{value.height_px}"
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
