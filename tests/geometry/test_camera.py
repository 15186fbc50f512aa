import math

import cv2
import numpy as np
import pytest

from adc_bench.errors import InputError
from adc_bench.geometry import Camera

LENSES = {"pinhole": (0.0, 0.0), "wide": (-0.12, 0.015), "PS3 Eye": (-0.276, 0.045), "pincushion": (0.08, 0.01)}
each_lens = pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES.keys())
Lens = tuple[float, float]


def camera_of(lens: Lens, hfov_deg: float = 70) -> Camera:
    return Camera.from_hfov(width_px=320, height_px=240, hfov_rad=math.radians(hfov_deg), k1=lens[0], k2=lens[1])


PLAIN = camera_of(LENSES["pinhole"])


@each_lens
def test_projection_agrees_with_opencv(lens: Lens) -> None:
    rng, camera = np.random.default_rng(0), camera_of(lens)
    points = np.column_stack([rng.uniform(-2, 2, (50, 2)), rng.uniform(0.3, 6, 50)])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix(), np.array([*lens, 0.0, 0.0]))
    assert np.allclose(camera.project(points), expected[:, 0])


@each_lens
@pytest.mark.parametrize("hfov_deg", [70, 90])
def test_rays_agree_with_opencv(lens: Lens, hfov_deg: float) -> None:
    camera = camera_of(lens, hfov_deg)
    pixels = np.random.default_rng(1).uniform(0, (320, 240), (200, 2))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 1000, 1e-12)
    plane = cv2.undistortPoints(pixels, camera.matrix(), np.array([*lens, 0.0, 0.0]), criteria=criteria)
    assert np.allclose(camera.rays(pixels)[:, :2], plane[:, 0], atol=1e-6)


@each_lens
def test_a_ray_through_a_pixel_projects_back_on_it(lens: Lens) -> None:
    camera, pixels = camera_of(lens), np.array([[0.0, 0.0], [160.5, 17.25], [160.0, 120.0], [320.0, 240.0]])
    assert np.allclose(camera.project(camera.rays(pixels) * 3.7), pixels)


def test_the_field_of_view_ends_at_the_picture_border() -> None:
    edge = [[math.tan(math.radians(35)), 0.0, 1.0]]
    assert np.allclose(PLAIN.project(edge), [[320.0, 120.0]])
    assert camera_of(LENSES["wide"]).project(edge)[0, 0] < 320.0


def test_points_behind_the_camera_have_no_pixel() -> None:
    assert np.isnan(PLAIN.project([[0.0, 0.0, -1.0]])).all()


@each_lens
@pytest.mark.parametrize("hfov_deg", [70, 90])
def test_the_covering_pinhole_sees_all_and_hardly_more(lens: Lens, hfov_deg: float) -> None:
    camera = camera_of(lens, hfov_deg)
    pinhole = camera.covering_pinhole()
    seen = pinhole.project(camera.rays(np.stack(np.meshgrid(range(321), range(241)), axis=-1).reshape(-1, 2)))
    size = np.array([pinhole.width_px, pinhole.height_px])
    assert (seen > -1e-6).all() and (seen < size + 1e-6).all()
    assert (seen.min(axis=0) < 1).all() and (seen.max(axis=0) > size - 1).all()
    assert pinhole.fx_px == camera.fx_px and pinhole.k1 == 0.0 == pinhole.k2


def test_a_camera_without_distortion_covers_itself() -> None:
    assert PLAIN.covering_pinhole() is PLAIN


def test_a_lens_that_folds_the_border_back_is_refused() -> None:
    with pytest.raises(InputError, match=r"k1 = -0\.4, k2 = 0\.0, which show one direction twice"):
        camera_of((-0.4, 0.0), hfov_deg=100).covering_pinhole()


def test_what_lies_beyond_the_fold_of_a_distortion_is_not_seen() -> None:
    camera = Camera.from_hfov(width_px=320, height_px=240, hfov_rad=math.radians(70), k1=-0.3)
    radius = math.sqrt(1 / 0.9)  # where r - 0.3 r^3 is largest
    inside, outside = camera.project([[radius - 0.01, 0.0, 1.0], [radius + 0.01, 0.0, 1.0]])
    assert np.isfinite(inside).all() and np.isnan(outside).all()
    published = Camera.from_hfov(width_px=320, height_px=240, hfov_rad=math.radians(70), k1=-0.276, k2=0.045)
    assert np.isfinite(published.project([[9.0, 0.0, 1.0]])).all()
