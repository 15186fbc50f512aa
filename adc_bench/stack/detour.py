"""The way ahead past what the laser has met: by the other lane round boxes, between the cones through road-works."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Mission
from adc_bench.geometry import Path, Pose2
from adc_bench.stack.lane_change import ChangeParams, offsets, stop_m, taken
from adc_bench.stack.obstacle_map import MapParams, ObstacleMap, cones_among, things
from adc_bench.stack.reference_line import ReferenceLine, line_through, rounded
from adc_bench.stack.timetable import SpeedLimits, Timetable, fastest
from adc_bench.stack.works_way import WorksParams, corridor, works_cones

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class DetourParams:
    """How far is looked and planned, and how fast it is driven where something may stand on the road."""

    behind_m: float = 6.5  # road-works are as long
    ahead_m: float = 5.0
    beside_m: float = 2.2  # from the lane's middle: the road-works' outer row may stand so far out
    works_out_m: float = 1.7  # from a loop's outer line
    speed_mps: float = 1.1
    works_speed_mps: float = 0.7
    works_near_m: float = 1.5  # before the first cone and behind the last one
    changes: ChangeParams = field(default_factory=ChangeParams)
    works: WorksParams = field(default_factory=WorksParams)
    map: MapParams = field(default_factory=MapParams)


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """The line to drive over a stretch of a path: its `path_s_m` are the path's arc lengths. `stop_m` is where on the
    path to come to rest because both lanes are taken, and `works` the stretch of the path between the cones.
    """

    line: ReferenceLine
    stop_m: float | None = None
    works: tuple[float, float] | None = None


def way_ahead(
    mission: Mission, route: Path, known: ObstacleMap, here_m: tuple[float, float], end_m: float, params: DetourParams
) -> Way:
    """Return the way along a route from a little before the robot to `ahead_m` before it, or to `end_m`.

    `here_m` is where the robot is, (s, offset) from the route, and `known` what stands. Boxes take lanes, cones are
    road-works if the mission may hold them; what stands beside the road (a tunnel's walls, furniture) is in no one's
    way.
    """
    s_m, offset_m = here_m
    line = rounded(route, max(s_m - 0.5, 0.0), min(s_m + params.ahead_m, end_m))
    boxes, cones = _beside(mission, route, known, s_m, params)
    course = mission.course
    pitch_m = course.radius_outer_m - course.radius_centre_m
    own, other = (taken(*boxes, lane_m, params.changes) for lane_m in (0.0, pitch_m))
    stop = stop_m(own, other, params.changes)
    passed = tuple(box for box in own if stop is None or box.from_m < stop)
    aside = offsets(line.path_s_m, passed, pitch_m, params.changes)
    chosen = works_cones(*cones, params.works)
    works = None
    if len(chosen):
        cone_s, cone_offset = cones[0][chosen], cones[1][chosen]
        here = (s_m, offset_m - float(np.interp(s_m, line.path_s_m, aside)))
        middle = corridor(cone_s, cone_offset, route.curvature_pm(cone_s), here, params.works)
        assert middle is not None, "there are cones"
        aside = aside + middle.offsets(line.path_s_m)
        works = (float(cone_s[0]), float(cone_s[-1]))
    normals = np.column_stack([-np.sin(line.yaw_rad), np.cos(line.yaw_rad)])
    points = np.column_stack([line.x_m, line.y_m]) + aside[:, None] * normals
    return Way(line=line_through(points, line.path_s_m), stop_m=stop, works=works)


def _beside(
    mission: Mission, route: Path, known: ObstacleMap, s_m: float, params: DetourParams
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return (s, offset) of the boxes' points, and of the cones' middles, on and beside the stretch about `s_m`."""
    near = (params.ahead_m + params.behind_m) / 2
    around = {"around_s_m": s_m + params.ahead_m - near, "window_m": near}
    s, offset = route.project(known.points_world, **around)
    inside = (np.abs(offset) < params.beside_m) & (np.abs(s - around["around_s_m"]) < near)
    found = things(known, inside, params.map)
    narrow = cones_among(found, params.map) if "works" in mission.elements else ()
    cones = [thing.middle_m for thing in narrow if _is_round_a_loop(mission, thing.middle_m, params)]
    boxes = [thing.points_world for thing in found if thing not in narrow]
    return (
        route.project(np.concatenate([np.zeros((0, 2)), *boxes]), **around),
        route.project(np.array(cones).reshape(-1, 2), **around),
    )


def _is_round_a_loop(mission: Mission, place_m: Array, params: DetourParams) -> bool:
    """Return whether a place lies where road-works may be: not by the crosswalk, where the gantry's posts stand."""
    course = mission.course
    apart_m = np.hypot(abs(place_m[0]) - course.loop_centre_x_m, place_m[1])
    return bool(apart_m < course.radius_outer_m + params.works_out_m)


@dataclass(frozen=True, kw_only=True)
class Detour:
    """Speeds along the way past what stands beside a route, up to the route's arc length `end_m`."""

    mission: Mission
    route: Path
    end_m: float
    params: DetourParams = field(default_factory=DetourParams)

    def timetable(self, known: ObstacleMap, s_m: float, pose: Pose2, speed_mps: float) -> Timetable:
        """Return the way ahead of a robot at a pose, near an arc length of the route, that is so fast."""
        ((s_m,), (offset_m,)) = self.route.project([(pose.x_m, pose.y_m)], around_s_m=s_m)
        way = way_ahead(self.mission, self.route, known, (s_m, offset_m), self.end_m, self.params)
        limits = SpeedLimits.of(self.mission.robot, speed_mps=self._speed_mps(way, s_m))
        line = way.line
        if way.stop_m is not None:
            line = _until(line, max(way.stop_m, s_m + speed_mps**2 / (2 * limits.acceleration_mps2)))
        return fastest(line, limits, start_mps=speed_mps)

    def _speed_mps(self, way: Way, s_m: float) -> float:
        near_m = self.params.works_near_m
        if way.works and way.works[0] - near_m < s_m < way.works[1] + near_m:
            return self.params.works_speed_mps
        return self.params.speed_mps


def _until(line: ReferenceLine, path_s_m: float) -> ReferenceLine:
    """Return a line's part up to an arc length of its path."""
    count = max(int(np.searchsorted(line.path_s_m, path_s_m)), 3)
    return replace(
        line,
        **{name: getattr(line, name)[:count] for name in ("s_m", "path_s_m", "x_m", "y_m", "yaw_rad", "curvature_pm")},
    )
