"""The driver: follows the legs of a plan from the true pose, with the errors that the plan prescribes.

Curvature command: that of the line, plus k^2 times the offset and 2 k times the heading error (a critically damped
line follower; k is the inverse of a distance that grows with speed).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.driving.leg import Leg
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.world.categories import PanelSign
from adc_bench.world.robot import Motion

CONTROL_PERIOD_S = 0.05
RECOVERY_M, RECOVERY_S = 0.30, 0.60  # the distance over which an error is driven off: so much, plus speed times this
OFFSET_ERROR_MAX = 1.2  # in those distances: the way back to the line is not too steep
CURVATURE_MAX_PM = 16.0
CREEP_MPS = 0.05  # towards a leg's end
ARRIVED_M = 0.01
AHEAD_STEPS = 1.5  # how far ahead of the pose the line's bend is driven, for the delay that every command has


@dataclass(frozen=True, kw_only=True, eq=False)
class Hand:
    """The driver's errors: each command acts `delay_steps` control steps late, with `steering_radps` (steps,) added
    while the robot is under way.
    """

    delay_steps: int
    steering_radps: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class DriverState:
    """Which leg is driven, how far along it the robot is, how long it has waited before it, and the commands under way.

    After the last leg `leg` is the number of legs.
    """

    leg: int
    s_m: float
    waited_steps: int
    sent: tuple[Motion, ...]


def begin(legs: Sequence[Leg], hand: Hand) -> DriverState:
    """Return the state of a driver who is to start the first leg."""
    return DriverState(leg=0, s_m=legs[0].start_m, waited_steps=0, sent=(Motion(),) * hand.delay_steps)


def drive(state: DriverState, legs: Sequence[Leg], hand: Hand, pose: Pose2, step: int) -> tuple[DriverState, Motion]:
    """Return the next state, and the command that acts from this control step to the next."""
    state, wanted = _decide(state, legs, pose)
    if wanted != Motion():
        wanted = Motion(v_mps=wanted.v_mps, omega_radps=wanted.omega_radps + float(hand.steering_radps[step]))
    acting, *sent = (*state.sent, wanted)
    return replace(state, sent=tuple(sent)), acting


def is_done(state: DriverState, legs: Sequence[Leg]) -> bool:
    """Return whether all legs are driven."""
    return state.leg == len(legs)


def shown_sign(state: DriverState, legs: Sequence[Leg], now: PanelSign) -> PanelSign:
    """Return what the panels show, which showed `now` before."""
    if is_done(state, legs):
        return now
    leg = legs[state.leg]
    if 2 * state.waited_steps * CONTROL_PERIOD_S < leg.wait_s:
        return now
    due = [sign for at_m, sign in leg.signs if at_m <= state.s_m]
    return due[-1] if due else now


def _decide(state: DriverState, legs: Sequence[Leg], pose: Pose2) -> tuple[DriverState, Motion]:
    if is_done(state, legs):
        return state, Motion()
    leg = legs[state.leg]
    if state.waited_steps * CONTROL_PERIOD_S < leg.wait_s:
        return replace(state, waited_steps=state.waited_steps + 1), Motion()
    nearest, _ = leg.path.project([(pose.x_m, pose.y_m)], around_s_m=state.s_m, window_m=1.0)
    s_m = float(nearest[0])
    if s_m >= leg.end_m - ARRIVED_M:
        following = state.leg + 1
        start_m = legs[following].start_m if following < len(legs) else 0.0
        return replace(state, leg=following, s_m=start_m, waited_steps=0), Motion()
    return replace(state, s_m=s_m), _follow(leg, s_m, pose)


def _follow(leg: Leg, s_m: float, pose: Pose2) -> Motion:
    x, y, heading, _, speed = leg.at(s_m)
    speed = max(leg.at(s_m + speed * AHEAD_STEPS * CONTROL_PERIOD_S)[4], CREEP_MPS)
    bend = leg.at(s_m + speed * AHEAD_STEPS * CONTROL_PERIOD_S)[3]
    yaw = pose.yaw_rad + (math.pi if leg.backwards else 0.0)
    right_m = math.sin(heading) * (pose.x_m - x) - math.cos(heading) * (pose.y_m - y)
    k = 1 / (RECOVERY_M + RECOVERY_S * speed)
    right_m = max(-OFFSET_ERROR_MAX / k, min(OFFSET_ERROR_MAX / k, right_m))
    curvature = bend + k**2 * right_m + 2 * k * wrap_rad(heading - yaw)
    curvature = max(-CURVATURE_MAX_PM, min(CURVATURE_MAX_PM, curvature))
    return Motion(v_mps=-speed if leg.backwards else speed, omega_radps=speed * curvature)
