from collections.abc import Callable

import pytest

from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import CourseSpec
from adc_bench.world.layout import Layout
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import set_up
from adc_bench.world.streams import stream

SetUp = Callable[..., Scenario]


@pytest.fixture(scope="session")
def arena() -> SetUp:
    """Sets up a scenario; keywords replace those of `set_up`."""
    family = LookFamily(floors=("felt",), walls=("brick",), light_sets=("window_left",))
    given = {
        "name": "test",
        "seed": 1,
        "look": draw_look(family, stream(1, "look")),
        "panel_sign": "up",
        "layout": Layout(),
        "course": CourseSpec(),
        "arena": ArenaSpec(),
        "robot": RobotParams(),
        "rig": SensorRig(),
    }

    def build(**changed: object) -> Scenario:
        return set_up(**(given | changed))

    return build
