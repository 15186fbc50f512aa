"""A shard of independent frames: arenas one after the other, poses in each, pictures with their truth.

The driver draws a picture in threads of its own. While it does, the picture before is developed, encoded and labelled,
and the next frame is planned: nothing but the order of the work differs from taking frame after frame.
"""

from collections.abc import Iterator

from adc_bench.dataset.sampling import FramePlan, draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.shard import encode_shard
from adc_bench.generate.plan import ShardTask, process_renderer
from adc_bench.render import ArenaRenderer
from adc_bench.world.frame import Frame
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


def render_frames(task: ShardTask) -> tuple[bytes, int]:
    """Render one shard; return its file and how many frames it has."""
    rig = SensorRig(cameras=task.plan.cameras)
    renderer = process_renderer(rig, task.plan.quality, task.plan.extras)
    scenarios: dict[str, Scenario] = {}
    frames = list(_frames(renderer, _plans(task, rig, scenarios)))
    return encode_shard(frames, [mount.name for mount in rig.cameras], list(scenarios.values())), len(frames)


def _plans(task: ShardTask, rig: SensorRig, scenarios: dict[str, Scenario]) -> Iterator[tuple[Scenario, FramePlan]]:
    """Yield what the shard's frames show, and collect their scenarios."""
    split, loaded = task.plan.split, None
    for index in task.plan.shard_frames(task.number):
        number = scenario_number(split, index)
        if number != loaded:
            loaded, scenario = number, draw_scenario(split, number, rig, task.salt)
            scenarios[scenario.name] = scenario
        yield scenario, draw_frame(split, scenario, index)


def _frames(renderer: ArenaRenderer, plans: Iterator[tuple[Scenario, FramePlan]]) -> Iterator[Frame]:
    """Yield the frames; each is finished while the next one is drawn."""
    loaded, before, coming = None, None, next(plans, None)
    while coming:
        scenario, plan = coming
        if scenario is not loaded:
            renderer.load(scenario)
            loaded = scenario
        renderer.set_panel(plan.panel_sign)
        shot = renderer.shoot(plan.index, plan.camera, plan.pose_world_robot, plan.motion)
        if before:
            yield renderer.finish(before)
        coming = next(plans, None)
        shot.read()
        before = shot
    if before:
        yield renderer.finish(before)
