"""What is to be made: the plan that `dataset.toml` begins with, and the task of making one of its shards."""

from functools import lru_cache

import msgspec

from adc_bench.dataset.layout import FRAMES_PER_SHARD, Kind, Manifest
from adc_bench.dataset.split import Split
from adc_bench.errors import InputError, UsageError
from adc_bench.generate.node import software
from adc_bench.render import ArenaRenderer
from adc_bench.world.quality import Extra, Quality
from adc_bench.world.salt import VARIABLE, salt_sha256
from adc_bench.world.sensors import SensorRig


class ShardTask(msgspec.Struct, frozen=True, kw_only=True):
    """One shard to be made in the folder (or at the address) `out`."""

    out: str
    number: int
    plan: Manifest
    salt: bytes | None


def plan_dataset(
    split: Split,
    count: int | None,
    size_px: tuple[int, int] = (320, 240),
    *,
    kind: Kind = "frames",
    quality: Quality = "fast",
    extras: tuple[Extra, ...] = (),
    salt: bytes | None = None,
    frames_per_shard: int = FRAMES_PER_SHARD,
) -> Manifest:
    """Return what `dataset.toml` says before anything is rendered; `count` None is the split's own number.

    Raises:
        UsageError: the split has no seeds for so many frames or drives.
        InputError: the split wants a salt, and there is none.
        MachineError: this machine cannot render.
    """
    own, most = (split.frames, split.frames_max) if kind == "frames" else (split.drives.count, split.seed_count)
    count = own if count is None else count
    if not 0 < count <= most:
        raise UsageError(
            where=f"split {split.name!r}",
            found=f"{count} {kind} asked for",
            wanted=f"1 to {most} {kind}",
            todo=f"ask for fewer {kind}, or give the split more seeds",
        )
    if split.salted and salt is None:
        raise InputError(
            where=f"split {split.name!r}",
            found="a salted split, and no salt",
            wanted=f"--salt-file FILE, or {VARIABLE} in the environment",
            todo="give the salt; only its owner can make this split",
        )
    rig = _rig(size_px)
    return Manifest(
        kind=kind,
        count=count,
        frames_per_shard=frames_per_shard,
        split=split,
        split_sha256=split.sha256,
        salt_sha256=salt_sha256(salt) if split.salted and salt is not None else None,
        software=software(process_renderer(rig, quality, extras).device_name),
        cameras=rig.cameras,
        quality=quality,
        extras=extras,
    )


@lru_cache(maxsize=1)
def process_renderer(rig: SensorRig, quality: Quality = "fast", extras: tuple[Extra, ...] = ()) -> ArenaRenderer:
    """Return this process' renderer: starting one is dear, so it is kept from shard to shard."""
    return ArenaRenderer(rig, quality, extras)


def plan_renderer(plan: Manifest) -> ArenaRenderer:
    """Return this process' renderer for a plan's pictures."""
    return process_renderer(SensorRig(cameras=plan.cameras), plan.quality, plan.extras)


def _rig(size_px: tuple[int, int]) -> SensorRig:
    rig = SensorRig()
    return msgspec.structs.replace(rig, cameras=tuple(mount.resized(*size_px) for mount in rig.cameras))
