"""The whole run: a plan, its missing shards as tasks, and the finished folder."""

from collections.abc import Callable
from pathlib import Path
from time import perf_counter

from adc_bench.dataset.layout import FRAMES_PER_SHARD, Extra, Kind, Summary
from adc_bench.dataset.receipts import put_shard
from adc_bench.dataset.split import Split
from adc_bench.dataset.store import Store
from adc_bench.dataset.write import begin, finish, missing_shards, sweep
from adc_bench.engine import run_tasks
from adc_bench.generate.frames import render_frames
from adc_bench.generate.plan import ShardDone, ShardTask, plan_dataset
from adc_bench.world.quality import Quality


def render_split(
    split: Split,
    out: Path | str,
    *,
    kind: Kind = "frames",
    count: int | None = None,
    size_px: tuple[int, int] = (320, 240),
    quality: Quality = "fast",
    extras: tuple[Extra, ...] = (),
    salt: bytes | None = None,
    frames_per_shard: int = FRAMES_PER_SHARD,
    workers: int = 1,
    overwrite: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Summary:
    """Render the split's first `count` frames or drives (its own number if None) into `out`; return the counts.

    Finished shards of an earlier, equal run are kept. The bytes are the same for any number of workers, and frame i is
    the same for any `count`. `progress` is told how many shards are done,
    those kept included, and how many there are.

    Raises:
        UsageError: the split has no seeds for so many frames.
        InputError: the folder holds something else (see `begin`), or a salt is missing.
        MachineError: this machine cannot render.
    """
    wanted = split.frames if count is None else count
    plan = plan_dataset(
        split,
        wanted,
        size_px,
        kind=kind,
        quality=quality,
        extras=extras,
        salt=salt,
        frames_per_shard=frames_per_shard,
    )
    store = Store(out)
    begin(store, plan, overwrite=overwrite)
    missing = missing_shards(store, plan)
    done = plan.shard_count - len(missing)
    tell = progress or (lambda count, total: None)
    tell(done, plan.shard_count)

    def told(_: int, __: ShardDone) -> None:
        nonlocal done
        done += 1
        tell(done, plan.shard_count)

    tasks = [ShardTask(out=str(out), number=number, plan=plan, salt=salt) for number in missing]
    try:
        run_tasks(render_shard, tasks, workers=workers, done=told)
        return finish(store, plan)
    finally:
        sweep(store)


def render_shard(task: ShardTask) -> ShardDone:
    """Make one shard and write it."""
    begun = perf_counter()
    data, frames = render_frames(task)
    put_shard(Store(task.out), task.plan, task.number, data, frames)
    return ShardDone(frames=frames, elapsed_s=perf_counter() - begun)
