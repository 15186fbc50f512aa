"""The robot: nominal parameters known to everyone, and the true ones drawn per seed."""

import math

import msgspec
import numpy as np

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Camera, Pose3, rotation_zyx


class RobotParams(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A differential-drive robot's nominal figures (default: `pioneer`); part of the rules."""

    name: str = "pioneer"
    wheel_radius_m: float = 0.0975
    wheel_separation_m: float = 0.33
    wheel_width_m: float = 0.05
    mass_kg: float = 9.0
    length_m: float = 0.46
    width_m: float = 0.38
    height_m: float = 0.22
    friction: float = 0.8
    speed_max_mps: float = 2.2
    rim_speed_max_mps: float = 2.45
    acceleration_max_mps2: float = 2.0
    turn_rate_max_radps: float = math.radians(300)
    encoder_ticks_per_turn: int = 500


class RobotTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What differs between this robot and its nominal figures; never told to a submission."""

    wheel_radius_left_m: float
    wheel_radius_right_m: float
    wheel_separation_m: float
    gyro_bias_radps: float
    camera_pitch_rad: float
    camera_roll_rad: float


def draw_robot_truth(params: RobotParams, rng: np.random.Generator) -> RobotTruth:
    """Draw the true parameters: radius sd 0.3 %, left-right difference sd 0.05 %, separation sd 0.5 %, gyro bias
    sd 0.5 deg/s, camera pitch and roll sd 0.3 deg.
    """
    radius = params.wheel_radius_m * (1 + 0.003 * rng.standard_normal())
    difference = params.wheel_radius_m * 0.0005 * rng.standard_normal()
    return RobotTruth(
        wheel_radius_left_m=radius - difference / 2,
        wheel_radius_right_m=radius + difference / 2,
        wheel_separation_m=params.wheel_separation_m * (1 + 0.005 * rng.standard_normal()),
        gyro_bias_radps=math.radians(0.5) * rng.standard_normal(),
        camera_pitch_rad=math.radians(0.3) * rng.standard_normal(),
        camera_roll_rad=math.radians(0.3) * rng.standard_normal(),
    )


class CameraMount(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A camera on the robot: where it sits, where it looks (pitch down positive), what it delivers and how often."""

    name: str
    x_m: float
    z_m: float
    pitch_down_rad: float
    hfov_rad: float
    width_px: int = 320
    height_px: int = 240
    period_steps: int = 1  # control steps between two pictures

    def camera(self) -> Camera:
        """Return the intrinsics."""
        return Camera.from_hfov(width_px=self.width_px, height_px=self.height_px, hfov_rad=self.hfov_rad)

    def resized(self, width_px: int, height_px: int) -> "CameraMount":
        """Return the same mount with another picture size."""
        return msgspec.structs.replace(self, width_px=width_px, height_px=height_px)

    def pose_robot_camera(self, pitch_error_rad: float = 0.0, roll_error_rad: float = 0.0) -> Pose3:
        """Return where the camera (x right, y down, z forward) is, seen from the robot."""
        body = rotation_zyx(0.0, self.pitch_down_rad + pitch_error_rad, roll_error_rad)
        return Pose3(rotation=body @ ROTATION_BODY_OPTICAL, translation_m=np.array([self.x_m, 0.0, self.z_m]))


class SensorRig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The sensors a submission drives with."""

    cameras: tuple[CameraMount, ...] = (
        CameraMount(
            name="road",
            x_m=0.10,
            z_m=0.70,
            pitch_down_rad=math.radians(28),
            hfov_rad=math.radians(70),
            period_steps=1,
        ),
        CameraMount(
            name="panel",
            x_m=-0.05,
            z_m=0.78,
            pitch_down_rad=math.radians(-16),
            hfov_rad=math.radians(90),
            period_steps=4,
        ),
    )
    encoder_rate_hz: int = 50
    imu_rate_hz: int = 100

    def camera(self, name: str) -> CameraMount:
        """Return the mount of this name."""
        return next(mount for mount in self.cameras if mount.name == name)
