"""Arenas to drive in."""

from collections.abc import Callable

import msgspec
import pytest

from adc_bench.geometry import Pose2
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import RobotParams, RobotTruth, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.streams import stream

FAMILY = LookFamily(floors=("felt",), walls=("plaster",), light_sets=("warm_hall",))
NOMINAL = RobotTruth(
    wheel_radius_left_m=0.0975,
    wheel_radius_right_m=0.0975,
    wheel_separation_m=0.33,
    gyro_bias_radps=0.0,
    camera_pitch_rad=0.0,
    camera_roll_rad=0.0,
)


def scenario_of_seed(seed: int) -> Scenario:
    return Scenario(
        name=f"drive-{seed}",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(RobotParams(), stream(seed, "robot")),
        panel_sign="up",
    )


@pytest.fixture
def drawn() -> Callable[[int], Scenario]:
    """A scenario with its robot drawn from the seed."""
    return scenario_of_seed


@pytest.fixture
def nominal(drawn: Callable[[int], Scenario]) -> Scenario:
    """A scenario whose robot is exactly as its data sheet says."""
    return msgspec.structs.replace(drawn(1), robot_truth=NOMINAL)


@pytest.fixture
def start() -> Pose2:
    return Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
