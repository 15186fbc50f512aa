"""Where the cameras were: rotations that are rotations, and cameras where the robot carries them."""

import math
from collections.abc import Iterator

import numpy as np

from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.shard import Shard
from adc_bench.geometry import Pose2, Pose3

ROUNDING = 1e-6
# `pose_world_robot` is a pose on the floor; the body's own pitch and roll show in the camera's alone. In independent
# frames they are drawn with sd 0.3 degrees, in a drive the robot brakes, bumps and climbs.
TILT_MAX_RAD = {"frames": math.radians(2), "drives": math.radians(20)}
LIFT_MAX_M = {"frames": 0.0, "drives": 0.15}


def pose_faults(shard: Shard, kind: str) -> Iterator[Fault]:
    """Yield what is wrong with the poses of a shard of a dataset of this kind."""
    robots, cameras = shard.pose_world_robot, shard.pose_world_camera
    for row in range(len(shard)):
        if not (np.isfinite(cameras[row]).all() and np.isfinite(robots[row]).all()):
            yield Fault(row, "a pose is not finite")
        elif not _is_rigid(cameras[row]):
            yield Fault(row, "the camera's pose is no rotation and translation")
        elif text := _mount_fault(shard, row, kind):
            yield Fault(row, text)


def _is_rigid(matrix: np.ndarray) -> bool:
    rotation = matrix[:3, :3]
    orthonormal = np.allclose(rotation @ rotation.T, np.eye(3), atol=ROUNDING)
    return bool(orthonormal and np.linalg.det(rotation) > 0 and np.array_equal(matrix[3], (0, 0, 0, 1)))


def _mount_fault(shard: Shard, row: int, kind: str) -> str | None:
    """Compare the camera's pose with robot pose @ mount: what is left must be a small tilt about the robot's origin."""
    scenario = shard.scenarios.get(shard.condition_columns["scenario"][row].decode())
    if scenario is None:
        return "its scenario is not in the shard"
    truth, mount = scenario.robot_truth, scenario.rig.camera(shard.cameras[row])
    x_m, y_m, yaw_rad = shard.pose_world_robot[row].tolist()
    level = Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad).to_pose3()
    matrix = shard.pose_world_camera[row]
    seen = level.inverse() @ Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())
    body = seen @ mount.pose_robot_camera(truth.camera_pitch_rad, truth.camera_roll_rad).inverse()
    tilt_rad = math.acos(min(1.0, max(-1.0, (float(np.trace(body.rotation)) - 1) / 2)))
    if tilt_rad > TILT_MAX_RAD[kind]:
        return f"the camera is turned by {math.degrees(tilt_rad):.2f} degrees against its mount on the robot"
    if (shift_m := float(np.linalg.norm(body.translation_m))) > LIFT_MAX_M[kind] + 1e-3:
        return f"the camera is {shift_m:.3f} m from its mount on the robot"
    return None
