"""The referee: watches the true poses of a run, step by step, and says when it is over.

The loop and the score use the same watch, so that a score from a log equals the score of the drive.
"""

import math
from dataclasses import dataclass, replace

from adc_bench.evaluate.course_progress import Moment, Progress, follow, progress_at
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.wheels import Footing, footing
from adc_bench.geometry import Pose2
from adc_bench.world.course import Course

NEVER_S = -math.inf


@dataclass(frozen=True, kw_only=True)
class Watch:
    """What the referee knows after a step."""

    now: Moment
    progress: Progress
    best_m: float  # the farthest progress so far
    gained_from_m: float  # progress when the blocked clock last started again
    gained_s: float  # and when that was
    on_line_s: float = NEVER_S  # when a wheel last was on a line
    line_touches: int = 0
    off_track_s: float = 0.0
    off_road: bool = False
    going_back: bool = False
    wrong_ways: int = 0
    distance_m: float = 0.0
    false_start: bool = False
    set_out: bool = False  # moved after the arrow appeared


@dataclass(frozen=True, kw_only=True)
class Referee:
    """Knows the course, the rules and the run's own truths; holds no state."""

    course: Course
    rules: Rules
    header: Header

    @property
    def arrow_s(self) -> float:
        """When the arrow appears."""
        return self.header.start_step * self.rules.control_period_s

    def begin(self, pose: Pose2) -> Watch:
        """Return the watch over a robot that stands at a pose at time 0."""
        progress = progress_at(self.course, pose)
        reached_m = progress.progress_m
        return Watch(
            now=Moment(time_s=0.0, pose=pose),
            progress=progress,
            best_m=reached_m,
            gained_from_m=reached_m,
            gained_s=0.0,
        )

    def step(self, watch: Watch, now: Moment) -> Watch:
        """Return the watch after the robot moved to `now`."""
        before = watch.now
        progress = follow(self.course, watch.progress, before, now)
        ground = footing(
            self.course,
            before.pose,
            now.pose,
            self.header.wheel_separation_m,
            self.rules.robot.wheel_width_m,
        )
        moved_m = math.hypot(now.pose.x_m - before.pose.x_m, now.pose.y_m - before.pose.y_m)
        watch = replace(watch, now=now, progress=progress, distance_m=watch.distance_m + moved_m)
        watch = self._watch_ground(watch, ground, now.time_s - before.time_s)
        return self._watch_start(self._watch_direction(watch))

    def _watch_ground(self, watch: Watch, ground: Footing, period_s: float) -> Watch:
        time_s = watch.now.time_s
        new = ground.on_line and time_s - watch.on_line_s >= self.rules.touch_gap_s
        return replace(
            watch,
            on_line_s=time_s if ground.on_line else watch.on_line_s,
            line_touches=watch.line_touches + new,
            off_track_s=watch.off_track_s + (period_s if ground.a_wheel_off else 0.0),
            off_road=watch.off_road or ground.all_off,
        )

    def _watch_direction(self, watch: Watch) -> Watch:
        reached_m = watch.progress.progress_m
        back = watch.best_m - reached_m > self.rules.wrong_way_m
        going_back = back or (watch.going_back and reached_m < watch.best_m)
        gained = reached_m - watch.gained_from_m > self.rules.blocked_progress_m
        return replace(
            watch,
            best_m=max(watch.best_m, reached_m),
            going_back=going_back,
            wrong_ways=watch.wrong_ways + (going_back and not watch.going_back),
            gained_from_m=reached_m if gained else watch.gained_from_m,
            gained_s=watch.now.time_s if gained else watch.gained_s,
        )

    def _watch_start(self, watch: Watch) -> Watch:
        start, pose = self.header.start_pose, watch.now.pose
        away = math.hypot(pose.x_m - start.x_m, pose.y_m - start.y_m) > self.rules.false_start_m
        early = watch.now.time_s <= self.arrow_s
        return replace(
            watch,
            false_start=watch.false_start or (away and early),
            set_out=watch.set_out or (away and not early),
        )

    def end(self, watch: Watch) -> Reason | None:
        """Return why the run is over, or None while it goes on."""
        suite, time_s = self.header.run.suite, watch.now.time_s
        if len(watch.progress.lap_ends_s(self.course)) >= suite.laps:
            return Reason.FINISHED
        if watch.off_road:
            return Reason.OFF_ROAD
        if time_s - self.arrow_s >= suite.time_limit_s:
            return Reason.TIME_LIMIT
        if time_s - max(self.arrow_s, watch.gained_s) >= suite.blocked_after_s:
            return Reason.BLOCKED
        return None

    def laps_s(self, watch: Watch) -> tuple[float, ...]:
        """Return the lap times: from the arrow to the first crossing of the start line, then crossing to crossing."""
        ends_s = watch.progress.lap_ends_s(self.course)
        starts_s = (self.arrow_s, *ends_s)
        return tuple(end_s - start_s for start_s, end_s in zip(starts_s, ends_s, strict=False))

    def half_laps(self, watch: Watch) -> int:
        """Return how often the crosswalk was passed, each time after the gates before it."""
        names = [gate.name for gate in self.course.gates]
        passed = len(watch.progress.gate_times_s)
        laps, rest = divmod(passed, len(names))
        return 2 * laps + ("crosswalk_back" in names[:rest])

    def completion(self, watch: Watch) -> float:
        """Return the share of the laps driven, gates in order, in [0, 1]."""
        laps = self.header.run.suite.laps
        if len(watch.progress.lap_ends_s(self.course)) >= laps:
            return 1.0
        reached_m = min(watch.best_m, watch.progress.next_gate_m(self.course))
        return min(max(reached_m / (laps * self.course.lap.length_m), 0.0), 1.0)
