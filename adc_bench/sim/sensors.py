"""Encoders, gyro and accelerometer: exact grids in time, late by their latency, errors from named random streams."""

import math

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples, ImuSamples
from adc_bench.geometry import wrap_array_rad
from adc_bench.sim.delivery import Delivery
from adc_bench.sim.surfaces import GRAVITY_MPS2
from adc_bench.world.sensors import EncoderSpec, ImuSpec
from adc_bench.world.streams import stream

Array = NDArray[np.float64]
_UP_MPS2 = np.array([0.0, 0.0, GRAVITY_MPS2])  # what an accelerometer feels at rest


class Encoders:
    """Two incremental encoders: cumulative ticks since time 0, from wheel angles that are known up to whole turns."""

    def __init__(self, seed: int, spec: EncoderSpec, ticks_per_turn: int, angles_rad: Array) -> None:
        self._ticks_per_rad = ticks_per_turn / (2 * math.pi)
        # Where the wheels stood between two marks at the start.
        self._turned_rad = stream(seed, "sim", "encoder_phase").uniform(0.0, 1 / self._ticks_per_rad, size=2)
        self._last_rad = angles_rad
        self._rows: Delivery[tuple[float, Array]] = Delivery(spec.latency_s)

    def follow(self, angles_rad: Array) -> None:
        """Take note of the wheels' angles (2,); a wheel must not turn by half a turn between two calls."""
        self._turned_rad = self._turned_rad + wrap_array_rad(angles_rad - self._last_rad)
        self._last_rad = angles_rad

    def sample(self, time_s: float) -> None:
        """Record a reading."""
        self._rows.put(time_s, (time_s, np.floor(self._turned_rad * self._ticks_per_rad)))

    def read(self, now_s: float) -> EncoderSamples:
        """Return the readings that have arrived since the last call."""
        rows = self._rows.take(now_s)
        ticks = np.array([row[1] for row in rows], dtype=np.int64).reshape(-1, 2)
        return EncoderSamples(
            time_s=np.array([row[0] for row in rows], dtype=np.float64),
            left_ticks=ticks[:, 0].copy(),
            right_ticks=ticks[:, 1].copy(),
        )


class Imu:
    """A gyro about the robot's z and an accelerometer along its x, midway between the wheels.

    A sample is the mean over its period, so that the gyro's samples without their errors add up to the yaw turned.
    """

    def __init__(self, seed: int, spec: ImuSpec, gyro_bias_radps: float, rotation: Array, velocity_mps: Array) -> None:
        self._spec, self._period_s = spec, 1 / spec.rate_hz
        self._gyro_noise, self._gyro_walk = stream(seed, "sim", "gyro_noise"), stream(seed, "sim", "gyro_walk")
        self._acceleration_noise = stream(seed, "sim", "acceleration_noise")
        self._gyro_bias_radps = gyro_bias_radps
        bias = stream(seed, "sim", "acceleration_bias").standard_normal()
        self._acceleration_bias_mps2 = spec.acceleration_bias_mps2 * bias
        self._last_rotation, self._last_velocity_mps = rotation, velocity_mps
        self._rows: Delivery[tuple[float, float, float]] = Delivery(spec.latency_s)

    def sample(self, time_s: float, rotation: Array, velocity_mps: Array) -> None:
        """Record a reading, from the attitude (3, 3) and the origin's velocity (3,) in the world at its end."""
        spec = self._spec
        turn = self._last_rotation.T @ rotation
        yaw_rate_radps = math.atan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]) / self._period_s
        felt_mps2 = rotation.T @ ((velocity_mps - self._last_velocity_mps) / self._period_s + _UP_MPS2)
        self._last_rotation, self._last_velocity_mps = rotation, velocity_mps
        yaw_rate_radps += self._gyro_bias_radps + spec.gyro_noise_radps * self._gyro_noise.standard_normal()
        noise_mps2 = spec.acceleration_noise_mps2 * self._acceleration_noise.standard_normal()
        felt_x_mps2 = felt_mps2[0] + self._acceleration_bias_mps2 + noise_mps2
        self._rows.put(time_s, (time_s, yaw_rate_radps, felt_x_mps2))
        walk_radps = spec.gyro_walk_radps_sqrts * math.sqrt(self._period_s)
        self._gyro_bias_radps += walk_radps * self._gyro_walk.standard_normal()

    def read(self, now_s: float) -> ImuSamples:
        """Return the readings that have arrived since the last call."""
        rows = np.array(self._rows.take(now_s), dtype=np.float64).reshape(-1, 3)
        return ImuSamples(
            time_s=rows[:, 0].copy(), yaw_rate_radps=rows[:, 1].copy(), acceleration_x_mps2=rows[:, 2].copy()
        )
