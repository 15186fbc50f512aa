"""The referee: watches the true poses of a run, step by step, says what the panels show and when the run is over.

The loop and the score use the same watch, so that a score from a log equals the score of the drive.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import shapely

from adc_bench.evaluate.course_progress import Moment, progress_at
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.ground import ground_of
from adc_bench.evaluate.log import Header
from adc_bench.evaluate.orders import Orders
from adc_bench.evaluate.programme import Programme
from adc_bench.evaluate.referee_watch import INSTANT_S, Watch
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.standing import is_inside, is_still
from adc_bench.evaluate.wheels import footing
from adc_bench.evaluate.works_gates import mouths_crossed
from adc_bench.geometry import Pose2
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import Course
from adc_bench.world.parking_zones import free_places


@dataclass(frozen=True, kw_only=True)
class Referee:
    """Knows the course, the rules and the run's own truths; holds no state."""

    course: Course
    rules: Rules
    header: Header

    @cached_property
    def programme(self) -> Programme:
        """What the panels order."""
        return Programme(orders=self.header.orders)

    @property
    def start_s(self) -> float:
        """When the first order appears."""
        return self.header.start_step * self.rules.control_period_s

    @cached_property
    def orders(self) -> Orders:
        """The programme on this course."""
        return Orders(
            course=self.course,
            rules=self.rules,
            programme=self.programme,
            works=self.header.layout.works,
            start_s=self.start_s,
        )

    @cached_property
    def _places(self) -> tuple[shapely.Geometry, ...]:
        parking = self.header.suite.parking
        return free_places(self.course, self.header.layout, parking) if parking else ()

    def panels(self, watch: Watch) -> PanelSign:
        """Return what the panels show."""
        return self.programme.sign(watch.shown)

    def begin(self, pose: Pose2) -> Watch:
        """Return the watch over a robot that stands at a pose at time 0."""
        progress = progress_at(self.course, self.orders.half_lap(0), pose)
        return Watch(
            now=Moment(time_s=0.0, pose=pose),
            progress=progress,
            best_m=progress.s_m,
            anchor=pose,
            shown=0 if self.start_s <= 0 else -1,
        )

    def step(self, watch: Watch, now: Moment) -> Watch:
        """Return the watch after the robot moved to `now`."""
        before = watch.now
        moved_m = _apart_m(now.pose, before.pose)
        watch = replace(
            watch,
            now=now,
            distance_m=watch.distance_m + moved_m,
            moved_s=watch.moved_s if is_still(before, now, self.rules) else now.time_s,
        )
        watch = self.orders.follow(watch, before)
        watch = self._watch_parking(watch) if self.orders.is_parking(watch) else self._watch_driving(watch, before)
        return self._watch_start(self._watch_place(self._watch_ground(watch, before)))

    def _watch_driving(self, watch: Watch, before: Moment) -> Watch:
        if self.header.layout.works:
            crossed = mouths_crossed(self.header.layout.works, before, watch.now)
            watch = replace(watch, mouths=watch.mouths | crossed)
        return self._watch_lane(self._watch_direction(watch))

    def _watch_direction(self, watch: Watch) -> Watch:
        reached_m = watch.progress.s_m
        going_back = watch.best_m - reached_m > self.rules.wrong_way_m or (
            watch.going_back and reached_m < watch.best_m
        )
        turned = going_back and not watch.going_back
        watch = replace(watch, best_m=max(watch.best_m, reached_m), going_back=going_back)
        return watch.at_fault(FaultKind.WRONG_WAY) if turned else watch

    def _watch_lane(self, watch: Watch) -> Watch:
        c = self.course.spec
        if watch.progress.offset_m <= (c.radius_outer_m - c.radius_centre_m) / 2:
            return replace(watch, in_lane_m=watch.distance_m)
        if watch.distance_m - watch.in_lane_m <= self.rules.wrong_lane_m:
            return watch
        return replace(watch, in_lane_m=math.inf).at_fault(FaultKind.WRONG_LANE)

    def _watch_parking(self, watch: Watch) -> Watch:
        stood_s = watch.now.time_s - watch.moved_s
        if watch.parked_s is not None or stood_s < self.rules.park_s - INSTANT_S:
            return watch
        if not is_inside(watch.now.pose, self.rules.robot, self._places):
            return watch
        return replace(watch, parked_s=watch.moved_s, obeyed=watch.obeyed + 1)

    def _watch_ground(self, watch: Watch, before: Moment) -> Watch:
        ground = footing(
            ground_of(self.course, self.header.layout, self.header.suite.parking),
            before.pose,
            watch.now.pose,
            self.header.wheel_separation_m,
            self.rules.robot.wheel_width_m,
        )
        time_s = watch.now.time_s
        if ground.on_line and time_s - watch.on_line_s >= self.rules.touch_gap_s:
            watch = watch.at_fault(FaultKind.LINE_TOUCH)
        if ground.all_off and not watch.count(FaultKind.OFF_ROAD):
            watch = watch.at_fault(FaultKind.OFF_ROAD)
        return replace(
            watch,
            on_line_s=time_s if ground.on_line else watch.on_line_s,
            off_track_s=watch.off_track_s + (time_s - before.time_s if ground.a_wheel_off else 0.0),
        )

    def _watch_place(self, watch: Watch) -> Watch:
        if _apart_m(watch.now.pose, watch.anchor) <= self.rules.blocked_m:
            return watch
        return replace(watch, anchor=watch.now.pose, anchored_s=watch.now.time_s)

    def _watch_start(self, watch: Watch) -> Watch:
        if watch.set_out or _apart_m(watch.now.pose, self.header.start_pose) <= self.rules.false_start_m:
            return watch
        if watch.now.time_s > self.start_s + INSTANT_S:
            return replace(watch, set_out=True)
        return watch if watch.count(FaultKind.FALSE_START) else watch.at_fault(FaultKind.FALSE_START)

    def end(self, watch: Watch) -> Reason | None:
        """Return why the run is over, or None while it goes on."""
        suite, time_s = self.header.suite, watch.now.time_s
        if watch.parked_s is not None or (watch.half == len(self.programme.half_laps) and not self.programme.parks):
            return Reason.FINISHED
        if watch.count(FaultKind.OFF_ROAD):
            return Reason.OFF_ROAD
        if time_s - self.start_s >= suite.time_limit_s - INSTANT_S:
            return Reason.TIME_LIMIT
        if time_s - max(self.start_s, watch.anchored_s) >= suite.blocked_after_s - INSTANT_S:
            return Reason.BLOCKED
        return None

    def laps_s(self, watch: Watch) -> tuple[float, ...]:
        """Return the lap times: from the start to the end of the first lap, then from crossing to crossing."""
        ends_s = watch.crossings_s[1::2]
        return tuple(end_s - begin_s for begin_s, end_s in zip((self.start_s, *ends_s), ends_s, strict=False))

    def finished_s(self, watch: Watch) -> float | None:
        """Return when the last order was carried out, None if it was not."""
        if self.end(watch) is not Reason.FINISHED:
            return None
        return watch.crossings_s[-1] if watch.parked_s is None else watch.parked_s

    def completion(self, watch: Watch) -> float:
        """Return the share of half laps and parking done as ordered, the half lap that is being driven in part."""
        parked = watch.parked_s is not None
        best = replace(watch.progress, s_m=watch.best_m).share
        driving = watch.half < len(self.programme.half_laps) and not watch.astray
        done = watch.as_ordered + parked + (best if driving else 0.0)
        return done / (len(self.programme.half_laps) + self.programme.parks)


def _apart_m(a: Pose2, b: Pose2) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
