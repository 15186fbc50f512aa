"""The contract of a submission: a factory returns an `Agent`; it gets `Observation`s and answers with `Command`s. A
detector gets pictures, and answers with `Detection`s.

Nothing here holds, or can hold, the truth.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.world.categories import Category, SignCategory
from adc_bench.world.course import CourseSpec
from adc_bench.world.parking import ParkingKind
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import SensorRig

# What a submission is: it drives, or says where a robot is that others drive, or what is on pictures.
Kind = Literal["driver", "localizer", "detector"]
Point = tuple[float, float]

Element = Literal["orders", "boxes", "tunnel", "works", "vertical_signs"]


class Mission(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a submission knows before it drives: the task, the map, the nominal robot and rig, the start pose.

    Attributes:
        laps: how many are to be driven; 0 where one only parks.
        parking: where the panels' P sends the robot at the end; None where the run ends on the crosswalk.
        elements: what the run may hold. `orders`: the panels may also say left, right and stop; without it they only
            start and end the run. `vertical_signs`: they are to be reported, see `Command.sign`.
    """

    name: str
    laps: int
    parking: ParkingKind | None = None
    elements: tuple[Element, ...] = ()
    time_limit_s: float
    control_period_s: float
    latency_s: float
    start_pose: Pose2
    course: CourseSpec
    robot: RobotParams
    rig: SensorRig
    options: dict[str, str]


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A delivered picture: rgb (height, width, 3) uint8, as decoded from the rig's JPEG."""

    time_s: float
    rgb: NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True, eq=False)
class EncoderSamples:
    """Encoder readings since the last observation: time_s (n,), cumulative ticks left and right (n,)."""

    time_s: NDArray[np.float64]
    left_ticks: NDArray[np.int64]
    right_ticks: NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class ImuSamples:
    """Gyro and accelerometer readings since the last observation, each (n,)."""

    time_s: NDArray[np.float64]
    yaw_rate_radps: NDArray[np.float64]
    acceleration_x_mps2: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class LaserScan:
    """One scan: ranges_m (beams,); beam k looks at the angle -field / 2 + k step, left positive, as its spec says."""

    time_s: float
    ranges_m: NDArray[np.float64]


class SeenObject(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An object that a semantic camera has in view, and where it is, seen from the robot.

    The pose is on the floor: the crosswalk's middle with the road's direction there; where a sign or panel hangs and
    the way it faces; where a box or cone stands.
    """

    category: str
    instance: str
    pose_robot_object: Pose2


@dataclass(frozen=True, kw_only=True, eq=False)
class Observation:
    """What the sensors delivered up to `time_s`; `pictures` holds what arrived from the cameras.

    `laser` is the newest scan that became due at this step, None if none did; `objects` is what the rig's semantic
    camera has in view, empty without one.
    """

    step: int
    time_s: float
    pictures: Mapping[str, Picture]
    encoders: EncoderSamples
    imu: ImuSamples
    laser: LaserScan | None = None
    objects: tuple[SeenObject, ...] = ()


class Command(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the robot shall do, and where the submission believes it is at the observation's `time_s`.

    `covariance` is optional: the (x, y, yaw) covariance of the estimate, nine figures by rows. `sign` reports the
    vertical sign that the robot is coming to; once a sign is enough, again does no harm.
    """

    v_mps: float
    omega_radps: float
    pose_world_robot: Pose2
    covariance: tuple[float, float, float, float, float, float, float, float, float] | None = None
    sign: SignCategory | None = None


@runtime_checkable
class Agent(Protocol):
    """A driver: told the mission once, then asked once a control step."""

    def start(self, mission: Mission) -> None:
        """Get ready; may take seconds."""
        ...

    def step(self, observation: Observation) -> Command:
        """Answer one observation."""
        ...


class Detection(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An object found on a picture, in pixels: x to the right, y downwards, from the picture's top left corner.

    Attributes:
        score: how likely it is right, 0 to 1.
        box_px: left, top, right, bottom.
        corners_px: optional, the corners of a crosswalk, panel or sign. Of the crosswalk far left, far right, near
            right, near left of who looks at it; of a board from its own top left clockwise as seen from the front.
    """

    category: Category
    score: float
    box_px: tuple[float, float, float, float]
    corners_px: tuple[Point, Point, Point, Point] | None = None


@runtime_checkable
class PictureDetector(Protocol):
    """A detector: told the mission once, for its rig and its options, then asked about one picture after another."""

    def start(self, mission: Mission) -> None:
        """Get ready; may take seconds."""
        ...

    def detect(self, rgb: NDArray[np.uint8]) -> Sequence[Detection]:
        """Return what is on a picture (height, width, 3)."""
        ...
