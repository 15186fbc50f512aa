"""A run seen from above, as SVG in metres, y upwards: the course, what stands on it, the driven path, the estimates."""

from functools import lru_cache
from html import escape

import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.evaluate.recorded_suite import DetectionSuite
from adc_bench.evaluate.suite import Suite, scenario_for
from adc_bench.leaderboard.site.run_data import RunData
from adc_bench.world.course import Course
from adc_bench.world.footprints import extents
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import SensorRig

Array = NDArray[np.float64]
MARGIN_M = 0.45
TOLERANCE_M = 0.004
KINDS = ("box", "cone", "tunnel", "gantry", "sign")


def course_symbol(course: Course) -> str:
    """Return the road and its paint as a symbol that each map of the page uses."""
    road, paint = (_outline(shapely.union_all(parts)) for parts in ([course.road], course.paint))
    return (
        '<svg class="symbols" aria-hidden="true"><defs><g id="course">'
        f'<path class="road" d="{road}"/><path class="paint" d="{paint}"/></g></defs></svg>'
    )


def run_map(run: RunData, course: Course) -> str:
    """Return the map of a run; the script moves the two robots in it."""
    things = _things(run)
    shown = [*course.paint, *(shape for _, shape in things), shapely.MultiPoint(run.truth_m)]
    x0, y0, x1, y1 = shapely.total_bounds(shown) + MARGIN_M * np.array([-1.0, -1.0, 1.0, 1.0])
    outlines = "".join(f'<path class="{kind}" d="{_outline(shape)}"/>' for kind, shape in things)
    robots = "".join(f'<g class="robot {name}">{_robot(run.robot)}</g>' for name in ("estimate", "truth"))
    estimate = "" if run.estimate_m is None else f'<polyline class="estimate" points="{_points(run.estimate_m)}"/>'
    return (
        f'<svg class="map" role="img" aria-label="{escape(run.told)}" viewBox="{x0:.2f} {-y1:.2f} {x1 - x0:.2f} '
        f'{y1 - y0:.2f}"><g transform="scale(1 -1)"><use href="#course"/>{outlines}'
        f'<polyline class="truth" points="{_points(run.truth_m)}"/>{estimate}{_faults(run)}{robots}</g></svg>'
    )


def _robot(robot: RobotParams) -> str:
    half_l, half_w = robot.length_m / 2, robot.width_m / 2
    return (
        f'<circle r="0.42"/><path d="M{-half_l:g} {-half_w:g}H{half_l:g}V{half_w:g}H{-half_l:g}Z"/>'
        f'<path class="nose" d="M{half_l:g} 0L{half_l - 0.16:.3g} {half_w * 0.7:.3g}V{-half_w * 0.7:.3g}Z"/>'
    )


def _faults(run: RunData) -> str:
    return "".join(
        f'<circle class="fault" cx="{x_m:.2f}" cy="{y_m:.2f}" r="0.16"><title>{escape(told)}</title></circle>'
        for (x_m, y_m), told in run.faults
    )


def _things(run: RunData) -> list[tuple[str, shapely.Geometry]]:
    """Return the kinds and footprints of what can be met on the course; of a hidden suite that is private."""
    suite = run.suite
    if suite.salt_sha256 or isinstance(suite, DetectionSuite):
        return []
    if isinstance(suite, Suite):
        scenario = scenario_for(suite, run.seed)
    else:
        scenario, _ = suite.drawn(run.seed, SensorRig(), None)
    found = extents([solid for solid in scenario.solids if solid.kind in KINDS], scenario.bodies)
    parts: dict[tuple[int, str], list[shapely.Polygon]] = {}
    for index, owner in enumerate(found.owner):
        kind = owner.split("_")[0]
        if kind in KINDS:
            parts.setdefault((KINDS.index(kind), owner), []).append(found.footprint(index))
    return [(KINDS[order], shapely.union_all(shapes)) for (order, _), shapes in sorted(parts.items())]


@lru_cache(maxsize=64)
def _outline(shape: shapely.Geometry) -> str:
    """Return a shape's rings as an SVG path: holes are cut out by the even-odd rule."""
    polygons = shapely.get_parts(shape.simplify(TOLERANCE_M))
    rings = [ring for polygon in polygons for ring in (polygon.exterior, *polygon.interiors)]
    return "".join(f"M{_points(np.asarray(ring.coords)[:-1], 3)}Z" for ring in rings)


def _points(points_m: Array, decimals: int = 2) -> str:
    return " ".join(f"{x:.{decimals}f},{y:.{decimals}f}" for x, y in points_m)
