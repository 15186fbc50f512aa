import math

import numpy as np
import pytest
import shapely
from floor_pictures import LENSES, look, road_mount

from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.crosswalk import CrosswalkFinder, SeenCrosswalk
from adc_bench.stack.crosswalk_box import place_of_box
from adc_bench.stack.crosswalk_pattern import CrosswalkPattern
from adc_bench.stack.paint import find_paint
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.frame import BoxPx
from adc_bench.world.sensors import Lens

PATTERN = CrosswalkPattern(spec=CourseSpec())
EASTWARD = Pose2(x_m=0.0, y_m=-2.225, yaw_rad=0.0)
WESTWARD = Pose2(x_m=0.0, y_m=-2.225, yaw_rad=math.pi)
PICTURE = shapely.box(0, 0, 320, 240)


def box_of(birds_eye: BirdsEye, pose: Pose2, noise: np.ndarray | None = None) -> BoxPx:
    """Return the box around the visible part of the crosswalk, with noise, clipped to the picture."""
    ring = shapely.segmentize(shapely.Polygon(pose.inverse().transform(Course().crosswalk_corners)), 0.01)
    outline = shapely.Polygon(birds_eye.to_pixels(np.asarray(ring.exterior.coords)))
    box = np.array(outline.intersection(PICTURE).bounds) + (0 if noise is None else noise)
    x0, y0, x1, y1 = np.clip(box, 0, [320, 240, 320, 240])
    return float(x0), float(y0), float(x1), float(y1)


@pytest.fixture(scope="module")
def finder(birds_eye: BirdsEye) -> CrosswalkFinder:
    return CrosswalkFinder(spec=CourseSpec(), birds_eye=birds_eye)


def find(
    finder: CrosswalkFinder, pose: Pose2, road: Pose2, rng: np.random.Generator, **light: float
) -> SeenCrosswalk | None:
    eye = finder.birds_eye
    yaw_rad = wrap_rad(road.yaw_rad - pose.yaw_rad) + 0.02 * rng.standard_normal()
    box = box_of(eye, pose, 3.0 * rng.standard_normal(4))
    return finder.find(box, yaw_rad, find_paint(eye, look(pose, mount=eye.mount, **light)))


def near_corners(pose: Pose2, road: Pose2) -> np.ndarray:
    return pose.inverse().transform(road.transform(PATTERN.corners[:2]))


@pytest.mark.parametrize(
    ("s_m", "road"), [*((s, EASTWARD) for s in (-1.9, -1.6, -1.3, -1.0)), *((s, WESTWARD) for s in (19.7, 19.9, 20.1))]
)
def test_near_corners_to_a_centimetre_from_both_sides(finder: CrosswalkFinder, s_m: float, road: Pose2) -> None:
    rng = np.random.default_rng(round(s_m * 10) + 100)
    for _ in range(3):
        aside = Pose2(x_m=0.0, y_m=0.03 * rng.standard_normal(), yaw_rad=0.03 * rng.standard_normal())
        pose = Course().lap.pose(s_m) @ aside
        seen = find(finder, pose, road, rng)
        assert seen is not None
        np.testing.assert_allclose(seen.corners_robot, near_corners(pose, road), atol=0.012)


@pytest.mark.parametrize("light", [{"floor_level": 3.0, "paint_level": 14.0}, {"shade": 0.6, "noise": 4.0}])
def test_dark_and_half_shaded_pictures_serve(finder: CrosswalkFinder, light: dict[str, float]) -> None:
    pose = Course().lap.pose(-1.5)
    seen = find(finder, pose, EASTWARD, np.random.default_rng(2), **light)
    assert seen is not None
    np.testing.assert_allclose(seen.corners_robot, near_corners(pose, EASTWARD), atol=0.02)


def test_the_covariance_covers_an_unknown_tilt(finder: CrosswalkFinder) -> None:
    rng = np.random.default_rng(8)
    distances = []
    for _ in range(16):
        pose = Course().lap.pose(float(rng.uniform(-1.9, -1.0)))
        pitch, roll = np.radians(0.3) * rng.standard_normal(2)
        seen = find(finder, pose, EASTWARD, rng, pitch_error_rad=pitch, roll_error_rad=roll)
        assert seen is not None
        errors = seen.corners_robot - near_corners(pose, EASTWARD)
        distances += [e @ np.linalg.solve(c, e) for e, c in zip(errors, seen.covariances, strict=True)]
    assert 0.3 < np.mean(distances) < 3.0


def test_a_box_a_stripe_aside_or_over_bare_floor_finds_nothing_wrong(finder: CrosswalkFinder) -> None:
    eye = finder.birds_eye
    pose = Course().lap.pose(-1.6)
    paint = find_paint(eye, look(pose, mount=eye.mount))
    wrong = Course().lap.pose(-1.6) @ Pose2(x_m=0.0, y_m=0.2, yaw_rad=0.0)
    seen = finder.find(box_of(eye, wrong), wrap_rad(-pose.yaw_rad), paint)
    assert seen is None or np.abs(seen.corners_robot - near_corners(pose, EASTWARD)).max() < 0.02
    bare = find_paint(eye, look(Course().lap.pose(30.0), mount=eye.mount))
    assert finder.find(box_of(eye, pose), 0.0, bare) is None


def test_a_box_cut_off_at_the_near_side_has_no_place(birds_eye: BirdsEye) -> None:
    start = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
    assert place_of_box(box_of(birds_eye, start), 0.0, PATTERN, birds_eye) is None


@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
@pytest.mark.parametrize("s_m", [-2.2, -1.6, -1.0])
def test_the_place_of_an_exact_box_is_exact_though_cut_off_at_one_end(lens: Lens, s_m: float) -> None:
    birds_eye = BirdsEye(mount=road_mount(lens))
    pose = Course().lap.pose(s_m)
    truth = pose.inverse() @ EASTWARD
    box = box_of(birds_eye, pose)
    assert box[0] == 0.0
    place = place_of_box(box, truth.yaw_rad, PATTERN, birds_eye)
    assert place is not None
    assert (place.x_m, place.y_m) == pytest.approx((truth.x_m, truth.y_m), abs=0.003)


def test_the_outline_runs_round_the_pattern_in_short_steps() -> None:
    outline = shapely.Polygon(PATTERN.outline(0.1))
    corners = shapely.MultiPoint(PATTERN.corners)
    assert outline.equals(corners.convex_hull)
    assert outline.exterior.is_ccw
    assert shapely.length(shapely.linestrings(PATTERN.outline(0.1)[:2])) <= 0.1 + 1e-12
    assert set(map(tuple, PATTERN.corners)) <= set(map(tuple, PATTERN.outline(0.07)))


def test_the_pattern_is_the_courses_paint() -> None:
    paint = shapely.union_all(Course().paint)
    inner = shapely.box(-0.35, -2.9, 0.35, -1.55)
    marks = shapely.union_all([shapely.box(x0, y0 - 2.225, x1, y1 - 2.225) for x0, y0, x1, y1 in PATTERN.marks])
    assert paint.intersection(inner).symmetric_difference(marks).area < 1e-9


def test_blurring_keeps_the_paint() -> None:
    step = 0.01
    grid = PATTERN.grid(step, 0.1)
    area = PATTERN.blurred(grid, 0.05).sum() * step**2
    assert area == pytest.approx(2 * 1.35 * 0.10 + 7 * 0.35 * 0.10, rel=0.01)
    assert PATTERN.blurred(np.array([[0.0, 0.0], [-0.30, 0.3], [0.0, 0.1]]), 0.05) == pytest.approx([1, 1, 0])
