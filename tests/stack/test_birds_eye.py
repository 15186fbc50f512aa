import numpy as np
import pytest
from floor_pictures import look, road_mount
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye, FloorRegion

BIRDS_EYE = BirdsEye(mount=road_mount())
POINTS = np.array([[0.7, -0.3], [1.0, 0.2], [2.0, 1.1], [2.9, -1.2]])


def test_pixels_agree_with_the_camera_looking_at_points_in_space() -> None:
    pose = road_mount().pose_robot_camera()
    in_camera = pose.inverse().transform(np.column_stack([POINTS, np.zeros(len(POINTS))]))
    np.testing.assert_allclose(BIRDS_EYE.to_pixels(POINTS), road_mount().camera().project(in_camera), atol=1e-9)


@given(st.floats(0.6, 3.0), st.floats(-1.3, 1.3))
def test_floor_and_pixels_are_inverse(x_m: float, y_m: float) -> None:
    there_and_back = BIRDS_EYE.to_floor(BIRDS_EYE.to_pixels([(x_m, y_m)]))
    np.testing.assert_allclose(there_and_back, [(x_m, y_m)], atol=1e-9)


def test_no_floor_above_the_horizon_and_no_pixel_behind_the_camera() -> None:
    assert np.isnan(BIRDS_EYE.to_floor([(160.0, -20.0)])).all()
    assert np.isnan(BIRDS_EYE.to_pixels([(-2.0, 0.0)])).all()


def test_cells_and_points_are_inverse() -> None:
    region = FloorRegion()
    np.testing.assert_allclose(region.points(region.cells(POINTS)), POINTS, atol=1e-12)
    np.testing.assert_allclose(region.points([(0, 0)]), [(2.995, 1.295)])


def test_the_seen_floor_is_what_projects_into_the_picture() -> None:
    rows, columns = BIRDS_EYE.region.shape
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    pixels = BIRDS_EYE.to_pixels(BIRDS_EYE.region.points(np.stack([column.ravel(), row.ravel()], axis=1)))
    u, v = pixels.T
    clear = (u > 1) & (u < 319) & (v > 1) & (v < 239)
    outside = (u < -1) | (u > 321) | (v < -1) | (v > 241)
    assert BIRDS_EYE.seen.ravel()[clear].all()
    assert not BIRDS_EYE.seen.ravel()[outside].any()


def test_a_line_lies_in_the_floor_picture_where_it_lies_on_the_floor() -> None:
    pose = Pose2(x_m=-4.0, y_m=-2.6125, yaw_rad=0.0)  # the solid right line runs 0.3875 m to the right
    grey = BIRDS_EYE.grey(look(pose, noise=0.0)).astype(float)
    row = round(BIRDS_EYE.region.cells([(1.2, 0.0)])[0, 1])
    columns = np.arange(grey.shape[1])
    near_line = (
        np.abs(BIRDS_EYE.region.points(np.stack([columns, np.full(len(columns), row)], axis=1))[:, 1] + 0.4) < 0.1
    )
    weight = (grey[row] - 40) * near_line
    middle = BIRDS_EYE.region.points([(float(weight @ columns / weight.sum()), row)])[0, 1]
    assert middle == pytest.approx(-0.3875, abs=0.003)


def test_the_tilt_jacobian_is_what_a_tilted_camera_does() -> None:
    tilt = 0.004
    for k, errors in enumerate([(tilt, 0.0), (0.0, tilt)]):
        pose = road_mount().pose_robot_camera(*errors)
        in_camera = pose.inverse().transform(np.column_stack([POINTS, np.zeros(len(POINTS))]))
        moved = BIRDS_EYE.to_floor(road_mount().camera().project(in_camera)) - POINTS
        np.testing.assert_allclose(BIRDS_EYE.tilt_jacobian(POINTS)[:, :, k] * tilt, moved, atol=0.003)
