import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples, ImuSamples
from adc_bench.geometry import Pose2
from adc_bench.sim import Delivery, Simulation
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import ImuSpec

Draw = Callable[[int], Scenario]


def with_imu(scenario: Scenario, imu: ImuSpec) -> Scenario:
    return msgspec.structs.replace(scenario, rig=msgspec.structs.replace(scenario.rig, imu=imu))


def read(sim: Simulation) -> tuple[EncoderSamples, ImuSamples]:
    readings = sim.read_sensors()
    return readings.encoders, readings.imu


QUIET = ImuSpec(
    gyro_noise_radps=0.0, gyro_walk_radps_sqrts=0.0, acceleration_noise_mps2=0.0, acceleration_bias_mps2=0.0
)


def drive(
    scenario: Scenario, start: Pose2, steps: int = 60, imu: ImuSpec | None = None
) -> tuple[Simulation, EncoderSamples, ImuSamples, NDArray[np.float64]]:
    sim = Simulation(with_imu(scenario, imu) if imu else scenario, start)
    yaws = [sim.state().pose_world_robot.yaw_rad]
    for k in range(steps):
        sim.advance(1.0, 0.6 * math.sin(0.1 * k))
        yaws.append(sim.state().pose_world_robot.yaw_rad)
    return sim, *read(sim), np.array(yaws)


def test_samples_stand_on_an_exact_grid_each_delivered_once(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    encoders, imu = read(sim)
    encoder_times, imu_times = [encoders.time_s], [imu.time_s]
    counts = []
    for _ in range(20):
        sim.advance(0.5, 0.0)
        encoders, imu = read(sim)
        assert encoders.left_ticks.shape == encoders.right_ticks.shape == encoders.time_s.shape
        assert imu.yaw_rate_radps.shape == imu.acceleration_x_mps2.shape == imu.time_s.shape
        assert encoders.left_ticks.dtype == np.int64
        encoder_times.append(encoders.time_s)
        imu_times.append(imu.time_s)
        counts.append((encoders.time_s.size, imu.time_s.size))
    assert np.concatenate(encoder_times).tolist() == [k / 50 for k in range(51)]
    assert np.concatenate(imu_times).tolist() == [k / 100 for k in range(101)]
    assert set(counts) == {(2, 5), (3, 5)}
    encoders, imu = read(sim)
    assert encoders.time_s.size == encoders.left_ticks.size == imu.time_s.size == 0


@pytest.mark.parametrize("v_mps", [0.5, -0.5])
def test_ticks_agree_with_the_distance(drawn: Draw, start: Pose2, v_mps: float) -> None:
    arena = drawn(7)
    sim = Simulation(arena, start)
    first = sim.state().pose_world_robot
    for _ in range(100):
        sim.advance(v_mps, 0.0)
    moved = first.inverse() @ sim.state().pose_world_robot
    encoders, _ = read(sim)
    assert encoders.left_ticks[0] == encoders.right_ticks[0] == 0
    for ticks, radius_m in (
        (encoders.left_ticks, arena.robot_truth.wheel_radius_left_m),
        (encoders.right_ticks, arena.robot_truth.wheel_radius_right_m),
    ):
        rim_m = ticks[-1] / 500 * 2 * math.pi * radius_m
        assert rim_m == pytest.approx(math.copysign(math.hypot(moved.x_m, moved.y_m), v_mps), rel=0.003)


def test_ticks_tell_the_turn(nominal: Scenario, start: Pose2) -> None:
    _, encoders, _, yaws = drive(nominal, start)
    rim_m = 2 * math.pi * 0.0975 / 500
    turned = (encoders.right_ticks - encoders.left_ticks) * rim_m / 0.33
    assert np.abs(turned[::5] - (yaws - yaws[0])[::2]).max() < 2 * rim_m / 0.33 + 0.005


def test_gyro_adds_up_to_the_yaw(nominal: Scenario, start: Pose2) -> None:
    _, _, imu, yaws = drive(nominal, start, imu=QUIET)
    turned = np.cumsum(imu.yaw_rate_radps) / 100
    assert np.abs(turned[::5] - (yaws - yaws[0])).max() < 1e-4


def test_gyro_errors_have_the_stated_size(drawn: Draw, start: Pose2) -> None:
    arena = drawn(11)
    _, _, noisy, _ = drive(arena, start, steps=400)
    _, _, quiet, _ = drive(msgspec.structs.replace(arena), start, steps=400, imu=QUIET)
    error = noisy.yaw_rate_radps - quiet.yaw_rate_radps
    assert np.diff(error).std() == pytest.approx(math.sqrt(2) * ImuSpec().gyro_noise_radps, rel=0.1)
    assert abs(error.mean()) < 4 * ImuSpec().gyro_walk_radps_sqrts * math.sqrt(20)
    at_rest = quiet.yaw_rate_radps[0]
    assert at_rest == pytest.approx(arena.robot_truth.gyro_bias_radps, abs=1e-6)


def test_accelerometer_feels_the_ramp_and_then_nothing(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(with_imu(nominal, QUIET), start)
    for _ in range(40):
        sim.advance(1.0, 0.0)
    _, imu = read(sim)
    assert imu.acceleration_x_mps2[0] == pytest.approx(0.0, abs=0.01)
    assert imu.acceleration_x_mps2[5:45].mean() == pytest.approx(2.0, rel=0.03)
    assert imu.acceleration_x_mps2[80:].mean() == pytest.approx(0.0, abs=0.02)


def test_each_error_has_its_own_stream(drawn: Draw, start: Pose2) -> None:
    arena = drawn(12)
    _, encoders, imu, yaws = drive(arena, start)
    louder = msgspec.structs.replace(ImuSpec(), acceleration_noise_mps2=1.0)
    _, encoders2, imu2, yaws2 = drive(arena, start, imu=louder)
    assert (imu.acceleration_x_mps2 != imu2.acceleration_x_mps2).all()
    assert imu.yaw_rate_radps.tobytes() == imu2.yaw_rate_radps.tobytes()
    assert encoders.left_ticks.tobytes() == encoders2.left_ticks.tobytes()
    assert yaws.tobytes() == yaws2.tobytes()


def test_seeds_give_other_errors(nominal: Scenario, start: Pose2) -> None:
    _, encoders, imu, yaws = drive(nominal, start)
    _, encoders2, imu2, yaws2 = drive(msgspec.structs.replace(nominal, seed=99), start)
    assert yaws.tobytes() == yaws2.tobytes()  # the same robot drives the same path
    assert (imu.yaw_rate_radps != imu2.yaw_rate_radps).all()
    assert (imu.acceleration_x_mps2 != imu2.acceleration_x_mps2).all()
    assert (encoders.left_ticks != encoders2.left_ticks).any()  # another phase
    assert np.abs(encoders.left_ticks - encoders2.left_ticks).max() <= 1


def late(scenario: Scenario, encoders_s: float, imu_s: float, laser_s: float) -> Scenario:
    replace, rig = msgspec.structs.replace, scenario.rig
    assert rig.laser is not None
    return replace(
        scenario,
        rig=replace(
            rig,
            encoders=replace(rig.encoders, latency_s=encoders_s),
            imu=replace(rig.imu, latency_s=imu_s),
            laser=replace(rig.laser, latency_s=laser_s),
        ),
    )


def test_late_samples_are_the_same_ones_at_the_first_step_after_their_latency(drawn: Draw, start: Pose2) -> None:
    arena, latencies_s = drawn(14), (0.03, 0.007, 0.12)
    prompt, slow = Simulation(arena, start), Simulation(late(arena, *latencies_s), start)
    taken: list[list[tuple[float, bytes]]] = [[], [], []]
    arrived: list[list[tuple[float, float, bytes]]] = [[], [], []]
    for k in range(40):
        for sim, told in ((prompt, taken), (slow, arrived)):
            readings = sim.read_sensors()
            e, i, scan = readings.encoders, readings.imu, readings.laser
            rows = [
                list(zip(e.time_s, np.stack([e.left_ticks, e.right_ticks], axis=1), strict=True)),
                list(zip(i.time_s, np.stack([i.yaw_rate_radps, i.acceleration_x_mps2], axis=1), strict=True)),
                [(scan.time_s, scan.ranges_m)] if scan else [],
            ]
            for kind, samples in enumerate(rows):
                told[kind] += [
                    (time_s, values.tobytes()) if sim is prompt else (sim.time_s, time_s, values.tobytes())
                    for time_s, values in samples
                ]
            sim.advance(1.0, 0.4 * math.sin(0.2 * k))
    for kind, latency_s in enumerate(latencies_s):
        assert [row[1:] for row in arrived[kind]] == taken[kind][: len(arrived[kind])]
        assert len(taken[kind]) - len(arrived[kind]) <= latency_s * 100 + 1
        for now_s, time_s, _ in arrived[kind]:
            first_step = math.ceil((time_s + latency_s) * 20 - 1e-6)
            assert now_s == pytest.approx(first_step / 20), (kind, time_s)


def test_a_delivery_keeps_the_order_and_hands_out_once() -> None:
    delivery: Delivery[str] = Delivery(0.1)
    delivery.put(0.0, "a")
    delivery.put(0.05, "b")
    delivery.put(0.2, "c")
    assert delivery.take(0.05) == []
    assert delivery.take(0.15) == ["a", "b"]
    assert delivery.take(0.29) == []
    assert delivery.take(0.1 + 0.2) == ["c"], "rounding does not hold a sample up"
    assert delivery.take(9.0) == []
