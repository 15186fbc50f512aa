"""Driving along a line at its speeds: the line's own turn fed forwards, a linear-quadratic regulator on what remains.

Everything is reckoned at the moment at which the command will begin to act. Offset e (left positive) and heading error
p, both from the line, then move over a control step of length T as
    e += v T p + v T^2 / 2 u,   p += T u
under a correction u of the turn rate. The regulator minimises  sum (e / e_0)^2 + (p / p_0)^2 + (u / u_0)^2  with its
gains for a grid of speeds.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_are

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.timetable import Timetable
from adc_bench.world.robot import Motion, RobotParams

Array = NDArray[np.float64]

SPEEDS_MPS = tuple(0.1 * k for k in range(1, 31))


@dataclass(frozen=True, kw_only=True)
class TrackerParams:
    """The errors and the correction that weigh alike, and how far an error of offset is believed."""

    offset_m: float = 0.05
    heading_rad: float = 0.10
    correction_radps: float = 0.30
    offset_max_m: float = 0.25


@dataclass(frozen=True, kw_only=True)
class Tracker:
    """Pure steps along a timetable, for one robot."""

    robot: RobotParams
    period_s: float
    timetable: Timetable
    params: TrackerParams = field(default_factory=TrackerParams)

    def track(self, s_m: float, pose: Pose2, motion: Motion) -> tuple[float, Motion]:
        """Return where on the line the robot will be, and the command, from pose and motion when that begins to act.

        `s_m` is where on the line the robot was.
        """
        line, period_s, accelerate = self.timetable.line, self.period_s, self.robot.acceleration_max_mps2
        s_m = line.project(pose, s_m)
        speed_mps = self.timetable.speed(s_m + motion.v_mps * period_s + accelerate * period_s**2 / 2)
        middle_mps = (motion.v_mps + speed_mps) / 2
        turn_radps = self._turn(s_m, middle_mps) + self._correction(line.pose(s_m), pose, middle_mps)
        return s_m, Motion(v_mps=speed_mps, omega_radps=self._ramped(motion.omega_radps, turn_radps))

    def _turn(self, s_m: float, speed_mps: float) -> float:
        """Return the line's mean turn rate over a control step."""
        line = self.timetable.line
        yaws = np.interp((s_m, s_m + speed_mps * self.period_s), line.s_m, line.yaw_rad)
        return float(yaws[1] - yaws[0]) / self.period_s

    def _correction(self, on_line: Pose2, pose: Pose2, speed_mps: float) -> float:
        seen = on_line.inverse() @ pose
        bound = self.params.offset_max_m
        offset_gain, heading_gain = gains(speed_mps, self.period_s, self.params)
        return -offset_gain * min(max(seen.y_m, -bound), bound) - heading_gain * wrap_rad(seen.yaw_rad)

    def _ramped(self, now_radps: float, mean_radps: float) -> float:
        """Return the turn rate whose mean over the control step, the ramp to it included, is the wanted one.

        A set point that ramps at rate a by D and then holds is short of its end by D^2 / (2 a T) in the mean.
        """
        reach = self.robot.acceleration_max_mps2 / (self.robot.wheel_separation_m / 2) * self.period_s
        wanted = mean_radps - now_radps
        change = reach * (1 - math.sqrt(max(1 - 2 * abs(wanted) / reach, 0.0)))
        return now_radps + math.copysign(change, wanted)


def gains(speed_mps: float, period_s: float, params: TrackerParams) -> tuple[float, float]:
    """Return what the regulator gives per metre of offset and per radian of heading, in rad/s."""
    offset, heading = _gain_table(period_s, params).T
    return float(np.interp(speed_mps, SPEEDS_MPS, offset)), float(np.interp(speed_mps, SPEEDS_MPS, heading))


@lru_cache(maxsize=8)
def _gain_table(period_s: float, params: TrackerParams) -> Array:
    """Return the gains (n, 2) at `SPEEDS_MPS`."""
    return np.array([regulator(speed_mps, period_s, params) for speed_mps in SPEEDS_MPS])


def regulator(speed_mps: float, period_s: float, params: TrackerParams) -> Array:
    """Return the gains (2,) on [offset, heading error] at one speed."""
    A, B = error_model(speed_mps, period_s)
    Q = np.diag([params.offset_m**-2, params.heading_rad**-2])
    R = np.array([[params.correction_radps**-2]])
    P = solve_discrete_are(A, B, Q, R)
    gain: Array = np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)[0]
    return gain


def error_model(speed_mps: float, period_s: float) -> tuple[Array, Array]:
    """Return A (2, 2) and B (2, 1) of the errors' step."""
    along_m = speed_mps * period_s
    return np.array([[1.0, along_m], [0.0, 1.0]]), np.array([[along_m * period_s / 2], [period_s]])
