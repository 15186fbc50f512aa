import math

import numpy as np
import pytest

from adc_bench.geometry import Path, Pose2
from adc_bench.geometry.path import arc, line
from adc_bench.stack.reference_line import ROUNDING_M, STEP_M, line_through, rounded
from adc_bench.world.course import COURSE_SETS, Course

LAP = Course().lap
ORIGIN = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
S_BEND = Path(start=ORIGIN, pieces=(line(2.0), arc(1.8, math.pi / 2), arc(2.6, -math.pi / 2), line(2.0)))


def offsets_m(path: Path, from_m: float, to_m: float) -> np.ndarray:
    road = rounded(path, from_m, to_m)
    there = zip(road.x_m, road.y_m, road.path_s_m, strict=True)
    return np.array([path.project([(x, y)], around_s_m=s)[1][0] for x, y, s in there])


@pytest.mark.parametrize("course", sorted(COURSE_SETS))
def test_the_rounded_lap_stays_within_6_mm_of_the_lane(course: str) -> None:
    lap = Course(spec=COURSE_SETS[course]).lap
    assert np.abs(offsets_m(lap, 0.0, lap.length_m)).max() < 0.006


def test_long_arcs_and_straights_stay_where_they_are() -> None:
    road, away = rounded(LAP, 0.0, LAP.length_m), offsets_m(LAP, 0.0, LAP.length_m)
    from_knots = np.abs(road.path_s_m[:, None] - LAP.knots_m).min(axis=1)
    far = from_knots > 8 * ROUNDING_M
    assert far.mean() > 0.2
    assert np.abs(away[far]).max() < 3e-4
    np.testing.assert_allclose(road.curvature_pm[far], LAP.curvature_pm(road.path_s_m[far]), atol=6e-3)


@pytest.mark.parametrize("rounding_m", [0.1, 0.15, 0.2])
def test_a_jump_of_curvature_becomes_a_slope_of_a_third_of_it_over_the_rounding(rounding_m: float) -> None:
    road = rounded(S_BEND, 0.0, S_BEND.length_m, rounding_m)
    jump = 1 / 1.8 + 1 / 2.6
    assert np.abs(np.gradient(road.curvature_pm, road.s_m)).max() == pytest.approx(jump / (3 * rounding_m), rel=0.08)


def test_no_other_line_is_cheaper_by_brute_force() -> None:
    road = rounded(S_BEND, 0.0, S_BEND.length_m, 0.2)
    step_m, count = road.path_s_m[1], len(road.s_m)
    poses = S_BEND.poses(road.path_s_m)
    bends = line_through(poses[:, :2], road.path_s_m).curvature_pm
    third = np.diff(np.eye(count + 6), n=3, axis=0)[:, 3:-3] / step_m**3
    slopes = np.concatenate([[0.0, 0.0], np.diff(bends) / step_m, [0.0, 0.0]])
    problem = np.concatenate([0.2**3 * third, np.eye(count)])
    wanted, *_ = np.linalg.lstsq(problem, np.concatenate([-(0.2**3) * slopes, np.zeros(count)]))
    away = np.array([road.x_m, road.y_m]).T - poses[:, :2]
    found = np.cos(poses[:, 2]) * away[:, 1] - np.sin(poses[:, 2]) * away[:, 0]
    np.testing.assert_allclose(found, wanted, atol=1e-7)


def test_yaw_is_the_direction_and_curvature_its_rate() -> None:
    road = rounded(LAP, -0.65, LAP.length_m + 2.0)
    assert np.hypot(np.diff(road.x_m), np.diff(road.y_m)) == pytest.approx(np.diff(road.s_m))
    middles = (road.yaw_rad[1:] + road.yaw_rad[:-1]) / 2
    chords = np.unwrap(np.arctan2(np.diff(road.y_m), np.diff(road.x_m)))
    np.testing.assert_allclose(middles, chords, atol=1e-3)
    turned = np.concatenate(
        [[0.0], np.cumsum(np.diff(road.s_m) * (road.curvature_pm[1:] + road.curvature_pm[:-1]) / 2)]
    )
    np.testing.assert_allclose(road.yaw_rad - road.yaw_rad[0], turned, atol=1e-3)


def test_its_ends_are_the_paths() -> None:
    road = rounded(S_BEND, 0.0, S_BEND.length_m)
    for s_m, end in ((0.0, ORIGIN), (road.length_m, S_BEND.pose(S_BEND.length_m))):
        found = road.pose(s_m)
        assert (found.x_m, found.y_m, found.yaw_rad) == pytest.approx((end.x_m, end.y_m, end.yaw_rad), abs=1e-4)
    assert road.length_m == pytest.approx(S_BEND.length_m, abs=0.02)
    assert np.diff(road.s_m).max() < 1.02 * STEP_M


def test_a_pose_is_found_again_on_its_branch() -> None:
    road = rounded(LAP, 0.0, 2 * LAP.length_m)
    for s_m in np.linspace(0.3, road.length_m - 0.3, 97):
        beside = road.pose(float(s_m)) @ Pose2(x_m=0.0, y_m=0.1, yaw_rad=0.4)
        assert road.project(beside, around_s_m=float(s_m) - 0.2) == pytest.approx(s_m, abs=1e-3)
    assert road.project(road.pose(0.0) @ Pose2(x_m=-0.2, y_m=0.0, yaw_rad=0.0), around_s_m=0.0) == 0.0
