"""Real renders on the software driver."""

import resource
import subprocess
import sys
from collections.abc import Callable

import cv2
import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.errors import UsageError
from adc_bench.geometry import Pose2, Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import Tunnel
from adc_bench.world.categories import CATEGORY_ID, PANEL_SIGNS
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SemanticCameraSpec, SensorRig

Make = Callable[..., Scenario]
OVER_EAST_LOOP = Tunnel(start_s_m=8.0, length_m=4.0)


def at(s_m: float, scenario: Scenario) -> Pose3:
    return scenario.course.lap.pose(s_m).to_pose3()


def decode(jpeg: bytes) -> NDArray[np.uint8]:
    return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), np.uint8)


def test_the_software_driver_is_used(renderer: ArenaRenderer) -> None:
    assert "llvmpipe" in renderer.device_name


def test_white_paint_lands_where_the_course_and_the_camera_put_it(renderer: ArenaRenderer, scenario_of: Make) -> None:
    """An independent projection of the painted polygons explains the bright pixels of a real render."""
    scenario = scenario_of("normal")
    renderer.load(scenario)
    pose = at(33.0, scenario)
    rgba, _ = renderer.raw("road", pose)
    mount = scenario.rig.camera("road")
    camera, pose_camera = mount.camera(), renderer.pose_world_camera("road", pose)
    expected = np.zeros(rgba.shape[:2], np.uint8)
    for polygon in scenario.course.paint:
        ring = np.asarray(polygon.exterior.coords)
        if polygon.interiors:
            continue  # the outlines as bands: their pieces are checked by the dashes and the crosswalk
        points = pose_camera.inverse().transform(np.column_stack([ring, np.zeros(len(ring))]))
        if (points[:, 2] > 0.1).all():
            cv2.fillPoly(expected, [np.round(camera.project(points) * 16 - 8).astype(np.int32)], 255, shift=4)
    near = slice(90, 240)  # below the horizon's blur
    bright = cv2.cvtColor(rgba[..., :3], cv2.COLOR_RGB2GRAY)[near] > 110
    painted = cv2.erode(expected, np.ones((3, 3), np.uint8))[near] > 0
    assert painted.sum() > 300
    assert bright[painted].mean() > 0.97


def test_scene_illuminance_spans_a_hundred_to_one_in_the_picture(renderer: ArenaRenderer, scenario_of: Make) -> None:
    bright, dark = scenario_of("bright", seed=3), scenario_of("dark", seed=3)
    fixed = msgspec.structs.replace(bright.look, illuminance_lux=1600.0)
    darkest = msgspec.structs.replace(dark.look, illuminance_lux=8.0)
    renderer.load(msgspec.structs.replace(bright, look=fixed))
    pose = at(5.0, bright)
    exposure = renderer.exposure(pose)
    assert 60 < renderer.exposed("road", pose, exposure)[..., :3].mean() < 200
    renderer.load(msgspec.structs.replace(dark, look=darkest))
    assert renderer.exposed("road", pose, exposure)[..., :3].mean() < 12


@pytest.mark.parametrize("level", ["dark", "dim", "normal", "bright"])
def test_lines_stand_out_at_every_light_level(renderer: ArenaRenderer, scenario_of: Make, level: str) -> None:
    scenario = scenario_of(level, seed=2)
    renderer.load(scenario)
    rgba, labels = renderer.raw("road", at(39.0, scenario))
    grey = cv2.cvtColor(rgba[..., :3], cv2.COLOR_RGB2GRAY)[labels == 1]
    assert np.percentile(grey, 90) > 1.6 * np.percentile(grey, 15)


def test_the_tunnel_is_dark_inside(renderer: ArenaRenderer, scenario_of: Make) -> None:
    with_tunnel, without = (scenario_of("normal", tunnel=t) for t in (OVER_EAST_LOOP, None))
    pose, light = at(9.6, without), []
    for scenario in (without, with_tunnel):
        renderer.load(scenario)
        exposure = renderer.exposure(at(2.0, scenario))
        light.append(renderer.exposed("road", pose, exposure)[120:, :, :3].mean())
    assert light[1] < 0.4 * light[0]
    assert renderer.frame(0, "road", pose).conditions.in_tunnel
    assert not renderer.frame(0, "road", at(2.0, with_tunnel)).conditions.in_tunnel


def test_a_frame_repeats_to_the_byte_whatever_came_before(renderer: ArenaRenderer, scenario_of: Make) -> None:
    first, other = scenario_of("dim", seed=5), scenario_of("bright", seed=6, tunnel=OVER_EAST_LOOP)
    renderer.load(first)
    pose = at(38.5, first)
    before = [renderer.frame(7, name, pose) for name in ("road", "panel")]
    renderer.load(other)
    renderer.frame(1, "road", pose)
    renderer.load(first)
    after = [renderer.frame(7, name, pose) for name in ("road", "panel")]
    assert [f.jpeg for f in before] == [f.jpeg for f in after]
    assert [f.labels for f in before] == [f.labels for f in after]
    assert renderer.frame(8, "road", pose).jpeg != before[0].jpeg


DIGEST = """
import hashlib
from adc_bench.render import ArenaRenderer
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import Motion, RobotParams, draw_robot_truth
from adc_bench.world.sensors import SensorRig
from adc_bench.world.scenario import Scenario
from adc_bench.world.streams import stream
family = LookFamily(floors=("felt",), walls=("blocks",), light_sets=("window_left",))
scenario = Scenario(name="x", seed=4, look=draw_look(family, stream(4, "look"), "dim"), panel_sign="end",
                    robot_truth=draw_robot_truth(RobotParams(), stream(4, "robot")))
renderer = ArenaRenderer(SensorRig())
renderer.load(scenario)
pose = scenario.course.lap.pose(39.0).to_pose3()
motion = Motion(v_mps=1.0, omega_radps=1.5)
files = [renderer.picture(name, pose, time_s=0.05 * k, motion=motion) for k in range(2) for name in ("road", "panel")]
print(hashlib.sha256(b"".join(files) + renderer.frame(3, "road", pose, motion=motion).jpeg).hexdigest())
"""


def test_processes_and_thread_counts_agree_to_the_byte() -> None:
    digests = {
        subprocess.run(
            [sys.executable, "-c", DIGEST],
            env={"LP_NUM_THREADS": n, "PATH": "/usr/bin"},
            capture_output=True,
            check=True,
        ).stdout
        for n in ("0", "1", "2")
    }
    assert len(digests) == 1


def test_both_panels_switch_and_are_labelled_by_what_they_show(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    pose = at(38.6, scenario)
    seen = set()
    for sign in PANEL_SIGNS:
        renderer.set_panel(sign)
        frame = renderer.frame(0, "panel", pose)
        assert [label.category_id for label in frame.labels if label.instance.startswith("panel")] == [
            CATEGORY_ID[f"panel_{sign}"]
        ]
        box = next(label.box_px for label in frame.labels if label.instance.startswith("panel"))
        x0, y0, x1, y1 = map(int, box)
        seen.add(decode(frame.jpeg)[y0:y1, x0:x1].tobytes())
    assert len(seen) == 6


def test_a_panel_is_not_labelled_from_behind(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    frame = renderer.frame(0, "panel", Pose2(x_m=2.0, y_m=-2.6125, yaw_rad=np.pi).to_pose3())
    assert [label.instance for label in frame.labels if label.instance.startswith("panel")] == ["panel_facing_east"]


def test_what_a_wall_hides_is_not_labelled(renderer: ArenaRenderer, scenario_of: Make) -> None:
    """A tunnel beside the crosswalk hides it from the infield: with it no crosswalk label, without it one."""
    pose = Pose2(x_m=-2.0, y_m=0.6, yaw_rad=-0.9).to_pose3()
    for tunnel, count in ((None, 1), (Tunnel(start_s_m=38.0, length_m=4.0), 0)):
        scenario = scenario_of("normal", tunnel=tunnel)
        renderer.load(scenario)
        labels = [label for label in renderer.frame(0, "road", pose).labels if label.instance == "crosswalk"]
        assert len([label for label in labels if not label.ignore]) == count


def test_a_drives_frames_are_its_pictures_with_truth(renderer: ArenaRenderer, scenario_of: Make) -> None:
    """The exposure follows into the tunnel and noise goes by the picture's number, with truth or without."""
    scenario, motion = scenario_of("normal", tunnel=OVER_EAST_LOOP), Motion(v_mps=1.0)
    way = [(0.1 * k, at(6.5 + 0.1 * k, scenario)) for k in range(12)]
    renderer.load(scenario)
    pictures = [renderer.picture("road", pose, time_s=time_s, motion=motion) for time_s, pose in way]
    renderer.load(scenario)
    frames = [
        renderer.drive_frame(100 + k, "road", pose, time_s=time_s, motion=motion)
        for k, (time_s, pose) in enumerate(way)
    ]
    assert [frame.jpeg for frame in frames] == pictures
    assert [frame.index for frame in frames] == list(range(100, 112))
    assert frames[-1].conditions.exposure > 1.05 * frames[0].conditions.exposure
    truth = renderer.frame(100, "road", way[0][1], motion)
    assert frames[0].labels == truth.labels
    assert np.allclose(frames[0].pose_world_camera.matrix(), truth.pose_world_camera.matrix())


def test_reloading_scenarios_does_not_grow_the_process(renderer: ArenaRenderer, scenario_of: Make) -> None:
    def load(rounds: int) -> int:
        for k in range(rounds):
            scenario = scenario_of("normal", seed=k, tunnel=OVER_EAST_LOOP if k % 2 else None)
            renderer.load(scenario)
            renderer.raw("road", at(3.0, scenario))
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    load(16)
    before = load(4)
    assert load(16) - before < 20_000  # kB


def test_objects_in_view_need_a_semantic_camera(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    with pytest.raises(UsageError, match="no semantic camera"):
        renderer.objects_in_view("road", at(38.6, scenario))


def test_objects_in_view_lie_where_the_arena_put_them(scenario_of: Make) -> None:
    renderer, scenario = ArenaRenderer(SensorRig(semantic=SemanticCameraSpec())), scenario_of("normal")
    renderer.load(scenario)
    pose = at(38.6, scenario)
    (seen,) = renderer.objects_in_view("road", pose)
    assert (seen.category, seen.instance) == ("crosswalk", "crosswalk")
    middle = pose.inverse().transform([[0.0, scenario.course.crosswalk_corners[:, 1].mean(), 0.0]])[0]
    assert np.allclose([seen.pose_robot_object.x_m, seen.pose_robot_object.y_m], middle[:2], atol=1e-9)
