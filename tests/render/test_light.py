"""Light without SAPIEN: sums of lights, shadows against rays, bodies that move and come back."""

import math

import numpy as np
import pytest
import shapely
from halls import EAST_FLOOD, TUNNEL, hall
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.render.floor_light import FloorLight
from adc_bench.render.light import TUNNEL_FLOOR_SHARE, TUNNEL_REACH_M, Lighting, flood_rays
from adc_bench.render.moving import lit_pose
from adc_bench.render.shadows import Blockers, Outlines, shadow_points, shadowed
from adc_bench.world.arena import road_centre, tunnel_s_on_centre
from adc_bench.world.layout import BoxPlace
from adc_bench.world.look import Flood
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Solid
from adc_bench.world.works import box_body

BOUNDS = (-3.0, -3.0, 3.0, 1.0)
NORTH_FLOOD = Flood(azimuth_rad=1.3, elevation_rad=0.4, share=0.25)
BOX = box_body(0, BoxPlace(x_m=0.0, y_m=0.0)).parts


def floor(scenario: Scenario, texel_m: float = 0.05) -> FloorLight:
    return FloorLight(Lighting(scenario=scenario), BOUNDS, texel_m)


def points(*places: tuple[float, float]) -> NDArray[np.float64]:
    return np.array(places)


def test_two_floodlights_add_up() -> None:
    """The rest of the light shrinks by the floodlights' shares, so: L(a, b) = L(a) + L(b) - L(none)."""
    sets = ((), (EAST_FLOOD,), (NORTH_FLOOD,), (EAST_FLOOD, NORTH_FLOOD))
    none, east, north, both = (floor(hall(floods=floods)).picture[..., :3].astype(np.float64) for floods in sets)
    np.testing.assert_allclose(both, east + north - none, rtol=1e-4, atol=1e-5)


def test_open_floor_gets_the_look_s_illuminance() -> None:
    scenario = hall(floods=(EAST_FLOOD,), lamp_share=0.0, illuminance_lux=300.0)
    np.testing.assert_allclose(floor(scenario).at(points((-2.5, 0.5)))[0, 1], 1.0, rtol=1e-3)


def test_the_floor_s_picture_is_the_light_at_its_points() -> None:
    """The floor computes its lamps in a way of its own; away from everything that stands, both are equal."""
    scenario = hall(floods=(EAST_FLOOD, NORTH_FLOOD))
    places = points((-1.975, 0.425), (2.325, -0.175), (1.725, -2.075))  # middles of texels
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (3, 3))
    expected = Lighting(scenario=scenario).irradiance(np.column_stack([places, np.zeros(3)]), up)
    np.testing.assert_allclose(floor(scenario, 0.05).at(places), expected, rtol=1e-4)


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 2.5, -2.0])
def test_a_box_throws_its_shadow_away_from_the_floodlight(azimuth: float) -> None:
    scenario = hall(floods=(Flood(azimuth_rad=azimuth, elevation_rad=0.6, share=0.6),), lamp_share=0.0)
    light = floor(scenario)
    light.place({"box_0": (BOX, Pose2(x_m=0.0, y_m=-1.0, yaw_rad=azimuth).to_pose3())})
    out = np.array([math.cos(azimuth), math.sin(azimuth)])
    lit, shaded = light.at(np.array([[0.0, -1.0]]) + 0.55 * np.stack([out, -out]))[:, 1]
    assert shaded < 0.5 * lit


def test_shadow_outlines_are_where_rays_are_blocked() -> None:
    """Points inside the projected hull are those from which the ray to the light meets the box."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        box = Solid(
            name="box",
            kind="box",
            centre_m=(*rng.uniform(-1, 1, 2), rng.uniform(0.3, 0.8)),
            size_m=tuple(rng.uniform(0.1, 0.6, 3)),
            yaw_rad=rng.uniform(-3, 3),
        )
        ray = flood_rays(Flood(azimuth_rad=rng.uniform(-3, 3), elevation_rad=rng.uniform(0.4, 1.2), share=1.0))[0]
        places = rng.uniform(-4, 4, (4000, 2))
        (blocked,) = shadowed(np.column_stack([places, np.zeros(len(places))]), ray[None], Blockers.of([box]))
        corners = box.pose_world_solid().transform(
            np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * box.size_m
        )
        hull = shapely.MultiPoint(shadow_points(corners, np.array([[*ray, 0.0]]))[0]).convex_hull
        away = shapely.distance(hull.exterior, shapely.points(places))
        inside = shapely.contains_xy(hull, places)
        assert (blocked == inside)[away > 1e-6].all() and blocked.any()


def test_a_moved_body_takes_its_shadow_along_to_the_bit() -> None:
    scenario = hall(floods=(EAST_FLOOD, NORTH_FLOOD))
    here, there = (Pose2(x_m=x, y_m=-1.0, yaw_rad=0.4).to_pose3() for x in (-0.6, 0.9))
    other = {"box_1": (BOX, Pose2(x_m=0.2, y_m=-1.3, yaw_rad=1.0).to_pose3())}
    moved, fresh_there, fresh_here = floor(scenario), floor(scenario), floor(scenario)
    moved.place({"box_0": (BOX, here)} | other)
    fresh_here.place(other | {"box_0": (BOX, here)})
    fresh_there.place({"box_0": (BOX, there)} | other)
    assert moved.picture.tobytes() == fresh_here.picture.tobytes()
    moved.place({"box_0": (BOX, there)})
    assert moved.picture.tobytes() == fresh_there.picture.tobytes() != fresh_here.picture.tobytes()
    moved.place({"box_0": (BOX, here)})
    assert moved.picture.tobytes() == fresh_here.picture.tobytes()


def test_the_floor_is_darker_beside_a_body_even_without_lamps() -> None:
    light = floor(hall(floods=(), lamp_share=0.0))
    light.place({"box_0": (BOX, Pose2(x_m=0.0, y_m=-1.0, yaw_rad=0.0).to_pose3())})
    beside, near, far = light.at(points((0.32, -1.0), (0.42, -1.0), (0.9, -1.0)))[:, 1]
    assert beside < near < far


def test_the_tunnel_lets_in_the_documented_share() -> None:
    with_tunnel, without = (Lighting(scenario=hall(tunnel=t, floods=())) for t in (TUNNEL, None))
    course = with_tunnel.scenario.course
    s0, s1 = tunnel_s_on_centre(course, TUNNEL)
    depth = np.array([0.3, 1.0, (s1 - s0) / 2])
    places = np.column_stack([road_centre(course).poses(s0 + depth)[:, :2], np.zeros(3)])
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), places.shape)
    share = with_tunnel.irradiance(places, up)[:, 1] / without.irradiance(places, up)[:, 1]
    mouths = 0.5 * (np.exp(-depth / TUNNEL_REACH_M) + np.exp(-(s1 - s0 - depth) / TUNNEL_REACH_M))
    np.testing.assert_allclose(share, TUNNEL_FLOOR_SHARE + mouths, rtol=0.02)


def test_the_tunnel_keeps_floodlights_out() -> None:
    lighting = Lighting(scenario=hall(tunnel=TUNNEL, floods=(EAST_FLOOD,)))
    s0, s1 = tunnel_s_on_centre(lighting.scenario.course, TUNNEL)
    x, y, _ = road_centre(lighting.scenario.course).poses(np.array([(s0 + s1) / 2]))[0]
    inside, outside = lighting.irradiance(np.array([[x, y, 0.0], [-2.0, -2.6, 0.0]]), np.array([[0.0, 0.0, 1.0]] * 2))
    assert inside[1] < 2 * TUNNEL_FLOOR_SHARE * outside[1]


def test_poses_for_the_light_are_near_the_true_ones_and_do_not_move_again() -> None:
    rng = np.random.default_rng(2)
    for _ in range(50):
        yaw, x, y = rng.uniform(-3, 3, 3)
        pose = Pose2(x_m=x, y_m=y, yaw_rad=yaw).to_pose3()
        near = lit_pose(pose)
        assert np.abs(near.translation_m - pose.translation_m).max() <= 0.0025 + 1e-9
        assert np.abs(near.rotation - pose.rotation).max() < 0.01
        np.testing.assert_allclose(near.rotation @ near.rotation.T, np.eye(3), atol=1e-12)


def test_the_tunnel_s_light_on_the_floor_is_that_at_its_points() -> None:
    """The floor's openness is computed between coarser places; only where a wall stands may it differ by a texel."""
    lighting = Lighting(scenario=hall(tunnel=TUNNEL, floods=()))
    x, y = np.arange(-8.0, 8.0, 0.025), np.arange(-4.0, 4.0, 0.025)
    grid = np.stack([*np.meshgrid(x, y), np.zeros((len(y), len(x)))], axis=2).reshape(-1, 3)
    off = np.abs(lighting.openness_on_floor(x, y).ravel() - lighting.openness(grid))
    assert lighting.openness(grid).min() < 0.1 and (off > 0.005).mean() < 1e-3


def test_bodies_baked_with_the_floor_are_as_if_placed_later() -> None:
    scenario, bodies = hall(floods=(EAST_FLOOD,)), {"box_0": (BOX, Pose2(x_m=0.3, y_m=-1.0, yaw_rad=0.4).to_pose3())}
    later, at_once = floor(scenario), FloorLight(Lighting(scenario=scenario), BOUNDS, 0.05, bodies=bodies)
    later.place(bodies)
    np.testing.assert_array_equal(at_once.picture, later.picture)


def test_a_lamp_too_far_to_be_missed_throws_no_shadow() -> None:
    lighting = Lighting(scenario=hall(floods=(EAST_FLOOD,)))
    casts = lighting.casts(Outlines.of(BOX, Pose2(x_m=9.5, y_m=5.0, yaw_rad=0.0).to_pose3()))
    lamps = np.asarray(casts[4:].reshape(len(lighting.lamps), 4 * len(BOX)).any(axis=1))
    near = [math.hypot(place[0] - 9.5, place[1] - 5.0) < 6.0 for place in lighting.lamps]
    assert casts[:4].all() and lamps[near].all() and not lamps.all()
