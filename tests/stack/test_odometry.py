import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from adc_bench.api import EncoderSamples
from adc_bench.geometry import Pose2
from adc_bench.stack.ekf import Belief, WheelModel, start_belief
from adc_bench.stack.odometry import WheelTrack, advance

MODEL, TICKS = WheelModel(radius_m=0.0975, separation_m=0.33), 500
START = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)


def samples(times: np.ndarray, left_radps: float, right_radps: float, offset: int = 0) -> EncoderSamples:
    per_rad = TICKS / (2 * math.pi)
    return EncoderSamples(
        time_s=times,
        left_ticks=np.floor(times * left_radps * per_rad).astype(np.int64) + offset,
        right_ticks=np.floor(times * right_radps * per_rad).astype(np.int64) + offset,
    )


def drive(all_samples: EncoderSamples, steps: np.ndarray) -> tuple[Belief, WheelTrack | None]:
    """Advance to each of the times, handing over what came since the last."""
    belief, track, last = start_belief(START), None, -1.0
    for until in steps:
        now = (all_samples.time_s > last + 1e-9) & (all_samples.time_s <= until + 1e-9)
        part = EncoderSamples(
            time_s=all_samples.time_s[now],
            left_ticks=all_samples.left_ticks[now],
            right_ticks=all_samples.right_ticks[now],
        )
        belief, track = advance(belief, track, part, float(until), MODEL, TICKS)
        last = until
    return belief, track


def test_a_circle_is_integrated_to_the_encoders_resolution() -> None:
    v, omega = 1.0, 0.4
    left, right = ((v + sign * omega * 0.33 / 2) / 0.0975 for sign in (-1, 1))
    times = np.arange(0, 10.01, 0.02)
    belief, track = drive(samples(times, left, right, offset=-777), np.arange(0, 10.01, 0.05))
    radius, angle = v / omega, omega * 10.0
    wanted = [radius * math.sin(angle), radius * (1 - math.cos(angle)), angle - 2 * math.pi]
    np.testing.assert_allclose(belief.mean, wanted, atol=0.015)
    assert track is not None and abs(track.time_s - 10.0) < 1e-6


@given(st.floats(0.011, 0.09))
@settings(max_examples=20)
def test_the_estimate_does_not_depend_on_when_it_is_asked_for(step_s: float) -> None:
    times = np.arange(0, 3.01, 0.02)
    taken = samples(times, 9.0, 11.0)
    often, _ = drive(taken, np.append(np.arange(0, 3.0, step_s), 3.0))
    once, _ = drive(taken, np.array([3.0]))
    np.testing.assert_allclose(often.mean, once.mean, atol=1e-3)


def test_between_samples_the_last_speed_is_held() -> None:
    times = np.array([0.0, 0.02, 0.04])
    belief, _ = drive(samples(times, 10.0, 10.0), np.array([0.04, 0.05]))
    assert 0.97 * 0.04 < belief.mean[0] < 0.97 * 0.056


def test_without_samples_nothing_moves() -> None:
    none = EncoderSamples(time_s=np.array([]), left_ticks=np.array([], int), right_ticks=np.array([], int))
    belief, track = advance(start_belief(START), None, none, 1.0, MODEL, TICKS)
    assert track is None
    np.testing.assert_array_equal(belief.mean, [0, 0, 0])
