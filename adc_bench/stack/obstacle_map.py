"""What stands in the world as the laser has seen it: small cells with how often they were met, joined to things.

The map is bounded: cells that few scans met are forgotten after a while, and of too many the oldest go.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from adc_bench.geometry import Pose2

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

CELL_M = 0.05


@dataclass(frozen=True, kw_only=True)
class MapParams:
    """When cells are believed, forgotten and joined, and how wide a cone may seem."""

    hits_believed: int = 2  # a cell's, or those of a cell with its neighbours
    forget_s: float = 3.0
    hits_kept: int = 2  # cells with more hits are not forgotten
    cells_max: int = 6000
    join_m: float = 0.24
    cone_width_max_m: float = 0.24
    cone_alone_m: float = 0.45  # cones of a row may stand 0.6 m apart, the legs of a chair are 0.38 m apart
    cone_hits: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Thing:
    """What stands somewhere: the middles (n, 2) of its cells in the world, and how often each was met (n,)."""

    points_world: Array
    hits: Whole

    @property
    def middle_m(self) -> Array:
        """The mean (2,) of all hits."""
        return self._mean(self.points_world)

    @property
    def width_m(self) -> float:
        """Four times the hits' root mean square distance from their middle: of a line of hits a little over its length,
        while single hits far off count for little.
        """
        return 4 * math.sqrt(self._mean(np.square(self.points_world - self.middle_m)).sum())

    def _mean(self, values: Array) -> Array:
        return np.asarray(self.hits @ values / self.hits.sum(), dtype=np.float64)


@dataclass(frozen=True, kw_only=True, eq=False)
class ObstacleMap:
    """Cells (n, 2) of `CELL_M` in the world, sorted; how often each was met, and when at last."""

    cells: Whole = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    hits: Whole = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    seen_s: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def points_world(self) -> Array:
        """The cells' middles (n, 2)."""
        return np.asarray((self.cells + 0.5) * CELL_M, dtype=np.float64)


def see(
    known: ObstacleMap, points_robot: Array, pose_world_robot: Pose2, time_s: float, params: MapParams
) -> ObstacleMap:
    """Return the map after a scan's points (n, 2), taken at the believed pose."""
    met = np.unique(np.floor(pose_world_robot.transform(points_robot) / CELL_M).astype(np.int64), axis=0)
    cells, back = np.unique(np.concatenate([known.cells, met]), axis=0, return_inverse=True)
    back = back.ravel()
    hits, seen_s = np.zeros(len(cells), dtype=np.int64), np.full(len(cells), -np.inf)
    np.add.at(hits, back, np.concatenate([known.hits, np.ones(len(met), dtype=np.int64)]))
    np.maximum.at(seen_s, back, np.concatenate([known.seen_s, np.full(len(met), time_s)]))
    kept = (hits > params.hits_kept) | (seen_s >= time_s - params.forget_s)
    if kept.sum() > params.cells_max:
        newest = np.argsort(np.where(kept, seen_s, -np.inf), kind="stable")[-params.cells_max :]
        kept = np.zeros_like(kept)
        kept[newest] = True
    return ObstacleMap(cells=cells[kept], hits=hits[kept], seen_s=seen_s[kept])


def things(known: ObstacleMap, chosen: NDArray[np.bool_], params: MapParams) -> tuple[Thing, ...]:
    """Return the things that the chosen cells (n,) make up: cells nearer than `join_m` belong together.

    Things that were met too seldom are left out.
    """
    points, hits = known.points_world[chosen], known.hits[chosen]
    if not len(points):
        return ()
    count, label = connected_components(cdist(points, points) < params.join_m, directed=False)
    found = (Thing(points_world=points[label == k], hits=hits[label == k]) for k in range(count))
    return tuple(thing for thing in found if thing.hits.sum() >= params.hits_believed)


def cones_among(found: tuple[Thing, ...], params: MapParams) -> tuple[Thing, ...]:
    """Return the things that may be cones: as narrow, met often enough, and alone, as a chair's leg is not."""
    cones = []
    for thing in found:
        others = [other.points_world for other in found if other is not thing]
        alone = all(cdist([thing.middle_m], points).min() > params.cone_alone_m for points in others)
        if alone and thing.width_m <= params.cone_width_max_m and thing.hits.sum() >= params.cone_hits:
            cones.append(thing)
    return tuple(cones)
