"""Pilots: from where the robot will be to the next command, over the laps of a mission and to a stop behind the finish.

Each is pure steps over a state of its own. What it is given is pose and set points when the command will begin to act.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, TypeVar

from adc_bench.api import Mission
from adc_bench.geometry import Path, Pose2
from adc_bench.stack.linearisation import LinearisationParams, follow_moving
from adc_bench.stack.path_following import Follower, FollowParams, follow, wrap_to
from adc_bench.stack.reference_line import rounded
from adc_bench.stack.timetable import SpeedLimits, Timetable, fastest
from adc_bench.stack.tracker import Tracker, TrackerParams
from adc_bench.world.course import Course
from adc_bench.world.robot import Motion

State = TypeVar("State")
BEYOND_FINISH_M = 0.3


class Pilot(Protocol[State]):
    """Steers a robot; `start` returns the state at the mission's start pose."""

    def start(self) -> State:
        """Return the state before the first step."""
        ...

    def steer(self, state: State, pose: Pose2, motion: Motion) -> tuple[State, Motion]:
        """Return the next state and the command."""
        ...


@dataclass(frozen=True, kw_only=True)
class HeadingPilot:
    """The thesis' path following: PID on the heading at one speed, at once to zero behind the finish."""

    mission: Mission
    speed_mps: float = 1.0
    params: FollowParams = field(default_factory=FollowParams)

    @cached_property
    def _lap(self) -> Path:
        return Course(spec=self.mission.course).lap

    def start(self) -> Follower:
        """Return the follower at the start pose."""
        return Follower(s_m=start_s(self._lap, self.mission.start_pose))

    def steer(self, state: Follower, pose: Pose2, motion: Motion) -> tuple[Follower, Motion]:
        """Return the next state and the command."""
        if state.s_m > self.mission.laps * self._lap.length_m + BEYOND_FINISH_M:
            return state, Motion()
        period_s = self.mission.control_period_s
        state, omega_radps = follow(state, pose, self._lap, self.speed_mps, period_s, self.params)
        return state, Motion(v_mps=self.speed_mps, omega_radps=omega_radps)


@dataclass(frozen=True, kw_only=True)
class TrajectoryPilot:
    """The thesis' trajectory tracking: feedback linearisation about a robot that keeps a timetable.

    Its state is the time on the timetable.
    """

    mission: Mission
    speed_mps: float = 1.0
    params: LinearisationParams = field(default_factory=LinearisationParams)

    @cached_property
    def _timetable(self) -> Timetable:
        return timetable_of(self.mission, self.speed_mps)

    def start(self) -> float:
        """Return the time on the timetable at the start pose."""
        return 0.0

    def steer(self, state: float, pose: Pose2, motion: Motion) -> tuple[float, Motion]:
        """Return the next time and the command; speeds are those at the end of the control step that begins then."""
        timetable, after_s = self._timetable, state + self.mission.control_period_s
        now_m, after_m = timetable.place(state), timetable.place(after_s)
        v_mps = timetable.speed(after_m)
        feed = Motion(v_mps=v_mps, omega_radps=v_mps * timetable.line.curvature((now_m + after_m) / 2))
        return after_s, follow_moving(pose, timetable.line.pose(now_m), feed, self.params)


@dataclass(frozen=True, kw_only=True)
class LinePilot:
    """The reference's pilot: a rounded line at the limits of the robot.

    Its state is the arc length on the line.
    """

    mission: Mission
    speed_mps: float
    params: TrackerParams = field(default_factory=TrackerParams)

    @cached_property
    def _tracker(self) -> Tracker:
        return Tracker(
            robot=self.mission.robot,
            period_s=self.mission.control_period_s,
            timetable=timetable_of(self.mission, self.speed_mps),
            params=self.params,
        )

    def start(self) -> float:
        """Return the line's start."""
        return 0.0

    def steer(self, state: float, pose: Pose2, motion: Motion) -> tuple[float, Motion]:
        """Return the next arc length and the command."""
        return self._tracker.track(state, pose, motion)


def timetable_of(mission: Mission, speed_mps: float) -> Timetable:
    """Return the fastest timetable of the mission's laps, at most `speed_mps`, from the start pose to a stop.

    It brakes behind the finish line and comes to rest `BEYOND_FINISH_M` after the way that takes.
    """
    lap = Course(spec=mission.course).lap
    limits = SpeedLimits.of(mission.robot, speed_mps=speed_mps)
    braking_m = limits.speed_mps**2 / (2 * limits.acceleration_mps2)
    end_m = mission.laps * lap.length_m + braking_m + BEYOND_FINISH_M
    return fastest(rounded(lap, start_s(lap, mission.start_pose), end_m), limits)


def start_s(lap: Path, pose: Pose2) -> float:
    """Return the arc length of a start pose: negative before the start line."""
    s_m, _ = lap.project([(pose.x_m, pose.y_m)])
    return wrap_to(float(s_m[0]), lap.length_m)
