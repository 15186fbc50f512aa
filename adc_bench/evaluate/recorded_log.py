"""The logs of runs over recordings: a line an observation, with its truth and what the submission answered."""

import msgspec

from adc_bench.api import Detection
from adc_bench.dataset.drive_recipe import Behaviour, MissionName
from adc_bench.evaluate.run_header import RunHeader
from adc_bench.geometry import Pose2
from adc_bench.world.frame import Label
from adc_bench.world.look import Look

Covariance = tuple[float, float, float, float, float, float, float, float, float]


class Encoders(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The encoder samples of one observation."""

    time_s: tuple[float, ...]
    left_ticks: tuple[int, ...]
    right_ticks: tuple[int, ...]


class LocalizationHeader(RunHeader, frozen=True, kw_only=True, tag="localizer"):
    """A recorded drive: under which light, from where, what was driven and how well."""

    look: Look
    start_pose: Pose2
    mission: MissionName
    behaviour: Behaviour


class Located(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a localiser believes the robot to be at the row's time."""

    estimate: Pose2
    covariance: Covariance | None = None


class LocalizationRow(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The truth at one observation, what the encoders said since the one before, and the answer (none since it
    failed).
    """

    step: int
    time_s: float
    truth: Pose2
    encoders: Encoders
    answer: Located | None


class DetectionHeader(RunHeader, frozen=True, kw_only=True, tag="detector"):
    """A set of pictures."""


class DetectionRow(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A picture: who took it and where that camera was, what is to be found on it (labels without their masks), and the
    answer (none once the detector failed). `pose_world_camera`: x, y, z in metres and the quaternion x, y, z, w.
    """

    step: int
    time_s: float
    camera: str
    pose_world_camera: tuple[float, float, float, float, float, float, float]
    labels: tuple[Label, ...]
    answer: tuple[Detection, ...] | None
