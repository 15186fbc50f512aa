import math

import numpy as np
import pytest

from adc_bench.api import EncoderSamples, ImuSamples
from adc_bench.stack.travel import Reached, Tape, forget, record, travel
from adc_bench.world.robot import RobotParams

ROBOT = RobotParams()
PER_RAD = ROBOT.encoder_ticks_per_turn / (2 * math.pi)
TICK_M = ROBOT.wheel_radius_m / PER_RAD


def tape_of(v_mps: float, omega_radps: float, seconds: float = 1.0, spike: dict[int, float] | None = None) -> Tape:
    """Return what the sensors say of a steady motion."""
    wheel_s, gyro_s = np.arange(0, seconds + 1e-9, 0.02), np.arange(0.01, seconds + 1e-9, 0.01)
    half = omega_radps * ROBOT.wheel_separation_m / 2
    ticks = [np.floor((v_mps + sign * half) / ROBOT.wheel_radius_m * wheel_s * PER_RAD) for sign in (-1, 1)]
    rates = np.full(len(gyro_s), omega_radps)
    for index, rate in (spike or {}).items():
        rates[index] = rate
    encoders = EncoderSamples(
        time_s=wheel_s, left_ticks=ticks[0].astype(np.int64), right_ticks=ticks[1].astype(np.int64)
    )
    imu = ImuSamples(time_s=gyro_s, yaw_rate_radps=rates, acceleration_x_mps2=np.zeros(len(gyro_s)))
    return record(Tape(), encoders, imu, ROBOT)


@pytest.mark.parametrize(("v_mps", "omega_radps"), [(1.0, 0.0), (2.0, 1.1), (-0.4, 0.5), (0.0, -2.0)])
def test_a_steady_motion_is_read_out(v_mps: float, omega_radps: float) -> None:
    way, reached = travel(tape_of(v_mps, omega_radps), Reached(), 0.9, ROBOT)
    assert way.duration_s.sum() == pytest.approx(0.9)
    assert way.forward_m.sum() == pytest.approx(0.9 * v_mps, abs=2 * TICK_M)
    assert way.turn_rad.sum() == pytest.approx(0.9 * omega_radps, abs=1e-9)
    assert way.slip_m == 0.0
    assert reached.time_s == 0.9


def test_it_may_be_read_in_parts_and_the_tape_cut_behind() -> None:
    tape = tape_of(1.3, 0.7)
    whole, at_end = travel(tape, Reached(), 0.93, ROBOT)
    reached, forward, turn = Reached(), 0.0, 0.0
    for until_s in (0.05, 0.1, 0.37, 0.38, 0.55, 0.93):
        way, reached = travel(tape, reached, until_s, ROBOT)
        tape = forget(tape, until_s)
        forward, turn = forward + way.forward_m.sum(), turn + way.turn_rad.sum()
    assert forward == pytest.approx(whole.forward_m.sum(), abs=1e-12)
    assert turn == pytest.approx(whole.turn_rad.sum(), abs=1e-12)
    np.testing.assert_allclose(reached.wheel_rad, at_end.wheel_rad, atol=1e-12)
    assert len(tape.wheel_time_s) < 8 and len(tape.gyro_time_s) < 9


def test_beyond_the_last_sample_the_speed_holds_and_the_next_sample_makes_it_good() -> None:
    early, late = tape_of(1.0, 0.0, seconds=0.5), tape_of(1.0, 0.0)
    way, reached = travel(early, Reached(), 0.55, ROBOT)
    assert way.forward_m.sum() == pytest.approx(0.55, abs=5 * TICK_M)
    rest, _ = travel(late, reached, 0.9, ROBOT)
    whole, _ = travel(late, Reached(), 0.9, ROBOT)
    assert way.forward_m.sum() + rest.forward_m.sum() == pytest.approx(whole.forward_m.sum(), abs=1e-12)


def test_a_leaping_gyro_is_not_believed() -> None:
    calm, _ = travel(tape_of(1.0, 0.3), Reached(), 0.9, ROBOT)
    leaping, _ = travel(tape_of(1.0, 0.3, spike={40: 9.0, 60: -7.0}), Reached(), 0.9, ROBOT)
    tick_rad = 2 * TICK_M / ROBOT.wheel_separation_m
    assert leaping.turn_rad.sum() == pytest.approx(calm.turn_rad.sum(), abs=2 * tick_rad)


def test_without_a_gyro_the_wheels_turn_the_robot() -> None:
    tape = tape_of(1.0, 0.8)
    blind = Tape(wheel_time_s=tape.wheel_time_s, wheel_rad=tape.wheel_rad)
    way, _ = travel(blind, Reached(), 0.9, ROBOT)
    assert way.turn_rad.sum() == pytest.approx(0.72, abs=2 * TICK_M / ROBOT.wheel_separation_m)
    cut = Tape(
        wheel_time_s=tape.wheel_time_s,
        wheel_rad=tape.wheel_rad,
        gyro_time_s=tape.gyro_time_s[:30],
        gyro_radps=tape.gyro_radps[:30],
    )
    way, _ = travel(cut, Reached(), 0.9, ROBOT)
    assert way.turn_rad.sum() == pytest.approx(0.72, abs=2 * TICK_M / ROBOT.wheel_separation_m)


def test_a_wheel_that_slips_is_told_by_the_gyro() -> None:
    tape = tape_of(1.0, 0.0)
    slipping = tape.wheel_rad.copy()
    slipping[25:, 0] += 0.05 / ROBOT.wheel_radius_m
    slipped = Tape(
        wheel_time_s=tape.wheel_time_s,
        wheel_rad=slipping,
        gyro_time_s=tape.gyro_time_s,
        gyro_radps=tape.gyro_radps,
    )
    way, _ = travel(slipped, Reached(), 0.9, ROBOT)
    assert way.turn_rad.sum() == pytest.approx(0.0, abs=0.02)
    assert way.slip_m == pytest.approx(0.05, abs=4 * TICK_M)


def test_before_the_first_sample_it_stands() -> None:
    way, reached = travel(Tape(), Reached(), 0.05, ROBOT)
    assert way.forward_m.sum() == way.turn_rad.sum() == 0.0
    assert reached.time_s == 0.05
