"""Scenarios x renderer -> dataset: a split rendered into shards, each an idempotent task."""

from collections.abc import Callable
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

import msgspec

from adc_bench import __version__
from adc_bench.dataset.layout import Manifest, Summary, shard_name, write_file
from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.shard import encode_shard
from adc_bench.dataset.split import Split
from adc_bench.dataset.write import begin, finish, missing_shards, sweep
from adc_bench.engine import run_tasks
from adc_bench.errors import UsageError
from adc_bench.render import ArenaRenderer
from adc_bench.world.frame import Frame
from adc_bench.world.quality import Quality
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


class ShardTask(msgspec.Struct, frozen=True, kw_only=True):
    """One shard to be made in the folder `root`."""

    root: Path
    number: int
    plan: Manifest


def render_split(
    split: Split,
    root: Path,
    *,
    frames: int | None = None,
    size_px: tuple[int, int] = (320, 240),
    quality: Quality = "fast",
    workers: int = 1,
    overwrite: bool = False,
    progress: Callable[[int], None] | None = None,
) -> Summary:
    """Render the split's first `frames` frames (its own number if None) into the folder `root`; return the counts.

    Finished shards of an earlier, equal run are kept. The bytes are the same for any number of workers, and frame i is
    the same for any `frames`. `progress` is told how many frames are done, those kept included.

    Raises:
        UsageError: the split has no seeds for so many frames.
        InputError: the folder holds something else (see `begin`).
        MachineError: this machine cannot render.
    """
    plan = plan_dataset(split, split.frames if frames is None else frames, size_px, quality)
    begin(root, plan, overwrite=overwrite)
    missing = missing_shards(root, plan)
    done = plan.frames - sum(len(plan.shard_frames(number)) for number in missing)
    tell = progress or (lambda count: None)
    tell(done)

    def told(_: int, count: int) -> None:
        nonlocal done
        done += count
        tell(done)

    tasks = [ShardTask(root=root, number=number, plan=plan) for number in missing]
    try:
        run_tasks(render_shard, tasks, workers=workers, done=told)
        return finish(root, plan)
    finally:
        sweep(root)


def plan_dataset(split: Split, frames: int, size_px: tuple[int, int], quality: Quality = "fast") -> Manifest:
    """Return what `dataset.toml` says before anything is rendered.

    Raises:
        UsageError: the split has no seeds for so many frames.
        MachineError: this machine cannot render.
    """
    if not 0 < frames <= split.frames_max:
        raise UsageError(
            where=f"split {split.name!r}",
            found=f"{frames} frames asked for",
            wanted=f"1 to {split.frames_max} frames",
            todo="ask for fewer frames, or give the split more seeds",
        )
    rig = _rig(size_px)
    packages = {name: version(name) for name in ("sapien", "numpy", "opencv-python-headless")}
    return Manifest(
        frames=frames,
        split=split,
        split_sha256=split.sha256,
        software={"adc_bench": __version__, **packages, "renderer": process_renderer(rig, quality).device_name},
        cameras=rig.cameras,
        quality=quality,
    )


def render_shard(task: ShardTask) -> int:
    """Render one shard and write it; return how many frames it has."""
    plan = task.plan
    rig = SensorRig(cameras=plan.cameras)
    renderer = process_renderer(rig, plan.quality)
    frames: list[Frame] = []
    scenarios: list[Scenario] = []
    for index in plan.shard_frames(task.number):
        number = scenario_number(plan.split, index)
        if not scenarios or scenarios[-1].seed != plan.split.seed_first + number:
            scenarios.append(draw_scenario(plan.split, number, rig))
            renderer.load(scenarios[-1])
        frame = draw_frame(plan.split, scenarios[-1], index)
        renderer.set_panel(frame.panel_sign)
        frames.append(renderer.frame(index, frame.camera, frame.pose_world_robot, frame.motion))
    cameras = [mount.name for mount in plan.cameras]
    write_file(task.root / shard_name(task.number), encode_shard(frames, cameras, scenarios))
    return len(frames)


@lru_cache(maxsize=1)
def process_renderer(rig: SensorRig, quality: Quality = "fast") -> ArenaRenderer:
    """Return this process' renderer: starting one is dear, so it is kept from shard to shard."""
    return ArenaRenderer(rig, quality)


def _rig(size_px: tuple[int, int]) -> SensorRig:
    rig = SensorRig()
    return msgspec.structs.replace(rig, cameras=tuple(mount.resized(*size_px) for mount in rig.cameras))
