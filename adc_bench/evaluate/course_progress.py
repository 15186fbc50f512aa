"""How far along its half lap a robot is: projection onto the right-hand lane, and gates crossed in order."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from adc_bench.evaluate.programme import HalfLap
from adc_bench.geometry import Path, Pose2, line
from adc_bench.world.course import Course
from adc_bench.world.route import crosswalk_pose, half_lap

GateName = Literal["leg", "loop", "s_road", "crosswalk"]
LEAD_M = 5.0  # of straight before the crosswalk, where a run starts
# How far a gate reaches to both sides of the road's middle: over both lanes, and past road-works outside the loop.
REACH_M: Mapping[GateName, float] = {"leg": 1.2, "loop": 1.75, "s_road": 1.2, "crosswalk": 1.2}


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Where the robot truly is at a time."""

    time_s: float
    pose: Pose2


@dataclass(frozen=True, kw_only=True)
class Gate:
    """A segment across the road at `s_m` of a route: `pose` is the road's middle and the driving direction there."""

    name: GateName
    s_m: float
    pose: Pose2
    half_width_m: float


@dataclass(frozen=True, kw_only=True)
class Route:
    """A half lap as it is to be driven; arc lengths count from the crosswalk, negative before it."""

    half_lap: HalfLap
    path: Path  # from LEAD_M before the crosswalk
    gates: tuple[Gate, ...]  # in order; the last is the crosswalk at its end

    @property
    def length_m(self) -> float:
        """The length from crosswalk to crosswalk."""
        return self.path.length_m - LEAD_M

    def pose(self, s_m: float) -> Pose2:
        """Return the pose in the middle of the right-hand lane."""
        return self.path.pose(s_m + LEAD_M)

    def project(self, pose: Pose2, around_s_m: float) -> tuple[float, float]:
        """Return (s_m, offset_m) of a pose near an arc length; left is positive."""
        s, offset = self.path.project([(pose.x_m, pose.y_m)], around_s_m=around_s_m + LEAD_M)
        return float(s[0]) - LEAD_M, float(offset[0])


@lru_cache(maxsize=16)
def route_of(course: Course, ordered: HalfLap) -> Route:
    """Return the route of a half lap with its gates: half-way along the leg beside the island, half-way round the loop,
    where loop and S-road meet, and at the crosswalk.
    """
    c = course.spec
    pieces = half_lap(course, ordered.loop, ordered.way)
    start = crosswalk_pose(course, ordered.loop) @ Pose2(x_m=-LEAD_M, y_m=0.0, yaw_rad=0.0)
    path = Path(start=start, pieces=(line(LEAD_M), *pieces))
    knots = path.knots_m[1:] - LEAD_M
    tip_m = c.loop_centre_x_m - abs(float(course.drops[0].start.x_m))  # the island beside the leg, as long as this
    length_m = float(knots[-1])
    stations: dict[GateName, float]
    if ordered.way == "straight":
        stations = {"leg": knots[1] - tip_m / 2, "loop": (knots[1] + knots[2]) / 2, "s_road": knots[2]}
    else:
        stations = {"s_road": knots[2], "loop": (knots[2] + knots[3]) / 2, "leg": knots[3] + tip_m / 2}
    middle = Pose2(x_m=0.0, y_m=(c.radius_outer_m - c.radius_centre_m) / 2, yaw_rad=0.0)
    gates = tuple(
        Gate(name=name, s_m=float(s), pose=path.pose(float(s) + LEAD_M) @ middle, half_width_m=REACH_M[name])
        for name, s in (*stations.items(), ("crosswalk", length_m))
    )
    return Route(half_lap=ordered, path=path, gates=gates)


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Where on its route a robot is. `offset_m` is its distance from the lane's middle, left positive."""

    route: Route
    s_m: float
    offset_m: float
    gates: int = 0  # passed in this half lap

    @property
    def next_gate(self) -> Gate:
        """The gate to be crossed next: progress beyond it does not count."""
        return self.route.gates[self.gates]

    @property
    def share(self) -> float:
        """The share of the half lap driven, in [0, 1]."""
        return min(max(min(self.s_m, self.next_gate.s_m) / self.route.length_m, 0.0), 1.0)


def progress_at(course: Course, ordered: HalfLap, pose: Pose2) -> Progress:
    """Return the progress of a robot on the straight before the crosswalk, where runs start."""
    route = route_of(course, ordered)
    s_m, offset_m = route.project(pose, pose.x_m)
    return Progress(route=route, s_m=s_m, offset_m=offset_m)


def follow(progress: Progress, now: Moment) -> Progress:
    """Return the progress after a step that crossed no gate."""
    s_m, offset_m = progress.route.project(now.pose, progress.s_m)
    return replace(progress, s_m=s_m, offset_m=offset_m)


def onto(course: Course, ordered: HalfLap, gates: int, now: Moment) -> Progress:
    """Return the progress on another route, of which some gates are passed."""
    route = route_of(course, ordered)
    s_m, offset_m = route.project(now.pose, route.gates[gates - 1].s_m if gates else 0.0)
    return Progress(route=route, s_m=s_m, offset_m=offset_m, gates=gates)


def crossing_s(gate: Gate, before: Moment, now: Moment) -> float | None:
    """Return the interpolated time at which the robot's origin crossed the gate forwards; None if it did not."""
    ends = [(moment.pose.x_m, moment.pose.y_m) for moment in (before, now)]
    (x0, y0), (x1, y1) = gate.pose.inverse().transform(ends).tolist()
    if not x0 < 0.0 <= x1:
        return None
    share: float = -x0 / (x1 - x0)
    if abs(y0 + share * (y1 - y0)) > gate.half_width_m:
        return None
    return before.time_s + share * (now.time_s - before.time_s)
