"""Where boxes take lanes, and the offsets that pass them."""

import numpy as np
import pytest

from adc_bench.stack.lane_change import ChangeParams, Taken, offsets, stop_m, taken

PARAMS = ChangeParams()
PITCH_M = 0.775
S = np.arange(0.0, 20.0, 0.01)
BOX = Taken(from_m=9.7, to_m=10.3)


def box_points(s_m: float, offset_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a box's front and its right side."""
    side = np.linspace(-0.3, 0.3, 13)
    s = np.concatenate([np.full(13, s_m - 0.3), s_m + side])
    return s, np.concatenate([offset_m + side, np.full(13, offset_m - 0.3)])


def test_a_box_takes_its_own_lane_only() -> None:
    s, offset = box_points(10.0, 0.05)
    (found,) = taken(s, offset, 0.0, PARAMS)
    assert found.from_m == pytest.approx(9.7) and found.to_m == pytest.approx(10.3)
    assert taken(s, offset, PITCH_M, PARAMS) == ()


def test_a_tunnel_s_wall_takes_no_lane() -> None:
    s = np.linspace(5.0, 9.0, 80)
    for offset_m in (0.3875 - 0.85, 0.3875 + 0.85):
        for lane_m in (0.0, PITCH_M):
            assert taken(s, np.full_like(s, offset_m), lane_m, PARAMS) == ()


def test_behind_a_front_that_is_all_one_sees_a_whole_box_is_supposed() -> None:
    (found,) = taken(np.full(5, 4.0), np.linspace(-0.2, 0.2, 5), 0.0, PARAMS)
    assert found.to_m - found.from_m == pytest.approx(PARAMS.box_length_m)


def test_two_boxes_in_a_row_are_two_stretches() -> None:
    s = np.concatenate([box_points(4.0, 0.0)[0], box_points(10.0, 0.0)[0]])
    assert len(taken(s, np.zeros_like(s), 0.0, PARAMS)) == 2


def test_the_robot_is_in_the_other_lane_beside_the_box_and_in_its_own_elsewhere() -> None:
    aside = offsets(S, (BOX,), PITCH_M, PARAMS)
    beside = (BOX.from_m < S) & (BOX.to_m > S)
    np.testing.assert_allclose(aside[beside], PITCH_M)
    nose = (BOX.from_m - PARAMS.nose_m - 0.01 < S) & (BOX.to_m + PARAMS.nose_m + 0.01 > S)
    assert aside[nose].min() > 0.3 + 0.19 + 0.1
    away = np.abs(S - 10.0) > 0.3 + PARAMS.before_m + PARAMS.change_m
    assert np.all(aside[away] == 0.0)


def test_the_change_bends_gently() -> None:
    """5.77 h / L^2 is the greatest second derivative of the smooth step over L by h."""
    bend = np.gradient(np.gradient(offsets(S, (BOX,), PITCH_M, PARAMS), S), S)
    assert np.abs(bend).max() < 5.8 * PITCH_M / PARAMS.change_m**2
    assert np.abs(np.diff(bend)).max() < 0.2


def test_it_stops_only_where_both_lanes_are_taken() -> None:
    beside, clear = Taken(from_m=9.0, to_m=9.6), Taken(from_m=12.7, to_m=13.3)
    assert stop_m((BOX,), (), PARAMS) is None
    assert stop_m((BOX,), (clear,), PARAMS) is None
    assert stop_m((), (beside,), PARAMS) is None
    assert stop_m((BOX,), (beside,), PARAMS) == pytest.approx(BOX.from_m - PARAMS.stop_before_m)
