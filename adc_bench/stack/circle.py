"""The circle landmark: three points of a line -> circle -> radius test -> centre, refined with the radii of the map."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.robust_fit import Fit, FitNoise, fit_shape

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class CircleParams:
    """When a line counts as the map's circle."""

    least_points: int = 6
    least_chord_m: float = 0.5
    radius_tolerance: float = 0.15  # share of the map's curvature; twice what the chord leaves open comes on top
    sagitta_sd_m: float = 0.006
    worst_distance_m: float = 0.08  # of a point from its circle, to join the refinement
    worst_rms: float = 2.0


def circle_through(a: ArrayLike, b: ArrayLike, c: ArrayLike) -> tuple[Array, float] | None:
    """Return (centre (2,), radius) of the circle through three points: where their perpendicular bisectors meet.

    None where the points lie on a straight line.
    """
    pa, pb, pc = (np.asarray(p, dtype=np.float64) for p in (a, b, c))
    sides = 2 * np.stack([pb - pa, pc - pa])
    if abs(np.linalg.det(sides)) < 1e-9:
        return None
    centre = np.linalg.solve(sides, [pb @ pb - pa @ pa, pc @ pc - pa @ pa])
    return np.asarray(centre, dtype=np.float64), float(np.hypot(*(centre - pa)))


def radius_fits(radius_m: float, map_radius_m: float, chord_m: float, params: CircleParams) -> bool:
    """Return whether a radius measured over a chord is the map's: a short chord leaves the curvature more open.

    The sagitta is chord^2 k / 8 for curvature k, so its error moves the curvature by 8 / chord^2 times as much.
    """
    open_pm = 2 * params.sagitta_sd_m * 8 / chord_m**2
    return abs(1 / radius_m - 1 / map_radius_m) < params.radius_tolerance / map_radius_m + open_pm


def first_centre(points: Array, map_radius_m: float, turn: float, params: CircleParams) -> Array | None:
    """Return the centre that three points of a line (n, 2) give, or None if they are no circle of this radius.

    `turn` is the sign of the curvature along the line: a centre on the other side is refused.
    """
    if len(points) < params.least_points:
        return None
    third = len(points) // 3
    a, b, c = (part.mean(axis=0) for part in (points[:third], points[third:-third], points[-third:]))
    chord_m = float(np.hypot(*(c - a)))
    circle = circle_through(a, b, c)
    if circle is None or chord_m < params.least_chord_m:
        return None
    centre, radius_m = circle
    side = (c - a)[0] * (centre - a)[1] - (c - a)[1] * (centre - a)[0]
    if side * turn < 0 or not radius_fits(radius_m, map_radius_m, chord_m, params):
        return None
    # Keep the direction to the centre, take the length from the map: what is known beats what is measured.
    return np.asarray(b + (centre - b) * (map_radius_m / float(np.hypot(*(centre - b)))), dtype=np.float64)


def see_circle(
    lines: Mapping[float, Array],
    turn: float,
    birds_eye: BirdsEye,
    noise: FitNoise | None = None,
    params: CircleParams | None = None,
) -> Fit | None:
    """Return the common centre (parameters (2,), robot frame) of concentric lines, or None where none passes the test.

    `lines` maps each line's radius on the map to its points (n, 2), nearest first; the line with most points starts.
    """
    p = params or CircleParams()
    ordered = sorted(lines.items(), key=lambda item: -len(item[1]))
    starts = (first_centre(points, radius, turn, p) for radius, points in ordered)
    start = next((centre for centre in starts if centre is not None), None)
    if start is None:
        return None
    kept = [(radius, points[_near_circle(points, start, radius, p)]) for radius, points in ordered]
    points = np.concatenate([part for _, part in kept])
    radii = np.concatenate([np.full(len(part), radius) for radius, part in kept])
    if len(points) < p.least_points:
        return None
    fit = fit_shape(lambda centre: _to_circle(centre, points, radii), start, points, birds_eye, noise or FitNoise())
    return fit if fit.rms < p.worst_rms else None


def _near_circle(points: Array, centre: Array, radius_m: float, p: CircleParams) -> NDArray[np.bool_]:
    near: NDArray[np.bool_] = np.abs(np.hypot(*(points - centre).T) - radius_m) < p.worst_distance_m
    return near


def _to_circle(centre: Array, points: Array, radii: Array) -> tuple[Array, Array, Array]:
    """Return residuals |p - c| - r, their Jacobian in c, and the normals in p."""
    delta = points - centre
    distance = np.hypot(delta[:, 0], delta[:, 1])
    normals = delta / distance[:, None]
    return distance - radii, -normals, normals
