import math

import numpy as np
import pytest
from bellman import least_time_s
from hypothesis import given, settings
from hypothesis import strategies as st

from adc_bench.geometry import Path, Pose2
from adc_bench.geometry.path import arc, line
from adc_bench.stack.reference_line import ReferenceLine, rounded
from adc_bench.stack.timetable import SpeedLimits, Timetable, fastest
from adc_bench.world.course import Course
from adc_bench.world.robot import ROBOTS, RobotParams

ORIGIN = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
NOMINAL = SpeedLimits.of(RobotParams())

pieces = st.lists(
    st.one_of(
        st.builds(line, st.floats(0.2, 3.0)),
        st.builds(arc, st.floats(0.4, 4.0), st.floats(-math.pi, math.pi).filter(lambda turn: abs(turn) > 0.1)),
    ),
    min_size=1,
    max_size=6,
)


def straight(length_m: float) -> ReferenceLine:
    return rounded(Path(start=ORIGIN, pieces=(line(length_m),)), 0.0, length_m)


def shares(timetable: Timetable, limits: SpeedLimits) -> dict[str, float]:
    """Return how much of each limit is used at the most, by plain differences."""
    speed, bend = timetable.speed_mps, timetable.line.curvature_pm
    gaps = np.diff(timetable.line.s_m)
    middle, middle_bend = (speed[1:] + speed[:-1]) / 2, (bend[1:] + bend[:-1]) / 2
    gain = np.diff(speed**2) / (2 * gaps)
    turn_gain = np.diff(bend) / gaps * middle**2 + middle_bend * gain
    return {
        "speed": float(speed.max()) / limits.speed_mps,
        "rim": float((speed * (1 + np.abs(bend) * limits.half_separation_m)).max()) / limits.rim_speed_mps,
        "turn": float(np.abs(speed * bend).max()) / limits.turn_rate_radps,
        "gain": float(np.abs(gain).max()) / limits.acceleration_mps2,
        "turn gain": float(np.abs(turn_gain).max()) / limits.turn_acceleration_radps2,
        "side": float((np.abs(bend) * speed**2).max()) / limits.side_mps2,
    }


@settings(max_examples=60, deadline=None)
@given(pieces, st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.sampled_from(sorted(ROBOTS)))
def test_every_limit_holds(parts: list, start_mps: float, end_mps: float, robot: str) -> None:
    path = Path(start=ORIGIN, pieces=tuple(parts))
    limits = SpeedLimits.of(ROBOTS[robot])
    timetable = fastest(rounded(path, 0.0, path.length_m), limits, start_mps, end_mps)
    used = shares(timetable, limits)
    assert max(used.values()) < 1.01, used
    assert timetable.speed_mps[0] <= start_mps and timetable.speed_mps[-1] <= end_mps


@settings(max_examples=30, deadline=None)
@given(pieces)
def test_nowhere_can_it_go_faster(parts: list) -> None:
    path = Path(start=ORIGIN, pieces=tuple(parts))
    timetable = fastest(rounded(path, 0.0, path.length_m), NOMINAL)
    for k in range(1, len(timetable.speed_mps) - 1, 7):
        speeds = timetable.speed_mps.copy()
        speeds[k] *= 1.05
        used = shares(Timetable(line=timetable.line, speed_mps=speeds), NOMINAL)
        assert max(used.values()) > 1.0


@pytest.mark.parametrize("length_m", [0.5, 2.0, 10.0])
def test_a_straight_takes_the_time_of_full_throttle_and_full_brake(length_m: float) -> None:
    a, top = NOMINAL.acceleration_mps2, NOMINAL.speed_mps
    wanted_s = 2 * math.sqrt(length_m / a) if length_m < top**2 / a else top / a + length_m / top
    assert fastest(straight(length_m), NOMINAL).time_s[-1] == pytest.approx(wanted_s, rel=1e-3)


@pytest.mark.parametrize(("robot", "steering_share"), [("pioneer", 0.1), ("pioneer", 0.75), ("pioneer-stock", 0.75)])
def test_no_plan_over_places_and_speeds_is_faster(robot: str, steering_share: float) -> None:
    pieces = (line(1.0), arc(0.7, 1.5), arc(0.5, -1.5), line(1.0))
    path = Path(start=ORIGIN, pieces=pieces)
    road = rounded(path, 0.0, path.length_m)
    limits = SpeedLimits.of(ROBOTS[robot], steering_share=steering_share)
    found_s = fastest(road, limits, end_mps=math.inf).time_s[-1]
    assert 0.99 < least_time_s(road, limits, start_mps=0.0, step_m=0.01) / found_s < 1.02


def test_nor_on_the_lap() -> None:
    lap = Course().lap
    road = rounded(lap, -0.65, 10.0)
    found_s = fastest(road, NOMINAL, end_mps=math.inf).time_s[-1]
    assert least_time_s(road, NOMINAL, start_mps=0.0) == pytest.approx(found_s, rel=1e-3)


def test_place_and_speed_belong_together() -> None:
    timetable = fastest(straight(4.0), NOMINAL)
    for time_s in (0.3, 0.8, 1.4, 2.5):
        rate = (timetable.place(time_s + 0.02) - timetable.place(time_s - 0.02)) / 0.04
        assert timetable.speed(timetable.place(time_s)) == pytest.approx(rate, rel=0.03)
    assert timetable.speed(-1.0) == timetable.speed(99.0) == 0.0
    assert timetable.speed(0.0025) == pytest.approx(math.sqrt(2 * 2.0 * 0.0025))


def test_the_lap_is_driven_at_full_speed_but_for_start_and_stop() -> None:
    lap = Course().lap
    timetable = fastest(rounded(lap, -0.65, 2 * lap.length_m + 1.8), NOMINAL)
    assert (timetable.speed_mps > 2.19).mean() > 0.95
    finish_s = np.interp(2 * lap.length_m, timetable.line.path_s_m, timetable.time_s)
    assert 37.5 < finish_s < 37.7


def test_less_grip_and_a_wished_speed_slow_it() -> None:
    lap = Course().lap
    road = rounded(lap, 0.0, lap.length_m)
    ice = fastest(road, SpeedLimits.of(RobotParams(friction=0.1)))
    assert np.max(np.abs(road.curvature_pm) * ice.speed_mps**2) <= 0.5 * 0.1 * 9.81 * 0.8 * 1.001
    assert fastest(road, SpeedLimits.of(RobotParams(), speed_mps=0.7)).speed_mps.max() == 0.7
