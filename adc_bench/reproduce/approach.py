"""With what score the detector finds the crosswalk as the robot comes up to it and passes over it."""

from collections.abc import Iterator

import msgspec
import numpy as np

from adc_bench.dataset import load_split
from adc_bench.detector import Detector
from adc_bench.detector.evaluation.operating import CROSSWALK
from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import Course
from adc_bench.world.look import LightLevel, draw_look
from adc_bench.world.picture import decode_picture
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

FIRST_M, LAST_M = -6.0, 5.0
SEED_FIRST = 3_700_000  # no split has these
LEAST_SCORE = 0.01  # scores below it are told as 0


class Approach(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The surest crosswalk's score by the robot's x, one series an arena; the crosswalk's middle is at 0."""

    camera: str
    places_m: tuple[float, ...]
    scores: dict[str, tuple[float, ...]]


def approach_arena(number: int, level: LightLevel, layout: str, rig: SensorRig) -> Scenario:
    """Return the arena of an approach, with the looks of the test family."""
    split, seed = load_split("test"), SEED_FIRST + number
    return set_up(
        name=f"approach-{number}",
        seed=seed,
        look=draw_look(split.looks, stream(seed, "look"), level),
        panel_sign="up",
        layout=draw_layout(layout, Course(), stream(seed, "layout")),
        course=Course().spec,
        arena=ArenaSpec(),
        robot=ROBOTS[split.robot],
        rig=rig,
    )


def approach_places_m(step_m: float) -> tuple[float, ...]:
    """Return where the pictures of an approach are taken."""
    return tuple(np.arange(FIRST_M, LAST_M + step_m / 2, step_m).tolist())


def best_scores(
    renderer: ArenaRenderer, detector: Detector, camera: str, scenario: Scenario, places_m: tuple[float, ...]
) -> Iterator[float]:
    """Yield the surest crosswalk's score at each x of the robot in the starting lane; the scenario is loaded."""
    for x_m in places_m:
        place = Pose2(x_m=x_m, y_m=-scenario.course.spec.lane_outer_radius_m, yaw_rad=0.0)
        frame = renderer.frame(round(1000 * (x_m - FIRST_M)), camera, place.to_pose3())
        rgb = decode_picture(frame.jpeg)
        assert rgb is not None, "the renderer's own JPEG"
        found = detector(rgb)
        yield float(found.scores[found.category_ids == CROSSWALK].max(initial=0.0))
