import math
from collections import Counter
from itertools import product

import msgspec
import numpy as np
import pytest
import shapely
from shapely import affinity

from adc_bench.dataset import load_split
from adc_bench.dataset.sampling import FramePlan, draw_frame, draw_scenario, scenario_number
from adc_bench.world.categories import PANEL_SIGNS
from adc_bench.world.look import LIGHT_LEVELS
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

RIG = SensorRig()
VAL = load_split("val")
Plans = list[tuple[Scenario, FramePlan]]


@pytest.fixture(scope="module")
def plans() -> Plans:
    scenarios = [draw_scenario(VAL, number, RIG) for number in range(20)]
    return [
        (scenarios[scenario_number(VAL, i)], draw_frame(VAL, scenarios[scenario_number(VAL, i)], i)) for i in range(320)
    ]


def test_320_frames_hold_every_light_level_camera_and_sign_evenly(plans: Plans) -> None:
    levels = Counter(scenario.look.light_level for scenario, _ in plans)
    assert levels == dict.fromkeys(LIGHT_LEVELS, 80)
    shown = Counter((plan.camera, plan.panel_sign) for _, plan in plans)
    assert set(shown) == set(product(("road", "panel"), PANEL_SIGNS))
    assert min(shown.values()) >= 24


def test_320_frames_hold_100_crosswalks(plans: Plans) -> None:
    """Counted by a projection of our own: most of the crosswalk inside the picture, nearer than 5 m."""
    assert sum(_crosswalk_share(scenario, plan) > 0.5 for scenario, plan in plans) >= 100


def _crosswalk_share(scenario: Scenario, plan: FramePlan) -> float:
    (x0, y0), _, (x1, y1), _ = scenario.course.crosswalk_corners
    points = np.array([(x, y, 0.0) for x in np.linspace(x0, x1, 9) for y in np.linspace(y0, y1, 9)])
    mount = scenario.rig.camera(plan.camera)
    robot = (points - plan.pose_world_robot.translation_m) @ plan.pose_world_robot.rotation
    forward, left, up = (robot - (mount.x_m, 0.0, mount.z_m)).T
    down = mount.pitch_down_rad
    depth = forward * math.cos(down) - up * math.sin(down)
    height = forward * math.sin(down) + up * math.cos(down)
    reach = math.tan(mount.hfov_rad / 2)
    inside = (depth > 0.05) & (depth < 5) & (abs(left) < reach * depth) & (abs(height) < 0.75 * reach * depth)
    return float(inside.mean())


def test_tunnels_keep_their_share_and_stand_at_every_light_level() -> None:
    scenarios = [draw_scenario(VAL, number, RIG) for number in range(64)]
    for first in range(0, 64, 4):
        assert sum(scenario.tunnel is not None for scenario in scenarios[first : first + 4]) == 1
    tunnels = [scenario for scenario in scenarios if scenario.tunnel]
    assert {scenario.look.light_level for scenario in tunnels} == set(LIGHT_LEVELS)
    assert any(_roof_covers(scenario, (0.0, -scenario.course_spec.radius_centre_m)) for scenario in tunnels)


def _roof_covers(scenario: Scenario, point: tuple[float, float]) -> bool:
    roofs = [solid for solid in scenario.solids if solid.kind == "tunnel" and "roof" in solid.name]
    return any(math.dist(point, solid.centre_m[:2]) < 0.3 for solid in roofs)


def test_no_robot_stands_in_a_wall() -> None:
    tunnels = [number for number in range(64) if draw_scenario(VAL, number, RIG).tunnel]
    for number in tunnels:
        scenario = draw_scenario(VAL, number, RIG)
        low = [solid for solid in scenario.solids if solid.centre_m[2] - solid.size_m[2] / 2 < 0.5]
        footprints = []
        for solid in low:
            x, y = solid.size_m[0] / 2, solid.size_m[1] / 2
            turned = affinity.rotate(shapely.box(-x, -y, x, y), solid.yaw_rad, origin=(0, 0), use_radians=True)
            footprints.append(affinity.translate(turned, *solid.centre_m[:2]))
        walls = shapely.union_all(footprints)
        for k in range(VAL.frames_per_scenario):
            plan = draw_frame(VAL, scenario, number * VAL.frames_per_scenario + k)
            assert walls.distance(shapely.Point(plan.pose_world_robot.translation_m[:2])) > 0.29


def test_poses_lie_on_and_around_the_lanes(plans: Plans) -> None:
    points = np.array([plan.pose_world_robot.translation_m for _, plan in plans])
    assert (points[:, 2] == 0).all()
    course = plans[0][0].course
    assert 0.85 < course.on_road(points[:, :2]).mean() < 1.0
    tilts = np.array([math.acos(plan.pose_world_robot.rotation[2, 2]) for _, plan in plans])
    assert 0 < np.median(tilts) < math.radians(0.6)


def test_a_frame_depends_on_its_split_and_index_alone(plans: Plans) -> None:
    for index in (0, 37, 319):
        scenario = draw_scenario(VAL, scenario_number(VAL, index), RIG)
        again, before = draw_frame(VAL, scenario, index), plans[index][1]
        assert msgspec.json.encode(scenario) == msgspec.json.encode(plans[index][0])
        assert (again.camera, again.panel_sign) == (before.camera, before.panel_sign)
        np.testing.assert_array_equal(again.pose_world_robot.matrix(), before.pose_world_robot.matrix())


def test_the_size_of_the_pictures_moves_nothing() -> None:
    large = SensorRig(cameras=tuple(mount.resized(640, 480) for mount in RIG.cameras))
    pose = draw_frame(VAL, draw_scenario(VAL, 0, large), 5).pose_world_robot.matrix()
    np.testing.assert_array_equal(pose, draw_frame(VAL, draw_scenario(VAL, 0, RIG), 5).pose_world_robot.matrix())
