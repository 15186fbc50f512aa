"""A whole driver on the simulated robot and the oracle's pictures, with what a test does to its observations."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import msgspec
import numpy as np
from floor_pictures import look
from numpy.typing import NDArray
from panel_pictures import panel

from adc_bench.api import Agent, Command, Mission, Observation, Picture
from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import Course
from adc_bench.world.frame import Detections
from adc_bench.world.layout import BoxPlace, Layout
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.streams import stream

PERIOD_S, PANEL_STEPS = 0.05, 4
LAP = Course().lap
FAMILY = LookFamily(floors=("felt",), walls=("plaster",), light_sets=("warm_hall",))
Change = Callable[[Observation], Observation]


def unchanged(observation: Observation) -> Observation:
    """Leave an observation as it is."""
    return observation


@dataclass
class Eyes:
    """A detector that is told what the panel's pictures show; anything else it is shown, `seen` says."""

    sign: Callable[[float], PanelSign | None] = lambda time_s: "up"
    seen: Callable[[float], Detections] = lambda time_s: panel(None)
    time_s: float = 0.0
    panel: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((240, 320, 3), dtype=np.uint8))

    def detect(self, rgb: NDArray[np.uint8]) -> Detections:
        """Return what a picture shows."""
        return panel(self.sign(self.time_s)) if rgb is self.panel else self.seen(self.time_s)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drive:
    """By control step: time, true poses (n, 3), the answers; and with what the robot collided."""

    time_s: np.ndarray
    poses: np.ndarray
    commands: list[Command]
    touched: frozenset[str]

    @property
    def position_error_m(self) -> np.ndarray:
        """How far the estimate is from the truth, (n,)."""
        told = np.array([(c.pose_world_robot.x_m, c.pose_world_robot.y_m) for c in self.commands])
        error: np.ndarray = np.hypot(*(told - self.poses[:, :2]).T)
        return error

    @property
    def heading_error_rad(self) -> np.ndarray:
        """How far the estimated heading is from the true one, (n,)."""
        told = np.array([c.pose_world_robot.yaw_rad for c in self.commands])
        error: np.ndarray = np.abs((told - self.poses[:, 2] + math.pi) % (2 * math.pi) - math.pi)
        return error

    @property
    def aside_m(self) -> np.ndarray:
        """How far the robot is from the middle of the lap's lane, (n,)."""
        return np.abs(LAP.project(self.poses[:, :2])[1])

    @property
    def way_m(self) -> float:
        """How far the robot came."""
        return float(np.hypot(*np.diff(self.poses[:, :2], axis=0).T).sum())

    def during(self, from_s: float, to_s: float) -> np.ndarray:
        """Return which steps (n,) lie in a stretch of time."""
        return (self.time_s >= from_s) & (self.time_s < to_s)


def mission(start_m: float, *, elements: tuple[str, ...] = ()) -> Mission:
    """Return the mission of two laps from an arc length of the lap on."""
    return msgspec.convert(
        {
            "name": "faults",
            "laps": 2,
            "elements": elements,
            "time_limit_s": 200.0,
            "control_period_s": PERIOD_S,
            "latency_s": 0.0,
            "start_pose": msgspec.to_builtins(LAP.pose(start_m)),
            "course": {},
            "robot": {},
            "rig": {},
            "options": {},
        },
        Mission,
    )


def world_of(task: Mission, *, box_m: float | None = None, seed: int = 3) -> Simulation:
    """Return the seed's robot at the mission's start, with a box in the middle of the lane at an arc length."""
    boxes = () if box_m is None else (_box(LAP.pose(box_m)),)
    scenario = Scenario(
        name="faults",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(task.robot, stream(seed, "robot")),
        panel_sign="up",
        layout=Layout(name="faults", boxes=boxes),
        robot=task.robot,
        rig=msgspec.structs.replace(SensorRig(), laser=SensorRig().laser if boxes else None),
    )
    return Simulation(scenario, task.start_pose, PERIOD_S)


def _box(pose: Pose2) -> BoxPlace:
    return BoxPlace(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=pose.yaw_rad)


def drive(
    agent: Agent, task: Mission, world: Simulation, eyes: Eyes, seconds: float, change: Change = unchanged
) -> Drive:
    """Drive for so long; a command acts one step after its observation."""
    agent.start(task)
    queue, rows, commands, touched = deque([(0.0, 0.0)]), [], [], set()
    for step in range(round(seconds / PERIOD_S)):
        pose, eyes.time_s = world.state().pose_world_robot, world.time_s
        command = agent.step(change(_observe(world, eyes, step, pose)))
        rows.append((world.time_s, pose.x_m, pose.y_m, pose.yaw_rad))
        commands.append(command)
        world.advance(*queue.popleft())
        queue.append((command.v_mps, command.omega_radps))
        touched |= {contact.with_name for contact in world.take_contacts()}
    table = np.array(rows)
    return Drive(time_s=table[:, 0], poses=table[:, 1:], commands=commands, touched=frozenset(touched))


def _observe(world: Simulation, eyes: Eyes, step: int, pose: Pose2) -> Observation:
    readings, time_s = world.read_sensors(), world.time_s
    pictures = {"road": Picture(time_s=time_s, rgb=look(pose, seed=step))}
    if step % PANEL_STEPS == 0:
        pictures["panel"] = Picture(time_s=time_s, rgb=eyes.panel)
    return Observation(
        step=step,
        time_s=time_s,
        pictures=pictures,
        encoders=readings.encoders,
        imu=readings.imu,
        laser=readings.laser,
    )
