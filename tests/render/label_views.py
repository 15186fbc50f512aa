"""Cameras that look at labelled objects, and what they should see: by OpenCV, by rays, by polygons."""

import cv2
import numpy as np
from numpy.typing import NDArray
from rays import rays_through_pixels

from adc_bench.geometry import Camera, Pose3, rotation_zyx
from adc_bench.render.targets import Target
from adc_bench.world.frame import Label
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount

Array = NDArray[np.float64]


LENSES = [(0.0, 0.0), (-0.12, 0.015), (-0.276, 0.045)]


LAYOUT = Layout(
    boxes=(BoxPlace(x_m=2.0, y_m=-2.2), BoxPlace(x_m=3.0, y_m=-3.0, yaw_rad=0.4)),
    works=Works(left=((8.5, 3.5), (9.3, 2.5)), right=((7.7, 3.0), (8.5, 2.1))),
)


def road_mount(scenario: Scenario) -> CameraMount:
    return scenario.rig.camera("road")


def camera_of(k1: float = 0.0, k2: float = 0.0, width_px: int = 320, height_px: int = 240) -> Camera:
    return Camera.from_hfov(width_px=width_px, height_px=height_px, hfov_rad=np.radians(70), k1=k1, k2=k2)


def pose_towards(target: Target, offset_object: Array, roll_rad: float = 0.0) -> Pose3:
    """Return a camera at a point of the target's frame that looks at its origin."""
    (eye,) = target.pose_world_object.transform(offset_object[None])
    ahead = target.pose_world_object.translation_m - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    upright = np.column_stack([right, np.cross(ahead, right), ahead])
    rolled = upright @ rotation_zyx(roll_rad, 0.0, 0.0)
    return Pose3(rotation=rolled, translation_m=eye)


def by_opencv(points_world: Array, camera: Camera, pose_world_camera: Pose3) -> Array:
    """Return pixels (n, 2), the first pixel's middle at one half as everywhere here."""
    inverse = pose_world_camera.inverse()
    turn, _ = cv2.Rodrigues(inverse.rotation)
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    pixels, _ = cv2.projectPoints(points_world, turn, inverse.translation_m, camera.matrix(), lens)
    return np.asarray(pixels.reshape(-1, 2), np.float64)


def edge_points(target: Target) -> Array:
    """Return points (n, 3) in the world on all lines between two corners of a piece: its edges are among them."""
    share = np.linspace(0.0, 1.0, 8 if len(target.faces[0]) > 20 else 60)[:, None, None, None]
    lines = [(face[:, None] * share + face[None] * (1 - share)).reshape(-1, 3) for face in target.faces]
    return target.pose_world_object.transform(np.concatenate(lines))


def ray_cast(target: Target, low: Array, high: Array, camera: Camera, pose: Pose3) -> NDArray[np.uint8]:
    """Return the label picture of an upright box (in the target's frame) alone, by slabs."""
    inside = target.pose_world_object.inverse() @ pose
    way = rays_through_pixels(camera) @ inside.rotation.T + 1e-12
    near, far = (low - inside.translation_m) / way, (high - inside.translation_m) / way
    enter, leave = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
    return np.where((enter < leave) & (leave > 0), target.label_id, 0).astype(np.uint8)


def only(labels: tuple[Label, ...]) -> Label:
    (label,) = labels
    return label


def corners_of(target: Target, scenario: Scenario) -> Array:
    """Return the four corners (4, 3) in the world, put together from what the world says of the object."""
    if target.instance == "crosswalk":
        return np.column_stack([scenario.course.crosswalk_corners, np.zeros(4)])
    solid = next(solid for solid in scenario.solids if solid.name == target.instance)
    clockwise = np.array([[1, -1, 1], [1, 1, 1], [1, 1, -1], [1, -1, -1]])  # who sees +x has +y on the right
    return solid.pose_world_solid().transform(clockwise * solid.size_m / 2)


def filled(points_px: Array, label_id: int, size_px: tuple[int, int] = (320, 240)) -> NDArray[np.uint8]:
    """Return the label picture of a polygon (n, 2) alone."""
    ids = np.zeros((size_px[1], size_px[0]), np.uint8)
    cv2.fillPoly(ids, [np.round((points_px - 0.5) * 256).astype(np.int32)], label_id, shift=8)
    return ids


def ring(target: Target) -> Array:
    """Return points (n, 3) in the world around a flat target."""
    face = target.faces[0]
    share = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in zip(face, np.roll(face, -1, axis=0), strict=True)]
    return target.pose_world_object.transform(np.concatenate(sides))


FLAT = ["crosswalk", "panel_facing_west", "panel_facing_east", *(f"sign_{k}" for k in range(12))]
