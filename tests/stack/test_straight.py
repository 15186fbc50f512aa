import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.straight import see_straight


def lane(yaw_rad: float, middle_m: float, noise_m: float = 0.0) -> dict[float, np.ndarray]:
    rng = np.random.default_rng(3)
    direction = np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
    normal = np.array([-math.sin(yaw_rad), math.cos(yaw_rad)])
    along = np.linspace(0.7, 2.1, 15)[:, None]
    return {
        offset: along * direction + (middle_m + offset) * normal + noise_m * rng.standard_normal((len(along), 2))
        for offset in (-0.3875, 0.3875)
    }


@given(st.floats(-0.4, 0.4), st.floats(-0.3, 0.3))
def test_direction_and_distance_are_recovered(birds_eye: BirdsEye, yaw_rad: float, middle_m: float) -> None:
    fit = see_straight(lane(yaw_rad, middle_m), birds_eye)
    assert fit is not None
    np.testing.assert_allclose(fit.parameters, [yaw_rad + math.pi / 2, middle_m], atol=1e-6)
    np.testing.assert_allclose(fit.tilt_rad, 0, atol=1e-6)


def test_one_line_of_two_will_do(birds_eye: BirdsEye) -> None:
    both = lane(0.1, 0.05, noise_m=0.003)
    fit = see_straight({-0.3875: both[-0.3875]}, birds_eye)
    assert fit is not None
    np.testing.assert_allclose(fit.parameters, [0.1 + math.pi / 2, 0.05], atol=0.02)


def test_outliers_weigh_little(birds_eye: BirdsEye) -> None:
    lines = lane(0.0, 0.1, noise_m=0.002)
    lines[0.3875][4] += (0.0, 0.2)
    fit = see_straight(lines, birds_eye)
    assert fit is not None
    np.testing.assert_allclose(fit.parameters, [math.pi / 2, 0.1], atol=0.01)


def test_few_short_or_bent_points_are_refused(birds_eye: BirdsEye) -> None:
    lines = lane(0.0, 0.0)
    assert see_straight({-0.3875: lines[-0.3875][:4]}, birds_eye) is None
    assert see_straight({offset: points[:4] for offset, points in lines.items()}, birds_eye) is None
    bent = {
        offset: points + np.column_stack([np.zeros(15), 0.2 * points[:, 0] ** 2]) for offset, points in lines.items()
    }
    assert see_straight(bent, birds_eye) is None
