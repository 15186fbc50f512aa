"""How a robot follows the panels' orders: gates in their order, ways at the crosswalk, stops, and the next sign."""

from dataclasses import dataclass, replace

from adc_bench.evaluate.course_progress import Gate, Moment, crossing_s, follow, onto, route_of
from adc_bench.evaluate.faults import FaultKind
from adc_bench.evaluate.programme import HalfLap, Programme, loop_of
from adc_bench.evaluate.referee_watch import INSTANT_S, Watch
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.standing import stop_place
from adc_bench.evaluate.works_gates import is_missed
from adc_bench.world.course import Course
from adc_bench.world.layout import Works


@dataclass(frozen=True, kw_only=True)
class Orders:
    """A run's programme on its course."""

    course: Course
    rules: Rules
    programme: Programme
    works: Works | None
    start_s: float  # when the first order appears

    def is_parking(self, watch: Watch) -> bool:
        """Return whether all half laps are driven and a place is to be found."""
        return self.programme.parks and watch.half == len(self.programme.half_laps)

    def half_lap(self, half: int) -> HalfLap:
        """Return the half lap of this number; behind the last one, the straight on which one parks."""
        ordered = self.programme.half_laps
        return ordered[half] if half < len(ordered) else HalfLap(loop=loop_of(half), way="straight")

    def follow(self, watch: Watch, before: Moment) -> Watch:
        """Return the watch, which knows the new moment already, with its progress and the sign shown."""
        if watch.shown < 0 and watch.now.time_s >= self.start_s - INSTANT_S:
            watch = replace(watch, shown=0)
        if not self.is_parking(watch):
            gate = watch.progress.next_gate
            crossed_s = crossing_s(gate, before, watch.now)
            if crossed_s is not None:
                return self._pass(watch, gate, crossed_s)
            if watch.progress.gates == 0 and crossing_s(self._other_gate(watch), before, watch.now) is not None:
                return self._go_astray(watch)
        return self._wait(replace(watch, progress=follow(watch.progress, watch.now)))

    def _pass(self, watch: Watch, gate: Gate, crossed_s: float) -> Watch:
        """Return the watch after the robot passed the next gate of its route."""
        watch = replace(watch, progress=follow(watch.progress, watch.now))
        if gate.name == "crosswalk":
            return self._end_half_lap(watch, crossed_s)
        turned_as_ordered = watch.progress.gates == 0 and watch.half > 0
        shown = max(watch.shown, self.programme.shown_after_loop(watch.half)) if gate.name == "loop" else watch.shown
        return replace(
            watch,
            progress=replace(watch.progress, gates=watch.progress.gates + 1),
            obeyed=watch.obeyed + turned_as_ordered,
            shown=shown,
        )

    def _end_half_lap(self, watch: Watch, crossed_s: float) -> Watch:
        if self.works and is_missed(self.works, watch.progress.route.half_lap.loop, watch.mouths):
            watch = watch.at_fault(FaultKind.WORKS_MISSED)
        if self.programme.sign(watch.shown) == "stop":
            watch = watch.at_fault(FaultKind.STOP_PASSED)
        shown, half = self.programme.shown_after_stop(watch.shown), watch.half + 1
        progress = onto(self.course, self.half_lap(half), 0, watch.now)
        return replace(
            watch,
            shown=shown,
            half=half,
            as_ordered=watch.as_ordered + (not watch.astray),
            astray=False,
            obeyed=watch.obeyed + (self.programme.sign(shown) == "end"),
            crossings_s=(*watch.crossings_s, crossed_s),
            mouths=frozenset(),
            progress=progress,
            best_m=progress.s_m,
            going_back=False,
        )

    def _other_way(self, watch: Watch) -> HalfLap:
        now = watch.progress.route.half_lap
        return HalfLap(loop=now.loop, way="turn" if now.way == "straight" else "straight")

    def _other_gate(self, watch: Watch) -> Gate:
        return route_of(self.course, self._other_way(watch)).gates[0]

    def _go_astray(self, watch: Watch) -> Watch:
        """Return the watch over a robot that goes round the loop the other way than ordered."""
        progress = onto(self.course, self._other_way(watch), 1, watch.now)
        watch = replace(watch, progress=progress, best_m=progress.s_m, astray=True)
        return watch.at_fault(FaultKind.ORDER_DISOBEYED)

    def _wait(self, watch: Watch) -> Watch:
        """Let the next order appear to a robot that has stood long enough before a stop."""
        stopped = watch.shown >= 0 and self.programme.sign(watch.shown) == "stop"
        if not stopped or watch.now.time_s - watch.moved_s < self.rules.stop_s - INSTANT_S:
            return watch
        place = stop_place(watch.progress, self.rules)
        if place == "far":
            return watch
        watch = replace(watch, shown=watch.shown + 1, obeyed=watch.obeyed + (place == "zone"))
        return watch if place == "zone" else watch.at_fault(FaultKind.STOP_OUTSIDE_ZONE)
