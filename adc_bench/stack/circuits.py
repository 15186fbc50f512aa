"""The circuits of the right-hand lane, and on which of them the robot is, by its believed pose alone.

Round either loop there are two ways, so there are four circuits; the lap is the one that goes straight on twice. They
share stretches: where ways part, the robot is on the one that its pose fits.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Path, Piece, Pose2, wrap_array_rad
from adc_bench.stack.path_following import progress, wrap_to
from adc_bench.world.course import Course
from adc_bench.world.route import Way, crosswalk_pose, half_lap

Array = NDArray[np.float64]
Ways = tuple[Way, Way]  # round the +x loop, then round the -x loop

WAYS: tuple[Ways, ...] = (("straight", "straight"), ("straight", "turn"), ("turn", "straight"), ("turn", "turn"))
SAMPLE_M = 0.05
TURN_M = 0.6  # so far beside a lane counts as much as looking one radian off it
BETTER_M = 0.15  # by which another circuit must fit better to be changed to


@dataclass(frozen=True, kw_only=True)
class Circuit:
    """A closed lane: `path` begins on the crosswalk towards +x and comes to it towards -x at `crosswalk_back_m`."""

    path: Path
    crosswalk_back_m: float

    @cached_property
    def samples(self) -> Array:
        """Poses (n, 3) every `SAMPLE_M` of arc length."""
        return self.path.poses(np.arange(0.0, self.path.length_m, SAMPLE_M))


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where the robot is: on which circuit, and at which arc length; that grows along the circuit and beyond it."""

    ways: Ways
    s_m: float


@dataclass(frozen=True, kw_only=True)
class Circuits:
    """All circuits of a course."""

    course: Course

    @cached_property
    def by_ways(self) -> Mapping[Ways, Circuit]:
        """The circuits by their ways round the loops."""
        return {ways: circuit(self.course, ways) for ways in WAYS}

    def start(self, pose: Pose2) -> Place:
        """Return the place on the lap at a start pose: negative before the crosswalk."""
        lap = self.by_ways[WAYS[0]].path
        s_m, _ = lap.project([(pose.x_m, pose.y_m)])
        return Place(ways=WAYS[0], s_m=wrap_to(float(s_m[0]), lap.length_m))

    def follow(self, place: Place, pose: Pose2) -> Place:
        """Return the place at a pose a little farther on: on the same circuit unless another one fits better."""
        here = self.by_ways[place.ways]
        stayed = Place(ways=place.ways, s_m=progress(place.s_m, pose, here.path))
        on_own = misfit_m(here.path.poses(stayed.s_m), pose)[0]
        if on_own < BETTER_M:
            return stayed
        misfits = [misfit_m(self.by_ways[ways].samples, pose) for ways in WAYS]
        best = int(np.argmin([misfit.min() for misfit in misfits]))
        if misfits[best].min() > on_own - BETTER_M:
            return stayed
        return Place(ways=WAYS[best], s_m=SAMPLE_M * float(np.argmin(misfits[best])))


def misfit_m(lane_poses: Array, pose: Pose2) -> Array:
    """Return how far (n,) a pose is from poses on a lane (n, 3), its heading counted in."""
    apart = lane_poses[:, :2] - (pose.x_m, pose.y_m)
    turn = TURN_M * wrap_array_rad(lane_poses[:, 2] - pose.yaw_rad)
    misfit: Array = np.sqrt(np.square(apart).sum(axis=1) + np.square(turn))
    return misfit


def circuit(course: Course, ways: Ways) -> Circuit:
    """Return the circuit that goes these ways round the loops."""
    east, west = half_lap(course, "east", ways[0]), half_lap(course, "west", ways[1])
    # The straight over the crosswalk towards -x is one piece: that is a stretch of lane with both lines.
    over = Piece(length_m=east[-1].length_m + west[0].length_m, curvature_pm=0.0)
    return Circuit(
        path=Path(start=crosswalk_pose(course, "east"), pieces=(*east[:-1], over, *west[1:]), closed=True),
        crosswalk_back_m=math.fsum(piece.length_m for piece in east),
    )
