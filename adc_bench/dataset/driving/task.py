"""What a driver has been told, and the making of a leg from it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.drive_recipe import Behaviour
from adc_bench.dataset.driving.floor import passes_m
from adc_bench.dataset.driving.hand import draw_swerves, draw_wander
from adc_bench.dataset.driving.leg import Knots, Leg, course_aside, driven_line, speeds_mps, stations_m
from adc_bench.geometry import Path
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import Course
from adc_bench.world.route import Loop, Way, route
from adc_bench.world.scenario import Scenario

Array = NDArray[np.float64]
HALF_LAP_MIN_M = 19.0
SET_OUT_S = (0.6, 1.6)  # the robot stands at first, as in a run: half of it before a stop sign


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """The arena, how the robot is driven in it, and the generator that draws the rest.

    `care` in (0, 1] scales the driver's errors; `lateral_mps2` and `braking_mps2` bound what the speed may ask for.
    """

    scenario: Scenario
    behaviour: Behaviour
    cruise_mps: float
    lateral_mps2: float
    braking_mps2: float
    care: float
    duration_s: float
    rng: np.random.Generator

    @property
    def course(self) -> Course:
        """The road."""
        return self.scenario.course

    @property
    def lane_width_m(self) -> float:
        """From the middle of a lane to that of the other."""
        return self.course.spec.radius_outer_m - self.course.spec.radius_centre_m

    @property
    def reach_m(self) -> float:
        """How far the robot gets at most."""
        return self.cruise_mps * self.duration_s + 1.0

    def uniform(self, low: float, high: float) -> float:
        """Draw a number in a range."""
        return float(self.rng.uniform(low, high))

    def draw_route(self, *, turns_share: float | None = None) -> Path:
        """Draw a route that is long enough: straight laps, laps the other way round, or a mixture of both."""
        share = float(self.rng.choice([0.0, 0.5, 1.0], p=[0.4, 0.3, 0.3])) if turns_share is None else turns_share
        first: Loop = "east" if self.rng.random() < 0.5 else "west"
        halves = int(self.reach_m / HALF_LAP_MIN_M) + 3
        ways: list[Way] = ["turn" if self.rng.random() < share else "straight" for _ in range(halves)]
        return route(self.course, first, ways)

    def before(self, path: Path, x_m: float, y_m: float, ahead_m: tuple[float, float], within_m: float) -> float | None:
        """Return an arc length from which the path soon passes a point, None if it does not."""
        s_m = [at_m for at_m, _ in passes_m(path, stations_m(path), x_m, y_m, within_m) if at_m > ahead_m[0]]
        return max(s_m[0] - self.uniform(*ahead_m), 0.0) if s_m else None

    def free_leg(self, path: Path, start_m: float, knots: Knots = ()) -> Leg:
        """Return a leg along a route for as long as the drive lasts, with the swerves of the behaviour if nothing else
        is to be swerved round.
        """
        end_m = min(start_m + self.reach_m, path.length_m - 0.1)
        swerves = knots or draw_swerves(self.behaviour, start_m, end_m, self.lane_width_m, self.rng)
        return self.leg(path, start_m, end_m, knots=swerves, signs=((0.0, "up"),))

    def leg(
        self,
        path: Path,
        start_m: float,
        end_m: float,
        *,
        knots: Knots = ((0.0, 0.0),),
        backwards: bool = False,
        wait_s: tuple[float, float] = SET_OUT_S,
        signs: tuple[tuple[float, PanelSign], ...] = (),
    ) -> Leg:
        """Return a leg with this driver's wandering and speeds."""
        wander = draw_wander(self.behaviour, len(stations_m(path)), self.care, self.rng)
        aside_m = course_aside(path, knots) + wander
        speed = speeds_mps(
            driven_line(path, aside_m),
            start_m,
            end_m,
            cruise_mps=self.cruise_mps,
            lateral_mps2=self.lateral_mps2,
            braking_mps2=self.braking_mps2,
        )
        return Leg(
            path=path,
            start_m=start_m,
            end_m=end_m,
            aside_m=aside_m,
            speed_mps=speed,
            backwards=backwards,
            wait_s=self.uniform(*wait_s),
            signs=signs,
        )
