"""Where the robot will be when a command that is given now begins to act: the commands under way, played forwards.

The robot's own controller holds commands within its limits and ramps its set points (`world.drive`), and wheels that
hold the floor follow the set points within a few milliseconds.
"""

import math
from dataclasses import dataclass, replace

from adc_bench.geometry import Pose2
from adc_bench.world.drive import limit, ramp
from adc_bench.world.robot import Motion, RobotParams

FINE_S = 0.005


@dataclass(frozen=True, kw_only=True)
class UnderWay:
    """The set points' motion now, and the commands that will act from now on, a control step each."""

    motion: Motion
    commands: tuple[Motion, ...]


def at_rest(period_s: float, latency_s: float) -> UnderWay:
    """Return what is under way at a start: every command acts one control step late, or more by the latency."""
    return UnderWay(motion=Motion(), commands=(Motion(),) * (1 + math.ceil(latency_s / period_s - 1e-9)))


def send(state: UnderWay, robot: RobotParams, command: Motion, period_s: float) -> UnderWay:
    """Return what is under way one control step later, `command` being the last one sent."""
    acting, *waiting = (*state.commands, command)
    return replace(state, motion=_play(robot, state.motion, acting, period_s)[1], commands=tuple(waiting))


def when_acting(state: UnderWay, robot: RobotParams, pose: Pose2, period_s: float) -> tuple[Pose2, Motion]:
    """Return pose and motion when the next command begins to act, from the pose now."""
    motion = state.motion
    for command in state.commands:
        moved, motion = _play(robot, motion, command, period_s)
        pose = pose @ moved
    return pose, motion


def _play(robot: RobotParams, motion: Motion, command: Motion, period_s: float) -> tuple[Pose2, Motion]:
    """Return where a control step under a command leads, seen from its start, and the motion at its end."""
    target, moved = limit(robot, command), Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    for _ in range(round(period_s / FINE_S)):
        motion = ramp(robot, motion, target, FINE_S)
        moved = moved @ arc_step(motion.v_mps * FINE_S, motion.omega_radps * FINE_S)
    return moved, motion


def arc_step(length_m: float, turn_rad: float) -> Pose2:
    """Return the pose at the end of an arc of this length and turn, seen from its start."""
    half = turn_rad / 2
    chord_m = length_m * (math.sin(half) / half if half else 1.0)
    return Pose2(x_m=chord_m * math.cos(half), y_m=chord_m * math.sin(half), yaw_rad=turn_rad)
