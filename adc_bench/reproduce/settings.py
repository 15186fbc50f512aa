"""What the experiments are driven with; the defaults are what the thesis reports on."""

from typing import Literal

import msgspec

from adc_bench.world.look import LightLevel

Controller = Literal["pid", "linearisation"]


class SimulatedLandmarks(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The thesis' stand-in for eyes: the true relative position of a near landmark with Gaussian noise.

    Attributes:
        sd_m: of each coordinate.
        circle_range_m: a loop's centre is told while it is nearer than this: on the loop and little before it.
        corner_ahead_m: a crosswalk corner is told while it is this far ahead.
    """

    sd_m: float = 0.05
    circle_range_m: float = 2.75
    corner_ahead_m: tuple[float, float] = (0.5, 1.7)


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is driven.

    Attributes:
        laps: controller and speed of each lap with the true pose; the first is the one on which the filters are tried.
        robots: how many robots' odometry is compared over a lap.
        seed: of the robot of all other experiments.
        pixels_limit_s: how long the lap from pixels may take, from the green arrow on.
        approach_step_m: between two places of the approach to the crosswalk.
        approach_lights: one approach in each.
        boxes_s_m: for each drive past boxes, at which arc lengths of the lap one stands in the lane.
        boxes_speed_mps: of the PID between them.
    """

    laps: tuple[tuple[Controller, float], ...] = (
        ("pid", 1.0),
        ("pid", 0.5),
        ("pid", 1.5),
        ("pid", 2.0),
        ("linearisation", 1.0),
    )
    robots: int = 10
    seed: int = 6001
    landmarks: SimulatedLandmarks = SimulatedLandmarks()
    pixels_limit_s: float = 90.0
    approach_step_m: float = 0.1
    approach_lights: tuple[LightLevel, ...] = ("dark", "normal", "bright")
    boxes_s_m: tuple[tuple[float, ...], ...] = ((3.0,), (2.2, 5.2), (3.0, 11.0, 23.0))
    boxes_speed_mps: float = 0.5
