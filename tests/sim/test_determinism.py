import gc
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from sapien import physx

from adc_bench.geometry import Pose2
from adc_bench.sim import Simulation
from adc_bench.world.scenario import Scenario

Draw = Callable[[int], Scenario]


def drive(sim: Simulation, steps: int = 80) -> Iterator[bytes]:
    """Drive on, into a gantry post at the end; yield all that the simulation tells, as bytes, one control step each."""
    for k in range(steps):
        sim.advance(1.2, 0.8 * math.sin(0.11 * k))
        state, pose = sim.state(), sim.pose3_world_robot()
        readings = sim.read_sensors()
        encoders, imu, laser = readings.encoders, readings.imu, readings.laser
        arrays = (pose.matrix(), encoders.time_s, encoders.left_ticks, encoders.right_ticks, imu.yaw_rate_radps)
        arrays += (imu.acceleration_x_mps2, np.array([state.v_mps, state.omega_radps]))
        arrays += (laser.ranges_m,) if laser else ()
        yield b"".join(a.tobytes() for a in arrays) + repr((state, sim.take_contacts())).encode()


def test_equal_arguments_and_commands_give_equal_bits(drawn: Draw, start: Pose2) -> None:
    assert list(drive(Simulation(drawn(21), start))) == list(drive(Simulation(drawn(21), start)))


def test_seeds_differ(drawn: Draw, start: Pose2) -> None:
    assert list(drive(Simulation(drawn(21), start)))[-1] != list(drive(Simulation(drawn(22), start)))[-1]


def test_other_simulations_in_the_process_leave_no_trace(drawn: Draw, start: Pose2) -> None:
    alone = list(drive(Simulation(drawn(23), start)))
    other = Simulation(drawn(24), Pose2(x_m=-2.0, y_m=-1.225, yaw_rad=0.0))
    between = drive(other)
    beside = []
    sim = Simulation(drawn(23), start)
    for step in drive(sim):
        next(between)
        beside.append(step)
    assert beside == alone


@pytest.fixture
def odd_physics() -> Iterator[None]:
    """The physics library as another user of the process may have left it."""
    scene, shape, body = physx.get_scene_config(), physx.get_shape_config(), physx.get_body_config()
    physx.set_scene_config(gravity=[0.0, 0.0, -1.0], enable_tgs=False)
    physx.set_shape_config(contact_offset=0.1)
    physx.set_body_config(solver_position_iterations=2)
    yield
    physx.set_scene_config(scene)
    physx.set_shape_config(shape)
    physx.set_body_config(body)


@pytest.fixture
def expected(drawn: Draw, start: Pose2) -> list[bytes]:
    return list(drive(Simulation(drawn(25), start), steps=30))


def test_settings_of_the_physics_library_leave_no_trace(
    expected: list[bytes], odd_physics: None, drawn: Draw, start: Pose2
) -> None:
    assert list(drive(Simulation(drawn(25), start), steps=30)) == expected


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the resident size from /proc")
def test_scenes_are_given_back(drawn: Draw, start: Pose2) -> None:
    def resident_mb() -> float:
        gc.collect()
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6

    def once() -> None:
        sim = Simulation(drawn(26), start)
        for _ in range(4):
            sim.advance(1.0, 0.0)

    for _ in range(5):
        once()
    before = resident_mb()
    for _ in range(50):
        once()
    assert resident_mb() - before < 3.0
