"""Drawing a driver's errors: a wandering line, an unsteady and late hand, knocks, and needless or forbidden swerves."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from adc_bench.dataset.drive_recipe import Behaviour
from adc_bench.dataset.driving.driver import CONTROL_PERIOD_S, Hand
from adc_bench.dataset.driving.leg import STEP_M, Knots
from adc_bench.geometry import Pose2

Array = NDArray[np.float64]

WANDER_SD_M = (0.02, 0.09)
WANDER_LENGTH_M = (1.0, 3.0)  # of the Ornstein-Uhlenbeck process' memory
WANDER_ROUNDING_M = 0.25
WOBBLE_RADPS, WOBBLE_HZ = (0.0, 0.25), (0.3, 1.2)
NOISE_RADPS = (0.02, 0.25)
DELAY_STEPS = (1, 4)  # one is what every driver has
KNOCK_RADPS, KNOCK_S, KNOCK_EVERY_S = (1.0, 2.5), (0.2, 0.4), (4.0, 9.0)
ASKEW_M, ASKEW_RAD = 0.5, math.radians(40)
SWERVE_LENGTH_M, SWERVE_EVERY_M, RAMP_M = (2.0, 5.0), (3.0, 8.0), (1.4, 2.4)
OVER_LINE_M = (0.22, 0.85)  # from a lane's middle; a wheel touches the line from 0.2 m on


def draw_hand(behaviour: Behaviour, steps: int, care: float, rng: np.random.Generator) -> Hand:
    """Return the errors of a drive of so many control steps; `care` in (0, 1] scales the unsteadiness."""
    if behaviour == "clean":
        return Hand(delay_steps=1, steering_radps=np.zeros(steps))
    time_s = np.arange(steps, dtype=np.float64) * CONTROL_PERIOD_S
    wobble = rng.uniform(*WOBBLE_RADPS) * np.sin(2 * np.pi * (rng.uniform(*WOBBLE_HZ) * time_s + rng.uniform(0.0, 1.0)))
    steering = care * (wobble + rng.uniform(*NOISE_RADPS) * rng.standard_normal(steps))
    delay_steps = int(rng.integers(DELAY_STEPS[0], DELAY_STEPS[1] + 1))
    if behaviour == "recovery":
        steering += _knocks(time_s, rng)
    return Hand(delay_steps=delay_steps, steering_radps=steering)


def _knocks(time_s: Array, rng: np.random.Generator) -> Array:
    """Return turn rates that now and then throw the robot off its course."""
    knocks = np.zeros_like(time_s)
    start_s = rng.uniform(*KNOCK_EVERY_S)
    while start_s < time_s[-1]:
        hit = (time_s >= start_s) & (time_s < start_s + rng.uniform(*KNOCK_S))
        knocks[hit] = rng.choice([-1.0, 1.0]) * rng.uniform(*KNOCK_RADPS)
        start_s += rng.uniform(*KNOCK_EVERY_S)
    return knocks


def draw_wander(behaviour: Behaviour, stations: int, care: float, rng: np.random.Generator) -> Array:
    """Return how far the driver's line strays from what was meant, (stations,) metres: an Ornstein-Uhlenbeck process
    along the path, rounded; `care` in (0, 1] scales it.
    """
    if behaviour == "clean":
        return np.zeros(stations)
    sd_m, length_m = care * rng.uniform(*WANDER_SD_M), rng.uniform(*WANDER_LENGTH_M)
    keep = math.exp(-STEP_M / length_m)
    draws = sd_m * math.sqrt(1 - keep**2) * rng.standard_normal(stations)
    draws[0] = sd_m * rng.standard_normal()
    wander = np.empty(stations)
    now = 0.0
    for k, draw in enumerate(draws):
        now = keep * now + draw
        wander[k] = now
    rounded: Array = gaussian_filter1d(wander, WANDER_ROUNDING_M / STEP_M, mode="nearest")
    return rounded


def draw_swerves(
    behaviour: Behaviour, start_m: float, end_m: float, lane_width_m: float, rng: np.random.Generator
) -> Knots:
    """Return knots of the offset between two arc lengths: changes to the left lane and back, or over lines and back."""
    knots = [(start_m, 0.0)]
    if behaviour not in ("lane_changes", "off_road"):
        return knots
    at_m = start_m + rng.uniform(*RAMP_M)
    while at_m < end_m:
        aside_m = lane_width_m if behaviour == "lane_changes" else _over_a_line(lane_width_m, rng)
        ramp_m, length_m = rng.uniform(*RAMP_M), rng.uniform(*SWERVE_LENGTH_M)
        knots += [(at_m, 0.0), (at_m + ramp_m, aside_m), (at_m + ramp_m + length_m, aside_m)]
        at_m += 2 * ramp_m + length_m
        knots.append((at_m, 0.0))
        at_m += rng.uniform(*SWERVE_EVERY_M)
    return knots


def _over_a_line(lane_width_m: float, rng: np.random.Generator) -> float:
    """Return an offset that takes wheels onto or over the line right of the right lane or left of the left one."""
    beyond_m = float(rng.uniform(*OVER_LINE_M))
    return -beyond_m if rng.random() < 0.5 else lane_width_m + beyond_m


def draw_start(behaviour: Behaviour, wanted: Pose2, rng: np.random.Generator) -> Pose2:
    """Return where the robot starts: where it should, or beside it and askew."""
    if behaviour != "recovery":
        return wanted
    aside_m, turn_rad = rng.uniform(-1.0, 1.0, 2) * (ASKEW_M, ASKEW_RAD)
    return wanted @ Pose2(x_m=0.0, y_m=float(aside_m), yaw_rad=float(turn_rad))
