import numpy as np
import pytest
from floor_pictures import PER_M, X0_M, Y1_M, look, painted_floor

from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.paint import find_paint
from adc_bench.world.course import Course

NEAR_M = 1.8  # beyond, a pixel covers more floor than a line is wide

LIGHTS = {
    "dark": {"floor_level": 6.0, "paint_level": 30.0, "noise": 2.0},
    "normal": {"floor_level": 40.0, "paint_level": 200.0},
    "bright": {"floor_level": 90.0, "paint_level": 250.0, "noise": 4.0},
    "half in shade": {"floor_level": 90.0, "paint_level": 220.0, "shade": 0.6},
}


def truly_paint(points_robot: np.ndarray, pose: Pose2) -> np.ndarray:
    x, y = pose.transform(points_robot).T
    rows, columns = ((Y1_M - y) * PER_M).astype(int), ((x - X0_M) * PER_M).astype(int)
    return painted_floor()[rows, columns] > 127


@pytest.mark.parametrize("light", LIGHTS.values(), ids=LIGHTS)
@pytest.mark.parametrize("s_m", [-1.8, 3.0, 10.0, 17.0, 30.0])
def test_paint_is_found_at_any_light(birds_eye: BirdsEye, light: dict[str, float], s_m: float) -> None:
    pose = Course().lap.pose(s_m)
    paint = find_paint(birds_eye, look(pose, mount=birds_eye.mount, **light))
    rows, columns = np.nonzero(birds_eye.seen)
    points = birds_eye.region.points(np.stack([columns, rows], axis=1))
    near = points[:, 0] < NEAR_M
    truth, found = truly_paint(points[near], pose), paint.mask[rows[near], columns[near]]
    assert np.count_nonzero(truth & found) / np.count_nonzero(truth | found) > 0.65


@pytest.mark.parametrize("noise", [1.0, 5.0])
def test_bare_floor_has_next_to_no_paint(birds_eye: BirdsEye, noise: float) -> None:
    middle_of_an_island = Pose2(x_m=5.35, y_m=-0.6, yaw_rad=np.pi / 2)
    bare = look(middle_of_an_island, mount=birds_eye.mount, floor_level=60.0, paint_level=60.0, noise=noise)
    assert find_paint(birds_eye, bare).mask.mean() < 0.002


def test_near_returns_the_points_of_a_band(birds_eye: BirdsEye) -> None:
    paint = find_paint(birds_eye, look(Course().lap.pose(3.0), mount=birds_eye.mount))
    band = paint.near(1.2, 0.1)
    x = paint.points_robot[:, 0]
    wanted = paint.points_robot[np.abs(x - 1.2) <= 0.1]
    assert len(wanted) <= len(band) <= np.count_nonzero(np.abs(x - 1.2) <= 0.12)
    assert {tuple(p) for p in wanted} <= {tuple(p) for p in band}
    assert len(paint.near(9.0, 0.1)) == 0
