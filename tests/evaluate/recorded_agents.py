"""Localisers and detectors, most of them broken in one way each, for a `submission.toml`: recorded_agents:Name."""

import os
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Command, Detection, Mission, Observation
from adc_bench.geometry import Pose2

AT = 2  # the observation at which it happens
BOX = (10.0, 20.0, 30.0, 40.0)


class Located:
    """Says where it started, with what it has seen as the speed; strikes at its time."""

    def start(self, mission: Mission) -> None:
        self.pose = mission.start_pose

    def step(self, observation: Observation) -> Command:
        if observation.step == AT:
            return self.strike()
        seen = sum(float(picture.rgb.mean()) for picture in observation.pictures.values())
        return Command(v_mps=seen, omega_radps=0.0, pose_world_robot=self.pose, covariance=tuple(np.eye(3).ravel()))

    def strike(self) -> Command:
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose)


class Sure(Located):
    def strike(self) -> Command:
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose, covariance=tuple(np.eye(3).ravel()))


class LocatedRaises(Located):
    def strike(self) -> Command:
        raise ValueError("lost")


class LocatedNan(Located):
    def strike(self) -> Command:
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=Pose2(x_m=float("nan"), y_m=0.0, yaw_rad=0.0))


class LocatedWrongShape(Located):
    def strike(self) -> Command:
        square: Any = np.eye(3)
        return Command(v_mps=0.0, omega_radps=0.0, pose_world_robot=self.pose, covariance=square)


class LocatedSleeps(Located):
    def strike(self) -> Command:
        time.sleep(600)
        return super().strike()


class LocatedDies(Located):
    def strike(self) -> Command:
        os._exit(7)


class Finder:
    """Finds a box on every picture, with numpy's numbers; strikes at its time."""

    def start(self, mission: Mission) -> None:
        self.count = 0

    def detect(self, rgb: NDArray[np.uint8]) -> Sequence[Detection]:
        self.count += 1
        return self.strike() if self.count == AT + 1 else self.find(rgb)

    def find(self, rgb: NDArray[np.uint8]) -> list[Detection]:
        assert rgb.shape == (240, 320, 3) and rgb.dtype == np.uint8
        return [Detection(category="box", score=np.float32(0.5), box_px=tuple(np.array(BOX)))]

    def strike(self) -> Sequence[Detection]:
        return ()

    def box(self, **changed: Any) -> list[Detection]:
        return [Detection(**{"category": "box", "score": 0.5, "box_px": BOX, **changed})]


class FinderRaises(Finder):
    def strike(self) -> Sequence[Detection]:
        raise ValueError("blind")


class FinderNan(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(score=float("nan"))


class FinderNanCorner(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(category="crosswalk", corners_px=((0.0, 0.0), (1.0, float("inf")), (0.0, 0.0), (0.0, 0.0)))


class FinderHuge(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(box_px=(0.0, 0.0, 1e300, 1.0))


class FinderTooSure(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(score=1.5)


class FinderWrongShape(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(box_px=(1.0, 2.0, 3.0))


class FinderUnknownCategory(Finder):
    def strike(self) -> Sequence[Detection]:
        return self.box(category="tree")


class FinderNoList(Finder):
    def strike(self) -> Any:
        return None


class FinderOfTuples(Finder):
    def strike(self) -> Any:
        return [("box", 0.5, BOX)]


class FinderTooMany(Finder):
    def strike(self) -> Sequence[Detection]:
        return 101 * self.box()


class FinderSleeps(Finder):
    def strike(self) -> Sequence[Detection]:
        time.sleep(600)
        return ()
