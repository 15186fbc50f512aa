"""Arenas to drive in."""

from collections.abc import Callable

import msgspec
import pytest
from made_arenas import NOMINAL, scenario_of_seed

from adc_bench.geometry import Pose2
from adc_bench.world.scenario import Scenario


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
