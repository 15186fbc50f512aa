"""One fault at a time, through the drivers as they are shipped: what it costs, and that it is made good."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from faulted_drive import LAP, Change, Drive, Eyes, drive, mission, world_of

from adc_bench.api import Agent, Observation, Picture
from adc_bench.geometry import Pose2
from adc_bench.reference import BUILT_IN, Layers
from adc_bench.world.categories import CATEGORY_ID, PanelSign
from adc_bench.world.drawing import box_floor
from adc_bench.world.frame import Detections
from adc_bench.world.layout import BoxPlace
from adc_bench.world.robot import RobotParams

BEND_M = 4.0  # of the lap: the robot is at its full speed where the bend begins, 1.35 m on
FROM_S, TO_S, END_S = 1.6, 2.6, 3.6  # the fault's second, in the bend
ROBOT = RobotParams()


def shipped(name: str, eyes: Eyes) -> Agent:
    """Return a built-in driver with these eyes."""
    return BUILT_IN[name]({}, Layers(detect=eyes.detect))


def through_the_bend(change: Change) -> Drive:
    task, eyes = mission(BEND_M), Eyes()
    return drive(shipped("reference", eyes), task, world_of(task), eyes, END_S, change)


def within(from_s: float, to_s: float, change: Change) -> Change:
    return lambda o: change(o) if from_s <= o.time_s < to_s else o


def without_road(o: Observation) -> Observation:
    return replace(o, pictures={name: picture for name, picture in o.pictures.items() if name != "road"})


def dark(o: Observation) -> Observation:
    """The lamps are out: two grey levels of noise."""
    rgb = np.random.default_rng(o.step).integers(0, 3, (240, 320, 3)).astype(np.uint8)
    return replace(o, pictures={name: Picture(time_s=picture.time_s, rgb=rgb) for name, picture in o.pictures.items()})


def spiked(o: Observation) -> Observation:
    rates = o.imu.yaw_rate_radps.copy()
    rates[:2] = 8.0
    return replace(o, imu=replace(o.imu, yaw_rate_radps=rates))


def slipping(o: Observation) -> Observation:
    """In half a second the left wheel turns 12 cm farther than it rolls."""
    ticks = 10 * min(max(round((o.time_s - FROM_S) / 0.05), 0), 10)
    return replace(o, encoders=replace(o.encoders, left_ticks=o.encoders.left_ticks + ticks))


@pytest.mark.parametrize(
    ("change", "aside_m"),
    [
        (within(FROM_S, TO_S, without_road), 0.02),
        (within(FROM_S, TO_S, dark), 0.02),
        (within(2.0, 2.05, spiked), 0.01),
        (slipping, 0.01),
    ],
    ids=["no camera", "darkness", "gyro spike", "wheel slip"],
)
def test_at_full_speed_in_a_bend_a_fault_costs_little_and_is_made_good(change: Change, aside_m: float) -> None:
    run = through_the_bend(change)
    assert run.position_error_m.max() < 0.015
    assert run.heading_error_rad.max() < math.radians(0.5)
    assert run.aside_m.max() < aside_m
    assert run.position_error_m[run.during(TO_S + 0.3, END_S)].max() < 0.006
    assert run.way_m > 5.8  # it did not slow


def test_the_thesis_driver_reckons_through_a_second_without_the_road_camera() -> None:
    task, eyes = mission(BEND_M), Eyes()
    run = drive(shipped("thesis", eyes), task, world_of(task), eyes, END_S, within(FROM_S, TO_S, without_road))
    assert run.position_error_m.max() < 0.04
    assert run.aside_m.max() < 0.03


def test_a_crosswalk_seen_where_there_is_none_does_not_move_the_thesis_driver() -> None:
    """On the way to the crosswalk a false box is surer than anything true, in every picture."""
    task = mission(-2.5)
    box = Detections(
        boxes_px=np.array([(150.0, 90.0, 300.0, 160.0)], dtype=np.float32),
        scores=np.array([0.99], dtype=np.float32),
        category_ids=np.array([CATEGORY_ID["crosswalk"]], dtype=np.int64),
        keypoints_px=np.zeros((1, 4, 2), dtype=np.float32),
        keypoint_sigma_px=np.ones((1, 4), dtype=np.float32),
        keypoint_scores=np.zeros((1, 4), dtype=np.float32),
    )
    eyes = Eyes(seen=lambda time_s: box)
    run = drive(shipped("thesis", eyes), task, world_of(task), eyes, 2.4)
    assert run.position_error_m.max() < 0.03


def test_a_sign_in_one_picture_is_no_order() -> None:
    """Left is shown in one picture among stops: the robot stands until the arrow, and then goes straight on."""
    task = mission(-0.65, elements=("orders",))
    eyes = Eyes(sign=lambda time_s: "left" if 0.35 < time_s < 0.45 else "stop" if time_s < 1.0 else "up")
    run = drive(shipped("reference", eyes), task, world_of(task), eyes, 3.6)
    standing = run.poses[run.time_s < 1.2]
    assert np.ptp(standing[:, 0]) < 0.005
    assert run.poses[-1, 0] > 2.5 and run.aside_m.max() < 0.02


@pytest.mark.parametrize("sign", ["stop", None], ids=["stop", "nothing seen"])
def test_without_the_arrow_it_stands(sign: PanelSign | None) -> None:
    task, eyes = mission(-0.65), Eyes(sign=lambda time_s: sign)
    run = drive(shipped("reference", eyes), task, world_of(task), eyes, 1.0)
    assert run.way_m < 0.005
    assert all((command.v_mps, command.omega_radps) == (0.0, 0.0) for command in run.commands)


def silent(o: Observation) -> Observation:
    return replace(o, laser=None)


def blind(o: Observation) -> Observation:
    """Every beam reads the end of its range."""
    return o if o.laser is None else replace(o, laser=replace(o.laser, ranges_m=np.full_like(o.laser.ranges_m, 3.0)))


def past_a_box(name: str, change: Change) -> tuple[Drive, float]:
    """Return 5 s of a drive from rest past a box 3.2 m ahead, and how near the robot's outline came to it."""
    task, eyes, box_m = mission(-0.65, elements=("boxes",)), Eyes(), 2.55
    run = drive(shipped(name, eyes), task, world_of(task, box_m=box_m), eyes, 5.0, change)
    box = LAP.pose(box_m)
    floor = box_floor(BoxPlace(x_m=box.x_m, y_m=box.y_m, yaw_rad=box.yaw_rad))
    return run, min(outline(Pose2(x_m=x, y_m=y, yaw_rad=yaw)).distance(floor) for x, y, yaw in run.poses)


def outline(pose: Pose2) -> shapely.Polygon:
    """Return the robot's outline on the floor."""
    x_m, y_m = ROBOT.length_m / 2, ROBOT.width_m / 2
    return shapely.Polygon(pose.transform([(x_m, y_m), (-x_m, y_m), (-x_m, -y_m), (x_m, -y_m)]))


@pytest.mark.parametrize("change", [silent, blind])
def test_the_reference_passes_a_box_that_it_saw_before_its_laser_failed(change: Change) -> None:
    run, clear_m = past_a_box("reference", within(1.2, 2.2, change))
    assert clear_m > 0.10 and not run.touched
    assert run.poses[-1, 0] > 3.2


def test_the_thesis_driver_stands_while_its_laser_is_silent_beside_a_box() -> None:
    """A rule that follows the last scan alone would drive on by a scan of long ago."""
    run, clear_m = past_a_box("thesis", within(3.0, 4.0, silent))
    speeds = np.array([command.v_mps for command in run.commands])
    assert (speeds[run.during(2.5, 3.2)] > 0).all()
    assert (speeds[run.during(3.5, 4.0)] == 0).all()
    assert (speeds[run.during(4.1, 5.0)] > 0).all()
    assert clear_m > 0.10 and not run.touched
