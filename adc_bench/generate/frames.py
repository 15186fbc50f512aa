"""A shard of independent frames: arenas one after the other, poses in each, pictures with their truth."""

from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.shard import encode_shard
from adc_bench.generate.plan import ShardTask, process_renderer
from adc_bench.world.frame import Frame
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


def render_frames(task: ShardTask) -> tuple[bytes, int]:
    """Render one shard; return its file and how many frames it has."""
    plan = task.plan
    rig = SensorRig(cameras=plan.cameras)
    renderer = process_renderer(rig, plan.quality)
    frames: list[Frame] = []
    scenarios: list[Scenario] = []
    loaded = None
    for index in plan.shard_frames(task.number):
        number = scenario_number(plan.split, index)
        if number != loaded:
            loaded = number
            scenarios.append(draw_scenario(plan.split, number, rig, task.salt))
            renderer.load(scenarios[-1])
        frame = draw_frame(plan.split, scenarios[-1], index)
        renderer.set_panel(frame.panel_sign)
        frames.append(renderer.frame(index, frame.camera, frame.pose_world_robot, frame.motion))
    return encode_shard(frames, [mount.name for mount in plan.cameras], scenarios), len(frames)
