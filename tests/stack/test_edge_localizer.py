"""The reference's localiser on the oracle's pictures, with a robot that differs from its nominal figures."""

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from floor_pictures import look, road_mount

from adc_bench.api import EncoderSamples, ImuSamples, Mission, Observation, Picture
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.edge_localizer import EdgeLocalizer, EdgeState
from adc_bench.stack.pose_filter import GYRO_BIAS, SCALE
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import SensorRig

LAP, ROBOT = Course().lap, RobotParams()
SPEED_MPS, PERIOD_S, STEPS, START_M = 1.5, 0.05, 85, 3.5
RADIUS_SCALE, BIAS_RADPS, TILT_RAD = 1.004, math.radians(0.6), (math.radians(0.25), math.radians(-0.2))
FAULT = range(35, 55)  # 1 s, from the straight into the bend
Change = Callable[[int, Observation], Observation]


def true_pose(step: int) -> Pose2:
    """Stand for half a second, then drive."""
    return LAP.pose(START_M + SPEED_MPS * PERIOD_S * max(0, step - 10))


@pytest.fixture(scope="module")
def observations() -> list[Observation]:
    """Return what the sensors say of a drive from the straight into the loop."""
    fine_s = 0.01
    poses = [LAP.pose(START_M + SPEED_MPS * max(0.0, k * fine_s - 0.5)) for k in range(5 * STEPS + 1)]
    moved = [a.inverse() @ b for a, b in itertools.pairwise(poses)]
    rng = np.random.default_rng(1)
    turns = np.array([step.yaw_rad for step in moved])
    forward = np.array([math.hypot(step.x_m, step.y_m) for step in moved])
    sides = np.stack([forward - turns * ROBOT.wheel_separation_m / 2, forward + turns * ROBOT.wheel_separation_m / 2])
    wheels = np.hstack([np.zeros((2, 1)), np.cumsum(sides, axis=1)]) / (ROBOT.wheel_radius_m * RADIUS_SCALE)
    ticks = np.floor(wheels * ROBOT.encoder_ticks_per_turn / (2 * math.pi)).astype(np.int64)
    rates = turns / fine_s + BIAS_RADPS + math.radians(0.1) * rng.standard_normal(len(turns))
    return [_observation(step, ticks, rates) for step in range(STEPS)]


def _observation(step: int, ticks: np.ndarray, rates: np.ndarray) -> Observation:
    fine = np.arange(max(0, 5 * step - 4), 5 * step + 1)
    wheel, gyro = fine[fine % 2 == 0], fine[fine > 0]
    rgb = look(true_pose(step), mount=road_mount(), pitch_error_rad=TILT_RAD[0], roll_error_rad=TILT_RAD[1], seed=step)
    time_s = step * PERIOD_S
    return Observation(
        step=step,
        time_s=time_s,
        pictures={"road": Picture(time_s=time_s, rgb=rgb)},
        encoders=EncoderSamples(time_s=wheel * 0.01, left_ticks=ticks[0, wheel], right_ticks=ticks[1, wheel]),
        imu=ImuSamples(time_s=gyro * 0.01, yaw_rate_radps=rates[gyro - 1], acceleration_x_mps2=np.zeros(len(gyro))),
    )


@pytest.fixture(scope="module")
def localizer() -> EdgeLocalizer:
    return EdgeLocalizer(
        Mission(
            name="test",
            laps=1,
            time_limit_s=100.0,
            control_period_s=PERIOD_S,
            latency_s=0.0,
            start_pose=true_pose(0),
            course=CourseSpec(),
            robot=ROBOT,
            rig=SensorRig(),
            options={},
        )
    )


def states(localizer: EdgeLocalizer, observations: list[Observation], change: Change) -> list[EdgeState]:
    state, found = localizer.start(), []
    for step, observation in enumerate(observations):
        state = localizer.step(state, change(step, observation))
        found.append(state)
    return found


def errors(found: list[EdgeState]) -> np.ndarray:
    """Return rows (distance in metres, yaw in radians) of error."""
    pairs = [(state.belief.pose, true_pose(step)) for step, state in enumerate(found)]
    return np.array(
        [(math.hypot(a.x_m - b.x_m, a.y_m - b.y_m), abs(wrap_rad(a.yaw_rad - b.yaw_rad))) for a, b in pairs]
    )


def unchanged(step: int, observation: Observation) -> Observation:
    return observation


def during(change: Callable[[Observation], Observation]) -> Change:
    return lambda step, observation: change(observation) if step in FAULT else observation


def with_picture(rgb: np.ndarray) -> Callable[[Observation], Observation]:
    return lambda o: replace(o, pictures={"road": Picture(time_s=o.time_s, rgb=rgb)})


def test_it_knows_where_it_is_and_what_its_sensors_hide(
    localizer: EdgeLocalizer, observations: list[Observation]
) -> None:
    found = states(localizer, observations, unchanged)
    error = errors(found)
    # The oracle's floor is drawn in cells of 5 mm.
    assert np.sqrt(np.mean(error[:, 0] ** 2)) < 0.005 and error[:, 0].max() < 0.012
    assert np.sqrt(np.mean(error[:, 1] ** 2)) < math.radians(0.15)
    assert all(state.fit for state in found)
    end = found[-1].now
    assert end.mean[GYRO_BIAS] == pytest.approx(BIAS_RADPS, abs=math.radians(0.2))
    assert end.mean[SCALE] == pytest.approx(RADIUS_SCALE - 1, abs=0.002)
    np.testing.assert_allclose(end.tilt_rad, TILT_RAD, atol=math.radians(0.1))


def test_a_step_leaves_its_state_and_says_the_same_twice(
    localizer: EdgeLocalizer, observations: list[Observation]
) -> None:
    before = states(localizer, observations[:15], unchanged)[-1]
    kept = before.now.mean.copy(), before.settled.covariance.copy()
    one, other = (localizer.step(before, observations[15]).now for _ in range(2))
    assert one.mean.tobytes() == other.mean.tobytes() and one.covariance.tobytes() == other.covariance.tobytes()
    np.testing.assert_array_equal(kept[0], before.now.mean)
    np.testing.assert_array_equal(kept[1], before.settled.covariance)


@pytest.mark.parametrize(
    "blind",
    [
        lambda o: replace(o, pictures={}),
        with_picture(np.zeros((240, 320, 3), dtype=np.uint8)),
        with_picture(np.random.default_rng(0).integers(0, 256, (240, 320, 3)).astype(np.uint8)),
        with_picture(np.full((240, 320, 3), 90, dtype=np.uint8)),
    ],
    ids=["none", "black", "noise", "fog"],
)
def test_a_second_without_sight_costs_centimetres_and_widens_the_doubt(
    localizer: EdgeLocalizer, observations: list[Observation], blind: Callable[[Observation], Observation]
) -> None:
    found = states(localizer, observations, during(blind))
    error = errors(found)
    assert error[:, 0].max() < 0.03
    assert error[-20:, 0].max() < 0.012
    assert not any(found[k].fit for k in FAULT)
    before, last, after = (
        np.trace(found[k].belief.covariance[:2, :2]) for k in (FAULT[0] - 1, FAULT[-1], FAULT[-1] + 5)
    )
    assert last > 2 * before and after < last / 2


def test_a_camera_that_is_stuck_is_not_believed(localizer: EdgeLocalizer, observations: list[Observation]) -> None:
    stuck = observations[FAULT[0]].pictures["road"].rgb
    found = states(localizer, observations, during(with_picture(stuck)))
    assert errors(found)[:, 0].max() < 0.03
    assert not any(found[k].fit for k in FAULT[1:])


def test_gyro_spikes_are_passed_over(localizer: EdgeLocalizer, observations: list[Observation]) -> None:
    def spike(step: int, o: Observation) -> Observation:
        rates = o.imu.yaw_rate_radps.copy()
        rates[2:3] = 9.0
        return replace(o, imu=replace(o.imu, yaw_rate_radps=rates)) if step in (40, 50) else o

    error = errors(states(localizer, observations, spike))
    assert error[:, 0].max() < 0.012 and error[:, 1].max() < math.radians(0.5)


@pytest.mark.parametrize("both", [0, 1], ids=["one wheel", "both wheels"])
def test_slipping_wheels_are_caught_by_the_pictures(
    localizer: EdgeLocalizer, observations: list[Observation], both: int
) -> None:
    """In half a second the wheels turn 12 cm too far."""

    def slip(step: int, o: Observation) -> Observation:
        extra = 10 * min(max(step - 40, 0), 10)
        wheels = replace(
            o.encoders,
            left_ticks=o.encoders.left_ticks + extra,
            right_ticks=o.encoders.right_ticks + both * extra,
        )
        return replace(o, encoders=wheels)

    assert errors(states(localizer, observations, slip))[:, 0].max() < 0.015


def test_without_a_gyro_the_wheels_do(localizer: EdgeLocalizer, observations: list[Observation]) -> None:
    none = np.empty(0)
    silent = ImuSamples(time_s=none, yaw_rate_radps=none, acceleration_x_mps2=none)
    error = errors(states(localizer, observations, during(lambda o: replace(o, imu=silent))))
    assert error[:, 0].max() < 0.015 and error[:, 1].max() < math.radians(1.0)


@pytest.mark.parametrize("late", [1, 4])
def test_late_pictures_correct_the_moment_they_show(
    localizer: EdgeLocalizer, observations: list[Observation], late: int
) -> None:
    def delayed(step: int, o: Observation) -> Observation:
        return replace(o, pictures=observations[step - late].pictures if step >= late else {})

    error = errors(states(localizer, observations, delayed))
    assert error[:, 0].max() < 0.02
    assert np.sqrt(np.mean(error[:, 0] ** 2)) < 0.007


def test_a_picture_from_before_the_horizon_is_left_out(
    localizer: EdgeLocalizer, observations: list[Observation]
) -> None:
    def stale(step: int, o: Observation) -> Observation:
        return replace(o, pictures=observations[step - 12].pictures if step >= 12 else {})

    assert not any(state.fit for state in states(localizer, observations[:40], stale))
