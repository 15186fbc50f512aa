"""Parking: come alongside, look which place is free where boxes may stand, go in tail first, and stand.

A robot that turns on the spot needs a circle of 0.6 m. Both kinds of place hold one, and so does the lane: it stops
abreast of the free place, turns its tail to it, backs straight in with the road before its camera, and in the parallel
place turns back along the road.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from adc_bench.api import LaserScan, Mission
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.manoeuvre import Manoeuvre, ManoeuvreParams, Straight, Turn, follow_manoeuvre
from adc_bench.stack.parking_view import Array, free_pose, places_of, points_met
from adc_bench.world.course import Course
from adc_bench.world.parking import ParkingKind
from adc_bench.world.robot import Motion

AWAY_RAD = math.pi / 2  # the heading in which the places beside the start straight lie behind
SAME_RAD = 0.01
LOOK_S = 1.0

Stage = Literal["called", "coming", "looking", "entering"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ParkingState:
    """How far parking is: its stage, the pieces left to drive, for how many steps it looked, what the laser met."""

    stage: Stage = "called"
    manoeuvre: Manoeuvre = ()
    looked_steps: int = 0
    points_world: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def is_done(self) -> bool:
        """Whether the robot has come to rest in its place."""
        return self.stage == "entering" and not self.manoeuvre


@dataclass(frozen=True, kw_only=True)
class ParkingPilot:
    """Parks a robot that is called to on the start straight's right-hand lane, before or beside the places.

    Stages follow one another and never come back. `see` takes scans; without any, the places count as free.
    """

    mission: Mission
    kind: ParkingKind
    params: ManoeuvreParams = field(default_factory=ManoeuvreParams)

    @cached_property
    def _course(self) -> Course:
        return Course(spec=self.mission.course)

    @property
    def _has_to_look(self) -> bool:
        return "boxes" in self.mission.elements

    def start(self) -> ParkingState:
        """Return the state when parking is called for, wherever on the straight that is."""
        return ParkingState()

    def see(self, state: ParkingState, pose: Pose2, scan: LaserScan) -> ParkingState:
        """Return the state after a scan taken at this pose; it counts while the robot stands and looks."""
        laser = self.mission.rig.laser
        if state.stage != "looking" or laser is None:
            return state
        return replace(state, points_world=np.concatenate([state.points_world, points_met(scan, laser, pose)]))

    def steer(self, state: ParkingState, pose: Pose2, motion: Motion) -> tuple[ParkingState, Motion]:
        """Return the next state and the command, from pose and motion when that begins to act."""
        if not state.manoeuvre:
            state = self._next_stage(state, pose)
        left, command = follow_manoeuvre(state.manoeuvre, pose, motion, self.mission.control_period_s, self.params)
        return replace(state, manoeuvre=left), command

    def _next_stage(self, state: ParkingState, pose: Pose2) -> ParkingState:
        if state.stage == "called" and self._has_to_look:
            first = places_of(self._course, self.kind)[0]
            return replace(state, stage="coming", manoeuvre=(along_lane(self._course, pose, first.pose.x_m),))
        if state.stage == "coming":
            return replace(state, stage="looking")
        if state.stage == "looking" and state.looked_steps * self.mission.control_period_s < LOOK_S:
            return replace(state, looked_steps=state.looked_steps + 1)
        if state.stage == "entering":
            return state
        place = free_pose(self._course, self.kind, state.points_world)
        return replace(state, stage="entering", manoeuvre=plan_parking(self._course, pose, place))


def along_lane(course: Course, pose: Pose2, x_m: float) -> Straight:
    """Return the way along the start straight's right-hand lane to an x, backwards where that lies behind the pose."""
    goal = Pose2(x_m=x_m, y_m=-course.spec.lane_outer_radius_m, yaw_rad=0.0)
    return Straight(goal=goal, reverse=x_m < pose.x_m)


def plan_parking(course: Course, pose: Pose2, place: Pose2) -> Manoeuvre:
    """Return the way from a pose in the start straight's right-hand lane to standing at a place's pose beside it."""
    entered = Straight(goal=Pose2(x_m=place.x_m, y_m=place.y_m, yaw_rad=AWAY_RAD), reverse=True)
    way: Manoeuvre = (along_lane(course, pose, place.x_m), Turn(yaw_rad=AWAY_RAD), entered)
    turned = abs(wrap_rad(place.yaw_rad - AWAY_RAD)) > SAME_RAD
    return (*way, Turn(yaw_rad=place.yaw_rad)) if turned else way
