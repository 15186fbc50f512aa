import cv2
import numpy as np
import pytest
from floor_pictures import LENSES, look, road_mount
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye, FloorRegion
from adc_bench.world.sensors import CameraMount

EYES = {name: BirdsEye(mount=road_mount(lens)) for name, lens in LENSES.items()}
any_lens = pytest.mark.parametrize("eye", EYES.values(), ids=EYES)
POINTS = np.array([[0.7, -0.3], [1.0, 0.2], [2.0, 1.1], [2.9, -1.2], [0.5, -1.3]])
NEWTON = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-12)


def opencv_pixels(mount: CameraMount, points_robot: np.ndarray, *tilt: float) -> np.ndarray:
    camera, pose = mount.camera(), mount.pose_robot_camera(*tilt).inverse()
    points = np.column_stack([points_robot, np.zeros(len(points_robot))])
    turn, _ = cv2.Rodrigues(pose.rotation)
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    pixels, _ = cv2.projectPoints(points, turn, pose.translation_m, camera.matrix(), lens)
    return np.asarray(pixels).reshape(-1, 2)


def opencv_floor(mount: CameraMount, pixels_px: np.ndarray) -> np.ndarray:
    camera, pose = mount.camera(), mount.pose_robot_camera()
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    plane = cv2.undistortPoints(pixels_px[:, None], camera.matrix(), lens, criteria=NEWTON)
    rays = np.column_stack([np.asarray(plane).reshape(-1, 2), np.ones(len(pixels_px))]) @ pose.rotation.T
    return np.asarray(pose.translation_m[:2] - rays[:, :2] * (pose.translation_m[2] / rays[:, 2:]))


@any_lens
def test_pixels_are_opencvs(eye: BirdsEye) -> None:
    np.testing.assert_allclose(eye.to_pixels(POINTS), opencv_pixels(eye.mount, POINTS), atol=1e-9)


@any_lens
def test_the_floor_under_a_pixel_is_opencvs(eye: BirdsEye) -> None:
    u, v = np.meshgrid(np.linspace(0, 320, 9), np.linspace(60, 240, 7))
    pixels = np.stack([u.ravel(), v.ravel()], axis=1)
    np.testing.assert_allclose(eye.to_floor(pixels), opencv_floor(eye.mount, pixels), atol=1e-6)


@any_lens
@given(st.floats(0.6, 3.0), st.floats(-1.3, 1.3))
def test_floor_and_pixels_are_inverse(eye: BirdsEye, x_m: float, y_m: float) -> None:
    np.testing.assert_allclose(eye.to_floor(eye.to_pixels([(x_m, y_m)])), [(x_m, y_m)], atol=1e-9)


@any_lens
@given(st.floats(0, 320), st.floats(60, 240))
def test_pixels_and_floor_are_inverse(eye: BirdsEye, u_px: float, v_px: float) -> None:
    np.testing.assert_allclose(eye.to_pixels(eye.to_floor([(u_px, v_px)])), [(u_px, v_px)], atol=1e-6)


@any_lens
def test_no_floor_above_the_horizon_and_no_pixel_behind_the_camera(eye: BirdsEye) -> None:
    assert np.isnan(eye.to_floor([(160.0, -20.0)])).all()
    assert np.isnan(eye.to_pixels([(-2.0, 0.0)])).all()


def test_a_lens_shows_more_floor() -> None:
    seen = [np.count_nonzero(EYES[name].seen) for name in LENSES]
    assert seen[0] < seen[1] < seen[2]


def test_cells_and_points_are_inverse() -> None:
    region = FloorRegion()
    np.testing.assert_allclose(region.points(region.cells(POINTS)), POINTS, atol=1e-12)
    np.testing.assert_allclose(region.points([(0, 0)]), [(2.995, 1.295)])


def cell_pixels(eye: BirdsEye) -> np.ndarray:
    rows, columns = eye.region.shape
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    return opencv_pixels(eye.mount, eye.region.points(np.stack([column.ravel(), row.ravel()], axis=1)))


@any_lens
def test_the_seen_floor_is_what_projects_into_the_picture(eye: BirdsEye) -> None:
    u, v = cell_pixels(eye).T
    inside = (u > 0) & (u < 320) & (v > 0) & (v < 240)
    np.testing.assert_array_equal(eye.seen.ravel(), inside)


@any_lens
def test_every_cell_shows_its_pixel(eye: BirdsEye) -> None:
    """In a picture whose brightness grows evenly along an axis, a cell's brightness tells where it looks."""
    v, u = np.indices((240, 320)) + 0.5
    for ramp, pixels in zip((u / 320, v / 240), cell_pixels(eye).T / [[320], [240]], strict=True):
        rgb = np.repeat(np.round(ramp * 255).astype(np.uint8)[:, :, None], 3, axis=2)
        error = np.abs(eye.grey(rgb) - pixels.reshape(eye.region.shape) * 255)
        assert error[eye.seen].max() < 1.7


def test_a_cell_behind_the_camera_is_not_seen() -> None:
    around = BirdsEye(mount=road_mount(), region=FloorRegion(x_near_m=-1.0, x_far_m=1.0, cell_m=0.1))
    assert not around.seen[-10:].any()
    assert around.seen[:4].any()
    assert around.grey(np.full((240, 320, 3), 77, dtype=np.uint8)).shape == around.region.shape


@any_lens
def test_a_line_lies_in_the_floor_picture_where_it_lies_on_the_floor(eye: BirdsEye) -> None:
    pose = Pose2(x_m=-4.0, y_m=-2.6125, yaw_rad=0.0)  # the solid right line runs 0.3875 m to the right
    grey = eye.grey(look(pose, mount=eye.mount, noise=0.0)).astype(float)
    for x_m in (0.7, 1.2, 1.7):
        row = round(eye.region.cells([(x_m, 0.0)])[0, 1])
        columns = np.arange(grey.shape[1])
        y = eye.region.points(np.stack([columns, np.full(len(columns), row)], axis=1))[:, 1]
        weight = (grey[row] - 40) * (np.abs(y + 0.4) < 0.1)
        middle = eye.region.points([(float(weight @ columns / weight.sum()), row)])[0, 1]
        assert middle == pytest.approx(-0.3875, abs=0.003)


@any_lens
def test_the_tilt_jacobian_is_what_a_tilted_camera_does(eye: BirdsEye) -> None:
    tilt = 1e-5
    for k, errors in enumerate([(tilt, 0.0), (0.0, tilt)]):
        ahead = opencv_floor(eye.mount, opencv_pixels(eye.mount, POINTS, *errors))
        behind = opencv_floor(eye.mount, opencv_pixels(eye.mount, POINTS, *(-error for error in errors)))
        np.testing.assert_allclose(
            eye.tilt_jacobian(POINTS)[:, :, k], (ahead - behind) / (2 * tilt), rtol=1e-3, atol=1e-3
        )
