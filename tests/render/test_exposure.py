"""Auto-exposure: what it settles on, how it follows, how it is brought about."""

import math
from collections.abc import Callable

import cv2
import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.render.exposure import Metered, exposure_for, follow, moved, shutter_and_gain, way_back
from adc_bench.world.arena import Tunnel
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import IDEAL, Imaging

Make = Callable[..., Scenario]
LAG_S = 0.4
OVER_EAST_LOOP = Tunnel(start_s_m=8.0, length_m=4.0)
speeds, rates = st.floats(-2.2, 2.2), st.floats(-5, 5)


def test_the_step_response_has_the_time_constant() -> None:
    start = Metered(time_s=1.0, exposure=0.5)
    stops = [math.log2(4.0 / follow(start, 4.0, 1.0 + k * LAG_S, LAG_S).exposure) for k in range(4)]
    assert stops == pytest.approx([3 * math.exp(-k) for k in range(4)])


@given(st.lists(st.floats(0.001, 0.5), min_size=1, max_size=20), st.floats(0.1, 6))
def test_many_steps_towards_one_light_are_as_good_as_one(steps_s: list[float], wanted: float) -> None:
    now = start = Metered(time_s=0.0, exposure=1.0)
    for step_s in steps_s:
        now = follow(now, wanted, now.time_s + step_s, LAG_S)
    assert now.exposure == pytest.approx(follow(start, wanted, now.time_s, LAG_S).exposure)


def test_without_a_lag_or_a_past_the_exposure_has_settled() -> None:
    assert follow(Metered(time_s=0.0, exposure=1.0), 3.0, 0.05, 0.0).exposure == 3.0
    assert follow(None, 3.0, 0.05, LAG_S).exposure == 3.0


def test_white_paint_comes_out_at_seven_tenths_down_to_60_lux(scenario_of: Make) -> None:
    look = msgspec.structs.replace(scenario_of().look, exposure_bias_ev=0.0)
    assert 0.8 * 2.0 * exposure_for(look, 2.0) == pytest.approx(0.7)
    assert exposure_for(look, 0.2) == exposure_for(look, 0.001)


@given(st.floats(0.01, 20))
def test_time_and_gain_make_the_exposure(exposure: float) -> None:
    imaging = Imaging()
    shutter_s, gain = shutter_and_gain(exposure, imaging)
    reference_s, one = shutter_and_gain(0.1, imaging)
    assert one == 1.0 and gain >= 1.0 and shutter_s <= imaging.shutter_max_s
    assert shutter_s * gain == pytest.approx(reference_s * exposure / 0.1)
    assert gain == 1.0 or shutter_s == imaging.shutter_max_s


def test_a_camera_without_blur_has_no_exposure_time_but_the_usual_gain() -> None:
    assert shutter_and_gain(5.0, IDEAL) == (0.0, shutter_and_gain(5.0, Imaging(shutter_max_s=1 / 60))[1])


@given(speeds, rates, st.floats(-2, 2))
def test_an_arc_there_and_back_ends_where_it_began(v_mps: float, omega_radps: float, time_s: float) -> None:
    motion = Motion(v_mps=v_mps, omega_radps=omega_radps)
    back = moved(motion, time_s) @ moved(motion, -time_s)
    assert np.allclose([back.x_m, back.y_m, back.yaw_rad], 0, atol=1e-9)


@given(speeds, rates)
def test_an_arc_is_what_many_short_straights_add_up_to(v_mps: float, omega_radps: float) -> None:
    pose, dt_s = Pose2(x_m=0.0, y_m=0.0, yaw_rad=omega_radps * 5e-4), 1e-3
    for _ in range(500):
        pose = pose @ Pose2(x_m=v_mps * dt_s, y_m=0.0, yaw_rad=omega_radps * dt_s)
    arc = moved(Motion(v_mps=v_mps, omega_radps=omega_radps), 0.5)
    assert math.hypot(arc.x_m - pose.x_m, arc.y_m - pose.y_m) < 1e-5


def test_the_way_back_ends_here_and_is_driven_at_the_motion() -> None:
    here = Pose2(x_m=1.0, y_m=2.0, yaw_rad=0.3).to_pose3()
    way = way_back(here, Motion(v_mps=1.0), LAG_S)
    assert way[-1][0] == 0 and np.allclose(way[-1][1].matrix(), here.matrix())
    assert way[0][0] <= -3 * LAG_S + 1e-9
    back = [here.inverse().transform(pose.translation_m[None])[0] for _, pose in way]
    assert np.allclose(back, [[time_s, 0, 0] for time_s, _ in way])
    assert len(way_back(here, Motion(), LAG_S)) == 1


def test_frames_at_the_tunnel_mouths_are_exposed_for_where_the_robot_came_from(
    renderer: ArenaRenderer, scenario_of: Make
) -> None:
    scenario = scenario_of("normal", tunnel=OVER_EAST_LOOP)
    renderer.load(scenario)
    for s_m, longer in ((7.5, False), (11.5, True)):
        pose = scenario.course.lap.pose(s_m).to_pose3()
        curvature = 1 / scenario.course.spec.lane_outer_radius_m
        driving = Motion(v_mps=1.0, omega_radps=curvature)
        came = renderer.frame(0, "road", pose, motion=driving).conditions.exposure
        stood = renderer.frame(0, "road", pose).conditions.exposure
        assert stood == pytest.approx(renderer.exposure(pose))
        assert came > 1.15 * stood if longer else came < stood / 1.1


def test_a_drive_into_the_tunnel_agrees_with_frames_along_it(renderer: ArenaRenderer, scenario_of: Make) -> None:
    """The exposure after driving up to a place is that of a frame taken there by itself."""
    scenario = scenario_of("normal", tunnel=OVER_EAST_LOOP)
    renderer.load(scenario)
    motion = Motion(v_mps=1.0, omega_radps=1.0 / scenario.course.spec.lane_outer_radius_m)
    before = None
    for step in range(60):
        pose = scenario.course.lap.pose(4.6 + 0.05 * step).to_pose3()
        before = follow(before, renderer.exposure(pose), 0.05 * step, LAG_S)
    assert before
    alone = renderer.frame(0, "road", pose, motion=motion).conditions.exposure
    assert abs(math.log2(alone / before.exposure)) < 0.2


def brightness(file: bytes) -> float:
    return float(cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_GRAYSCALE).mean())


def test_the_first_picture_has_settled_and_a_new_scenario_forgets(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal", tunnel=OVER_EAST_LOOP)
    outside, inside = (scenario.course.lap.pose(s_m).to_pose3() for s_m in (2.0, 9.5))
    renderer.load(scenario)
    fresh = renderer.picture("road", inside, time_s=0.0)
    renderer.load(scenario)
    renderer.picture("panel", outside, time_s=0.0)
    assert renderer.picture("road", inside, time_s=0.0) == fresh  # each camera follows by itself
    renderer.load(scenario)
    renderer.picture("road", outside, time_s=0.0)
    assert brightness(renderer.picture("road", inside, time_s=0.05)) < 0.8 * brightness(fresh)
    assert brightness(renderer.picture("road", inside, time_s=5.0)) == pytest.approx(brightness(fresh), rel=0.02)
