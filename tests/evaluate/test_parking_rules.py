"""Parking: inside, at rest for five seconds, and what lies in the way."""

import math

import msgspec
import pytest
from made_runs import COURSE, PERIOD_S, PoseAt, header_of, referee_of, watch_run

from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.suite import load_suite
from adc_bench.geometry import Pose2

P1, P2, B1, B2 = (header_of(load_suite(name)) for name in ("p1", "p2", "b1", "b2"))
PARALLEL, BAY_NEAR, BAY_FAR = (place.pose for place in COURSE.parking_places)


def through(header: Header, *stations: tuple[Pose2, float]) -> PoseAt:
    """Return a robot that goes from the start to poses in turn, at 1 m/s and turning on the way, and rests at each for
    so many seconds; at the last one for good.
    """
    legs, now, here = [], header.start_step * PERIOD_S, header.start_pose
    for pose, rest_s in stations:
        there_s = now + max(math.hypot(pose.x_m - here.x_m, pose.y_m - here.y_m), 0.05)
        legs.append((now, there_s, here, pose))
        now, here = there_s + rest_s, pose

    def pose_at(time_s: float) -> Pose2:
        pose = header.start_pose
        for begin_s, end_s, a, b in legs:
            if time_s > begin_s:
                share = min((time_s - begin_s) / (end_s - begin_s), 1.0)
                pose = Pose2(
                    x_m=a.x_m + share * (b.x_m - a.x_m),
                    y_m=a.y_m + share * (b.y_m - a.y_m),
                    yaw_rad=a.yaw_rad + share * (b.yaw_rad - a.yaw_rad),
                )
        return pose

    return pose_at


def run(header: Header, *stations: tuple[Pose2, float]) -> tuple[Watch, Reason]:
    _, watch, reason = watch_run(header, through(header, *stations))
    return watch, reason


def at(pose: Pose2, ahead_m: float = 0.0, left_m: float = 0.0, turn_rad: float = 0.0) -> Pose2:
    return pose @ Pose2(x_m=ahead_m, y_m=left_m, yaw_rad=turn_rad)


@pytest.mark.parametrize(
    ("place", "parked"),
    [
        (at(PARALLEL), True),
        (at(PARALLEL, ahead_m=1.2), True),
        (at(PARALLEL, turn_rad=math.pi), True),
        (at(PARALLEL, left_m=0.425 - 0.19 - 0.005), True),
        (at(PARALLEL, left_m=0.425 - 0.19 + 0.005), False),
        (at(PARALLEL, left_m=-0.425 + 0.19 + 0.005), True),
        (at(PARALLEL, left_m=-0.425 + 0.19 - 0.005), False),
        (at(PARALLEL, ahead_m=2.3, left_m=-0.1), False),
    ],
)
def test_the_whole_robot_must_be_in_the_parallel_place(place: Pose2, parked: bool) -> None:
    watch, reason = run(P1, (place, 30.0))
    assert (watch.parked_s is not None) == parked
    assert (reason is Reason.FINISHED) == parked
    assert referee_of(P1).completion(watch) == float(parked)


@pytest.mark.parametrize(("rest_s", "parked"), [(4.9, False), (5.1, True)])
def test_five_seconds_at_rest(rest_s: float, parked: bool) -> None:
    watch, reason = run(P1, (at(PARALLEL), rest_s), (P1.start_pose, 30.0))
    assert (watch.parked_s is not None) == parked and reason is (Reason.FINISHED if parked else Reason.BLOCKED)
    if parked:
        way_m = math.hypot(PARALLEL.x_m - P1.start_pose.x_m, PARALLEL.y_m - P1.start_pose.y_m)
        assert watch.parked_s == pytest.approx(referee_of(P1).start_s + way_m, abs=PERIOD_S)
        assert watch.now.time_s == pytest.approx(watch.parked_s + 5.0, abs=1e-6)
        assert referee_of(P1).finished_s(watch) == watch.parked_s


@pytest.mark.parametrize(("speed_mps", "parked"), [(0.015, True), (0.025, False)])
def test_creeping_is_not_standing(speed_mps: float, parked: bool) -> None:
    def creeps(time_s: float) -> Pose2:
        return at(PARALLEL, ahead_m=-0.5 + speed_mps * max(time_s - 10.0, 0.0)) if time_s > 10.0 else P1.start_pose

    _, watch, _ = watch_run(P1, creeps)
    assert (watch.parked_s is not None) == parked


def test_between_the_boxes_and_nowhere_else() -> None:
    (left, right) = sorted(box.x_m for box in P2.layout.boxes)
    middle = Pose2(x_m=(left + right) / 2, y_m=PARALLEL.y_m, yaw_rad=0.0)
    room_m = (right - left - 0.60 - RULES.robot.length_m) / 2
    assert room_m == pytest.approx(0.195)
    for ahead_m, parked in ((room_m - 0.005, True), (room_m + 0.005, False), (-1.25, False)):
        watch, _ = run(P2, (at(middle, ahead_m=ahead_m), 30.0))
        assert (watch.parked_s is not None) == parked


@pytest.mark.parametrize("turn_rad", [0.0, math.pi])
def test_bay_places_nose_or_tail_first(turn_rad: float) -> None:
    for place in (BAY_NEAR, BAY_FAR):
        before = Pose2(x_m=place.x_m, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=place.yaw_rad + turn_rad)
        watch, reason = run(B1, (before, 0.5), (at(place, turn_rad=turn_rad), 30.0))
        assert reason is Reason.FINISHED
        assert watch.faults == (), "the road's line before the bay may be crossed"


def test_the_taken_place_does_not_count() -> None:
    assert B2.layout.name == "b2_v1", "the near place is taken"
    for place, parked in ((BAY_NEAR, False), (BAY_FAR, True)):
        before = Pose2(x_m=place.x_m, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=place.yaw_rad)
        watch, _ = run(B2, (before, 0.5), (at(place), 30.0))
        assert (watch.parked_s is not None) == parked


def test_the_far_line_of_the_bay_is_a_limit() -> None:
    before = Pose2(x_m=BAY_NEAR.x_m, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=BAY_NEAR.yaw_rad)
    line_m = COURSE.spec.bay.depth_m / 2 - COURSE.spec.bay.line_width_m  # from the place's middle to the line
    for ahead_m, touches in ((line_m - 0.005, 0), (line_m + 0.005, 1)):
        watch, _ = run(B1, (before, 0.5), (at(BAY_NEAR, ahead_m=ahead_m), 30.0))
        assert watch.count(FaultKind.LINE_TOUCH) == touches


def test_the_bay_may_only_be_driven_to_where_one_parks_in_it() -> None:
    before = Pose2(x_m=BAY_NEAR.x_m, y_m=-COURSE.spec.lane_outer_radius_m, yaw_rad=BAY_NEAR.yaw_rad)
    header = msgspec.structs.replace(P1, start_pose=B1.start_pose)
    watch, reason = run(header, (before, 0.5), (BAY_NEAR, 30.0))
    assert reason is Reason.OFF_ROAD and watch.count(FaultKind.LINE_TOUCH) == 1


def test_setting_out_before_the_p_is_a_false_start() -> None:
    early = msgspec.structs.replace(P1, start_step=P1.start_step - 3)
    _, watch, _ = watch_run(P1, through(early, (at(PARALLEL), 30.0)))
    assert watch.parked_s is not None and watch.count(FaultKind.FALSE_START) == 1
