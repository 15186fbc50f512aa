"""An eye of its own for the tests: rays through the pixels' centres against the scenario's solids, no rasteriser."""

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]
FLOOR, CEILING = "floor", "ceiling"


def rays_through_pixels(camera: Camera) -> Array:
    """Return OpenCV's directions (h, w, 3), z = 1, through all pixels' centres."""
    v, u = np.mgrid[: camera.height_px, : camera.width_px] + 0.5
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    pixels, exact = np.column_stack([u.ravel(), v.ravel()])[:, None], (cv2.TERM_CRITERIA_COUNT, 60, 0.0)
    flat = cv2.undistortImagePoints(pixels, camera.matrix(), lens, arg1=exact).reshape(*u.shape, 2)
    return np.dstack([(flat - (camera.cx_px, camera.cy_px)) / camera.fx_px, np.ones(u.shape)])


def seen(scenario: Scenario, camera: Camera, pose_world_camera: Pose3) -> tuple[Array, NDArray[np.str_]]:
    """Return how far along the camera's axis each ray goes (h, w), and what it meets (h, w): a box's name and face.

    Boxes, floor and ceiling only: no round things, no tapes, no signs.
    """
    rays = rays_through_pixels(camera) @ pose_world_camera.rotation.T
    eye = pose_world_camera.translation_m
    depth, name = np.full(rays.shape[:2], np.inf), np.full(rays.shape[:2], "", "U40")
    for what, z in ((FLOOR, 0.0), (CEILING, scenario.arena_spec.hall_height_m)):
        _keep(depth, name, np.where(rays[..., 2] * (z - eye[2]) > 0, (z - eye[2]) / rays[..., 2], np.inf), what)
    for solid, pose in _boxes(scenario):
        to_solid = pose.inverse()
        way = rays @ to_solid.rotation.T + 1e-12
        start, half = to_solid.transform(eye[None])[0], np.array(solid.size_m) / 2
        ends = np.stack([(-half - start) / way, (half - start) / way])
        enter, leave = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
        met = np.where((enter < leave) & (enter > 0), enter, np.inf)
        for axis, face in enumerate("xyz"):
            of_face = ends.min(axis=0).argmax(axis=-1) == axis
            _keep(depth, name, np.where(of_face, met, np.inf), f"{solid.name}/{face}")
    return depth, name


def _keep(depth: Array, name: NDArray[np.str_], found: Array, what: str) -> None:
    nearer = found < depth
    depth[nearer], name[nearer] = found[nearer], what


def _boxes(scenario: Scenario) -> Iterable[tuple[Solid, Pose3]]:
    for solid in scenario.solids:
        yield solid, solid.pose_world_solid()
    for body in scenario.bodies:
        for part in body.parts:
            yield part, body.pose.to_pose3() @ part.pose_world_solid()
