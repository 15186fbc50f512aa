"""Our closed loop without an agent: drive_ours.py WIDTH HEIGHT (camera | blind)

A step is a control step of 50 ms: physics at 200 Hz, encoders at 50 Hz, gyro, laser at 10 Hz, and, if not blind, one
picture of the road camera as it is delivered. The robot follows the lap at 1 m/s, steered by its true pose.
"""

import sys

from arenas import arena, rig
from turns import serve

from adc_bench.geometry import Path, Pose2
from adc_bench.sim import Simulation
from adc_bench.world.robot import Motion

SPEED_MPS, AHEAD_M = 1.0, 0.35
START_S_M = 0.9


class Drive:
    """The robot on its way round the lap."""

    def __init__(self, size_px: tuple[int, int], blind: bool) -> None:
        scenario = arena(0, rig(*size_px))
        self.lap, self.s_m = scenario.course.lap, START_S_M
        self.sim, self.renderer = Simulation(scenario, self.lap.pose(START_S_M)), None
        if not blind:
            from adc_bench.render.renderer import ArenaRenderer

            self.renderer = ArenaRenderer(scenario.rig)
            self.renderer.load(scenario)

    def step(self) -> None:
        state = self.sim.state()
        reached, _ = self.lap.project([(state.pose_world_robot.x_m, state.pose_world_robot.y_m)], around_s_m=self.s_m)
        self.s_m = float(reached[0])
        self.sim.advance(SPEED_MPS, steering(self.lap, self.s_m, state.pose_world_robot))
        self.sim.read_sensors()
        if self.renderer:
            state = self.sim.state()
            self.renderer.place(self.sim.body_poses(), self.sim.torn_tapes())
            motion = Motion(v_mps=state.v_mps, omega_radps=state.omega_radps)
            self.renderer.picture("road", self.sim.pose3_world_robot(), time_s=self.sim.time_s, motion=motion)


def steering(lap: Path, s_m: float, pose: Pose2) -> float:
    """Return the turn rate towards a point ahead on the lap."""
    x_m, y_m = pose.inverse().transform([(lap.pose(s_m + AHEAD_M).x_m, lap.pose(s_m + AHEAD_M).y_m)])[0]
    return 2 * SPEED_MPS * float(y_m) / float(x_m**2 + y_m**2)


width_px, height_px = map(int, sys.argv[1:3])
drive = Drive((width_px, height_px), sys.argv[3] == "blind")
drive.step()
serve(drive.step)
