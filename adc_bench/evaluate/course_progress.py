"""How far along the lap a robot is: projection onto the lane and gates crossed in order."""

import math
from dataclasses import dataclass, replace

from adc_bench.geometry import Pose2
from adc_bench.world.course import Course, Gate


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Where the robot truly is at a time."""

    time_s: float
    pose: Pose2


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Metres along the laps from the start line (negative before it), and when each gate was crossed.

    `progress_m` follows the lane's projection and may fall; `offset_m` is the distance from the lane's centre, left
    positive; `gate_times_s` has one time for each gate crossed in order, lap after lap.
    """

    progress_m: float
    offset_m: float
    gate_times_s: tuple[float, ...] = ()

    def next_gate_m(self, course: Course) -> float:
        """Return where the next gate is along the laps: progress beyond it does not count."""
        laps, index = divmod(len(self.gate_times_s), len(course.gates))
        return laps * course.lap.length_m + (course.gates[index].s_m or course.lap.length_m)

    def lap_ends_s(self, course: Course) -> tuple[float, ...]:
        """Return when each lap ended."""
        count = len(course.gates)
        return self.gate_times_s[count - 1 :: count]


def progress_at(course: Course, pose: Pose2) -> Progress:
    """Return the progress of a robot that has not set out; in the second half of the lap it is before the line."""
    s, offset = course.lap.project([(pose.x_m, pose.y_m)])
    return Progress(progress_m=math.remainder(float(s[0]), course.lap.length_m), offset_m=float(offset[0]))


def follow(course: Course, progress: Progress, before: Moment, now: Moment) -> Progress:
    """Return the progress after a step from `before` to `now`."""
    length_m = course.lap.length_m
    s, offset = course.lap.project([(now.pose.x_m, now.pose.y_m)], around_s_m=progress.progress_m % length_m)
    moved_m = math.remainder(float(s[0]) - progress.progress_m, length_m)
    times_s = progress.gate_times_s
    crossed_s = crossing_s(course.gates[len(times_s) % len(course.gates)], before, now)
    return replace(
        progress,
        progress_m=progress.progress_m + moved_m,
        offset_m=float(offset[0]),
        gate_times_s=times_s if crossed_s is None else (*times_s, crossed_s),
    )


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
