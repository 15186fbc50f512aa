"""Legs of a mission: over a crosswalk and on to the stop zone before the next, or to the end of the run."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from adc_bench.geometry import Path, Piece, Pose2, line
from adc_bench.stack.reference_line import ReferenceLine, rounded
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.robot import RobotParams
from adc_bench.world.route import OTHER, Loop, Way, crosswalk_pose, half_lap

LEAD_M = 5.0  # of every leg, before its crosswalk: a decision may come anywhere on it
STOP_ROOM_M = 0.25  # from the robot's nose to the stop line where it waits


@dataclass(frozen=True, kw_only=True, eq=False)
class Leg:
    """The lane from before a crosswalk on, rounded from `LEAD_M` before it; it ends at rest at the lane's arc length
    `end_m`.
    """

    lane: Path
    line: ReferenceLine
    end_m: float

    def place_m(self, pose: Pose2) -> float:
        """Return the lane's arc length at which a robot comes to its crosswalk."""
        on_line_m = self.line.project(pose, around_s_m=LEAD_M, window_m=LEAD_M)
        return float(np.interp(on_line_m, self.line.s_m, self.line.path_s_m))

    def ahead(self, s_m: float) -> ReferenceLine:
        """Return what remains of the line from an arc length of the lane on."""
        line = self.line
        return line.part(*np.interp((s_m, self.end_m), line.path_s_m, line.s_m))


def stop_before_m(course: CourseSpec, robot: RobotParams) -> float:
    """Return how far before a crosswalk's middle the robot waits."""
    return course.crosswalk_depth_m / 2 + STOP_ROOM_M + robot.length_m / 2


def way_of(sign: PanelSign) -> Way:
    """Return how a driving order goes round the next loop."""
    return "straight" if sign == "up" else "turn"


@lru_cache(maxsize=16)
def half_lap_leg(spec: CourseSpec, loop: Loop, came: Way, way: Way, stop_before_m: float) -> Leg:
    """Return the leg round a loop, for who came to the crosswalk round the other loop by `came`.

    Its line goes on over the next crosswalk to where the ways part, so that the line of the next leg begins as this one
    ends.
    """
    round_loop = half_lap(Course(spec=spec), loop, way)
    end_m = sum(piece.length_m for piece in round_loop) - stop_before_m
    return _leg(spec, loop, came, (*round_loop, line(spec.s_road_centre_x_m)), end_m)


@lru_cache(maxsize=16)
def last_leg(spec: CourseSpec, loop: Loop, came: Way, roll_out_m: float) -> Leg:
    """Return the leg straight over a crosswalk to rest, `roll_out_m` behind its middle."""
    return _leg(spec, loop, came, (line(spec.loop_centre_x_m),), roll_out_m)


def _leg(spec: CourseSpec, loop: Loop, came: Way, beyond: tuple[Piece, ...], end_m: float) -> Leg:
    """Return the leg that goes on by the pieces `beyond` a crosswalk, to rest `end_m` behind its middle."""
    before = half_lap(Course(spec=spec), OTHER[loop], came)
    path = Path(start=crosswalk_pose(Course(spec=spec), OTHER[loop]), pieces=(*before, *beyond))
    crosswalk_m = float(path.knots_m[len(before)])
    driven = rounded(path, crosswalk_m - LEAD_M, path.length_m)
    return Leg(lane=path, line=driven, end_m=crosswalk_m + end_m)
