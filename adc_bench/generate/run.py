"""The whole run: a plan, its missing shards as tasks, and the finished dataset."""

from collections.abc import Callable, Sequence
from pathlib import Path

from adc_bench.dataset.layout import FRAMES_PER_SHARD, Kind, Manifest, Summary
from adc_bench.dataset.receipts import put_shard
from adc_bench.dataset.split import Split
from adc_bench.dataset.store import Store
from adc_bench.dataset.write import begin, finish, missing_shards, sweep
from adc_bench.engine import Done, Engine, default_workers, run_tasks
from adc_bench.generate.drives import render_drive
from adc_bench.generate.frames import render_frames
from adc_bench.generate.node import check_sight, check_software
from adc_bench.generate.plan import ShardTask, plan_dataset, plan_renderer
from adc_bench.generate.progress import Count, Progress
from adc_bench.world.quality import Extra, Quality


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
    engine: Engine = "local",
    workers: int | None = 1,
    overwrite: bool = False,
    progress: Callable[[Progress], None] | None = None,
) -> Summary:
    """Render the split's first `count` frames or drives (its own number if None) into `out`; return the counts.

    Finished shards of an earlier, equal run are kept. The bytes are the same for any engine and any number of workers
    (see `run_tasks`), and frame i is the same for any `count`. `progress` is told at first and after each shard.

    Raises:
        UsageError: the split has no seeds for so many frames or drives.
        InputError: the folder holds something else (see `begin`), another process writes there, or a salt is missing.
        MachineError: this machine, or a node, cannot render or cannot write; workers died again and again; no cluster.
    """
    plan = plan_dataset(
        split,
        count,
        size_px,
        kind=kind,
        quality=quality,
        extras=extras,
        salt=salt,
        frames_per_shard=frames_per_shard,
    )
    store = Store(out)
    with store.locked():
        begin(store, plan, overwrite=overwrite)
        try:
            missing = missing_shards(store, plan)
            _render_missing(store, plan, missing, salt, engine, workers, progress or (lambda now: None))
            return finish(store, plan)
        finally:
            sweep(store)


def _render_missing(
    store: Store,
    plan: Manifest,
    missing: Sequence[int],
    salt: bytes | None,
    engine: Engine,
    workers: int | None,
    progress: Callable[[Progress], None],
) -> None:
    tally = Count(plan.shard_count - len(missing), plan.shard_count)
    progress(tally.now())
    if not missing:
        return

    def told(done: Done[int]) -> None:
        tally.add(done.node, done.result, done.elapsed_s)
        progress(tally.now())

    if engine == "local":
        workers = min(workers or default_workers(), len(missing))
    # A worker's own folder may be another: workers are told the whole path.
    out = str(Path(store.root).resolve()) if store.is_local else store.root
    tasks = (ShardTask(out=out, number=number, plan=plan, salt=salt) for number in missing)
    run_tasks(render_shard, tasks, engine=engine, workers=workers, done=told)


def render_shard(task: ShardTask) -> int:
    """Make one shard and write it; return how many frames it has.

    Raises:
        MachineError: this machine cannot render, would give other bytes than the plan's, or does not see the dataset.
        InputError: the dataset cannot be written.
    """
    store = Store(task.out)
    check_software(task.plan.software, plan_renderer(task.plan).device_name)
    check_sight(store)
    make = render_drive if task.plan.kind == "drives" else render_frames
    data, frames = make(task)
    put_shard(store, task.plan, task.number, data, frames)
    return frames
