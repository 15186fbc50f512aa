"""A shard of independent frames: arenas one after the other, poses in each, pictures with their truth.

The driver draws a picture in threads of its own. While it does, the picture before is developed, encoded and labelled,
the next one planned, and a piece of the next arena built: nothing but the order of the work differs from taking frame
after frame.
"""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager

import cv2

from adc_bench.dataset.sampling import FramePlan, draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.shard import encode_shard
from adc_bench.dataset.split import Split
from adc_bench.generate.plan import ShardTask, process_renderer
from adc_bench.render import ArenaRenderer
from adc_bench.render.renderer import Shot
from adc_bench.world.frame import Frame
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

Arenas = Iterator[tuple[Scenario, list[int]]]


def render_frames(task: ShardTask) -> tuple[bytes, int]:
    """Render one shard; return its file and how many frames it has."""
    rig = SensorRig(cameras=task.plan.cameras)
    renderer = process_renderer(rig, task.plan.quality, task.plan.extras)
    scenarios: list[Scenario] = []
    with one_thread():
        frames = list(_frames(renderer, task, _arenas(task, rig, scenarios)))
    return encode_shard(frames, [mount.name for mount in rig.cameras], scenarios), len(frames)


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV work in the calling thread alone: the driver has the other cores, and threads have their price."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def _arenas(task: ShardTask, rig: SensorRig, scenarios: list[Scenario]) -> Arenas:
    """Yield the shard's arenas, each with the numbers of its frames, and collect them."""
    split = task.plan.split
    for number, indices in itertools.groupby(
        task.plan.shard_frames(task.number), lambda index: scenario_number(split, index)
    ):
        scenarios.append(draw_scenario(split, number, rig, task.salt))
        yield scenarios[-1], list(indices)


def _frames(renderer: ArenaRenderer, task: ShardTask, arenas: Arenas) -> Iterator[Frame]:
    """Yield the frames; each is finished, and the next one planned, while one is drawn."""
    before, arena = None, next(arenas, None)
    while arena:
        scenario, indices = arena
        renderer.load(scenario)
        plans = _plans(renderer, task.plan.split, scenario, indices)
        plan = next(plans, None)
        while plan:
            shot = _begun(renderer, *plan)
            if before:
                yield renderer.finish(before)
            is_first, plan = plan[0].index == indices[0], next(plans, None)
            if is_first:
                arena = next(arenas, None)
            elif arena:
                renderer.prepare(arena[0])
            shot.read()
            before = shot
    if before:
        yield renderer.finish(before)


def _plans(
    renderer: ArenaRenderer, split: Split, scenario: Scenario, indices: list[int]
) -> Iterator[tuple[FramePlan, float]]:
    """Yield the loaded arena's frames to be, each with its exposure."""
    for index in indices:
        plan = draw_frame(split, scenario, index)
        yield plan, renderer.exposure_on_the_way(plan.camera, plan.pose_world_robot, plan.motion)


def _begun(renderer: ArenaRenderer, plan: FramePlan, exposure: float) -> Shot:
    renderer.set_panel(plan.panel_sign)
    return renderer.shoot(plan.index, plan.camera, plan.pose_world_robot, exposure, plan.motion)
