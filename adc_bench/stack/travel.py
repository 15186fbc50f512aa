"""Encoders and gyro as one record of the way: kept for a while, and read out between any two moments."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples, ImuSamples
from adc_bench.stack.pose_filter import Travel
from adc_bench.world.robot import RobotParams

Array = NDArray[np.float64]
SAME_S = 1e-6
GYRO_GAP_S = 0.015  # a gyro sample speaks for at most this long
SPIKE_RADPS = 2.0  # a gyro so far from the wheels is not believed; a tick of one wheel in 20 ms is 0.2 rad/s
TICKS_OF_DOUBT = 3.0  # wheels and gyro may differ by so many ticks


@dataclass(frozen=True, kw_only=True, eq=False)
class Tape:
    """What encoders and gyro said lately: times (n,), wheel angles [left, right] (n, 2); times (m,), rates (m,)."""

    wheel_time_s: Array = field(default_factory=lambda: np.empty(0))
    wheel_rad: Array = field(default_factory=lambda: np.empty((0, 2)))
    gyro_time_s: Array = field(default_factory=lambda: np.empty(0))
    gyro_radps: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Reached:
    """A moment of the way, and how far the wheels had turned by it, as was believed then; None before they spoke."""

    time_s: float = 0.0
    wheel_rad: Array | None = None


def record(tape: Tape, encoders: EncoderSamples, imu: ImuSamples, robot: RobotParams) -> Tape:
    """Return the tape with new samples."""
    per_tick = 2 * math.pi / robot.encoder_ticks_per_turn
    ticks = np.stack([encoders.left_ticks, encoders.right_ticks], axis=1)
    return Tape(
        wheel_time_s=np.concatenate([tape.wheel_time_s, encoders.time_s]),
        wheel_rad=np.concatenate([tape.wheel_rad, ticks * per_tick]),
        gyro_time_s=np.concatenate([tape.gyro_time_s, imu.time_s]),
        gyro_radps=np.concatenate([tape.gyro_radps, imu.yaw_rate_radps]),
    )


def forget(tape: Tape, before_s: float) -> Tape:
    """Return the tape without what was before a moment, but for the last two samples of the wheels."""
    wheels = max(0, min(int(np.searchsorted(tape.wheel_time_s, before_s)), len(tape.wheel_time_s)) - 2)
    gyro = int(np.searchsorted(tape.gyro_time_s, before_s - SAME_S))
    return Tape(
        wheel_time_s=tape.wheel_time_s[wheels:],
        wheel_rad=tape.wheel_rad[wheels:],
        gyro_time_s=tape.gyro_time_s[gyro:],
        gyro_radps=tape.gyro_radps[gyro:],
    )


def travel(tape: Tape, reached: Reached, until_s: float, robot: RobotParams) -> tuple[Travel, Reached]:
    """Return what was travelled from a moment to a later one, and the later moment.

    Beyond the last encoder sample the last speed holds; what was held too long or too short is made good by the next
    reading, which counts from the wheels' angles that were believed. Where the gyro is silent or leaps, the wheels'
    turn stands in.
    """
    inner = tape.gyro_time_s[(tape.gyro_time_s > reached.time_s + SAME_S) & (tape.gyro_time_s < until_s - SAME_S)]
    times = np.concatenate([[reached.time_s], inner, [until_s]])
    wheels = _wheels_at(tape, times, reached)
    turned_m = np.diff(wheels, axis=0) * robot.wheel_radius_m
    by_wheels = (turned_m[:, 1] - turned_m[:, 0]) / robot.wheel_separation_m
    turn = _turn(tape, times, by_wheels)
    tick_m = 2 * math.pi / robot.encoder_ticks_per_turn * robot.wheel_radius_m
    apart_m = abs(float(by_wheels.sum() - turn.sum())) * robot.wheel_separation_m
    way = Travel(
        duration_s=np.diff(times),
        forward_m=turned_m.mean(axis=1),
        turn_rad=turn,
        slip_m=max(0.0, apart_m - TICKS_OF_DOUBT * tick_m),
    )
    return way, Reached(time_s=until_s, wheel_rad=wheels[-1])


def _wheels_at(tape: Tape, times: Array, reached: Reached) -> Array:
    """Return the wheels' angles (n, 2) at times (n,) from `reached` on."""
    if not len(tape.wheel_time_s):
        return np.zeros((len(times), 2))
    start_rad = tape.wheel_rad[0] if reached.wheel_rad is None else reached.wheel_rad
    later = tape.wheel_time_s > reached.time_s + SAME_S
    knots_s = np.concatenate([[reached.time_s], tape.wheel_time_s[later]])
    angles = np.concatenate([start_rad[None], tape.wheel_rad[later]])
    beyond_s = times[-1] - knots_s[-1]
    if beyond_s > 0 and len(tape.wheel_time_s) > 1:
        speed = (tape.wheel_rad[-1] - tape.wheel_rad[-2]) / (tape.wheel_time_s[-1] - tape.wheel_time_s[-2])
        knots_s = np.append(knots_s, times[-1])
        angles = np.concatenate([angles, angles[-1:] + speed * beyond_s])
    return np.stack([np.interp(times, knots_s, angles[:, k]) for k in (0, 1)], axis=1)


def _turn(tape: Tape, times: Array, by_wheels: Array) -> Array:
    """Return the turns (n,) between times (n + 1,): the gyro's, or the wheels' (n,) where it is silent or leaps.

    A sample of the gyro is the mean since the one before.
    """
    if not len(tape.gyro_time_s):
        return by_wheels
    duration_s, ends_s = np.diff(times), times[1:]
    index = np.minimum(np.searchsorted(tape.gyro_time_s, ends_s - SAME_S), len(tape.gyro_time_s) - 1)
    by_gyro = tape.gyro_radps[index] * duration_s
    speaks = np.abs(tape.gyro_time_s[index] - ends_s) < GYRO_GAP_S
    mean_radps = by_wheels.sum() / duration_s.sum()
    calm = np.abs(by_gyro - mean_radps * duration_s) < SPIKE_RADPS * duration_s
    return np.where(speaks & calm, by_gyro, by_wheels)
