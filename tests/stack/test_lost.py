"""A robot that is not where it believes to be: guesses, more doubt and less speed, and its place found again."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from faulted_drive import LAP, Drive, Eyes, drive, mission, world_of

from adc_bench.geometry import Pose2
from adc_bench.stack import Driver
from adc_bench.stack.caution import CautionParams, carefully
from adc_bench.stack.conduct import AfterArrow
from adc_bench.stack.edge_localizer import EdgeLocalizer
from adc_bench.stack.lost import LostParams, guessed, next_guesses
from adc_bench.stack.pilots import LinePilot
from adc_bench.stack.pose_filter import StartSpread, start_estimate

PARAMS, START_M, SPEED_MPS = LostParams(), 2.5, 2.2


def displaced(aside_m: float, along_m: float, turn_rad: float, seconds: float) -> Drive:
    """Drive a robot that was put down so far from where it is told to start."""
    told, eyes = mission(START_M), Eyes()
    put = told.start_pose @ Pose2(x_m=along_m, y_m=aside_m, yaw_rad=turn_rad)
    agent = Driver(
        eyes.detect,
        lambda task: EdgeLocalizer(mission=task),
        lambda task: AfterArrow(pilot=LinePilot(mission=task, speed_mps=SPEED_MPS)),
        carefully,
    )
    return drive(agent, told, world_of(msgspec.structs.replace(told, start_pose=put)), eyes, seconds)


@pytest.mark.parametrize(
    ("aside_m", "along_m", "turn_deg"), [(0.15, 0.3, 0.0), (-0.2, 0.0, 10.0)], ids=["far off", "turned away"]
)
def test_put_down_elsewhere_it_goes_slowly_until_it_has_found_its_place(
    aside_m: float, along_m: float, turn_deg: float
) -> None:
    run = displaced(aside_m, along_m, math.radians(turn_deg), 4.0)
    found_s = run.time_s[np.flatnonzero(run.position_error_m > 0.03)[-1]]
    assert found_s < 2.0
    lost = run.time_s < found_s
    assert max(command.v_mps for command, so in zip(run.commands, lost, strict=True) if so) < 0.7 * SPEED_MPS
    assert run.aside_m.max() < 0.35 and run.aside_m[-5:].max() < 0.05
    assert run.commands[-1].v_mps > 0.95 * SPEED_MPS


def test_every_guess_comes_in_turn_the_nearest_first() -> None:
    assert next_guesses(PARAMS.pictures - 1, PARAMS) == ()
    rounds = [next_guesses(PARAMS.pictures + k, PARAMS) for k in range(100)]
    tried = [guess for batch in rounds for guess in batch]
    assert tried[0] == Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    corner = Pose2(x_m=PARAMS.reach_m, y_m=-PARAMS.reach_m, yaw_rad=PARAMS.reach_rad)
    near = Pose2(x_m=0.0, y_m=PARAMS.step_m, yaw_rad=0.0)
    assert tried.index(near) < tried.index(corner)
    assert len(set(tried)) == 9 * 9 * 7


def test_a_guess_moves_the_pose_and_nothing_else() -> None:
    before = start_estimate(LAP.pose(30.0), StartSpread())
    after = guessed(before, Pose2(x_m=0.1, y_m=-0.2, yaw_rad=0.1))
    assert after.belief.pose.inverse() @ before.belief.pose != Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0)
    seen = before.belief.pose.inverse() @ after.belief.pose
    assert (seen.x_m, seen.y_m, seen.yaw_rad) == pytest.approx((0.1, -0.2, 0.1))
    np.testing.assert_array_equal(after.mean[3:], before.mean[3:])
    np.testing.assert_array_equal(after.covariance, before.covariance)


def test_the_more_doubt_the_less_speed_and_never_none() -> None:
    p, belief = CautionParams(), start_estimate(LAP.pose(0.0), StartSpread()).belief

    def share(sd_m: float) -> float:
        return carefully(replace(belief, covariance=np.diag(np.square([sd_m, sd_m / 2, 0.1]))))

    shares = [share(sd_m) for sd_m in np.linspace(0.0, 1.0, 101)]
    assert shares == sorted(shares, reverse=True)
    assert share(p.sure_m * 0.99) == 1.0 and share(p.lost_m) == shares[-1] == p.least_share > 0.0
