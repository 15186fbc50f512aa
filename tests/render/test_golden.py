"""Golden pictures: a change of look is seen here first. `python tests/render/test_golden.py` writes them anew."""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import ArenaSpec, Tunnel
from adc_bench.world.course import CourseSpec
from adc_bench.world.layout import Layout
from adc_bench.world.look import LightLevel, LookFamily, draw_look
from adc_bench.world.robot import Motion, RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import load_layout, set_up
from adc_bench.world.streams import stream

FOLDER = Path(__file__).parent / "golden"
FAMILY = LookFamily(floors=("felt", "worn_vinyl"), walls=("brick", "shelves"), light_sets=("window_left", "warm_hall"))
OPEN = Layout()
TURNING = Motion(v_mps=0.8, omega_radps=1.0)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A view: under which light, from where, of what; `taken` through the whole camera while turning."""

    level: LightLevel
    camera: str
    s_m: float
    left_m: float = 0.0
    layout: Layout = OPEN
    taken: bool = False


CASES = {
    "dark": Case(level="dark", camera="road", s_m=38.9),
    "dim": Case(level="dim", camera="panel", s_m=38.0, layout=Layout(tunnel=Tunnel(start_s_m=37.5, length_m=3.5))),
    "normal": Case(level="normal", camera="road", s_m=7.0, layout=Layout(tunnel=Tunnel(start_s_m=8.0, length_m=4.0))),
    "bright": Case(level="bright", camera="panel", s_m=26.0, layout=Layout(signs=True)),
    "works": Case(level="normal", camera="road", s_m=3.2, layout=load_layout("d4_v1")),
    "boxes": Case(level="dim", camera="road", s_m=31.2, layout=load_layout("d3_v1"), taken=True),
}


def scenario_of(name: str, case: Case) -> Scenario:
    return set_up(
        name=name,
        seed=11,
        look=draw_look(FAMILY, stream(11, "look", case.level), case.level),
        panel_sign="left",
        layout=case.layout,
        course=CourseSpec(),
        arena=ArenaSpec(),
        robot=RobotParams(),
        rig=SensorRig(),
    )


def picture(renderer: ArenaRenderer, name: str) -> NDArray[np.uint8]:
    case = CASES[name]
    scenario = scenario_of(name, case)
    renderer.load(scenario)
    pose = (scenario.course.lap.pose(case.s_m) @ Pose2(x_m=0.0, y_m=case.left_m, yaw_rad=0.0)).to_pose3()
    if case.taken:
        jpeg = renderer.frame(0, case.camera, pose, motion=TURNING).jpeg
        return np.asarray(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR), np.uint8)
    rgba, _ = renderer.raw(case.camera, pose)
    return np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), np.uint8)


@pytest.mark.parametrize("name", CASES)
def test_the_picture_is_the_golden_one(renderer: ArenaRenderer, name: str) -> None:
    golden = cv2.imread(str(FOLDER / f"{name}.png"))
    assert golden is not None
    difference = np.abs(picture(renderer, name).astype(int) - golden.astype(int))
    # another Mesa may round a texel or move an edge by a pixel; a change of look moves far more
    assert difference.mean() < 1.0 and np.percentile(difference, 99) < 12


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    shared = ArenaRenderer(SensorRig())
    for name in CASES:
        cv2.imwrite(str(FOLDER / f"{name}.png"), picture(shared, name))
