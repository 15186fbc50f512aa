"""Shapes of a scenario and their pictures, by OpenCV's camera model and nothing of the renderer's."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount
from adc_bench.world.signs import BOARD_M, board_outline
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
NEAR_M = 0.05
EDGE_POINTS = 24
FAR = 4.0  # half pictures from the axis, beyond which an outline is cut
CIRCLE = np.stack([np.cos(np.arange(64) * np.pi / 32), np.sin(np.arange(64) * np.pi / 32)], axis=1) / 2
SQUARE = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)])  # from the top left clockwise, x right, y up


@dataclass(frozen=True, kw_only=True, eq=False)
class Shape:
    """A labelled thing in its own frame: convex pieces as corners (n, 3), keypoints (4, 3) or none, and its place."""

    pose_world: Pose3
    pieces: tuple[Array, ...]
    keypoints: Array | None


def shapes_of(scenario: Scenario) -> Mapping[str, Shape]:
    """Return the shapes of all that may be labelled, by the names of instances, where the scenario puts them."""
    shapes = {"crosswalk": _crosswalk(scenario)}
    signs = {sign.name: board_outline(sign) for sign in scenario.signs}
    for solid in scenario.solids:
        if solid.kind == "panel":
            screen = SQUARE * solid.size_m[1:]
            shapes[solid.name] = _board(solid, screen, screen)
        elif solid.name in signs:
            shapes[solid.name] = _board(solid, signs[solid.name], SQUARE * BOARD_M)
    for body in scenario.bodies:
        if body.category:
            pieces = tuple(_corners(part) for part in body.parts)
            shapes[body.name] = Shape(pose_world=body.pose.to_pose3(), pieces=pieces, keypoints=None)
    return shapes


def _crosswalk(scenario: Scenario) -> Shape:
    corners = scenario.course.crosswalk_corners
    x_m, y_m = corners.mean(axis=0).tolist()
    own = np.column_stack([corners - (x_m, y_m), np.zeros(4)])
    return Shape(pose_world=Pose2(x_m=x_m, y_m=y_m, yaw_rad=0.0).to_pose3(), pieces=(own,), keypoints=own)


def _board(solid: Solid, outline: Array, corners: Array) -> Shape:
    front = solid.size_m[0] / 2
    on_front = [np.column_stack([np.full(len(flat), front), flat]) for flat in (outline, corners)]
    return Shape(pose_world=solid.pose_world_solid(), pieces=(on_front[0],), keypoints=on_front[1])


def _corners(part: Solid) -> Array:
    base = SQUARE if part.shape == "box" else CIRCLE
    top = np.zeros((1, 2)) if part.shape == "cone" else base
    unit = np.concatenate([np.insert(base, 2, -0.5, axis=1), np.insert(top, 2, 0.5, axis=1)])
    return part.pose_world_solid().transform(unit * part.size_m)


class View:
    """One camera at one place: projects points of the world into the delivered picture."""

    def __init__(self, mount: CameraMount, pose_world_camera: Array) -> None:
        focal_px = mount.width_px / 2 / np.tan(mount.hfov_rad / 2)
        self.size_px = np.array([mount.width_px, mount.height_px], dtype=np.float64)
        self._matrix = np.array([[focal_px, 0, self.size_px[0] / 2], [0, focal_px, self.size_px[1] / 2], [0, 0, 1]])
        self._far = FAR * self.size_px / 2 / focal_px
        self._lens = np.array([mount.lens.k1, mount.lens.k2, 0.0, 0.0])
        self._rotation = np.ascontiguousarray(pose_world_camera[:3, :3].T)
        self._turn, _ = cv2.Rodrigues(self._rotation)
        self._shift = -self._rotation @ pose_world_camera[:3, 3]

    def depth_m(self, points_world: Array) -> Array:
        """Return how far (n,) the points (n, 3) lie before the camera."""
        depth: Array = points_world @ self._rotation[2] + self._shift[2]
        return depth

    def project(self, points_world: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 3) before the camera."""
        pixels, _ = cv2.projectPoints(points_world, self._turn, self._shift, self._matrix, self._lens)
        return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)

    def outline(self, pieces_world: list[Array]) -> shapely.Geometry | None:
        """Return the picture of an object's convex pieces, cut only far outside the picture.

        None where it is not all before the camera, or reaches so far aside that the lens model does not hold.
        """
        corners = np.concatenate(pieces_world)
        if self.depth_m(corners).min() < NEAR_M or not self._is_within_lens(corners):
            return None
        return shapely.union_all([self._hull(piece) for piece in pieces_world])

    def _hull(self, piece_world: Array) -> shapely.Geometry:
        """Take the hull where lines are straight (without the lens), cut what lies far out, then bend its edges."""
        seen = piece_world @ self._rotation.T + self._shift
        hull = shapely.convex_hull(shapely.multipoints(seen[:, :2] / seen[:, 2:]))
        hull = shapely.intersection(hull, shapely.box(*-self._far, *self._far))
        step = min(np.sqrt(hull.area) / EDGE_POINTS + 1e-3, self._far.min() / FAR / EDGE_POINTS)
        ring = shapely.get_coordinates(shapely.segmentize(hull, step))
        if not len(ring):
            return hull
        rays = np.column_stack([ring, np.ones(len(ring))])
        pixels, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), self._matrix, self._lens)
        return shapely.Polygon(pixels.reshape(-1, 2)).buffer(0)

    def _is_within_lens(self, points_world: Array) -> bool:
        """Return whether pictures of points move outwards as the points do, up to the farthest of these."""
        seen = points_world @ self._rotation.T + self._shift
        square = np.linspace(0.0, float(((seen[:, :2] / seen[:, 2:]) ** 2).sum(axis=1).max()), 64)
        k1, k2 = self._lens[:2]
        return bool((1 + 3 * k1 * square + 5 * k2 * square**2 > 0).all())
