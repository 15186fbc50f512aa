"""From edges seen in a picture to the estimate they call for: a robust fit of pose, tilt and the picture's bloom."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import wrap_rad
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.edge_search import ExpectedEdges
from adc_bench.stack.pose_filter import (
    PITCH,
    ROLL,
    SIZE,
    YAW,
    Estimate,
    Residuals,
    correct,
    squared_distance,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Bloom:
    """How far beyond its edge a picture shows paint, in pixels: mean and sd of three parts.

    Blur and the camera's tone curve move every edge outwards, a narrow mark's by more, for the fall on its one side
    takes from the other's; across the picture more than down it, as far floor is seen at a grazing angle. Each picture
    has its own blur, so the parts are found anew with each.

    Attributes:
        even_px: of every edge.
        narrow_upright_px: on top, of edges of narrow marks that stand upright in the picture.
        narrow_level_px: on top, of edges of narrow marks that lie level in it.
        narrow_px: marks narrower than the second figure are narrow; at the first they have the whole of it.
    """

    even_px: tuple[float, float] = (0.25, 0.15)
    narrow_upright_px: tuple[float, float] = (0.8, 0.4)
    narrow_level_px: tuple[float, float] = (0.12, 0.15)
    narrow_px: tuple[float, float] = (3.0, 7.0)

    @property
    def parts(self) -> Array:
        """Rows mean, sd of the three parts, (2, 3)."""
        return np.array([self.even_px, self.narrow_upright_px, self.narrow_level_px]).T

    def narrowness(self, expected: ExpectedEdges) -> Array:
        """Return (n,): 0 for wide marks, 1 for narrow ones."""
        full_px, none_px = self.narrow_px
        width_px = expected.scale_px_pm * expected.edges_robot.widths_m
        return np.clip((none_px - width_px) / (none_px - full_px), 0.0, 1.0)

    def columns(self, expected: ExpectedEdges) -> Array:
        """Return (n, 3): how far on the floor a pixel of each part moves the edges."""
        narrow, upright = self.narrowness(expected), expected.across_px[:, 0] ** 2
        parts = np.stack([np.ones(len(narrow)), narrow * upright, narrow * (1 - upright)], axis=1)
        return np.asarray(parts / expected.scale_px_pm[:, None])


@dataclass(frozen=True, kw_only=True)
class EdgeFitParams:
    """How edges are weighed.

    Attributes:
        wide_sd_px: of an edge's place in the picture ...
        narrow_sd_px: ... and what a narrow mark adds.
        floor_sd_m: of the paint's own edge.
        independent: how many edges' worth a picture of another place tells: neighbours, and pictures running, share
            their errors.
        believed_sds: where an edge counts half; beyond, it is soon another edge.
        rounds: of weighing anew.
    """

    wide_sd_px: float = 0.15
    narrow_sd_px: float = 0.25
    floor_sd_m: float = 0.001
    independent: float = 12.0
    believed_sds: float = 2.5
    rounds: int = 4
    bloom: Bloom = field(default_factory=Bloom)


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeFit:
    """The estimate that fits, how many edges agree with it, and what they said against the estimate before: the
    innovation's squared Mahalanobis distance and its degrees of freedom.
    """

    estimate: Estimate
    agreeing: int
    squared_distance: float
    freedoms: int


def offset_jacobian(expected: ExpectedEdges, eye: BirdsEye, yaw_rad: float) -> Array:
    """Return (n, 7): how far along its normal an edge is seen from where it is expected, per unit of error in the
    state, all else being right; `eye` and the edges are those of the estimate.
    """
    points, normals = expected.edges_robot.points, expected.edges_robot.normals
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    H = np.zeros((len(points), SIZE))
    H[:, :2] = -normals @ np.array([[c, s], [-s, c]])
    H[:, YAW] = points[:, 1] * normals[:, 0] - points[:, 0] * normals[:, 1]
    H[:, [PITCH, ROLL]] = np.einsum("ni,nij->nj", normals, eye.tilt_jacobian(points))
    return H


def fit_edges(
    estimate: Estimate, seen: ExpectedEdges, offsets_m: Array, jacobian: Array, news: float, params: EdgeFitParams
) -> EdgeFit:
    """Return the estimate after edges seen `offsets_m` (n,) from where it expects them, with their Jacobian (n, 7).

    `news` is the share of the picture's errors that the ones before did not have. The bloom's parts join the state for
    this picture. Weights are Cauchy's, found in a few rounds.
    """
    mean, sd = params.bloom.parts
    columns = params.bloom.columns(seen)
    with_bloom = _joined(estimate, np.square(sd))
    values, jacobian = offsets_m - columns @ mean, np.hstack([jacobian, columns])
    sd_px = params.wide_sd_px + params.narrow_sd_px * params.bloom.narrowness(seen)
    sd_m = np.hypot(sd_px / seen.scale_px_pm, params.floor_sd_m)
    shared = max(1.0, len(values) / params.independent) / news
    # The spread of the estimate itself must not count against an edge before the first round.
    before_m = np.sqrt(sd_m**2 + np.einsum("ni,ij,nj->n", jacobian, with_bloom.covariance, jacobian))
    weights = _cauchy(values / before_m, params)
    for _ in range(params.rounds):
        residuals = Residuals(values=values, jacobian=jacobian, variances=shared * sd_m**2 / weights)
        fitted = correct(with_bloom, residuals)
        moved = fitted.mean - with_bloom.mean
        moved[YAW] = wrap_rad(float(moved[YAW]))
        left = (values - jacobian @ moved) / sd_m
        weights = _cauchy(left, params)
    distance, freedoms = squared_distance(with_bloom, residuals)
    return EdgeFit(
        estimate=Estimate(mean=fitted.mean[:SIZE], covariance=fitted.covariance[:SIZE, :SIZE]),
        agreeing=int(np.count_nonzero(np.abs(left) < params.believed_sds)),
        squared_distance=distance,
        freedoms=freedoms,
    )


def _joined(estimate: Estimate, variances: Array) -> Estimate:
    """Return the estimate with further unknowns, independent of it and expected to be 0."""
    size = SIZE + len(variances)
    covariance = np.zeros((size, size))
    covariance[:SIZE, :SIZE] = estimate.covariance
    covariance[range(SIZE, size), range(SIZE, size)] = variances
    return Estimate(mean=np.concatenate([estimate.mean, np.zeros(len(variances))]), covariance=covariance)


def _cauchy(sds: Array, params: EdgeFitParams) -> Array:
    return np.asarray(1 / (1 + (sds / params.believed_sds) ** 2))
