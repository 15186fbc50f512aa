"""Arenas with everything in them: nothing moves by itself, and the laser sees what PhysX meets."""

import math

import numpy as np
import pytest
import sapien

from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.sim.bodies import Bodies
from adc_bench.sim.laser import Laser, beam_angles_rad
from adc_bench.sim.rays import Obstacles
from adc_bench.sim.surfaces import add_floor, add_solid, physics
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import LaserSpec, SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream


@pytest.fixture(params=["d3_v1", "d4_v1", "random_all", "random_parking"])
def full(request: pytest.FixtureRequest, nominal: Scenario) -> Scenario:
    return set_up(
        name="full",
        seed=5,
        look=nominal.look,
        panel_sign="up",
        layout=draw_layout(request.param, Course(), stream(5, "layout"), signs=True),
        course=CourseSpec(),
        arena=ArenaSpec(),
        robot=RobotParams(),
        rig=SensorRig(),
    )


def test_nothing_moves_by_itself(full: Scenario, start: Pose2) -> None:
    sim = Simulation(full, start)
    before = sim.body_poses()
    assert list(before) == [body.name for body in full.bodies]
    for _ in range(20):
        sim.advance(0.5, 0.0)
    assert all(pose is before[name] for name, pose in sim.body_poses().items())
    assert sim.torn_tapes() == frozenset() and sim.take_contacts() == []


def test_all_bodies_stand_when_woken(full: Scenario) -> None:
    scene = sapien.Scene([physics(200)])
    add_floor(scene)
    for solid in full.solids:
        add_solid(scene, solid, 0.8)
    bodies = Bodies(scene, full.bodies)
    before = bodies.poses()
    for component in scene.physx_system.rigid_dynamic_components:
        component.wake_up()
    for _ in range(200):
        scene.step()
        bodies.follow()
    for name, pose in bodies.poses().items():
        assert np.abs(pose.matrix() - before[name].matrix()).max() < 1e-3, name


def test_the_laser_sees_what_physx_meets_round_the_lap(full: Scenario) -> None:
    system = physics(200)
    scene = sapien.Scene([system])
    for solid in full.solids:
        add_solid(scene, solid, 0.8)
    Bodies(scene, full.bodies)
    spec = LaserSpec()
    laser, obstacles = Laser(1, spec), Obstacles(full.solids, full.bodies)
    angles = beam_angles_rad(spec)
    errors, seen = [], 0
    for s_m in np.arange(0.0, full.course.lap.length_m, 1.0):
        pose = full.course.lap.pose(float(s_m)).to_pose3()
        read = laser.true_ranges_m(pose, obstacles)
        origin = pose.transform([[spec.x_m, 0.0, spec.z_m]])[0]
        beams = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1) @ pose.rotation.T
        for k in range(0, spec.beams, 3):
            hit = system.raycast(origin, beams[k], spec.range_max_m)
            met = math.inf if hit is None else hit.distance
            seen += math.isfinite(met)
            errors.append(0.0 if read[k] == met else abs(read[k] - met))
    assert seen > 60
    assert np.mean(np.array(errors) > 2e-3) < 0.01, "beams that graze a hull's rounded side"
