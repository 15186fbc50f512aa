"""Physics and sensors without pictures: laps through an arena with everything in it, against simulated time.

python benchmarks/physics.py [--laps 2] [--arenas 3]
"""

import argparse
import time

import msgspec
import numpy as np
from arenas import arena
from odometry import START, pursue

from adc_bench.sim import Simulation
from adc_bench.sim.laser import Laser
from adc_bench.sim.rays import Obstacles
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import LaserSpec, SensorRig


def drive(scenario: Scenario, laps: int) -> tuple[float, float]:
    """Return the simulated seconds of some laps at 1 m/s and the CPU seconds that they cost."""
    path, sim = scenario.course.lap, Simulation(scenario, START)
    s_m, busy_s = path.length_m + START.x_m, 0.0
    for _ in range(round(laps * path.length_m / 0.05)):
        omega_radps, s_m = pursue(path, sim.state().pose_world_robot, s_m, 1.0)
        begin = time.process_time()
        sim.advance(1.0, omega_radps)
        sim.read_sensors()
        sim.body_poses()
        sim.take_contacts()
        busy_s += time.process_time() - begin
    return sim.time_s, busy_s


def scan_cost_s(scenario: Scenario) -> float:
    """Return the median CPU time of a scan over poses round the lap."""
    laser, obstacles = Laser(1, LaserSpec()), Obstacles(scenario.solids, scenario.bodies)
    costs = []
    for s_m in np.arange(0.0, scenario.course.lap.length_m, 0.1):
        pose = scenario.course.lap.pose(float(s_m)).to_pose3()
        begin = time.process_time()
        laser.sample(0.0, pose, obstacles)
        costs.append(time.process_time() - begin)
    return float(np.median(costs))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laps", type=int, default=2)
    parser.add_argument("--arenas", type=int, default=3)
    options = parser.parse_args()
    for number in range(options.arenas):
        full = arena(number, SensorRig())
        blind = msgspec.structs.replace(full, rig=SensorRig(laser=None))
        for name, scenario in (("with laser", full), ("without", blind)):
            simulated_s, busy_s = drive(scenario, options.laps)
            print(
                f"arena {number}, {name}: {len(full.solids)} solids, {len(full.bodies)} bodies,"
                f" {simulated_s / busy_s:.1f} x real time of CPU"
            )
        print(f"arena {number}: a scan takes {scan_cost_s(full) * 1e3:.2f} ms")


if __name__ == "__main__":
    main()
