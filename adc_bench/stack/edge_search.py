"""Edges of the map looked for in a picture: across each expected edge, the steepest fall from light to dark.

So the picture is asked only what the map knows, and answers with a distance an edge: a few thousand pixels are read.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.paint_edges import PaintEdges

Array = NDArray[np.float64]
FLOOR_STEP_M = 0.005  # over which the floor's scale in the picture is taken
LAG = 2  # samples each way between which a fall is taken


@dataclass(frozen=True, kw_only=True)
class EdgeSearchParams:
    """Where edges are looked for and when one is believed.

    Attributes:
        reach_m: of the floor ahead.
        resolution_px_pm: pixels a metre across an edge, at least: a line must be wider than the blur.
        border_px: kept clear of at the picture's border.
        spreads: how many standard deviations of its place an edge is looked for on either side ...
        search_px: ... but at least and at most so far.
        step_px: between samples.
        blur_px: sd of the smoothing before.
        least_fall: of an edge, as a share of the brightness round it ...
        fall_share: ... and of what half of the edges in the picture have.
        dark_levels: added to that brightness, so that noise in the dark is no edge.
    """

    reach_m: float = 4.0
    resolution_px_pm: float = 50.0
    border_px: float = 3.0
    spreads: float = 3.0
    search_px: tuple[float, float] = (5.0, 24.0)
    step_px: float = 0.5
    blur_px: float = 0.8
    least_fall: float = 0.1
    fall_share: float = 0.4
    dark_levels: float = 12.0


@dataclass(frozen=True, kw_only=True, eq=False)
class ExpectedEdges:
    """Edges that the picture should show: where they are seen from the robot, where in the picture (n, 2), the unit
    vectors (n, 2) across them there, from light to dark, and the scale (n,) across them in pixels a metre of floor.
    """

    edges_robot: PaintEdges
    pixels_px: Array
    across_px: Array
    scale_px_pm: Array

    def of(self, chosen: NDArray[np.bool_]) -> "ExpectedEdges":
        """Return some of them."""
        return ExpectedEdges(
            edges_robot=self.edges_robot.of(chosen),
            pixels_px=self.pixels_px[chosen],
            across_px=self.across_px[chosen],
            scale_px_pm=self.scale_px_pm[chosen],
        )


def expect_edges(eye: BirdsEye, edges_robot: PaintEdges, params: EdgeSearchParams) -> ExpectedEdges:
    """Return those of the edges that the picture resolves."""
    p, mount = params, eye.mount
    ahead_m = edges_robot.points[:, 0] - mount.x_m
    near = edges_robot.of((ahead_m > 0) & (ahead_m**2 + edges_robot.points[:, 1] ** 2 < p.reach_m**2))
    pixels = eye.to_pixels(near.points)
    along = eye.to_pixels(near.points + FLOOR_STEP_M * np.stack([-near.normals[:, 1], near.normals[:, 0]], axis=1))
    # Across the edge as the picture shows it, which is not where the floor's normal points.
    across = (along - pixels)[:, ::-1] * (1.0, -1.0)
    across = across / np.hypot(across[:, 0], across[:, 1])[:, None]
    outward = eye.to_pixels(near.points + FLOOR_STEP_M * near.normals) - pixels
    scale = np.sum(across * outward, axis=1) / FLOOR_STEP_M
    limits = np.array([mount.width_px, mount.height_px]) - p.border_px
    inside = np.all((pixels > p.border_px) & (pixels < limits), axis=1)
    every = ExpectedEdges(
        edges_robot=near,
        pixels_px=pixels,
        across_px=across * np.sign(scale)[:, None],
        scale_px_pm=np.abs(scale),
    )
    return every.of(inside & (np.abs(scale) > p.resolution_px_pm))


def find_edges(
    rgb: NDArray[np.uint8], expected: ExpectedEdges, spread_m: Array, params: EdgeSearchParams
) -> tuple[NDArray[np.bool_], Array]:
    """Return which of the edges (n,) a picture (height, width, 3) shows, and how far those are from where they were
    expected, (m,) in metres along their normals. `spread_m` (n,) is how well their places are known, one sd.
    """
    if not len(spread_m):
        return np.zeros(0, dtype=np.bool_), np.zeros(0)
    half_px = np.clip(params.spreads * spread_m * expected.scale_px_pm, *params.search_px)
    steps_px, falls = _falls(rgb, expected, float(half_px.max()), params)
    falls = np.where(np.abs(steps_px) < half_px[:, None], falls, -np.inf)
    best = np.clip(np.argmax(falls, axis=1), 1, len(steps_px) - 2)
    before, peak, after = (falls[np.arange(len(best)), best + k] for k in (-1, 0, 1))
    # At the end of a search there is a slope, not yet an edge.
    found = np.isfinite(before) & np.isfinite(after) & (peak >= np.maximum(before, after)) & (peak > params.least_fall)
    if found.any():
        found &= peak > params.fall_share * np.median(peak[found])
    before, peak, after = before[found], peak[found], after[found]
    bend = np.maximum(2 * peak - before - after, 1e-9)
    offset_px = steps_px[best[found]] + np.clip((after - before) / (2 * bend), -0.5, 0.5) * params.step_px
    return found, offset_px / expected.scale_px_pm[found]


def _falls(rgb: NDArray[np.uint8], expected: ExpectedEdges, half_px: float, p: EdgeSearchParams) -> tuple[Array, Array]:
    """Return places (k,) across the edges in pixels, and the falls of brightness (n, k) there, relative to it."""
    count = math.ceil(half_px / p.step_px) + LAG
    steps_px = np.arange(-count, count + 1) * p.step_px
    grey = cv2.GaussianBlur(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY).astype(np.float32), (3, 3), p.blur_px)
    # Pixel centres are at whole numbers plus one half, array indices at whole numbers.
    at = expected.pixels_px[:, :, None] - 0.5 + expected.across_px[:, :, None] * steps_px
    columns, rows = (np.ascontiguousarray(at[:, k], dtype=np.float32) for k in (0, 1))
    seen = cv2.remap(grey, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    levels = np.asarray(seen, dtype=np.float64)
    falls: Array = (levels[:, : -2 * LAG] - levels[:, 2 * LAG :]) / (levels.mean(axis=1)[:, None] + p.dark_levels)
    return np.asarray(steps_px[LAG:-LAG]), falls
