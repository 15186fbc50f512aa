"""One renderer for the whole room: starting it costs half a second."""

from collections.abc import Callable

import msgspec
import pytest
from label_views import LAYOUT

from adc_bench.render import ArenaRenderer
from adc_bench.render.targets import Target, targets_of
from adc_bench.world.arena import Tunnel
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import CourseSpec
from adc_bench.world.layout import Layout
from adc_bench.world.look import LightLevel, LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import draw_signs
from adc_bench.world.streams import stream

FAMILY = LookFamily(floors=("charcoal_vinyl", "grey_carpet"), walls=("brick", "plaster"), light_sets=("window_left",))


@pytest.fixture(scope="session")
def renderer() -> ArenaRenderer:
    return ArenaRenderer(SensorRig())


@pytest.fixture(scope="session")
def scenario_of() -> Callable[..., Scenario]:
    def make(
        level: LightLevel = "normal", *, seed: int = 1, tunnel: Tunnel | None = None, sign: PanelSign = "up"
    ) -> Scenario:
        return Scenario(
            name=f"{level}-{seed}",
            seed=seed,
            look=draw_look(FAMILY, stream(seed, "look"), level),
            robot_truth=draw_robot_truth(RobotParams(), stream(seed, "robot")),
            panel_sign=sign,
            layout=Layout(tunnel=tunnel),
        )

    return make


@pytest.fixture(scope="session")
def scenario(scenario_of: Callable[..., Scenario]) -> Scenario:
    signs = draw_signs(CourseSpec(), stream(1, "signs"))
    return msgspec.structs.replace(scenario_of("normal"), layout=LAYOUT, signs=signs)


@pytest.fixture(scope="session")
def targets(scenario: Scenario) -> dict[str, Target]:
    return {target.instance: target for target in targets_of(scenario, "up")}
