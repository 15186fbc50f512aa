import math
from collections import Counter
from itertools import product

import msgspec
import numpy as np
import pytest
import shapely
from shapely import affinity

from adc_bench.dataset import load_split
from adc_bench.dataset.sampling import FramePlan, draw_frame, draw_scenario, layout_name, scenario_number
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.world.categories import PANEL_SIGNS
from adc_bench.world.course import COURSE_SETS
from adc_bench.world.look import LIGHT_LEVELS
from adc_bench.world.robot import ROBOTS, Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.solids import Solid

RIG = SensorRig()
VAL = load_split("val")
Plans = list[tuple[Scenario, FramePlan]]


@pytest.fixture(scope="module")
def plans() -> Plans:
    scenarios = [draw_scenario(VAL, number, RIG) for number in range(12)]
    return [
        (scenarios[scenario_number(VAL, i)], draw_frame(VAL, scenarios[scenario_number(VAL, i)], i)) for i in range(384)
    ]


def test_384_frames_hold_every_light_level_camera_and_sign_evenly(plans: Plans) -> None:
    levels = Counter(scenario.look.light_level for scenario, _ in plans)
    assert levels == dict.fromkeys(LIGHT_LEVELS, 96)
    shown = Counter((plan.camera, plan.panel_sign) for _, plan in plans)
    assert set(shown) == set(product(("road", "panel"), PANEL_SIGNS))
    assert min(shown.values()) >= 24


def test_320_frames_hold_100_crosswalks(plans: Plans) -> None:
    """Counted by a projection of our own: most of the crosswalk inside the picture, nearer than 5 m."""
    assert sum(_crosswalk_share(scenario, plan) > 0.5 for scenario, plan in plans[:320]) >= 100


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


def test_layouts_keep_their_shares_in_every_stretch_and_at_every_light_level() -> None:
    names = [layout_name(VAL, number) for number in range(640)]
    for stretch in (names[:160], names[160:320], names[320:], *(names[level::4] for level in range(4))):
        counts = Counter(stretch)
        for name, share in VAL.layouts.items():
            assert counts[name] / len(stretch) == pytest.approx(share, abs=0.03)
    assert Counter(names[:32]).keys() == VAL.layouts.keys()


def test_every_kind_of_thing_is_drawn() -> None:
    scenarios = [draw_scenario(VAL, number, RIG) for number in range(64)]
    tunnels = [scenario for scenario in scenarios if scenario.tunnel]
    assert {scenario.look.light_level for scenario in tunnels} == set(LIGHT_LEVELS)
    assert any(_roof_covers(scenario, (0.0, -scenario.course_spec.radius_centre_m)) for scenario in tunnels)
    with_works = [scenario for scenario in scenarios if scenario.layout.works]
    assert all(len(scenario.tapes) == 7 and not scenario.signs for scenario in with_works) and len(with_works) >= 12
    signs = sum(len(scenario.signs) == 12 for scenario in scenarios)
    assert 28 < signs < 48
    assert all(scenario.furniture for scenario in scenarios)


def _roof_covers(scenario: Scenario, point: tuple[float, float]) -> bool:
    roofs = [solid for solid in scenario.solids if solid.kind == "tunnel" and "roof" in solid.name]
    return any(math.dist(point, solid.centre_m[:2]) < 0.3 for solid in roofs)


def test_no_robot_stands_in_a_thing() -> None:
    for number in range(24):
        scenario = draw_scenario(VAL, number, RIG)
        standing = [(solid, Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)) for solid in scenario.solids]
        standing += [(part, body.pose) for body in scenario.bodies for part in body.parts]
        footprints = [_footprint(solid, pose) for solid, pose in standing if _bottom_m(solid) < 0.5]
        places = {body.name: (body.pose.x_m, body.pose.y_m) for body in scenario.bodies}
        tapes = [shapely.LineString([places[tape.first], places[tape.second]]) for tape in scenario.tapes]
        taken = shapely.union_all([*footprints, *tapes])
        for k in range(VAL.frames_per_scenario):
            plan = draw_frame(VAL, scenario, number * VAL.frames_per_scenario + k)
            assert taken.distance(shapely.Point(plan.pose_world_robot.translation_m[:2])) > 0.29


def _bottom_m(solid: Solid) -> float:
    return solid.centre_m[2] - solid.size_m[2] / 2


def _footprint(solid: Solid, pose: Pose2) -> shapely.Geometry:
    x, y = solid.size_m[0] / 2, solid.size_m[1] / 2
    turned = affinity.rotate(shapely.box(-x, -y, x, y), solid.yaw_rad, origin=(0, 0), use_radians=True)
    there = affinity.translate(turned, *solid.centre_m[:2])
    return affinity.translate(affinity.rotate(there, pose.yaw_rad, origin=(0, 0), use_radians=True), pose.x_m, pose.y_m)


def test_a_good_share_of_poses_looks_at_signs_boxes_and_cones(plans: Plans) -> None:
    """Counted by geometry of our own: within 25 degrees of straight ahead, 0.6 to 5 m away, a sign's front to us."""
    with_things = [(s, plan) for s, plan in plans if s.signs or any(body.category for body in s.bodies)]
    seen = [_looks_at_a_thing(scenario, plan) for scenario, plan in with_things]
    assert len(seen) > 100 and np.mean(seen) > 0.3


def _looks_at_a_thing(scenario: Scenario, plan: FramePlan) -> bool:
    things = [(sign.x_m, sign.y_m, sign.yaw_rad) for sign in scenario.signs]
    things += [(body.pose.x_m, body.pose.y_m, math.nan) for body in scenario.bodies if body.category]
    x, y, _ = plan.pose_world_robot.translation_m
    yaw = math.atan2(plan.pose_world_robot.rotation[1, 0], plan.pose_world_robot.rotation[0, 0])
    for thing_x, thing_y, facing in things:
        ahead = abs(wrap_rad(math.atan2(thing_y - y, thing_x - x) - yaw)) < math.radians(26)
        front = math.isnan(facing) or math.cos(math.atan2(y - thing_y, x - thing_x) - facing) > 0.4
        if ahead and front and 0.5 < math.dist((x, y), (thing_x, thing_y)) < 5.2:
            return True
    return False


def test_half_of_the_robots_stand_still_and_none_is_faster_than_drawn(plans: Plans) -> None:
    motions = [plan.motion for _, plan in plans]
    assert np.mean([motion == Motion() for motion in motions]) == pytest.approx(0.5, abs=0.1)
    assert all(0 <= motion.v_mps <= 2 and abs(motion.omega_radps) <= 2 for motion in motions)


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


def test_a_split_names_its_course_its_robot_and_whether_there_is_furniture() -> None:
    split = msgspec.structs.replace(VAL, course="b", robot="conde", furniture=False, layouts={"d3_v1": 1.0})
    for number in range(3):
        scenario = draw_scenario(split, number, RIG)
        assert (scenario.course_spec, scenario.robot) == (COURSE_SETS["b"], ROBOTS["conde"])
        assert (scenario.furniture, len(scenario.layout.boxes), scenario.layout.name) == ((), 2, "d3_v1")
        draw_frame(split, scenario, number * split.frames_per_scenario)
