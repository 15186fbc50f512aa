"""The figures that a score rests on, as one frozen record whose digest stands in every result."""

import msgspec

from adc_bench.evaluate.faults import Prices
from adc_bench.evaluate.limits import Limits
from adc_bench.sim import DYNAMICS, DynamicsSpec
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import CourseSpec
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import SensorRig


class Earnings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a run earns: all published (adc.md 4) but a sign read, which is our own.

    `half_lap` for each half lap driven as ordered and, when all laps are driven, the seconds by which that took less
    than `half_lap_par_s` a half lap (negative when more).
    """

    half_lap: float = 50.0
    half_lap_par_s: float = 35.0
    parked: float = 60.0
    sign_read: float = 10.0


class Rules(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that decides a score beside the suite. docs/rules.md says in words how the figures are used."""

    id: str = "adc-bench-2"
    control_period_s: float = 0.05
    limits: Limits = Limits()
    touch_gap_s: float = 2.0  # a wheel on a line is a new touch after this long without one
    false_start_m: float = 0.05
    blocked_m: float = 0.10  # a robot that stays in a circle of this radius gets nowhere
    wrong_way_m: float = 1.0  # back along the lane
    wrong_lane_m: float = 6.0  # at a stretch in the lane of the other direction
    still_mps: float = 0.02  # slower is standing still
    still_radps: float = 0.05
    stop_s: float = 2.0  # to stand before the stop line
    stop_zone_m: float = 0.60  # from the robot's nose to the stop line, at most
    stop_near_m: float = 3.0  # standing this near is a stop, though outside the zone
    park_s: float = 5.0  # to stand in a place
    sign_ahead_m: float = 4.0  # a vertical sign's report counts from here before it
    sign_beyond_m: float = 1.0  # to here behind it
    collision_gap_s: float = 1.0  # contacts with one object closer in time are one collision
    believed_score: float = 0.5  # detections with this score or more count for precision, recall and corners
    earnings: Earnings = Earnings()
    prices: Prices = Prices()
    course: CourseSpec = CourseSpec()
    arena: ArenaSpec = ArenaSpec()
    robot: RobotParams = RobotParams()
    rig: SensorRig = SensorRig()
    dynamics: DynamicsSpec = DYNAMICS


RULES = Rules()
