"""A drive's log: time stamps that increase at the sensors' rates, and sensors that agree with the truth."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.check.fault import Fault
from adc_bench.dataset.drive_log import Columns, DriveLog
from adc_bench.dataset.shard import Shard
from adc_bench.geometry import Pose3
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]
ROUNDING = 1e-6
# A wheel slips a little in bends; where the robot hits something, encoders need not agree with the way at all.
WAY_SHARE, WAY_M = 0.02, 0.05
TURN_SHARE, TURN_RAD = 0.02, 0.05
GYRO_SDS = 6.0
BETWEEN_STEPS_M, BETWEEN_STEPS_RAD = 0.02, 0.05  # a pose between two steps of the truth, along the straight line


def drive_faults(log: DriveLog, shard: Shard) -> Iterator[Fault]:
    """Yield what is wrong with a drive beside its pictures and labels."""
    scenario = shard.scenarios[shard.conditions(0).scenario]
    for text in (*_time_texts(log, scenario), *_picture_texts(log, shard), *_truth_texts(log)):
        yield Fault(None, text)
    for text in (*_encoder_texts(log, scenario), *_gyro_texts(log, scenario)):
        yield Fault(None, text)


def _time_texts(log: DriveLog, scenario: Scenario) -> Iterator[str]:
    rig = scenario.rig
    rates_hz = {"encoders": rig.encoders.rate_hz, "imu": rig.imu.rate_hz}
    latencies_s = {"encoders": rig.encoders.latency_s, "imu": rig.imu.latency_s}
    if rig.laser:
        rates_hz["laser"], latencies_s["laser"] = rig.laser.rate_hz, rig.laser.latency_s
    steps_s = np.diff(log.truth["time_s"])
    if (steps_s <= 0).any() or np.abs(steps_s - steps_s[:1]).max(initial=0.0) > ROUNDING:
        yield "truth: its time stamps are not evenly spaced"
    for name, rate_hz in rates_hz.items():
        columns: Columns = getattr(log, name)
        gaps_s = np.diff(columns["time_s"])
        if (gaps_s <= 0).any():
            yield f"{name}: time stamps do not increase"
        elif len(gaps_s) and np.abs(gaps_s - 1 / rate_hz).max() > ROUNDING:
            yield f"{name}: samples {gaps_s.min():.4f} to {gaps_s.max():.4f} s apart, not {1 / rate_hz:.4f} s"
        if np.abs(columns["arrival_time_s"] - columns["time_s"] - latencies_s[name]).max(initial=0.0) > ROUNDING:
            yield f"{name}: samples do not arrive {latencies_s[name]} s after they were taken"
    for name in ("contacts", "bodies", "tapes"):
        times: Columns = getattr(log, name)
        if (np.diff(times["time_s"]) < 0).any():
            yield f"{name}: time stamps fall"


def _picture_texts(log: DriveLog, shard: Shard) -> Iterator[str]:
    """Compare pictures' times with their cameras' periods, and their poses with the truth between its steps."""
    time_s, truth_s = log.pictures["time_s"], log.truth["time_s"]
    if len(time_s) != len(shard):
        yield f"pictures: {len(time_s)} times for {len(shard)} pictures"
        return
    rig = shard.scenarios[shard.conditions(0).scenario].rig
    cameras = np.array(shard.cameras)
    for mount in rig.cameras:
        gaps_s = np.diff(time_s[cameras == mount.name])
        if len(gaps_s) and np.abs(gaps_s - mount.period_steps * (truth_s[1] - truth_s[0])).max() > ROUNDING:
            yield f"pictures: camera {mount.name} does not take one every {mount.period_steps} steps"
    places, yaw_rad = log.truth["pose_world_robot"][:, :2], _yaw_rad(log)
    x_m, y_m = (np.interp(time_s, truth_s, places[:, k]) for k in range(2))
    off_m = np.hypot(shard.pose_world_robot[:, 0] - x_m, shard.pose_world_robot[:, 1] - y_m)
    turn = shard.pose_world_robot[:, 2] - np.interp(time_s, truth_s, yaw_rad)
    off_rad = np.abs(np.arctan2(np.sin(turn), np.cos(turn)))
    for row in np.flatnonzero((off_m > BETWEEN_STEPS_M) | (off_rad > BETWEEN_STEPS_RAD)).tolist():
        yield f"picture {row}: its robot is {off_m[row]:.3f} m and {off_rad[row]:.3f} rad off the truth at its time"


def _truth_texts(log: DriveLog) -> Iterator[str]:
    poses = log.truth["pose_world_robot"]
    if not np.isfinite(poses).all():
        yield "truth: a pose is not finite"
    elif (np.abs(np.linalg.norm(poses[:, 3:], axis=1) - 1) > ROUNDING).any():
        yield "truth: a pose has no unit quaternion"


def _encoder_texts(log: DriveLog, scenario: Scenario) -> Iterator[str]:
    """Compare what both wheels rolled, by their true radii, with the way and the turn."""
    if len(log.contacts["time_s"]) or len(log.encoders["time_s"]) < 2:
        return
    truth, robot = scenario.robot_truth, scenario.robot
    until_s = log.encoders["time_s"]
    per_tick_rad = 2 * math.pi / robot.encoder_ticks_per_turn
    left_m = _rolled_m(log, "left", per_tick_rad * truth.wheel_radius_left_m)
    right_m = _rolled_m(log, "right", per_tick_rad * truth.wheel_radius_right_m)
    speed_mps = np.interp(until_s, log.truth["time_s"], log.truth["v_mps"])
    way_m = float(np.trapezoid(speed_mps, until_s))
    length_m = float(np.trapezoid(np.abs(speed_mps), until_s))
    if abs(way_m - (left_m + right_m) / 2) > WAY_M + WAY_SHARE * length_m:
        yield f"encoders: {(left_m + right_m) / 2:.2f} m rolled on a way of {way_m:.2f} m"
    yaw_rad = np.interp(until_s, log.truth["time_s"], _yaw_rad(log))
    turn_rad, rolled_rad = yaw_rad[-1] - yaw_rad[0], (right_m - left_m) / truth.wheel_separation_m
    if abs(turn_rad - rolled_rad) > TURN_RAD + TURN_SHARE * np.abs(np.diff(yaw_rad)).sum():
        yield f"encoders: {rolled_rad:.2f} rad rolled on a turn of {turn_rad:.2f} rad"


def _rolled_m(log: DriveLog, side: str, per_tick_m: float) -> float:
    ticks = log.encoders[f"{side}_ticks"]
    return float(ticks[-1] - ticks[0]) * per_tick_m


def _gyro_texts(log: DriveLog, scenario: Scenario) -> Iterator[str]:
    """Integrate the gyro without its true bias: what is left is noise and the bias' walk, and the body's tilt."""
    time_s, rate_radps = log.imu["time_s"], log.imu["yaw_rate_radps"]
    if len(time_s) < 2:
        return
    imu, span_s = scenario.rig.imu, float(time_s[-1] - time_s[0])
    turned_rad = float(np.trapezoid(rate_radps - scenario.robot_truth.gyro_bias_radps, time_s))
    yaw_rad = np.interp(time_s, log.truth["time_s"], _yaw_rad(log))
    noise_rad = imu.gyro_noise_radps * math.sqrt(span_s / imu.rate_hz)
    walk_rad = imu.gyro_walk_radps_sqrts * math.sqrt(span_s**3 / 3)
    allowed_rad = TURN_RAD + GYRO_SDS * math.hypot(noise_rad, walk_rad)
    if abs(turned_rad - (yaw_rad[-1] - yaw_rad[0])) > allowed_rad:
        yield f"imu: its gyro turns by {turned_rad:.2f} rad, the robot by {yaw_rad[-1] - yaw_rad[0]:.2f} rad"


def _yaw_rad(log: DriveLog) -> Array:
    headings = [Pose3.from_figures(figures).rotation[:2, 0] for figures in log.truth["pose_world_robot"]]
    x, y = np.array(headings).T
    yaw: Array = np.unwrap(np.arctan2(y, x))
    return yaw
