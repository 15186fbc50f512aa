"""Which shards are finished: each leaves a receipt, a small file with the digest that its bytes had in memory.

A shard counts only with the receipt of the same plan, with the receipt's size and, in a folder of this machine, with
its digest: a truncated shard, a damaged one or one of another dataset is made again. When the dataset is finished, its
`dataset.toml` has all that the receipts say, and they go.
"""

import hashlib

import msgspec

from adc_bench.dataset.layout import RECEIPTS, FileEntry, Manifest, ShardEntry, receipt_name, shard_name, to_toml
from adc_bench.dataset.store import Store
from adc_bench.errors import InputError
from adc_bench.world.records import parse_record


class Receipt(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A shard that was written, and for which plan."""

    plan_sha256: str
    shard: ShardEntry


def plan_sha256(plan: Manifest) -> str:
    """Return the digest of what is wanted."""
    return hashlib.sha256(to_toml(plan.plan)).hexdigest()


def put_shard(store: Store, plan: Manifest, number: int, data: bytes, frames: int) -> ShardEntry:
    """Write a shard of `frames` frames, then its receipt.

    Raises:
        MachineError: the disk is full, writing is forbidden, or an object store does not answer.
    """
    digest = hashlib.sha256(data).hexdigest()
    entry = ShardEntry(file=shard_name(number), size_bytes=len(data), sha256=digest, frames=frames)
    store.write(entry.file, data)
    store.write(receipt_name(number), to_toml(Receipt(plan_sha256=plan_sha256(plan), shard=entry)))
    return entry


def finished_shards(store: Store, plan: Manifest, stored: Manifest) -> dict[int, ShardEntry]:
    """Return the plan's shards that are there, unread, as receipts and the stored `dataset.toml` tell of them."""
    found = {_number(entry): entry for entry in stored.shards}
    names, wanted = store.names(f"{RECEIPTS}/shard-*.toml"), plan_sha256(plan)
    for name, data in store.read_many(names).items():
        receipt = _parsed(data, store.path(name))
        if receipt is not None and receipt.plan_sha256 == wanted:
            found[_number(receipt.shard)] = receipt.shard
    sizes = store.sizes("shard-*.h5")
    return {number: entry for number, entry in sorted(found.items()) if sizes.get(entry.file) == entry.size_bytes}


def is_whole(store: Store, entry: FileEntry) -> bool:
    """Return whether a file has the bytes it should have; of a file in an object store only the size is compared."""
    if store.size(entry.file) != entry.size_bytes:
        return False
    return not store.is_local or store.sha256(entry.file) == entry.sha256


def _number(entry: ShardEntry) -> int:
    return int(entry.file.removeprefix("shard-").removesuffix(".h5"))


def _parsed(data: bytes, where: str) -> Receipt | None:
    try:
        return parse_record(data, where, Receipt)
    except InputError:
        return None  # its shard is made again, and a new receipt with it
