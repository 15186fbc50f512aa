"""Parking: backwards into the parallel bay, and nose or tail first into the two-place bay."""

import math
from dataclasses import replace

from adc_bench.dataset.driving.leg import Leg
from adc_bench.dataset.driving.task import SET_OUT_S, Task
from adc_bench.geometry import Path, Piece, Pose2, arc, line
from adc_bench.world.categories import PanelSign
from adc_bench.world.layout import BoxPlace
from adc_bench.world.parking import ParkingPlace
from adc_bench.world.route import half_lap, route

MANOEUVRE_MPS, MANOEUVRE_LATERAL_MPS2 = (0.15, 0.35), 0.15
CHANGING_S = (0.3, 1.0)  # from forwards to backwards
WIDE_TURN_RAD = (math.radians(50), math.radians(70))  # of the S into a free parallel bay
TIGHT_OUT_M, TIGHT_IN_M = 0.28, 0.08  # radii of the two bends into a gap between boxes, with a right angle between
TIGHT_BACK_M = 0.03  # behind the gap's middle, since the nose swings out
BAY_RADIUS_M = (0.45, 0.65)
FREE_ASIDE_M = 0.7  # from the parallel bay's middle, where nothing stands in it


def parallel_parking(task: Task) -> tuple[Leg, ...] | None:
    """From before the crosswalk past the parallel bay, and backwards into it; between the boxes if there are any."""
    path = route(task.course, "west", ["straight", "straight"])
    crosswalk_m = sum(piece.length_m for piece in half_lap(task.course, "west", "straight"))
    start_m = crosswalk_m - task.uniform(0.65, 5.0)
    return parallel_legs(task, path, start_m, crosswalk_m, wait_s=SET_OUT_S, signs=((0.0, "park"),))


def parallel_legs(
    task: Task,
    path: Path,
    start_m: float,
    crosswalk_m: float,
    *,
    wait_s: tuple[float, float],
    signs: tuple[tuple[float, PanelSign], ...],
) -> tuple[Leg, Leg]:
    """Return the legs along a route, which passes the crosswalk towards +x at `crosswalk_m`, and into the bay."""
    lane_y_m = -task.course.spec.lane_outer_radius_m
    target, tight = _parallel_target(task)
    drop_m = lane_y_m - target.y_m
    if tight:
        pieces: tuple[Piece, ...] = (
            arc(TIGHT_OUT_M, math.pi / 2),
            line(drop_m - TIGHT_OUT_M - TIGHT_IN_M),
            arc(TIGHT_IN_M, -math.pi / 2),
        )
        ahead_m = TIGHT_OUT_M + TIGHT_IN_M
    else:
        turn_rad = task.uniform(*WIDE_TURN_RAD)
        radius_m = drop_m / (2 * (1 - math.cos(turn_rad)))
        pieces = (arc(radius_m, turn_rad), arc(radius_m, -turn_rad))
        ahead_m = 2 * radius_m * math.sin(turn_rad)
    halt = Pose2(x_m=target.x_m + ahead_m, y_m=lane_y_m, yaw_rad=math.pi)  # tail first
    return (
        task.leg(path, start_m, crosswalk_m + halt.x_m, wait_s=wait_s, signs=signs),
        _manoeuvre(task, Path(start=halt, pieces=pieces), backwards=True),
    )


def _parallel_target(task: Task) -> tuple[Pose2, bool]:
    """Return where to stand in the parallel bay, and whether that is between two boxes."""
    place = task.course.parking_places[0]
    boxes = [box for box in task.scenario.layout.boxes if is_in(place, box)]
    if not boxes:
        x_m = place.pose.x_m + task.uniform(-FREE_ASIDE_M, FREE_ASIDE_M)
        return Pose2(x_m=x_m, y_m=place.pose.y_m, yaw_rad=0.0), False
    x_m, y_m = (sum(values) / len(boxes) for values in zip(*((box.x_m, box.y_m) for box in boxes), strict=True))
    return Pose2(x_m=x_m - TIGHT_BACK_M, y_m=y_m, yaw_rad=0.0), True


def bay_parking(task: Task) -> tuple[Leg, ...] | None:
    """Along the lane towards +x to a free place of the two-place bay, and in: nose first, or past it and tail first."""
    places = [
        place
        for place in task.course.parking_places[1:]
        if not any(is_in(place, box) for box in task.scenario.layout.boxes)
    ]
    place = places[int(task.rng.integers(len(places)))]
    path = route(task.course, "west", ["turn", "straight"])
    crosswalk_m = sum(piece.length_m for piece in half_lap(task.course, "west", "turn"))
    lane_y_m = -task.course.spec.lane_outer_radius_m
    backwards, radius_m = bool(task.rng.random() < 0.5), task.uniform(*BAY_RADIUS_M)
    along = 1.0 if backwards else -1.0  # the halt lies beyond the place, or before it
    halt = Pose2(x_m=place.pose.x_m + along * radius_m, y_m=lane_y_m, yaw_rad=math.pi if backwards else 0.0)
    pieces = (arc(radius_m, along * math.pi / 2), line(lane_y_m - place.pose.y_m - radius_m))
    start_m = crosswalk_m + halt.x_m - task.uniform(1.5, 6.0)
    return (
        task.leg(path, start_m, crosswalk_m + halt.x_m, signs=((0.0, "park"),)),
        _manoeuvre(task, Path(start=halt, pieces=pieces), backwards=backwards),
    )


def is_in(place: ParkingPlace, box: BoxPlace) -> bool:
    """Return whether a box' middle lies in a parking place."""
    (along_m, aside_m), *_ = place.pose.inverse().transform([(box.x_m, box.y_m)])
    return bool(abs(along_m) < place.length_m / 2 and abs(aside_m) < place.width_m / 2)


def _manoeuvre(task: Task, path: Path, *, backwards: bool) -> Leg:
    slow = replace(task, cruise_mps=task.uniform(*MANOEUVRE_MPS), lateral_mps2=MANOEUVRE_LATERAL_MPS2)
    return slow.leg(path, 0.0, path.length_m, backwards=backwards, wait_s=CHANGING_S)
