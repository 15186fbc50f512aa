"""Arenas made by hand, and a drive through one of them."""

import hashlib
import math

import msgspec

from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.world.layout import BoxPlace, Layout, Place, Works
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import RobotParams, RobotTruth, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.streams import stream

FAMILY = LookFamily(floors=("felt",), walls=("plaster",), light_sets=("warm_hall",))
NOMINAL = RobotTruth(
    wheel_radius_left_m=0.0975,
    wheel_radius_right_m=0.0975,
    wheel_separation_m=0.33,
    gyro_bias_radps=0.0,
    camera_pitch_rad=0.0,
    camera_roll_rad=0.0,
)


def scenario_of_seed(seed: int) -> Scenario:
    return Scenario(
        name=f"drive-{seed}",
        seed=seed,
        look=draw_look(FAMILY, stream(seed, "look")),
        robot_truth=draw_robot_truth(RobotParams(), stream(seed, "robot")),
        panel_sign="up",
    )


def ahead(start: Pose2, x_m: float, y_m: float = 0.0) -> Place:
    place = start @ Pose2(x_m=x_m, y_m=y_m, yaw_rad=0.0)
    return place.x_m, place.y_m


def through_cones() -> str:
    """Drive through a row of cones and two boxes; return a digest of all poses and readings."""
    start = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
    left = tuple(ahead(start, 1.0 + 0.5 * k, 0.1 * (-1) ** k) for k in range(4))
    works = Works(left=left, right=(ahead(start, 1.0, 3.0), ahead(start, 2.0, 3.0)))
    boxes = tuple(BoxPlace(x_m=x_m, y_m=y_m) for x_m, y_m in (ahead(start, 3.4, 0.2), ahead(start, 4.1)))
    arena = msgspec.structs.replace(scenario_of_seed(31), layout=Layout(works=works, boxes=boxes))
    sim, digest = Simulation(arena, start), hashlib.sha256()
    for k in range(80):
        sim.advance(1.8, 0.3 * math.sin(k))
        for name, pose in sim.body_poses().items():
            digest.update(name.encode() + pose.matrix().tobytes())
        readings = sim.read_sensors()
        digest.update(readings.laser.ranges_m.tobytes() if readings.laser else b"")
        digest.update(repr((sim.state(), sim.take_contacts(), sorted(sim.torn_tapes()))).encode())
    return digest.hexdigest()
