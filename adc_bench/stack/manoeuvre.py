"""Manoeuvres at low speed: straight ways, forwards or backwards, and turns on the spot, each to a stop."""

import math
from dataclasses import dataclass, field

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.tracker import TrackerParams, gains
from adc_bench.world.robot import Motion

BEHIND = Pose2(x_m=0.0, y_m=0.0, yaw_rad=math.pi)


@dataclass(frozen=True, kw_only=True)
class Straight:
    """A straight way that ends at `goal`, along its heading or, in reverse, tail first."""

    goal: Pose2
    reverse: bool = False


@dataclass(frozen=True, kw_only=True)
class Turn:
    """A turn on the spot to a heading in the world, the shorter way round."""

    yaw_rad: float


Manoeuvre = tuple[Straight | Turn, ...]


@dataclass(frozen=True, kw_only=True)
class ManoeuvreParams:
    """How fast a manoeuvre is driven, how hard it brakes, and how near to a piece's end the next begins."""

    speed_mps: float = 0.8
    braking_mps2: float = 0.8
    turn_radps: float = 1.5
    turn_braking_radps2: float = 3.0
    near_m: float = 0.004
    near_rad: float = math.radians(0.4)
    slow_mps: float = 0.1
    slow_radps: float = 0.3
    tracker: TrackerParams = field(default_factory=TrackerParams)


def follow_manoeuvre(
    manoeuvre: Manoeuvre, pose: Pose2, motion: Motion, period_s: float, params: ManoeuvreParams
) -> tuple[Manoeuvre, Motion]:
    """Return what is left of a manoeuvre, and the command, from pose and motion when that begins to act.

    A piece that is done leaves the manoeuvre for good; of an empty one nothing is left but to stand.
    """
    if not manoeuvre:
        return manoeuvre, Motion()
    piece, *later = manoeuvre
    command = (
        _drive(piece, pose, motion, period_s, params)
        if isinstance(piece, Straight)
        else _turn(piece, pose, motion, period_s, params)
    )
    return (manoeuvre, command) if command else (tuple(later), Motion())


def _drive(way: Straight, pose: Pose2, motion: Motion, period_s: float, params: ManoeuvreParams) -> Motion | None:
    """Return the command of a control step, None at the end.

    Backwards a robot follows a line as one that looks back does forwards: the turn rate is the same.
    """
    goal, pose, sign = (way.goal @ BEHIND, pose @ BEHIND, -1.0) if way.reverse else (way.goal, pose, 1.0)
    seen, now_mps = goal.inverse() @ pose, sign * motion.v_mps
    if -seen.x_m <= params.near_m and abs(now_mps) <= params.slow_mps:
        return None
    speed_mps = next_speed(-seen.x_m, now_mps, params.speed_mps, params.braking_mps2, period_s)
    offset_gain, heading_gain = gains((now_mps + speed_mps) / 2, period_s, params.tracker)
    bound_m = params.tracker.offset_max_m
    omega_radps = -offset_gain * min(max(seen.y_m, -bound_m), bound_m) - heading_gain * wrap_rad(seen.yaw_rad)
    return Motion(v_mps=sign * speed_mps, omega_radps=omega_radps)


def _turn(turn: Turn, pose: Pose2, motion: Motion, period_s: float, params: ManoeuvreParams) -> Motion | None:
    """Return the command of a control step, None at the end."""
    left_rad = wrap_rad(turn.yaw_rad - pose.yaw_rad)
    if abs(left_rad) <= params.near_rad and abs(motion.omega_radps) <= params.slow_radps:
        return None
    sign = math.copysign(1.0, left_rad)
    rate_radps = next_speed(
        abs(left_rad), sign * motion.omega_radps, params.turn_radps, params.turn_braking_radps2, period_s
    )
    return Motion(omega_radps=sign * rate_radps)


def next_speed(left: float, now: float, most: float, braking: float, period_s: float) -> float:
    """Return the greatest speed at the end of a control step from which braking still ends within what is left.

    With v the speed now, w the one sought, b the braking and T the step: (v + w) T / 2 + w^2 / (2 b) = left.
    """
    half = braking * period_s / 2
    room = max(left - now * period_s / 2, 0.0)
    return min(most, math.sqrt(half**2 + 2 * braking * room) - half)
