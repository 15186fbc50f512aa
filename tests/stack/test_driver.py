"""The whole driver on the oracle's pictures, with a robot that differs from its nominal figures."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import msgspec
import numpy as np
import pytest
import shapely
from floor_pictures import LENSES, look, road_mount

from adc_bench.api import Agent, Command, EncoderSamples, ImuSamples, Mission, Observation, Picture
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack import Driver, StandStill
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.conduct import AfterArrow
from adc_bench.stack.edge_localizer import EdgeLocalizer
from adc_bench.stack.localizer import Localizer, LocalizerParams
from adc_bench.stack.pilots import HeadingPilot, LinePilot
from adc_bench.stack.prediction import arc_step
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.frame import Detections
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import Lens, SensorRig

START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
LAP = Course().lap
PERIOD_S, ENCODER_S = 0.05, 0.02
PANEL = np.zeros((240, 320, 3), dtype=np.uint8)


def rig_behind(lens: Lens) -> SensorRig:
    rig = SensorRig()
    return msgspec.structs.replace(
        rig, cameras=tuple(msgspec.structs.replace(mount, lens=lens) for mount in rig.cameras)
    )


def mission(laps: int = 2, lens: Lens = LENSES["barrel"]) -> Mission:
    return Mission(
        name="test",
        laps=laps,
        time_limit_s=200.0,
        control_period_s=PERIOD_S,
        latency_s=0.0,
        start_pose=START,
        course=CourseSpec(),
        robot=RobotParams(),
        rig=rig_behind(lens),
        options={},
    )


def detections(*seen: tuple[str, tuple[float, float, float, float]]) -> Detections:
    return Detections(
        boxes_px=np.array([box for _, box in seen], dtype=np.float32).reshape(-1, 4),
        scores=np.full(len(seen), 0.9, dtype=np.float32),
        category_ids=np.array([CATEGORY_ID[name] for name, _ in seen], dtype=np.int64),
        keypoints_px=np.zeros((len(seen), 4, 2), dtype=np.float32),
        keypoint_sigma_px=np.ones((len(seen), 4), dtype=np.float32),
        keypoint_scores=np.zeros((len(seen), 4), dtype=np.float32),
    )


@dataclass
class World:
    """A robot with its own wheel radius and camera tilt, and a detector that is told where the crosswalk is."""

    radius_scale: float = 0.997
    pitch_error_rad: float = math.radians(0.2)
    arrow_at_s: float = 0.4
    lens: Lens = LENSES["barrel"]
    pose: Pose2 = START
    time_s: float = 0.0
    wheels_rad: np.ndarray = field(default_factory=lambda: np.zeros(2))
    encoders: list[tuple[float, int, int]] = field(default_factory=lambda: [(0.0, 0, 0)])

    def detect(self, rgb: np.ndarray) -> Detections:
        if rgb is PANEL:
            sign = "panel_up" if self.time_s >= self.arrow_at_s else "panel_stop"
            return detections((sign, (100, 50, 150, 90)))
        ring = shapely.segmentize(shapely.Polygon(self.pose.inverse().transform(Course().crosswalk_corners)), 0.05)
        outline = BirdsEye(mount=road_mount(self.lens)).to_pixels(np.asarray(ring.exterior.coords))
        if np.isnan(outline).any():
            return detections()
        shown = shapely.Polygon(outline).intersection(shapely.box(0, 0, 320, 240))
        return detections() if shown.area < 200 else detections(("crosswalk", shown.bounds))

    def observe(self, step: int, with_road: bool) -> Observation:
        pictures = {}
        if with_road:
            rgb = look(self.pose, mount=road_mount(self.lens), pitch_error_rad=self.pitch_error_rad, seed=step)
            pictures["road"] = Picture(time_s=self.time_s, rgb=rgb)
        if step % 4 == 0:
            pictures["panel"] = Picture(time_s=self.time_s, rgb=PANEL)
        times, left, right = zip(*self.encoders, strict=True) if self.encoders else ((), (), ())
        self.encoders = []
        samples = EncoderSamples(
            time_s=np.array(times), left_ticks=np.array(left, dtype=int), right_ticks=np.array(right, dtype=int)
        )
        none = np.array([])
        imu = ImuSamples(time_s=none, yaw_rate_radps=none, acceleration_x_mps2=none)
        return Observation(step=step, time_s=self.time_s, pictures=pictures, encoders=samples, imu=imu)

    def advance(self, v_mps: float, omega_radps: float) -> None:
        robot, fine_s = RobotParams(), 0.01
        for _ in range(round(PERIOD_S / fine_s)):
            self.pose = self.pose @ arc_step(v_mps * fine_s, omega_radps * fine_s)
            half = omega_radps * robot.wheel_separation_m / 2
            rim_mps = np.array([v_mps - half, v_mps + half])
            self.wheels_rad = self.wheels_rad + rim_mps * fine_s / (robot.wheel_radius_m * self.radius_scale)
            self.time_s = round(self.time_s + fine_s, 9)
            if abs(self.time_s / ENCODER_S - round(self.time_s / ENCODER_S)) < 1e-6:
                left, right = np.floor(self.wheels_rad * robot.encoder_ticks_per_turn / (2 * math.pi)).astype(int)
                self.encoders.append((self.time_s, int(left), int(right)))


def drive(world: World, agent: Agent, seconds: float, with_road: bool = True) -> Iterator[tuple[Pose2, Command]]:
    """Yield the true pose and the answer at every step; a command acts one step after its observation."""
    acting = (0.0, 0.0)
    for step in range(round(seconds / PERIOD_S)):
        command = agent.step(world.observe(step, with_road))
        yield world.pose, command
        world.advance(*acting)
        acting = command.v_mps, command.omega_radps


def error_m(truth: Pose2, command: Command) -> float:
    estimate = command.pose_world_robot
    return math.hypot(estimate.x_m - truth.x_m, estimate.y_m - truth.y_m)


def make_driver(world: World, laps: int = 2, speed_mps: float = 1.0, corrections: bool = True) -> Agent:
    params = LocalizerParams(corrections=corrections)
    agent = Driver(
        world.detect,
        lambda mission: Localizer(mission=mission, detect=world.detect, params=params),
        lambda mission: AfterArrow(pilot=HeadingPilot(mission=mission, speed_mps=speed_mps)),
    )
    agent.start(mission(laps, world.lens))
    return agent


def test_it_waits_for_two_pictures_of_the_arrow() -> None:
    world = World(arrow_at_s=0.4)
    agent = make_driver(world)
    started = [world.time_s for _, command in drive(world, agent, 1.0, with_road=False) if command.v_mps > 0]
    assert started[0] == pytest.approx(0.6)


def test_while_it_waits_the_estimate_is_the_start_pose() -> None:
    world = World(arrow_at_s=9.0)
    for _, command in drive(world, make_driver(world), 0.5):
        assert (command.v_mps, command.omega_radps, command.pose_world_robot) == (0.0, 0.0, START)
        np.testing.assert_allclose(command.covariance, np.diag([0.02, 0.02, 0.05]).ravel() ** 2)


def test_from_pixels_over_the_first_loop_the_s_road_and_the_crosswalk() -> None:
    world = World()
    agent = make_driver(world, speed_mps=1.5)
    errors, offsets, s_m = [], [], 0.0
    for truth, command in drive(world, agent, 17.0):
        errors.append(error_m(truth, command))
        ahead, offset = LAP.project([(truth.x_m, truth.y_m)], around_s_m=s_m)
        s_m = float(ahead[0])
        offsets.append(float(offset[0]))
        covariance = np.array(command.covariance).reshape(3, 3)
        assert np.linalg.eigvalsh(covariance).min() > 0
    assert 22.0 < s_m < 26.0
    assert np.abs(offsets).max() < 0.10
    assert np.sqrt(np.mean(np.square(errors))) < 0.05
    assert errors[-1] < 0.03


def test_the_reference_at_the_limit_from_pixels() -> None:
    world = World()
    agent = Driver(
        world.detect,
        lambda task: EdgeLocalizer(mission=task),
        lambda task: AfterArrow(pilot=LinePilot(mission=task, speed_mps=2.2)),
    )
    agent.start(mission())
    errors, offsets, s_m = [], [], 0.0
    for truth, command in drive(world, agent, 9.0):
        errors.append(error_m(truth, command))
        ahead, offset = LAP.project([(truth.x_m, truth.y_m)], around_s_m=s_m)
        s_m = float(ahead[0])
        offsets.append(float(offset[0]))
    assert 15.0 < s_m < 19.0
    assert np.abs(offsets).max() < 0.05
    assert np.max(errors) < 0.05


def test_without_corrections_it_drifts_as_its_wheels_say() -> None:
    world = World(radius_scale=0.99)
    agent = make_driver(world, corrections=False)
    *_, (truth, command) = drive(world, agent, 6.0, with_road=False)
    assert truth.x_m > 4.0
    assert command.pose_world_robot.x_m - truth.x_m == pytest.approx((truth.x_m - START.x_m) / 99, abs=0.02)
    assert wrap_rad(command.pose_world_robot.yaw_rad - truth.yaw_rad) == pytest.approx(0, abs=0.02)


def test_it_stops_behind_the_finish_line() -> None:
    world = World(radius_scale=1.0)
    agent = make_driver(world, laps=1, speed_mps=1.5, corrections=False)
    *_, (truth, command) = drive(world, agent, 31.0, with_road=False)
    assert (command.v_mps, command.omega_radps) == (0.0, 0.0)
    assert 0.2 < truth.x_m < 0.6 and abs(truth.y_m + 2.6125) < 0.2


def test_it_is_repeatable() -> None:
    runs = []
    for _ in range(2):
        world = World()
        runs.append([command for _, command in drive(world, make_driver(world), 1.5)])
    assert runs[0] == runs[1]


def test_stand_still_stands_still() -> None:
    agent = StandStill()
    agent.start(mission())
    world = World()
    for truth, command in drive(world, agent, 1.0, with_road=False):
        assert (command.v_mps, command.omega_radps, command.pose_world_robot) == (0.0, 0.0, START)
        assert truth == START
