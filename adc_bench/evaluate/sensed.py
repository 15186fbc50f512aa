"""What the sensors delivered at one step, on its way to an agent: as the API's observation, or as a message."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan, Observation, Picture, SeenObject
from adc_bench.evaluate.protocol import ObservationMessage, PicturePlace, Scan
from adc_bench.evaluate.shelf import ReadShelf, WrittenShelf
from adc_bench.world.picture import decode_picture


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensed:
    """An observation with its pictures as the rig's JPEG files: (time_s, jpeg) by camera."""

    step: int
    time_s: float
    pictures: dict[str, tuple[float, bytes]]
    encoders: EncoderSamples
    imu: ImuSamples
    laser: LaserScan | None = None
    objects: tuple[SeenObject, ...] = ()


def observation_of(sensed: Sensed) -> Observation:
    """Return the observation as the API's record."""
    return Observation(
        step=sensed.step,
        time_s=sensed.time_s,
        pictures={name: Picture(time_s=time_s, rgb=_rgb(jpeg)) for name, (time_s, jpeg) in sensed.pictures.items()},
        encoders=sensed.encoders,
        imu=sensed.imu,
        laser=sensed.laser,
        objects=sensed.objects,
    )


def message_of(sensed: Sensed, shelf: WrittenShelf) -> ObservationMessage:
    """Return the observation as a message, its pictures laid on the shelf."""
    pictures = {}
    for name, (time_s, jpeg) in sensed.pictures.items():
        rgb = _rgb(jpeg)
        height, width, _ = rgb.shape
        pictures[name] = PicturePlace(time_s=time_s, offset=shelf.put(name, rgb), width=width, height=height)
    laser = sensed.laser
    return ObservationMessage(
        step=sensed.step,
        time_s=sensed.time_s,
        pictures=pictures,
        encoder_time_s=sensed.encoders.time_s.tolist(),
        left_ticks=sensed.encoders.left_ticks.tolist(),
        right_ticks=sensed.encoders.right_ticks.tolist(),
        imu_time_s=sensed.imu.time_s.tolist(),
        yaw_rate_radps=sensed.imu.yaw_rate_radps.tolist(),
        acceleration_x_mps2=sensed.imu.acceleration_x_mps2.tolist(),
        laser=Scan(time_s=laser.time_s, ranges_m=laser.ranges_m.tolist()) if laser else None,
        objects=sensed.objects,
    )


def observation_in(message: ObservationMessage, shelf: ReadShelf) -> Observation:
    """Return the observation that a message tells of, its pictures taken from the shelf."""
    laser = message.laser
    return Observation(
        step=message.step,
        time_s=message.time_s,
        pictures={n: Picture(time_s=place.time_s, rgb=shelf.take(place)) for n, place in message.pictures.items()},
        encoders=EncoderSamples(
            time_s=np.array(message.encoder_time_s, dtype=np.float64),
            left_ticks=np.array(message.left_ticks, dtype=np.int64),
            right_ticks=np.array(message.right_ticks, dtype=np.int64),
        ),
        imu=ImuSamples(
            time_s=np.array(message.imu_time_s, dtype=np.float64),
            yaw_rate_radps=np.array(message.yaw_rate_radps, dtype=np.float64),
            acceleration_x_mps2=np.array(message.acceleration_x_mps2, dtype=np.float64),
        ),
        laser=LaserScan(time_s=laser.time_s, ranges_m=np.array(laser.ranges_m, dtype=np.float64)) if laser else None,
        objects=message.objects,
    )


def _rgb(jpeg: bytes) -> NDArray[np.uint8]:
    rgb = decode_picture(jpeg)
    assert rgb is not None, "the renderer's own JPEG"
    return rgb
