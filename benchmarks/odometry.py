"""How far encoders alone carry the robot: one D1 lap per seed under a driver that knows the true pose.

python benchmarks/odometry.py [--seeds 20] [--speed 1.0]
"""

import argparse
import math
import time

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples
from adc_bench.geometry import Path, Pose2
from adc_bench.sim import Simulation
from adc_bench.world.look import FLOOR_TEXTURES, LIGHT_SETS, WALL_TEXTURES, LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.streams import stream

Array = NDArray[np.float64]
START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
FAMILY = LookFamily(floors=FLOOR_TEXTURES, walls=WALL_TEXTURES, light_sets=tuple(LIGHT_SETS))


def scenario(seed: int) -> Scenario:
    return Scenario(
        name=f"odometry-{seed}",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(RobotParams(), stream(seed, "robot")),
        panel_sign="up",
        rig=SensorRig(laser=None),
    )


def pursue(path: Path, pose: Pose2, s_m: float, speed_mps: float) -> tuple[float, float]:
    """Return (turn rate, arc length reached): the arc to a point 0.35 m ahead (pure pursuit)."""
    reached, _ = path.project([(pose.x_m, pose.y_m)], around_s_m=s_m)
    ahead = path.pose(float(reached[0]) + 0.35)
    x_m, y_m = pose.inverse().transform([(ahead.x_m, ahead.y_m)])[0]
    return speed_mps * 2 * y_m / (x_m**2 + y_m**2), float(reached[0])


def dead_reckoning(start: Pose2, robot: RobotParams, samples: list[EncoderSamples]) -> Array:
    """Return (n, 3): time and position at each encoder sample, by arcs on nominal wheels."""
    time_s = np.concatenate([s.time_s for s in samples])
    ticks = np.stack(
        [np.concatenate([s.left_ticks for s in samples]), np.concatenate([s.right_ticks for s in samples])], axis=1
    )
    rim_m = np.diff(ticks, axis=0) * (2 * math.pi * robot.wheel_radius_m / robot.encoder_ticks_per_turn)
    turn = (rim_m[:, 1] - rim_m[:, 0]) / robot.wheel_separation_m
    yaw = start.yaw_rad + np.concatenate([[0.0], np.cumsum(turn)])
    chord = rim_m.mean(axis=1) * np.sinc(turn / (2 * math.pi))
    x = start.x_m + np.concatenate([[0.0], np.cumsum(chord * np.cos(yaw[:-1] + turn / 2))])
    y = start.y_m + np.concatenate([[0.0], np.cumsum(chord * np.sin(yaw[:-1] + turn / 2))])
    return np.stack([time_s, x, y], axis=1)


def lap(seed: int, speed_mps: float) -> tuple[Array, Array, float]:
    """Drive one lap: return true (n, 3) and reckoned (m, 3) time and position, and the seconds that the steps took."""
    arena = scenario(seed)
    path, sim = arena.course.lap, Simulation(arena, START)
    s_m, travelled_m, busy_s = path.length_m + START.x_m, 0.0, 0.0
    truth, samples = [(0.0, START.x_m, START.y_m)], [sim.read_sensors().encoders]
    while travelled_m < path.length_m:
        omega_radps, reached_m = pursue(path, sim.state().pose_world_robot, s_m, speed_mps)
        travelled_m += (reached_m - s_m + path.length_m / 2) % path.length_m - path.length_m / 2
        s_m = reached_m
        begin = time.process_time()
        sim.advance(speed_mps, omega_radps)
        busy_s += time.process_time() - begin
        pose = sim.state().pose_world_robot
        truth.append((sim.time_s, pose.x_m, pose.y_m))
        samples.append(sim.read_sensors().encoders)
    return np.array(truth), dead_reckoning(START, arena.robot, samples), busy_s / sim.step_index


def worst_error(truth: Array, reckoned: Array) -> Array:
    """Return the greatest error over the lap: distance, in x, in y."""
    at = np.searchsorted(reckoned[:, 0], truth[::2, 0] - 1e-9)  # both clocks meet every other control step
    assert np.allclose(reckoned[at, 0], truth[::2, 0])
    error = reckoned[at, 1:] - truth[::2, 1:]
    return np.array([np.hypot(*error.T).max(), *np.abs(error).max(axis=0)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--speed", type=float, default=1.0)
    options = parser.parse_args()
    errors, costs = [], []
    for seed in range(options.seeds):
        truth, reckoned, cost_s = lap(seed, options.speed)
        errors.append(worst_error(truth, reckoned))
        costs.append(cost_s)
        total_m, x_m, y_m = errors[-1]
        print(f"seed {seed:3d}: worst error {total_m:.3f} m (x {x_m:.3f}, y {y_m:.3f}), lap {truth[-1, 0]:.1f} s")
    for row, name in zip(np.array(errors).T, ("distance", "x", "y"), strict=True):
        print(f"worst error, {name}: median {np.median(row):.3f} m, 90th percentile {np.percentile(row, 90):.3f} m")
    print(f"control step of 50 ms: {np.median(costs) * 1e6:.0f} us of CPU time")


if __name__ == "__main__":
    main()
