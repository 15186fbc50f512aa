"""A built-in driver with the truth in place of one of its layers, to see what that layer costs.

It lives in the loop's own process. A submission's process knows nothing of this page (a contract of the imports), and
the truth is in no message to it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Agent, Command, Mission, Observation
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.witness import Witness
from adc_bench.geometry import Pose2
from adc_bench.reference import BUILT_IN, Layers
from adc_bench.stack.ekf import Belief
from adc_bench.world.corners_seen import keypoints_as_seen
from adc_bench.world.frame import KEYPOINT_VISIBLE, Detections, Label

TRUE_SIGMA_PX = 0.1
TRUE_COVARIANCE = np.diag(np.square([1e-3, 1e-3, 1e-3]))  # metres and radians: a filter's, all but certain


class PrivilegedAgent:
    """The driver of a built-in's name, with the layer that the witness vouches for."""

    def __init__(self, load: Load, witness: Witness) -> None:
        self._witness = witness
        layers = {"pose": Layers(localizer=self._localizer), "detections": Layers(detect=self._detect)}
        self._driver: Agent = BUILT_IN[load.entry](load.options, layers[witness.privilege])

    def start(self, mission: Mission) -> None:
        """Start the driver."""
        self._driver.start(mission)

    def step(self, observation: Observation) -> Command:
        """Let the driver answer, while the truth of this observation is at hand."""
        self._observation = observation
        return self._driver.step(observation)

    def _localizer(self, mission: Mission) -> "TrueLocalizer":
        return TrueLocalizer(mission=mission, witness=self._witness)

    def _detect(self, rgb: NDArray[np.uint8]) -> Detections:
        """Return what is labelled in one of the observation's pictures."""
        truth = self._witness.tell(self._observation.step)
        camera = next(name for name, picture in self._observation.pictures.items() if picture.rgb is rgb)
        return detections_of(truth.labels[camera], towards_plus_x=math.cos(truth.pose.yaw_rad) > 0)


@dataclass(frozen=True, kw_only=True, eq=False)
class TruePlace:
    """A true pose as a localiser's state."""

    belief: Belief


@dataclass(frozen=True, kw_only=True)
class TrueLocalizer:
    """Says where the robot is, in place of a localiser."""

    mission: Mission
    witness: Witness

    def start(self) -> TruePlace:
        """Return the mission's start pose."""
        return _place(self.mission.start_pose)

    def step(self, state: TruePlace, observation: Observation) -> TruePlace:
        """Return the pose at the observation."""
        return _place(self.witness.tell(observation.step).pose)


def _place(pose: Pose2) -> TruePlace:
    return TruePlace(belief=Belief(mean=np.array([pose.x_m, pose.y_m, pose.yaw_rad]), covariance=TRUE_COVARIANCE))


def detections_of(labels: tuple[Label, ...], *, towards_plus_x: bool) -> Detections:
    """Return labels as a perfect detector's answer, from a robot that looks so; what need not be found is not."""
    found = [label for label in labels if not label.ignore]
    keypoints = keypoints_as_seen(found, towards_plus_x=towards_plus_x)
    return Detections(
        boxes_px=np.array([label.box_px for label in found], dtype=np.float32).reshape(-1, 4),
        scores=np.ones(len(found), dtype=np.float32),
        category_ids=np.array([label.category_id for label in found], dtype=np.int64),
        keypoints_px=keypoints[..., :2],
        keypoint_sigma_px=np.full(keypoints.shape[:2], TRUE_SIGMA_PX, np.float32),
        keypoint_scores=(keypoints[..., 2] == KEYPOINT_VISIBLE).astype(np.float32),
    )
