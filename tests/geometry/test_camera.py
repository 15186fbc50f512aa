import math

import cv2
import numpy as np

from adc_bench.geometry import Camera

CAMERA = Camera.from_hfov(width_px=320, height_px=240, hfov_rad=math.radians(70))


def test_projection_agrees_with_opencv() -> None:
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-2, 2, (50, 2)), rng.uniform(0.3, 6, 50)])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), CAMERA.matrix(), np.zeros(4))
    assert np.allclose(CAMERA.project(points), expected[:, 0])


def test_a_ray_through_a_pixel_projects_back_on_it() -> None:
    pixels = np.array([[0.0, 0.0], [160.5, 17.25], [320.0, 240.0]])
    assert np.allclose(CAMERA.project(CAMERA.rays(pixels) * 3.7), pixels)


def test_the_field_of_view_ends_at_the_picture_border() -> None:
    edge = [[math.tan(math.radians(35)), 0.0, 1.0]]
    assert np.allclose(CAMERA.project(edge), [[320.0, 120.0]])


def test_points_behind_the_camera_have_no_pixel() -> None:
    assert np.isnan(CAMERA.project([[0.0, 0.0, -1.0]])).all()
