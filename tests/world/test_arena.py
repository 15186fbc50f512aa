import math

import msgspec
import numpy as np
import pytest

from adc_bench.world.arena import ArenaSpec, Tunnel, gantry_solids, panel_solids, road_centre, tunnel_solids
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID, PANEL_SIGNS
from adc_bench.world.course import Course
from adc_bench.world.look import FLOOR_TEXTURES, LIGHT_LEVELS, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.sensors import CameraMount, Lens, SensorRig
from adc_bench.world.streams import stream

COURSE, SPEC = Course(), ArenaSpec()


def test_panels_hang_over_the_lanes_and_face_the_traffic_tilted_down() -> None:
    west, east = panel_solids(SPEC, COURSE)
    assert (west.centre_m[1], east.centre_m[1]) == pytest.approx((-2.6125, -1.8375))
    for panel, direction in ((west, -1.0), (east, 1.0)):
        screen = panel.pose_world_solid().rotation[:, 0]
        assert screen[0] == pytest.approx(direction * math.cos(SPEC.panel_tilt_rad))
        assert screen[2] == pytest.approx(-math.sin(SPEC.panel_tilt_rad))


def test_the_gantry_stands_outside_the_road() -> None:
    posts = [s for s in gantry_solids(SPEC, COURSE) if "post" in s.name]
    assert not COURSE.on_road(np.array([post.centre_m[:2] for post in posts])).any()


def test_a_tunnel_clears_both_lanes_and_covers_its_length() -> None:
    tunnel = Tunnel(start_s_m=8.0, length_m=4.0)
    solids = tunnel_solids(SPEC, COURSE, tunnel)
    walls = [s for s in solids if "roof" not in s.name]
    _, offset = road_centre(COURSE).project([s.centre_m[:2] for s in walls], around_s_m=10.0, window_m=6.0)
    assert np.all(np.abs(offset) - SPEC.tunnel_wall_m > SPEC.tunnel_clear_half_width_m - 0.05)
    roofs = [s for s in solids if "roof" in s.name]
    assert sum(s.size_m[0] for s in roofs) > 4.0
    assert all(s.centre_m[2] > SPEC.panel_centre_z_m + 0.2 for s in roofs)


def test_categories_are_numbered_from_one_in_the_published_order() -> None:
    assert CATEGORIES[0] == "crosswalk" and CATEGORY_ID["crosswalk"] == 1
    assert [CATEGORY_ID[f"panel_{sign}"] for sign in PANEL_SIGNS] == [2, 3, 4, 5, 6, 7]
    assert len(CATEGORIES) == 21 and CATEGORIES[-2:] == ("box", "cone")


def test_streams_repeat_and_do_not_depend_on_each_other() -> None:
    assert stream(1, "a").random() == stream(1, "a").random()
    draws = {stream(seed, name).random() for seed in range(5) for name in ("look", "noise", "robot")}
    assert len(draws) == 15


def test_looks_come_from_their_family_and_light_levels_span_a_hundred_to_one() -> None:
    family = LookFamily(
        floors=("felt",), walls=("brick",), light_sets=("window_left",), light_levels=("dark", "bright")
    )
    looks = [draw_look(family, stream(seed, "look")) for seed in range(50)]
    assert {look.floor for look in looks} == {"felt"} and {look.light_level for look in looks} == {"dark", "bright"}
    for look in looks:
        low, high = LIGHT_LEVELS[look.light_level]
        assert low <= look.illuminance_lux <= high
        low, high = LIGHT_SETS["window_left"].flood_azimuth_rad
        assert low <= look.floods[0].azimuth_rad <= high
    assert LIGHT_LEVELS["bright"][1] / LIGHT_LEVELS["dark"][0] >= 100


def test_every_named_surface_can_be_drawn() -> None:
    from adc_bench.render.textures import FLOOR_KINDS, WALL_KINDS

    assert set(FLOOR_KINDS) == set(FLOOR_TEXTURES) and set(WALL_KINDS) == set(WALL_TEXTURES)


def test_true_robots_scatter_as_the_rules_say() -> None:
    params = RobotParams()
    truths = [draw_robot_truth(params, stream(seed, "robot")) for seed in range(4000)]
    mean_radius = (
        np.array([(t.wheel_radius_left_m + t.wheel_radius_right_m) / 2 for t in truths]) / params.wheel_radius_m
    )
    difference = np.array([t.wheel_radius_right_m - t.wheel_radius_left_m for t in truths]) / params.wheel_radius_m
    separation = np.array([t.wheel_separation_m for t in truths]) / params.wheel_separation_m
    bias = np.degrees([t.gyro_bias_radps for t in truths])
    pitch = np.degrees([t.camera_pitch_rad for t in truths])
    sds = [x.std() for x in (mean_radius, difference, separation, bias, pitch)]
    assert sds == pytest.approx([0.003, 0.0005, 0.005, 0.5, 0.3], rel=0.05)


def test_the_road_camera_sees_from_0_48_m_ahead_to_the_horizon() -> None:
    """As a pinhole; its lens shows a little more."""
    mount = SensorRig().camera("road")
    pinhole, lens = (_seen(mount, k) for k in (Lens(k1=0.0, k2=0.0), mount.lens))
    assert pinhole[0] == pytest.approx(0.48, abs=0.01) and abs(pinhole[1]) < 1.0
    assert 0.44 < lens[0] < pinhole[0] and pinhole[1] < lens[1] < 3.0


def _seen(mount: CameraMount, lens: Lens) -> tuple[float, float]:
    """Where the floor's nearest pixel is ahead of the mount in metres, and the elevation of the top row in degrees."""
    pose, camera = mount.pose_robot_camera(), msgspec.structs.replace(mount, lens=lens).camera()
    bottom, top = (pose.rotation @ ray for ray in camera.rays([[160, 240], [160, 0]]))
    return bottom[0] * mount.z_m / -bottom[2], math.degrees(math.atan2(top[2], top[0]))


def test_the_panel_camera_looks_16_degrees_up() -> None:
    forward = SensorRig().camera("panel").pose_robot_camera().rotation[:, 2]
    assert math.degrees(math.asin(forward[2])) == pytest.approx(16)
