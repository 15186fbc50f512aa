"""Drives as they are simulated: the missions do what they say, and the sensors tell of the true motion."""

import math
from functools import cache

import msgspec
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from adc_bench.dataset import load_split
from adc_bench.dataset.drive_log import DriveLog
from adc_bench.dataset.drive_recipe import Behaviour, MissionName
from adc_bench.dataset.driving.floor import outlines
from adc_bench.dataset.driving.leg import STEP_M
from adc_bench.dataset.driving.plan import DrivePlan, draw_drive
from adc_bench.generate.drive_columns import log_of
from adc_bench.generate.drives import Simulated, simulate
from adc_bench.sim.laser import beam_angles_rad
from adc_bench.world.categories import PanelSign
from adc_bench.world.footprints import extents
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

TRAIN, RIG = load_split("train"), SensorRig()
LEFT_LANE_M = 0.775


@cache
def planned(
    mission: MissionName, behaviour: Behaviour, number: int = 0, duration_s: float = 12.0
) -> tuple[Scenario, DrivePlan]:
    recipe = msgspec.structs.replace(
        TRAIN.drives, missions={mission: 1.0}, behaviours={behaviour: 1.0}, duration_s=(duration_s, duration_s)
    )
    return draw_drive(msgspec.structs.replace(TRAIN, drives=recipe), number, RIG)


@cache
def driven(
    mission: MissionName, behaviour: Behaviour, number: int = 0, duration_s: float = 12.0
) -> tuple[Scenario, DrivePlan, Simulated]:
    scenario, plan = planned(mission, behaviour, number, duration_s)
    return scenario, plan, simulate(scenario, plan)


def poses(simulated: Simulated) -> NDArray[np.float64]:
    """Return x, y and yaw at every step, (n, 3)."""
    found = [row.pose_world_robot for row in simulated.rows]
    yaw = [math.atan2(pose.rotation[1, 0], pose.rotation[0, 0]) for pose in found]
    return np.column_stack([np.array([pose.translation_m[:2] for pose in found]), yaw])


def hits(simulated: Simulated) -> set[str]:
    return {hit.with_name for row in simulated.rows for hit in row.contacts}


def off_line_m(plan: DrivePlan, simulated: Simulated) -> NDArray[np.float64]:
    """Return how far the robot is from the line that it was to drive, (n,)."""
    line = shapely.MultiLineString([leg.poses[:, :2] for leg in plan.legs])
    distance: NDArray[np.float64] = shapely.distance(line, shapely.points(poses(simulated)[:, :2]))
    return distance


@pytest.mark.parametrize("mission", ["speed", "tunnel", "vertical_signs", "signs"])
def test_a_clean_drive_stays_in_its_lane(mission: MissionName) -> None:
    scenario, plan, simulated = driven(mission, "clean", 0, 26.0 if mission == "signs" else 12.0)
    assert off_line_m(plan, simulated).max() < 0.06 and not hits(simulated)
    corners = shapely.get_coordinates(outlines(poses(simulated), scenario.robot))
    assert scenario.course.on_road(corners).all()


def test_a_clean_drive_goes_round_the_boxes_by_the_other_lane() -> None:
    for number in _round_a_box()[:2]:
        scenario, _, simulated = driven("obstacles", "clean", number, 20.0)
        assert not hits(simulated)
        boxes = [shapely.Point(box.x_m, box.y_m) for box in scenario.layout.boxes]
        path = shapely.LineString(poses(simulated)[:, :2])
        assert 0.5 < min(path.distance(box) for box in boxes) < 1.4


def _round_a_box() -> list[int]:
    """Return drives on which a box stands in the robot's lane, early enough."""
    plans = [planned("obstacles", "clean", number, 20.0)[1].legs[0] for number in range(12)]
    early = [leg.aside_m[int(leg.start_m / STEP_M) : int((leg.start_m + 5.0) / STEP_M)] for leg in plans]
    return [number for number, aside_m in enumerate(early) if aside_m.max() > 0.9 * LEFT_LANE_M]


def test_who_means_to_bump_moves_a_box_and_stops() -> None:
    _, _, simulated = driven("obstacles", "bump")
    assert simulated.script.ending == "contact" and any(name.startswith("box") for name in hits(simulated))
    log = log_of(simulated.script, RIG, simulated.rows, [])
    assert set(log.bodies["name"]) == {name.encode() for name in hits(simulated)}
    moved = np.hypot(*np.ptp(log.bodies["pose_world_body"][:, :2], axis=0))
    assert moved > 0.01 and log.bodies["time_s"][0] >= log.contacts["time_s"][0] - 0.05
    last = simulated.rows[-1]
    assert log.contacts["time_s"][0] < last.time_s <= log.contacts["time_s"][0] + 1.6
    assert (log.command["v_mps"][-1], log.command["omega_radps"][-1]) == (0.0, 0.0)


def test_the_corridor_is_driven_without_touching_cones_or_tapes() -> None:
    for number in range(2):
        scenario, _, simulated = driven("works", "clean", number, 22.0)
        works = scenario.layout.works
        assert works and not hits(simulated) and not simulated.rows[-1].torn
        path = shapely.LineString(poses(simulated)[:, :2])
        for gate in ((works.left[0], works.right[0]), (works.left[-1], works.right[-1])):
            assert path.crosses(shapely.LineString(gate))
        assert not scenario.course.on_road(poses(simulated)[:, :2]).all() or _swings_wide(scenario, path)


def _swings_wide(scenario: Scenario, path: shapely.LineString) -> bool:
    edge = shapely.LineString(scenario.course.outer_edge.sample(0.05)[:, :2])
    return bool(path.distance(edge) < 0.2)


@pytest.mark.parametrize("mission", ["parallel_parking", "bay_parking"])
@pytest.mark.parametrize("behaviour", ["clean", "sloppy"])
def test_the_robot_ends_inside_a_parking_place(mission: MissionName, behaviour: Behaviour) -> None:
    for number in range(2):
        scenario, _, simulated = driven(mission, behaviour, number, 40.0)
        assert simulated.script.ending == "finished" and not hits(simulated)
        stands = outlines(poses(simulated)[-1:], scenario.robot)[0]
        inside = []
        for place in scenario.course.parking_places:
            x, y = place.length_m / 2, place.width_m / 2
            area = shapely.Polygon(place.pose.transform([(x, y), (-x, y), (-x, -y), (x, -y)]))
            if area.contains(stands):
                inside.append(place.name)
        assert len(inside) == 1 and inside[0].startswith(mission.split("_")[0])
        assert abs(simulated.rows[-1].motion.v_mps) < 0.01


def test_at_the_cross_the_robot_waits_before_the_stop_line() -> None:
    number = next(n for n in range(40) if planned("signs", "clean", n, 26.0)[1].legs[0].signs[-1][1] == "stop")
    scenario, plan, simulated = driven("signs", "clean", number, 26.0)
    stopped = plan.legs[1].poses[0]
    assert abs(stopped[0]) - scenario.robot.length_m / 2 > scenario.course.spec.crosswalk_depth_m / 2
    near = np.hypot(*(poses(simulated)[:, :2] - stopped[:2]).T) < 0.03
    still = near & np.array([abs(row.motion.v_mps) < 1e-3 for row in simulated.rows])
    signs = [row.sign for row, here in zip(simulated.rows, still, strict=True) if here]
    assert signs[0] == "stop" and len(signs) * 0.05 > 1.5
    assert signs[-1] == plan.legs[1].signs[0][1] != "stop"  # and then goes on under another


@pytest.mark.parametrize("sign", ["up", "left", "right"])
def test_the_way_is_the_one_that_the_panels_show(sign: PanelSign) -> None:
    def shown(number: int) -> bool:
        legs = planned("signs", "clean", number, 26.0)[1].legs
        return len(legs[0].signs) > 1 and legs[0].signs[1][1] == sign

    number = next(number for number in range(200) if shown(number))
    _, _, simulated = driven("signs", "clean", number, 26.0)
    path = poses(simulated)
    crossing = np.flatnonzero(np.abs(path[:, 0]) < 0.1)[0]
    assert simulated.rows[crossing].sign == sign and simulated.rows[0].sign == "stop"
    later = path[crossing:][np.abs(path[crossing:, 0]) > 3.2][0]
    towards_plus_x, on_the_straight = later[0] > 0, later[1] < -1.6
    assert on_the_straight == (sign == "up")
    assert towards_plus_x or sign != "left"
    assert not towards_plus_x or sign != "right"


def test_who_leaves_the_road_and_who_comes_back_to_it() -> None:
    scenario, plan, simulated = driven("speed", "off_road")
    corners = shapely.get_coordinates(outlines(poses(simulated), scenario.robot))
    assert not scenario.course.on_road(corners).all()
    _, plan, simulated = driven("speed", "recovery", 1)
    off = off_line_m(plan, simulated)
    assert off.max() > 0.1 and off.min() < 0.04
    _, plan, simulated = driven("speed", "lane_changes")
    assert (plan.legs[0].aside_m > 0.9 * LEFT_LANE_M).any()


def test_a_sloppy_drive_errs_more_than_a_clean_one() -> None:
    plans = [planned("speed", "sloppy", number)[1] for number in range(5)]
    assert min(np.abs(plan.legs[0].aside_m).mean() for plan in plans) > 0.005
    assert min(plan.hand.steering_radps.std() for plan in plans) > 0.01


@pytest.fixture(scope="module")
def log() -> tuple[Scenario, Simulated, DriveLog]:
    scenario, _, simulated = driven("works", "clean", 0, 22.0)
    return scenario, simulated, log_of(simulated.script, RIG, simulated.rows, [])


def test_samples_lie_on_their_sensors_grids(log: tuple[Scenario, Simulated, DriveLog]) -> None:
    _, simulated, columns = log
    end_s = simulated.rows[-1].time_s
    for group, rate_hz in ((columns.encoders, 50), (columns.imu, 100), (columns.laser, 10), (columns.truth, 20)):
        np.testing.assert_allclose(group["time_s"], np.arange(math.floor(end_s * rate_hz + 1e-6) + 1) / rate_hz)
    for group in (columns.encoders, columns.imu, columns.laser):
        np.testing.assert_array_equal(group["arrival_time_s"], group["time_s"])


def test_a_late_sensors_samples_say_when_they_arrived() -> None:
    scenario, plan = planned("parallel_parking", "clean", 0, 3.0)
    rig = msgspec.structs.replace(RIG, encoders=msgspec.structs.replace(RIG.encoders, latency_s=0.12))
    simulated = simulate(msgspec.structs.replace(scenario, rig=rig), plan)
    columns = log_of(simulated.script, rig, simulated.rows, []).encoders
    np.testing.assert_allclose(columns["arrival_time_s"] - columns["time_s"], 0.12)
    assert columns["arrival_time_s"][-1] <= simulated.rows[-1].time_s < columns["arrival_time_s"][-1] + 0.03


def test_encoders_lead_along_the_true_path(log: tuple[Scenario, Simulated, DriveLog]) -> None:
    """Dead reckoning with the true wheels: what is left is slip and whole ticks."""
    scenario, simulated, columns = log
    truth, robot = scenario.robot_truth, scenario.robot
    per_tick = 2 * math.pi / robot.encoder_ticks_per_turn
    left, right = (
        np.diff(columns.encoders[side].astype(float)) * per_tick * radius
        for side, radius in (
            ("left_ticks", truth.wheel_radius_left_m),
            ("right_ticks", truth.wheel_radius_right_m),
        )
    )
    start = poses(simulated)[0]
    yaw = start[2] + np.concatenate([[0.0], np.cumsum((right - left) / truth.wheel_separation_m)])
    middle = (yaw[1:] + yaw[:-1]) / 2
    x = start[0] + np.concatenate([[0.0], np.cumsum((left + right) / 2 * np.cos(middle))])
    y = start[1] + np.concatenate([[0.0], np.cumsum((left + right) / 2 * np.sin(middle))])
    time_s = columns.truth["time_s"]
    error_m = np.hypot(
        np.interp(time_s, columns.encoders["time_s"], x) - columns.truth["pose_world_robot"][:, 0],
        np.interp(time_s, columns.encoders["time_s"], y) - columns.truth["pose_world_robot"][:, 1],
    )
    travelled_m = np.hypot(*np.diff(poses(simulated)[:, :2], axis=0).T).sum()
    assert travelled_m > 8.0 and error_m.max() < 0.03 * travelled_m


def test_the_gyro_adds_up_to_the_yaw_turned(log: tuple[Scenario, Simulated, DriveLog]) -> None:
    scenario, simulated, columns = log
    bias = scenario.robot_truth.gyro_bias_radps
    turned = np.cumsum((columns.imu["yaw_rate_radps"][1:] - bias) / 100)[4::5]
    true = np.unwrap(poses(simulated)[:, 2])
    np.testing.assert_allclose(turned, (true - true[0])[1 : len(turned) + 1], atol=math.radians(1.5))


def test_the_laser_measures_the_boxes_beside_a_parking_place() -> None:
    number = next(n for n in range(20) if planned("parallel_parking", "clean", n, 40.0)[0].layout.boxes)
    scenario, _, simulated = driven("parallel_parking", "clean", number, 40.0)
    ranges_m = log_of(simulated.script, RIG, simulated.rows, []).laser["ranges_m"]
    assert RIG.laser and ranges_m.shape[1] == RIG.laser.beams
    things = extents((), [body for body in scenario.bodies if body.kind == "box"])
    boxes = shapely.union_all([things.footprint(k) for k in range(len(things.owner))])
    compared = 0
    for scan in range(len(ranges_m) // 3, len(ranges_m), 10):
        x, y, yaw = poses(simulated)[2 * scan]
        origin = np.array([x + RIG.laser.x_m * math.cos(yaw), y + RIG.laser.x_m * math.sin(yaw)])
        angles = yaw + beam_angles_rad(RIG.laser)
        ends = origin + RIG.laser.range_max_m * np.column_stack([np.cos(angles), np.sin(angles)])
        rays = shapely.linestrings(np.stack([np.broadcast_to(origin, ends.shape), ends], axis=1))
        wanted_m = shapely.distance(shapely.Point(origin), shapely.intersection(rays, boxes))  # nan: no box
        met = np.isfinite(wanted_m) & (wanted_m < 2.5)
        error_m = np.abs(ranges_m[scan] - wanted_m)[met]
        assert np.count_nonzero(error_m > 0.08) <= 2  # a grazing beam may slip past an edge
        compared += met.sum()
    assert compared > 200
