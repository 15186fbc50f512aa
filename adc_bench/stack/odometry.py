"""Encoder ticks -> wheel speeds -> the filter's prediction, up to any moment between two samples."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples
from adc_bench.stack.ekf import Belief, WheelModel, predict

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class WheelTrack:
    """How far the wheels have turned as the belief knows it: `turned_rad` (2,) at `time_s`; and the last encoder sample
    with the speeds (2,) that led to it. Wheels are [left, right].
    """

    time_s: float
    turned_rad: Array
    sample_time_s: float
    sample_rad: Array
    speed_radps: Array


def advance(
    belief: Belief,
    track: WheelTrack | None,
    samples: EncoderSamples,
    until_s: float,
    model: WheelModel,
    ticks_per_turn: int,
) -> tuple[Belief, WheelTrack | None]:
    """Return belief and track at `until_s`, every sample up to it used, the last speed held beyond the last sample.

    What was held too long or too short is made good by the next sample: each step turns the wheels from where the
    belief has them to where the encoder says they are. `track` is None before the first sample.
    """
    readings = np.stack([samples.left_ticks, samples.right_ticks], axis=1) * (2 * math.pi / ticks_per_turn)
    for time_s, reading in zip(samples.time_s.tolist(), readings, strict=True):
        if track is None:
            track = WheelTrack(
                time_s=time_s,
                turned_rad=reading,
                sample_time_s=time_s,
                sample_rad=reading,
                speed_radps=np.zeros(2),
            )
        if time_s > track.sample_time_s:
            belief, track = _take_sample(belief, track, time_s, reading, model)
    if track is not None and until_s > track.time_s:
        belief, track = _turn_to(
            belief, track, until_s, track.turned_rad + track.speed_radps * (until_s - track.time_s), model
        )
    return belief, track


def _take_sample(
    belief: Belief, track: WheelTrack, time_s: float, reading: Array, model: WheelModel
) -> tuple[Belief, WheelTrack]:
    speed = (reading - track.sample_rad) / (time_s - track.sample_time_s)
    if time_s > track.time_s:
        belief, track = _turn_to(belief, track, time_s, reading, model)
    return belief, replace(track, sample_time_s=time_s, sample_rad=reading, speed_radps=speed)


def _turn_to(
    belief: Belief, track: WheelTrack, time_s: float, turned_rad: Array, model: WheelModel
) -> tuple[Belief, WheelTrack]:
    dt_s = time_s - track.time_s
    belief = predict(belief, (turned_rad - track.turned_rad) / dt_s, dt_s, model)
    return belief, replace(track, time_s=time_s, turned_rad=turned_rad)
