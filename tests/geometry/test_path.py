import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial import cKDTree

from adc_bench.geometry import Path, Piece, Pose2, arc, line, wrap_rad
from adc_bench.world.course import Course

LAP = Course().lap
pieces = st.lists(
    st.builds(lambda length, k: Piece(length_m=length, curvature_pm=k), st.floats(0.2, 3), st.floats(-0.8, 0.8)),
    min_size=1,
    max_size=5,
)


@settings(max_examples=30)
@given(pieces)
def test_poses_agree_with_integrating_the_curvature(given_pieces: list[Piece]) -> None:
    path = Path(start=Pose2(x_m=1.0, y_m=-2.0, yaw_rad=0.4), pieces=tuple(given_pieces))
    state = np.array([1.0, -2.0, 0.4])
    for piece in given_pieces:
        k = piece.curvature_pm
        solution = solve_ivp(
            lambda _, q, k=k: [math.cos(q[2]), math.sin(q[2]), k], (0, piece.length_m), state, rtol=1e-10, atol=1e-12
        )
        state = solution.y[:, -1]
    end = path.poses(path.length_m)[0]
    assert np.allclose(end[:2], state[:2], atol=1e-7)
    assert abs(wrap_rad(end[2] - state[2])) < 1e-7


@pytest.mark.parametrize("path", [LAP, Course().outer_edge, LAP.offset(0.5)])
def test_projection_is_the_nearest_point_of_a_dense_sampling(path: Path) -> None:
    points = np.random.default_rng(3).uniform([-9, -4.5], [9, 4], (400, 2))
    distance, _ = cKDTree(path.sample(0.001)[:, :2]).query(points)
    s_m, offset_m = path.project(points)
    assert np.allclose(np.abs(offset_m), distance, atol=1e-4)
    feet = path.poses(s_m)
    assert np.allclose(np.hypot(*(points - feet[:, :2]).T), np.abs(offset_m), atol=1e-9)


def test_points_beside_the_path_come_back_with_their_side() -> None:
    s = np.linspace(0.1, LAP.length_m - 0.1, 300)
    poses = LAP.poses(s)
    left = poses[:, :2] + 0.2 * np.stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])], axis=1)
    for s_m, point in zip(s, left, strict=True):
        found, offset = LAP.project(point, around_s_m=float(s_m) + 0.4)
        assert abs(found[0] - s_m) < 1e-6 and abs(offset[0] - 0.2) < 1e-6


def test_the_window_keeps_the_branch_where_the_lap_crosses_itself_and_at_its_end() -> None:
    start = LAP.pose(0.0)
    found, _ = LAP.project([(start.x_m + 0.01, start.y_m)], around_s_m=LAP.length_m - 0.1)
    assert found[0] == pytest.approx(0.01)
    found, _ = LAP.project([(start.x_m - 0.01, start.y_m)], around_s_m=0.1)
    assert found[0] == pytest.approx(LAP.length_m - 0.01)


def test_an_offset_path_keeps_its_distance() -> None:
    parallel = LAP.offset(0.3)
    for share in np.linspace(0.0, 0.99, 60):
        point = parallel.poses(share * parallel.length_m)[0, :2]
        _, offset = LAP.project(point, around_s_m=share * LAP.length_m, window_m=2.5)
        assert abs(offset[0] - 0.3) < 1e-9


def test_sampling_has_every_knot_and_no_long_step() -> None:
    path = Path(start=Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0), pieces=(line(1.03), arc(0.5, -1.0), line(0.2)))
    samples = path.sample(0.1)
    steps = np.hypot(*np.diff(samples[:, :2], axis=0).T)
    assert steps.max() <= 0.1 + 1e-12
    for knot in path.poses(path.knots_m):
        assert np.min(np.hypot(*(samples[:, :2] - knot[:2]).T)) < 1e-9


def test_a_fold_is_refused() -> None:
    with pytest.raises(AssertionError, match="fold"):
        LAP.offset(-1.9)
