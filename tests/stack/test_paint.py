import numpy as np
import pytest
from floor_pictures import PER_M, X0_M, Y1_M, look, painted_floor

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.paint import find_paint
from adc_bench.stack.prediction import arc_step
from adc_bench.world.course import Course

NEAR_M = 1.8  # beyond, a pixel covers more floor than a line is wide
PLACES_M = (-1.8, 3.0, 10.0, 17.0, 30.0)

LIGHTS = {
    "dark": {"floor_level": 6.0, "paint_level": 30.0, "noise": 2.0},
    "normal": {"floor_level": 40.0, "paint_level": 200.0},
    "bright": {"floor_level": 90.0, "paint_level": 250.0, "noise": 4.0},
    "half in shade": {"floor_level": 90.0, "paint_level": 220.0, "shade": 0.6},
    "vignetting": {"floor_level": 30.0, "paint_level": 150.0, "vignetting": 0.5},
}
# What is over-exposed blooms: a pixel that is paint in part is as white as one that is paint all over.
HARSH_LIGHTS = {
    "half in deep shade": {"floor_level": 90.0, "paint_level": 220.0, "shade": 0.9},
    "over-exposed": {"floor_level": 180.0, "paint_level": 600.0},
    "out of a tunnel": {"floor_level": 15.0, "paint_level": 75.0, "far_light": 12.0},
    "into a tunnel": {"floor_level": 50.0, "paint_level": 220.0, "far_light": 0.12},
}


def truly_paint(points_robot: np.ndarray, pose: Pose2) -> np.ndarray:
    x, y = pose.transform(points_robot).T
    rows, columns = ((Y1_M - y) * PER_M).astype(int), ((x - X0_M) * PER_M).astype(int)
    return painted_floor()[rows, columns] > 127


def agreement(birds_eye: BirdsEye, s_m: float, light: dict[str, float]) -> float:
    """Return the area of what is paint and found, over that of what is either, in the near part of a picture."""
    pose = Course().lap.pose(s_m)
    paint = find_paint(birds_eye, look(pose, mount=birds_eye.mount, **light))
    rows, columns = np.nonzero(birds_eye.seen)
    points = birds_eye.region.points(np.stack([columns, rows], axis=1))
    near = points[:, 0] < NEAR_M
    truth, found = truly_paint(points[near], pose), paint.mask[rows[near], columns[near]]
    return np.count_nonzero(truth & found) / np.count_nonzero(truth | found)


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
@pytest.mark.parametrize("s_m", PLACES_M)
def test_paint_is_found_at_any_light(birds_eye: BirdsEye, light: dict[str, float], s_m: float) -> None:
    assert agreement(birds_eye, s_m, light) > 0.65


@pytest.mark.parametrize("light", HARSH_LIGHTS.values(), ids=HARSH_LIGHTS)
@pytest.mark.parametrize("s_m", PLACES_M)
def test_paint_is_found_where_exposure_fails(birds_eye: BirdsEye, light: dict[str, float], s_m: float) -> None:
    assert agreement(birds_eye, s_m, light) > 0.55


@pytest.mark.parametrize("noise", [1.0, 5.0])
@pytest.mark.parametrize("level", [60.0, 215.0])
def test_bare_floor_has_next_to_no_paint(birds_eye: BirdsEye, level: float, noise: float) -> None:
    middle_of_an_island = Pose2(x_m=5.35, y_m=-0.6, yaw_rad=np.pi / 2)
    bare = look(middle_of_an_island, mount=birds_eye.mount, floor_level=level, paint_level=level, noise=noise)
    assert find_paint(birds_eye, bare).mask.mean() < 0.002


def test_motion_while_the_shutter_is_open_widens_the_marks_only_a_little(birds_eye: BirdsEye) -> None:
    moved = [arc_step(1.0 / 60 * part, 0.5 / 60 * part) for part in np.linspace(0, 1, 7)]
    pose = Course().lap.pose(10.0)
    still = find_paint(birds_eye, look(pose @ moved[3], mount=birds_eye.mount)).mask
    blurred = find_paint(birds_eye, look(pose, mount=birds_eye.mount, during=moved)).mask
    assert np.count_nonzero(still & blurred) / np.count_nonzero(still | blurred) > 0.8


@pytest.mark.parametrize("far_light", [0.1, 5.0, 13.0])
def test_the_lights_edge_is_no_mark(birds_eye: BirdsEye, far_light: float) -> None:
    middle_of_an_island = Pose2(x_m=5.35, y_m=-0.6, yaw_rad=np.pi / 2)
    level = min(60.0, 200.0 / far_light)
    bare = look(
        middle_of_an_island, mount=birds_eye.mount, floor_level=level, paint_level=level, far_light=far_light, far_m=0.9
    )
    assert find_paint(birds_eye, bare).mask.mean() < 0.002


def test_near_returns_the_points_of_a_square(birds_eye: BirdsEye) -> None:
    paint = find_paint(birds_eye, look(Course().lap.pose(3.0), mount=birds_eye.mount))
    rows, columns = np.nonzero(paint.mask)
    every = paint.region.points(np.stack([columns, rows], axis=1))
    for x_m, y_m, reach_m in ((1.2, -0.38, 0.1), (1.5, 0.3871, 0.123), (0.52, 0.0, 0.4), (2.9, 1.25, 0.3)):
        wanted = every[(np.abs(every - (x_m, y_m)) <= reach_m).all(axis=1)]
        np.testing.assert_array_equal(paint.near(x_m, y_m, reach_m), wanted)
    for x_m, y_m in ((9.0, 0.0), (-9.0, 0.0), (1.0, 9.0), (1.0, -9.0)):
        assert paint.near(x_m, y_m, 0.1).shape == (0, 2)
