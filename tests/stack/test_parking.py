"""Parking: what the laser shows to be free, ways that keep clear, stages, and whole manoeuvres before the referee."""

import math

import msgspec
import numpy as np
import pytest
import shapely
from driven_robot import Told, noisy, truth
from panel_pictures import panel
from parked_robot import COURSE, park, suite_of

from adc_bench.api import LaserScan
from adc_bench.evaluate.ground import ground_of
from adc_bench.evaluate.standing import is_inside
from adc_bench.evaluate.suite import load_suite, mission_for
from adc_bench.geometry import Pose2
from adc_bench.stack.manoeuvre import Straight, Turn
from adc_bench.stack.orders_pilot import OrdersPilot, OrdersProgress
from adc_bench.stack.parking import LOOK_S, ParkingPilot, along_lane, plan_parking
from adc_bench.stack.parking_view import free_pose, places_of, points_met
from adc_bench.world.drawing import box_floor
from adc_bench.world.layout import Layout
from adc_bench.world.parking import ParkingKind
from adc_bench.world.parking_zones import free_places
from adc_bench.world.robot import Motion, RobotParams
from adc_bench.world.sensors import LaserSpec
from adc_bench.world.setup import draw_layout
from adc_bench.world.streams import stream

ROBOT, LASER = RobotParams(), LaserSpec()
LANE_Y_M = -COURSE.spec.lane_outer_radius_m
KINDS: dict[str, ParkingKind] = {"random_p2": "parallel", "random_b2": "bay", "open": "parallel"}


def drawn(name: str, seed: int) -> Layout:
    return draw_layout(name, COURSE, stream(seed, "layout"))


def looked_at(layout: Layout, pose: Pose2, rng: np.random.Generator) -> np.ndarray:
    """Return the points of a scan, by intersecting beams with the boxes' floors, with 1 cm of noise."""
    boxes = shapely.union_all([box_floor(box) for box in layout.boxes])
    ranges_m = []
    for k in range(LASER.beams):
        angle = pose.yaw_rad + k * LASER.step_rad - LASER.field_rad / 2
        eye = pose.transform([(LASER.x_m, 0.0)])[0]
        beam = shapely.LineString([eye, eye + LASER.range_max_m * np.array([math.cos(angle), math.sin(angle)])])
        met = beam.intersection(boxes)
        ranges_m.append(shapely.distance(shapely.Point(eye), met) if met else LASER.range_max_m)
    seen = np.array(ranges_m)
    noisy_m = np.where(seen < LASER.range_max_m, seen + 0.01 * rng.standard_normal(len(seen)), seen)
    return points_met(LaserScan(time_s=0.0, ranges_m=noisy_m), LASER, pose)


def abreast(kind: ParkingKind) -> Pose2:
    return Pose2(x_m=places_of(COURSE, kind)[0].pose.x_m, y_m=LANE_Y_M, yaw_rad=0.0)


@pytest.mark.parametrize("name", ["random_p2", "random_b2"])
@pytest.mark.parametrize("seed", range(8))
def test_the_pose_found_lies_in_the_middle_of_the_free_place(name: str, seed: int) -> None:
    layout, kind = drawn(name, seed), KINDS[name]
    rng = np.random.default_rng(seed)
    points = np.concatenate([looked_at(layout, abreast(kind), rng) for _ in range(5)])
    found, (free,) = free_pose(COURSE, kind, points), free_places(COURSE, layout, kind)
    assert is_inside(found, ROBOT, [free])
    assert math.hypot(found.x_m - free.centroid.x, found.y_m - free.centroid.y) < 0.03


def test_without_boxes_it_is_the_parallel_places_middle_and_the_bays_first_place() -> None:
    nothing = np.empty((0, 2))
    parallel, near, far = (place.pose for place in COURSE.parking_places)
    assert free_pose(COURSE, "parallel", nothing) == parallel
    found = free_pose(COURSE, "bay", nothing)
    assert (found.x_m, found.y_m) == pytest.approx((far.x_m, far.y_m)) and found.x_m < near.x_m
    assert found.yaw_rad == pytest.approx(math.pi / 2)


def test_a_few_stray_points_take_no_place() -> None:
    parallel, _, far = (place.pose for place in COURSE.parking_places)
    stray = np.array([(parallel.x_m + 0.5, parallel.y_m), (far.x_m, far.y_m)])
    assert free_pose(COURSE, "parallel", stray) == parallel
    assert free_pose(COURSE, "bay", stray).x_m == pytest.approx(far.x_m)


def test_beside_one_box_the_wider_side_is_free() -> None:
    parallel = COURSE.parking_places[0].pose
    box = np.column_stack([np.linspace(-0.9, -0.3, 60), np.full(60, 0.1)])
    found = free_pose(COURSE, "parallel", parallel.transform(box))
    assert found.x_m - parallel.x_m == pytest.approx((-0.3 + 1.5) / 2)


def way_of(pose: Pose2, place: Pose2) -> list[Pose2]:
    """Return poses densely along the planned way, by the pieces' own ends."""
    poses = [pose]
    for piece in plan_parking(COURSE, pose, place):
        here = poses[-1]
        end = piece.goal if isinstance(piece, Straight) else msgspec.structs.replace(here, yaw_rad=piece.yaw_rad)
        if isinstance(piece, Straight):
            seen = here.inverse() @ end
            assert abs(seen.yaw_rad) < 1e-9 and abs(seen.y_m) < 1e-9
            assert abs(seen.x_m) < 1e-9 or (seen.x_m < 0) == piece.reverse
        for x_m, y_m, yaw_rad in np.linspace(msgspec.structs.astuple(here), msgspec.structs.astuple(end), 40):
            poses.append(Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad))
    return poses


@pytest.mark.parametrize("name", ["random_p2", "random_b2", "open"])
@pytest.mark.parametrize("seed", range(8))
def test_the_way_in_keeps_clear_of_boxes_and_lines_and_ends_well_inside(name: str, seed: int) -> None:
    layout, kind = drawn(name, seed), KINDS[name]
    free = free_places(COURSE, layout, kind)
    rng = np.random.default_rng(seed)
    scans = [looked_at(layout, abreast(kind), rng) for _ in range(5)]
    place = free_pose(COURSE, kind, np.concatenate(scans))
    ground, boxes = ground_of(COURSE, layout, kind), shapely.union_all([box_floor(box) for box in layout.boxes])
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (ROBOT.length_m / 2, ROBOT.width_m / 2)
    wheels = np.array([(0.0, 0.19), (0.0, -0.19)])
    way = way_of(abreast(kind), place)
    for pose in way:
        assert not layout.boxes or shapely.Polygon(pose.transform(corners)).distance(boxes) > 0.08
        assert ground.distance_to_lines_m(pose.transform(wheels)).min() > 0.10
        assert ground.is_drivable(pose.transform(wheels)).all()
    assert any(shapely.Polygon(way[-1].transform(corners)).buffer(0.10).within(zone) for zone in free)


def test_a_place_passed_is_driven_back_to() -> None:
    pose = Pose2(x_m=3.0, y_m=LANE_Y_M, yaw_rad=0.0)
    assert along_lane(COURSE, pose, 2.5).reverse and not along_lane(COURSE, pose, 3.5).reverse
    kinds = [type(piece) for piece in plan_parking(COURSE, pose, COURSE.parking_places[0].pose)]
    assert kinds == [Straight, Turn, Straight, Turn]


def test_stages_follow_one_another_and_looking_ends_by_itself() -> None:
    """A robot set where each piece ends: no scan comes, and parking still goes on."""
    mission = mission_for(load_suite("p2"), latency_s=0.0, options={})
    pilot, pose, stages = ParkingPilot(mission=mission, kind="parallel"), mission.start_pose, []
    state = pilot.start()
    for _ in range(200):
        state, command = pilot.steer(state, pose, Motion())
        stages += [state.stage] if stages[-1:] != [state.stage] else []
        if state.manoeuvre:
            piece = state.manoeuvre[0]
            pose = piece.goal if isinstance(piece, Straight) else msgspec.structs.replace(pose, yaw_rad=piece.yaw_rad)
        if state.is_done:
            break
    assert stages == ["coming", "looking", "entering"] and command == Motion()
    assert state.looked_steps == LOOK_S / mission.control_period_s
    again, command = pilot.steer(state, pose, Motion())
    assert again.is_done and command == Motion()


def test_where_no_boxes_may_stand_it_does_not_look() -> None:
    mission = mission_for(load_suite("b1"), latency_s=0.0, options={})
    pilot = ParkingPilot(mission=mission, kind="bay")
    state, _ = pilot.steer(pilot.start(), mission.start_pose, Motion())
    assert state.stage == "entering"
    scan = LaserScan(time_s=0.0, ranges_m=np.ones(LASER.beams))
    assert pilot.see(state, mission.start_pose, scan) is state


@pytest.mark.parametrize("name", ["p1", "p2", "b1", "b2"])
def test_parks_by_poses_with_noise_before_the_referee(name: str) -> None:
    suite = suite_of(name, 880001, 2)
    for seed in suite.seeds:
        parked = park(suite, seed, noisy(seed, 0.01, math.radians(0.5)))
        assert parked.is_clean, (parked.layout, parked.watch)
        assert parked.at_rest_s < 15.0


class ShownPark(OrdersPilot):
    """The reference's pilot of orders that has read the panel's P."""

    def start(self) -> OrdersProgress:
        """Return the state after two pictures of the P."""
        pose, shown = self.mission.start_pose, panel("park")
        return self.look(self.look(super().start(), pose, shown), pose, shown)


def test_who_obeys_the_panels_parks_when_they_say_so() -> None:
    suite = suite_of("b2", 880002, 1)
    parked = park(suite, suite.seeds[0], make=lambda mission: ShownPark(mission=mission, speed_mps=2.2))
    assert parked.layout.boxes and parked.is_clean


def test_a_box_in_the_way_is_found_to_be_touched() -> None:
    """Blind, it parks in the middle of the parallel place, where a box stands: the judge of these tests sees it."""
    suite = suite_of("p2", 880001, 4)
    blind = msgspec.structs.replace(suite, elements=())
    assert any(park(blind, seed).touched for seed in suite.seeds)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["p1", "p2", "b1", "b2"])
@pytest.mark.parametrize("is_noisy", [False, True])
def test_fifty_arenas_of_each_kind_are_parked_in_without_a_touch(name: str, is_noisy: bool) -> None:
    suite = suite_of(name, 990000, 50)
    for seed in suite.seeds:
        told: Told = noisy(seed, 0.01, math.radians(0.5)) if is_noisy else truth
        parked = park(suite, seed, told)
        assert parked.is_clean and parked.at_rest_s < 15.0, (seed, parked.layout, parked.watch.faults, parked.touched)
