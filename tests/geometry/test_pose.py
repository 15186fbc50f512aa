import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from adc_bench.geometry import Pose2, Pose3, rotation_zyx, wrap_array_rad, wrap_rad

coordinate = st.floats(-20, 20)
angle = st.floats(-10, 10)
poses = st.builds(lambda x, y, a: Pose2(x_m=x, y_m=y, yaw_rad=a), coordinate, coordinate, angle)


@given(angle)
def test_wrapping_keeps_the_direction_and_lands_in_the_half_open_turn(a: float) -> None:
    wrapped = wrap_rad(a)
    assert -np.pi <= wrapped < np.pi
    assert np.isclose(np.exp(1j * a), np.exp(1j * wrapped))
    assert wrap_array_rad([a])[0] == wrapped


@given(poses, poses)
def test_composition_agrees_with_homogeneous_matrices(a: Pose2, b: Pose2) -> None:
    expected = a.to_pose3().matrix() @ b.to_pose3().matrix()
    assert np.allclose((a @ b).to_pose3().matrix(), expected, atol=1e-9)


@given(poses)
def test_a_pose_and_its_inverse_cancel(a: Pose2) -> None:
    assert np.allclose((a @ a.inverse()).to_pose3().matrix(), np.eye(4), atol=1e-9)
    assert np.allclose((a.to_pose3() @ a.to_pose3().inverse()).matrix(), np.eye(4), atol=1e-9)


@given(poses, st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=4))
def test_points_transform_as_the_matrix_does(a: Pose2, points: list[tuple[float, float]]) -> None:
    spatial = np.column_stack([points, np.zeros(len(points))])
    assert np.allclose(a.transform(points), a.to_pose3().transform(spatial)[:, :2], atol=1e-9)


@given(angle, angle, angle)
def test_rotation_agrees_with_scipy(yaw: float, pitch: float, roll: float) -> None:
    assert np.allclose(rotation_zyx(yaw, pitch, roll), Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix())


def test_a_pose3_is_read_only() -> None:
    pose = Pose3(rotation=np.eye(3), translation_m=np.zeros(3))
    assert not pose.rotation.flags.writeable and not pose.translation_m.flags.writeable
