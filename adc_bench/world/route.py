"""Routes over the figure-eight: half laps from crosswalk to crosswalk, on the right-hand side whichever way."""

from collections.abc import Sequence
from typing import Literal

from adc_bench.geometry import Path, Piece, Pose2, line
from adc_bench.world.course import Course

Loop = Literal["east", "west"]
Way = Literal["straight", "turn"]
OTHER: dict[Loop, Loop] = {"east": "west", "west": "east"}


def route(course: Course, first: Loop, ways: Sequence[Way]) -> Path:
    """Return the middle of the right-hand lane over half laps: the first round the loop `first`, then in turns.

    It begins on the crosswalk, towards that loop. `straight` takes the loop as the lap does; `turn` takes the S-road
    first (left towards +x, right towards -x) and drives round the loop the other way.
    """
    loops = [first if k % 2 == 0 else OTHER[first] for k in range(len(ways))]
    pieces = [piece for loop, way in zip(loops, ways, strict=True) for piece in half_lap(course, loop, way)]
    return Path(start=crosswalk_pose(course, first), pieces=tuple(pieces))


def crosswalk_pose(course: Course, towards: Loop) -> Pose2:
    """Return where the right-hand lane towards a loop passes the crosswalk's middle."""
    return course.lap.pose(0.0 if towards == "east" else course.crosswalk_back_m)


def half_lap(course: Course, loop: Loop, way: Way) -> tuple[Piece, ...]:
    """Return the right-hand lane's pieces from the crosswalk round a loop and back to the crosswalk."""
    if way == "straight":
        return _half(course, course.lap, loop)
    against = _half(course, course.lanes["left"], loop)
    return tuple(Piece(length_m=piece.length_m, curvature_pm=-piece.curvature_pm) for piece in reversed(against))


def _half(course: Course, lane: Path, loop: Loop) -> tuple[Piece, ...]:
    """Return the part of a lane, in the lap's direction, that goes round a loop; the lap's piece 3 leads from one
    half to the other.
    """
    if loop == "east":
        return (*lane.pieces[:3], line(course.spec.s_road_centre_x_m))
    return (line(course.spec.loop_centre_x_m), *lane.pieces[4:])
