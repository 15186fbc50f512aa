"""The robot: nominal parameters known to everyone, and the true ones drawn per seed."""

import math
from collections.abc import Mapping
from typing import Literal

import msgspec
import numpy as np

RobotName = Literal["pioneer", "pioneer-stock", "conde"]


class Motion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Forward speed and turn rate, left positive."""

    v_mps: float = 0.0
    omega_radps: float = 0.0


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


# The parameter sets of benchmark.md; the body of `conde` is its mesh's (adc.md 11) without the camera mast.
ROBOTS: Mapping[RobotName, RobotParams] = {
    "pioneer": RobotParams(),
    "pioneer-stock": RobotParams(name="pioneer-stock", speed_max_mps=1.2),
    "conde": RobotParams(name="conde", wheel_radius_m=0.032, mass_kg=10.6, length_m=0.493, width_m=0.365),
}


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
