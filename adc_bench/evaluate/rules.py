"""The figures that a score rests on, as one frozen record whose digest stands in every result."""

import msgspec

from adc_bench.evaluate.limits import Limits
from adc_bench.sim import DYNAMICS, DynamicsSpec
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import CourseSpec
from adc_bench.world.robot import RobotParams
from adc_bench.world.sensors import SensorRig


class Points(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Points of a run. The first five are the published referee's; the rest are this benchmark's own.

    A run earns `half_lap` for each pass of the crosswalk and, when all laps are driven, the seconds by which it beat
    `half_lap_par_s` a half lap (negative when slower). Penalties are subtracted; a run has at least 0 points.
    """

    half_lap: float = 50.0
    half_lap_par_s: float = 35.0
    line_touch: float = 10.0
    off_road: float = 20.0
    false_start: float = 60.0  # the published charge for passing a panel that shows stop
    wrong_way: float = 25.0
    collision: float = 20.0


class Factors(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The driving score is 100 x completion x one factor for each fault."""

    line_touch: float = 0.95
    off_road: float = 0.80
    false_start: float = 0.70
    wrong_way: float = 0.80
    collision: float = 0.70


class Rules(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that decides a score beside the suite."""

    id: str = "adc-bench-1"
    control_period_s: float = 0.05
    start_x_m: float = -0.65
    limits: Limits = Limits()
    touch_gap_s: float = 2.0  # a wheel on a line is a new touch after this long without one
    false_start_m: float = 0.05
    blocked_progress_m: float = 0.10
    wrong_way_m: float = 1.0
    collision_gap_s: float = 1.0  # contacts with one object closer in time are one collision
    points: Points = Points()
    factors: Factors = Factors()
    course: CourseSpec = CourseSpec()
    arena: ArenaSpec = ArenaSpec()
    robot: RobotParams = RobotParams()
    rig: SensorRig = SensorRig()
    dynamics: DynamicsSpec = DYNAMICS


RULES = Rules()
