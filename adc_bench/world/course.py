"""The road as data: every line, dash and stripe of the figure-eight from one geometric description.

World frame: origin midway between the loop centres, x along the long axis in the starting direction, y left, z up.
Figures are of line centres, in metres. `COURSE_SETS["a"]` is measured on the 2022 track drawing, `"b"` has the wider
radii and lines of the older simulators.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import msgspec
import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from adc_bench.geometry import Path, Piece, Pose2, arc, line
from adc_bench.world.parking import BaySpec, ParkingPlace, bay_paint, bay_places

Array = NDArray[np.float64]
QUARTER = math.pi / 2
CourseName = Literal["a", "b"]


class CourseSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The figures that fix the course; part of the rules."""

    loop_centre_x_m: float = 5.35
    s_road_centre_x_m: float = 0.90
    radius_outer_m: float = 3.00
    radius_centre_m: float = 2.225
    radius_inner_m: float = 1.45
    edge_line_width_m: float = 0.05
    dash_width_m: float = 0.05
    dash_length_m: float = 0.20
    dash_period_m: float = 0.35
    dash_gap_at_crosswalk_m: float = 0.075
    dash_gap_at_mouth_m: float = 0.60  # the S-road's dashes end this far, across, before the straight's
    stop_line_length_m: float = 1.35
    stop_line_width_m: float = 0.10
    stop_line_gap_m: float = 0.075
    stripe_count: int = 7
    stripe_width_m: float = 0.10
    stripe_length_m: float = 0.35
    stripe_pitch_m: float = 0.20
    bulge_start_x_m: float = 0.35
    bulge_taper_m: float = 1.00
    bulge_depth_m: float = 0.85
    bulge_dash_width_m: float = 0.05
    bay: BaySpec = BaySpec()

    @property
    def crosswalk_depth_m(self) -> float:
        """Extent of stripes, gaps and both stop lines along the road."""
        return self.stripe_length_m + 2 * (self.stop_line_gap_m + self.stop_line_width_m)

    @property
    def lane_inner_radius_m(self) -> float:
        """Radius of the lane nearer to a loop's centre."""
        return (self.radius_centre_m + self.radius_inner_m) / 2

    @property
    def lane_outer_radius_m(self) -> float:
        """Radius of the lane farther from a loop's centre."""
        return (self.radius_centre_m + self.radius_outer_m) / 2


COURSE_SETS: Mapping[CourseName, CourseSpec] = {
    "a": CourseSpec(),
    # Radii, centres and 10 cm lines of benchmark.md's set B; crosswalk and dashes as CONDE's drawing has them.
    "b": CourseSpec(
        loop_centre_x_m=5.30,
        s_road_centre_x_m=0.60,
        radius_outer_m=3.15,
        radius_centre_m=2.35,
        radius_inner_m=1.55,
        edge_line_width_m=0.10,
        stop_line_length_m=1.30,
        stop_line_gap_m=0.05,
        stripe_length_m=0.30,
        bulge_start_x_m=0.30,
        bulge_dash_width_m=0.10,
    ),
}


@dataclass(frozen=True, kw_only=True)
class Course:
    """The road with its lines, lanes, crosswalk and map landmarks."""

    spec: CourseSpec = field(default_factory=CourseSpec)

    @cached_property
    def lap(self) -> Path:
        """The centre of the right lane over one lap, closed, from the start line x = 0 (40.46 m).

        +x leg, +x loop counter-clockwise in its outer lane, S-road, -x leg, -x loop clockwise in its inner lane,
        S-road.
        """
        c = self.spec
        outer, inner = c.lane_outer_radius_m, c.lane_inner_radius_m
        return Path(
            start=Pose2(x_m=0.0, y_m=-outer, yaw_rad=0.0),
            pieces=(
                line(c.loop_centre_x_m),
                arc(outer, 3 * QUARTER),
                arc(inner, -QUARTER),
                line(c.s_road_centre_x_m + c.loop_centre_x_m),
                arc(inner, -3 * QUARTER),
                arc(outer, QUARTER),
                line(c.s_road_centre_x_m),
            ),
            closed=True,
        )

    @cached_property
    def lanes(self) -> Mapping[str, Path]:
        """Lane centre lines by name: `right` is the lap, `left` the parallel lane, in the same direction."""
        return {
            "right": self.lap,
            "left": self.lap.offset(self.spec.radius_outer_m - self.spec.radius_centre_m),
        }

    @cached_property
    def outer_edge(self) -> Path:
        """The closed outer outline as painted without the bulge, counter-clockwise from (0, -r_outer)."""
        c = self.spec
        return Path(
            start=Pose2(x_m=0.0, y_m=-c.radius_outer_m, yaw_rad=0.0),
            pieces=(
                line(c.loop_centre_x_m),
                arc(c.radius_outer_m, 3 * QUARTER),
                arc(c.radius_inner_m, -QUARTER),
                line(2 * c.s_road_centre_x_m),
                arc(c.radius_inner_m, -QUARTER),
                arc(c.radius_outer_m, 3 * QUARTER),
                line(c.loop_centre_x_m),
            ),
            closed=True,
        )

    @cached_property
    def drops(self) -> tuple[Path, Path]:
        """The closed outlines of the two islands (+x loop, -x loop), each from its tip."""
        return self._drop_east, _mirror_x(self._drop_east)

    @cached_property
    def _drop_east(self) -> Path:
        c = self.spec
        half = math.asin(c.radius_inner_m / c.radius_outer_m)
        tip_x = c.s_road_centre_x_m + c.radius_outer_m * math.cos(half)
        return Path(
            start=Pose2(x_m=tip_x, y_m=-c.radius_inner_m, yaw_rad=0.0),
            pieces=(
                line(c.loop_centre_x_m - tip_x),
                arc(c.radius_inner_m, 3 * QUARTER),
                arc(c.radius_outer_m, -half),
            ),
            closed=False,
        )

    @cached_property
    def edge_lines(self) -> Mapping[str, Array]:
        """Solid edge lines as dense polylines (n, 2) by name; touching one is a line touch."""
        c = self.spec
        solid_start = self.outer_edge.knots_m[1]
        solid_length = self.outer_edge.length_m - c.loop_centre_x_m + c.bulge_start_x_m
        s = solid_start + np.linspace(0.0, solid_length, math.ceil(solid_length / 0.02) + 1)
        return {
            "outer": self.outer_edge.poses(s)[:, :2],
            "bulge": self.bulge_corners,
            "drop_east": self.drops[0].sample(0.02)[:, :2],
            "drop_west": self.drops[1].sample(0.02)[:, :2],
        }

    @cached_property
    def bulge_corners(self) -> Array:
        """The four corners (4, 2) of the parallel bay's solid line, in +x direction."""
        c = self.spec
        near, far = -c.radius_outer_m, -c.radius_outer_m - c.bulge_depth_m
        x0, x3 = c.bulge_start_x_m, c.loop_centre_x_m
        return np.array([[x0, near], [x0 + c.bulge_taper_m, far], [x3 - c.bulge_taper_m, far], [x3, near]])

    @cached_property
    def dashed_lines(self) -> tuple[Path, ...]:
        """The paths along which dashes are painted, each beginning with a dash: the road's centre line over the +x
        loop and over the -x loop, and the parallel bay's side.
        """
        c = self.spec
        clear = c.crosswalk_depth_m / 2 + c.dash_gap_at_crosswalk_m
        mouth = math.acos(1 - c.dash_gap_at_mouth_m / c.radius_centre_m)
        east = Path(
            start=Pose2(x_m=clear, y_m=-c.radius_centre_m, yaw_rad=0.0),
            pieces=(
                line(c.loop_centre_x_m - clear),
                arc(c.radius_centre_m, 3 * QUARTER),
                arc(c.radius_centre_m, -(QUARTER - mouth)),
            ),
        )
        bulge = Path(
            start=Pose2(x_m=c.bulge_start_x_m, y_m=-c.radius_outer_m, yaw_rad=0.0),
            pieces=(line(c.loop_centre_x_m - c.bulge_start_x_m),),
        )
        return east, _mirror_x(east), bulge

    @cached_property
    def crosswalk_corners(self) -> Array:
        """Corners (4, 2) of the rectangle around stripes and stop lines: (-x,-y), (+x,-y), (+x,+y), (-x,+y)."""
        half_x, half_y = self.spec.crosswalk_depth_m / 2, self.spec.stop_line_length_m / 2
        y = -self.spec.radius_centre_m
        return np.array([[-half_x, y - half_y], [half_x, y - half_y], [half_x, y + half_y], [-half_x, y + half_y]])

    @cached_property
    def paint(self) -> tuple[shapely.Polygon, ...]:
        """Every white mark on the floor as a polygon."""
        return (*self.line_paint, *self._crosswalk_paint(), *self.bay_paint)

    @cached_property
    def line_paint(self) -> tuple[shapely.Polygon, ...]:
        """The lines of the road and of the parallel place: edge lines, then dashes."""
        return (*self._edge_paint(), *self._dash_paint())

    @cached_property
    def bay_paint(self) -> tuple[shapely.Polygon, ...]:
        """The two-place bay: its outline, a ring, first."""
        return bay_paint(self.spec.bay, self.kerb_y_m)

    def _edge_paint(self) -> list[shapely.Polygon]:
        half = self.spec.edge_line_width_m / 2
        return [
            shapely.LineString(points).buffer(
                half, cap_style="square" if "drop" in name else "flat", join_style="mitre"
            )
            for name, points in self.edge_lines.items()
        ]

    def _dash_paint(self) -> list[shapely.Polygon]:
        c = self.spec
        widths_m = (c.dash_width_m, c.dash_width_m, c.bulge_dash_width_m)
        dashes = []
        for path, width_m in zip(self.dashed_lines, widths_m, strict=True):
            for start_m in np.arange(0.0, path.length_m, c.dash_period_m):
                s = np.linspace(start_m, min(start_m + c.dash_length_m, path.length_m), 9)
                if s[-1] - s[0] > c.dash_length_m / 2:
                    dashes.append(shapely.LineString(path.poses(s)[:, :2]).buffer(width_m / 2, cap_style="flat"))
        return dashes

    def _crosswalk_paint(self) -> list[shapely.Polygon]:
        c = self.spec
        (x0, y0), (x1, _), (_, y1), _ = self.crosswalk_corners
        y = -c.radius_centre_m
        marks = [
            shapely.box(x0, y0, x0 + c.stop_line_width_m, y1),
            shapely.box(x1 - c.stop_line_width_m, y0, x1, y1),
        ]
        for k in range(c.stripe_count):
            middle = y + (k - (c.stripe_count - 1) / 2) * c.stripe_pitch_m
            half_l, half_w = c.stripe_length_m / 2, c.stripe_width_m / 2
            marks.append(shapely.box(-half_l, middle - half_w, half_l, middle + half_w))
        return marks

    @property
    def kerb_y_m(self) -> float:
        """The y of the outer edge of the outer line beside the start straight."""
        return -self.spec.radius_outer_m - self.spec.edge_line_width_m / 2

    @cached_property
    def parking_places(self) -> tuple[ParkingPlace, ...]:
        """The places to park: `parallel` (the bulge's flat part), then `bay_near` and `bay_far` of the two-place bay.

        None of the two-place bay's lines is an edge line of the road.
        """
        c = self.spec
        flat_m = c.loop_centre_x_m - c.bulge_start_x_m - 2 * c.bulge_taper_m
        middle = Pose2(
            x_m=(c.loop_centre_x_m + c.bulge_start_x_m) / 2,
            y_m=-c.radius_outer_m - c.bulge_depth_m / 2,
            yaw_rad=0.0,
        )
        parallel = ParkingPlace(name="parallel", pose=middle, length_m=flat_m, width_m=c.bulge_depth_m)
        return (parallel, *bay_places(c.bay, self.kerb_y_m))

    @cached_property
    def road(self) -> shapely.Polygon:
        """The drivable surface between the line centres, parallel bay included, islands left out."""
        outline = shapely.Polygon(self.outer_edge.sample(0.02)[:, :2]).union(shapely.Polygon(self.bulge_corners))
        islands = [shapely.Polygon(drop.sample(0.02)[:, :2]) for drop in self.drops]
        road = outline.difference(shapely.union_all(islands))
        shapely.prepare(road)
        return road

    @cached_property
    def _edges(self) -> shapely.MultiLineString:
        edges = shapely.MultiLineString(list(self.edge_lines.values()))
        shapely.prepare(edges)
        return edges

    def on_road(self, points_world: ArrayLike) -> NDArray[np.bool_]:
        """Return for each point (n, 2) whether it lies on the road."""
        points = np.asarray(points_world, dtype=np.float64)
        inside: NDArray[np.bool_] = shapely.contains_xy(self.road, points[:, 0], points[:, 1])
        return inside

    def distance_to_edge_lines_m(self, points_world: ArrayLike) -> Array:
        """Return the distance (n,) from each point (n, 2) to the nearest solid edge line's centre."""
        distance: Array = shapely.distance(self._edges, shapely.points(np.asarray(points_world, dtype=np.float64)))
        return distance

    @cached_property
    def crosswalk_back_m(self) -> float:
        """Where the lap passes the crosswalk's middle towards -x; towards +x it does so at 0."""
        return float(self.lap.knots_m[3]) + self.spec.s_road_centre_x_m


def _mirror_x(path: Path) -> Path:
    """Return the path mirrored in the y axis, driven from its old start."""
    start = Pose2(x_m=-path.start.x_m, y_m=path.start.y_m, yaw_rad=math.pi - path.start.yaw_rad)
    pieces = tuple(Piece(length_m=p.length_m, curvature_pm=-p.curvature_pm) for p in path.pieces)
    return Path(start=start, pieces=pieces, closed=path.closed)
