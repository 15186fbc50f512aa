"""Frames made while others are drawn are those that are made one after the other."""

from adc_bench.dataset import load_split
from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.shard import encode_shard
from adc_bench.generate.frames import render_frames
from adc_bench.generate.plan import ShardTask, plan_dataset, process_renderer
from adc_bench.world.sensors import SensorRig


def test_a_shard_holds_what_frames_taken_one_by_one_would() -> None:
    """Across a change of the arena, and with a first frame in the middle of one."""
    split = load_split("val")
    most = split.frames_per_scenario
    plan = plan_dataset(split, 2 * most, (160, 120), frames_per_shard=most - 2)
    rig, task = SensorRig(cameras=plan.cameras), ShardTask(out="", number=1, plan=plan, salt=None)
    renderer, frames, scenarios = process_renderer(rig, plan.quality, plan.extras), [], []
    for index in plan.shard_frames(1):
        number = scenario_number(split, index)
        if not scenarios or scenarios[-1].name != draw_scenario(split, number, rig).name:
            scenarios.append(draw_scenario(split, number, rig))
            renderer.load(scenarios[-1])
        coming = draw_frame(split, scenarios[-1], index)
        renderer.set_panel(coming.panel_sign)
        frames.append(renderer.frame(index, coming.camera, coming.pose_world_robot, coming.motion))
    assert len(scenarios) == 2
    data, count = render_frames(task)
    assert count == len(frames)
    assert data == encode_shard(frames, [mount.name for mount in rig.cameras], scenarios)
