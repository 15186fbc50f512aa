"""Golden pictures: a change of look is seen here first. `python tests/render/test_golden.py` writes them anew."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import Tunnel
from adc_bench.world.layout import Layout
from adc_bench.world.look import LightLevel, LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.streams import stream

FOLDER = Path(__file__).parent / "golden"
FAMILY = LookFamily(floors=("felt", "worn_vinyl"), walls=("brick", "shelves"), light_sets=("window_left", "warm_hall"))
CASES: dict[LightLevel, tuple[str, float, Tunnel | None]] = {
    "dark": ("road", 38.9, None),
    "dim": ("panel", 38.0, Tunnel(start_s_m=37.5, length_m=3.5)),
    "normal": ("road", 7.0, Tunnel(start_s_m=8.0, length_m=4.0)),
    "bright": ("panel", 18.0, None),
}


def picture(renderer: ArenaRenderer, level: LightLevel) -> NDArray[np.uint8]:
    camera, s_m, tunnel = CASES[level]
    scenario = Scenario(
        name=level,
        seed=11,
        look=draw_look(FAMILY, stream(11, "look", level), level),
        robot_truth=draw_robot_truth(RobotParams(), stream(11, "robot")),
        panel_sign="left",
        layout=Layout(tunnel=tunnel),
    )
    renderer.load(scenario)
    rgba, _ = renderer.raw(camera, scenario.course.lap.pose(s_m).to_pose3())
    return np.asarray(cv2.cvtColor(rgba, cv2.COLOR_RGBA2BGR), np.uint8)


@pytest.mark.parametrize("level", CASES)
def test_the_picture_is_the_golden_one(renderer: ArenaRenderer, level: LightLevel) -> None:
    golden = cv2.imread(str(FOLDER / f"{level}.png"))
    assert golden is not None
    difference = np.abs(picture(renderer, level).astype(int) - golden.astype(int))
    # another Mesa may round a texel or move an edge by a pixel; a change of look moves far more
    assert difference.mean() < 1.0 and np.percentile(difference, 99) < 12


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    shared = ArenaRenderer(SensorRig())
    for name in CASES:
        cv2.imwrite(str(FOLDER / f"{name}.png"), picture(shared, name))
