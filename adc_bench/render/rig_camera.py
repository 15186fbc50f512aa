"""One camera of the rig, from the light that reaches it to the file that it delivers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.exposure import shutter_and_gain
from adc_bench.render.light import white_of
from adc_bench.render.motion_blur import MotionBlur
from adc_bench.render.sensor import Sensor
from adc_bench.render.view import View
from adc_bench.world.look import Look
from adc_bench.world.robot import Motion
from adc_bench.world.sensors import CameraMount, Imaging


@dataclass(frozen=True, kw_only=True, eq=False)
class Taken:
    """A delivered picture and how it came about; `blur_px` is the mean over the picture."""

    file: bytes
    exposure: float
    shutter_s: float
    blur_px: float


class RigCamera:
    """Its view of the scene with the lens, its motion blur, its sensor."""

    def __init__(self, view: View, mount: CameraMount) -> None:
        self.view, self.mount = view, mount
        self._blur = MotionBlur(view.camera)
        self._sensor = Sensor(mount)

    def expose(self, pose_world_camera: Pose3, look: Look, exposure: float) -> None:
        """Draw what the camera sees at an exposure, with its white balance."""
        self.view.take(pose_world_camera, exposure * white_gains(look, self.mount.imaging))

    def develop(
        self, poses_world: tuple[Pose3, Pose3], exposure: float, motion: Motion, rng: np.random.Generator
    ) -> Taken:
        """Return the file made of what was drawn; `poses_world` are the robot's and the camera's at mid-exposure."""
        shutter_s, gain = shutter_and_gain(exposure, self.mount.imaging)
        flow = self._blur.flow(*poses_world, motion, shutter_s)
        picture = self._sensor.develop(self.view.colour(flow), gain, rng)
        return Taken(
            file=self._sensor.encode(picture),
            exposure=exposure,
            shutter_s=shutter_s,
            blur_px=flow.mean_px if flow else 0.0,
        )


def white_gains(look: Look, imaging: Imaging) -> NDArray[np.float64]:
    """Return the gains (3,) by which a camera takes its share of the lamps' colour out."""
    gains: NDArray[np.float64] = white_of(look.colour_temperature_k) ** -imaging.white_balance
    return gains
