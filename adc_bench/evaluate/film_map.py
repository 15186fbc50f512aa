"""The course from above for a film: the road and what stands on it, the driven way, and where the submission was sure
to be.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from adc_bench.evaluate.log import Row
from adc_bench.geometry import Pose2
from adc_bench.world.footprints import extents
from adc_bench.world.scenario import Scenario

Picture = NDArray[np.uint8]
Colour = tuple[int, int, int]

SHIFT = 4  # OpenCV's sixteenths of a pixel
MARGIN_M = 0.5
FLOOR, ROAD, PAINT = (24, 24, 28), (58, 58, 62), (190, 190, 190)
THINGS: dict[str, Colour] = {
    "tunnel": (96, 84, 72),
    "box": (90, 200, 90),
    "cone": (60, 140, 255),
    "gantry": (150, 110, 110),
    "sign": (200, 200, 110),
}
DRIVEN, ESTIMATE, ROBOT = (255, 170, 80), (110, 110, 255), (60, 230, 255)


@dataclass(frozen=True, kw_only=True, eq=False)
class FilmMap:
    """The map of one arena, `size_px` wide and high."""

    scenario: Scenario
    size_px: tuple[int, int]

    def drawn(self, rows: Sequence[Row]) -> Picture:
        """Return the map (height, width, 3), blue first, after these rows of a run."""
        canvas = self._empty.copy()
        estimates = [row.answer.estimate for row in rows if row.answer]
        for poses, colour in ((estimates, ESTIMATE), ([row.truth for row in rows], DRIVEN)):
            way = self._pixels(np.array([(pose.x_m, pose.y_m) for pose in poses]).reshape(-1, 2))
            cv2.polylines(canvas, [way], False, colour, 1, cv2.LINE_AA, SHIFT)
        self._draw_robot(canvas, rows[-1].truth)
        return canvas

    @cached_property
    def _frame(self) -> tuple[float, float, float]:
        """The picture's left and upper edge in the world, and pixels a metre: all paint, and as large as it can be."""
        x0, y0, x1, y1 = shapely.union_all(self.scenario.course.paint).bounds
        width, height = self.size_px
        scale = min(width / (x1 - x0 + 2 * MARGIN_M), height / (y1 - y0 + 2 * MARGIN_M))
        return (x0 + x1 - width / scale) / 2, (y0 + y1 + height / scale) / 2, scale

    def _pixels(self, points_world: ArrayLike) -> NDArray[np.int32]:
        """Return points (n, 2) as OpenCV draws them."""
        left_m, top_m, scale = self._frame
        points = np.asarray(points_world, dtype=np.float64)
        pixels = np.column_stack([points[:, 0] - left_m, top_m - points[:, 1]]) * scale - 0.5
        # Estimates may be anywhere: OpenCV's coordinates may not.
        return np.asarray(np.round(np.clip(pixels, -1e4, 1e4) * 2**SHIFT), dtype=np.int32)

    @cached_property
    def _empty(self) -> Picture:
        width, height = self.size_px
        canvas = np.full((height, width, 3), FLOOR, dtype=np.uint8)
        self._fill(canvas, self.scenario.course.road, ROAD)
        for mark in self.scenario.course.paint:
            self._fill(canvas, mark, PAINT)
        scenario = self.scenario
        found = extents([solid for solid in scenario.solids if solid.kind in THINGS], scenario.bodies)
        for index, owner in enumerate(found.owner):
            colour = THINGS.get(owner.split("_")[0])
            if colour:
                self._fill(canvas, found.footprint(index), colour)
        return canvas

    def _fill(self, canvas: Picture, shape: shapely.Polygon, colour: Colour) -> None:
        rings = [self._pixels(np.asarray(ring.coords)) for ring in (shape.exterior, *shape.interiors)]
        cv2.fillPoly(canvas, rings, colour, cv2.LINE_AA, SHIFT)

    def _draw_robot(self, canvas: Picture, pose: Pose2) -> None:
        robot = self.scenario.robot
        half_l, half_w = robot.length_m / 2, robot.width_m / 2
        arrow = np.array([(half_l, 0.0), (-half_l, half_w), (-half_l / 2, 0.0), (-half_l, -half_w)])
        # A robot to scale would be ten pixels long.
        cv2.fillPoly(canvas, [self._pixels(pose.transform(1.6 * arrow))], ROBOT, cv2.LINE_AA, SHIFT)
