"""From a split and a frame index to the arena and the robot's pose in it; each depends on nothing else.

Scenario k holds the frames from k x frames_per_scenario on. Light levels take turns from scenario to scenario, cameras
from frame to frame, and the panel signs go round within a scenario, so every short run has all of them.
"""

import math
from dataclasses import dataclass

import numpy as np

from adc_bench.dataset.poses import draw_pose
from adc_bench.dataset.split import Split
from adc_bench.geometry import Pose3
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.categories import PANEL_SIGNS, PanelSign
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.look import draw_look
from adc_bench.world.robot import ROBOTS, Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

GOLDEN = (math.sqrt(5) - 1) / 2
STANDING_SHARE = 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class FramePlan:
    """What a frame shows: the camera, the sign on both panels, the robot's pose with its body's pitch and roll, and the
    robot's motion at mid-exposure.
    """

    index: int
    camera: str
    panel_sign: PanelSign
    pose_world_robot: Pose3
    motion: Motion


def scenario_number(split: Split, index: int) -> int:
    """Return the number of the scenario that a frame belongs to."""
    return index // split.frames_per_scenario


def draw_scenario(split: Split, number: int, rig: SensorRig, salt: bytes | None = None) -> Scenario:
    """Return the split's scenario of this number; a salted split needs its salt.

    Raises:
        InputError: a layout of the split or the rig makes an arena that cannot be.
    """
    seed = split.seed(number, salt)
    levels = split.looks.light_levels
    course = COURSE_SETS[split.course]
    with_signs = bool(stream(seed, "with signs").random() < split.signs_share)
    layout = draw_layout(layout_name(split, number), Course(spec=course), stream(seed, "layout"), signs=with_signs)
    return set_up(
        name=f"{split.name}-{number:05d}",
        seed=seed,
        look=draw_look(split.looks, stream(seed, "look"), levels[number % len(levels)]),
        panel_sign=PANEL_SIGNS[number % len(PANEL_SIGNS)],
        layout=layout,
        course=course,
        arena=ArenaSpec(),
        robot=ROBOTS[split.robot],
        rig=rig,
        furniture=split.furniture,
    )


def draw_frame(split: Split, scenario: Scenario, index: int) -> FramePlan:
    """Return the plan of a frame that belongs to this scenario."""
    number, k = divmod(index, split.frames_per_scenario)
    cameras = scenario.rig.cameras
    # The sign moves on once both cameras had it, so that each camera sees all of them.
    sign = PANEL_SIGNS[(number + k // len(cameras)) % len(PANEL_SIGNS)]
    return FramePlan(
        index=index,
        camera=cameras[k % len(cameras)].name,
        panel_sign=sign,
        pose_world_robot=draw_pose(split, scenario, stream(scenario.seed, "pose", k)),
        motion=_draw_motion(stream(scenario.seed, "motion", k)),
    )


def layout_name(split: Split, number: int) -> str:
    """Return which of its layouts the split's scenario of this number has.

    Evenly spread numbers in 0..1 choose: the shares hold in every stretch of scenarios and at every light level.
    """
    levels = len(split.looks.light_levels)
    turn, level = divmod(number, levels)
    spread = ((level + turn) % levels + turn * GOLDEN % 1.0) / levels
    names = sorted(split.layouts)
    ends = np.cumsum([split.layouts[name] for name in names])
    return names[min(int(np.searchsorted(ends, spread, side="right")), len(names) - 1)]


def _draw_motion(rng: np.random.Generator) -> Motion:
    """Half of the robots stand still."""
    if rng.random() < STANDING_SHARE:
        return Motion()
    return Motion(v_mps=float(rng.uniform(0.0, 2.0)), omega_radps=float(rng.uniform(-2.0, 2.0)))
