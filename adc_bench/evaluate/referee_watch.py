"""What the referee knows after a step of a run."""

import math
from dataclasses import dataclass, replace

from adc_bench.evaluate.course_progress import Moment, Progress
from adc_bench.evaluate.faults import Fault, FaultKind
from adc_bench.geometry import Pose2

NEVER_S = -math.inf
INSTANT_S = 1e-9  # times that differ by less are equal


@dataclass(frozen=True, kw_only=True)
class Watch:
    """All that a run has come to so far."""

    now: Moment
    progress: Progress
    best_m: float  # the farthest progress in this half lap
    anchor: Pose2  # the robot stays about here
    anchored_s: float = 0.0  # and since when
    moved_s: float = 0.0  # when it last moved
    shown: int = -1  # which order the panels show, see `Programme`
    half: int = 0  # half laps driven
    as_ordered: int = 0  # of these, the ones that count
    astray: bool = False  # this half lap goes the other way round than ordered
    obeyed: int = 0  # orders obeyed, the first one apart
    crossings_s: tuple[float, ...] = ()  # when each half lap ended
    mouths: frozenset[int] = frozenset()  # of the road-works, crossed in this half lap
    parked_s: float | None = None  # when the robot that is parked came to rest
    on_line_s: float = NEVER_S  # when a wheel last was on a line
    off_track_s: float = 0.0
    going_back: bool = False
    in_lane_m: float = 0.0  # how far it had driven when it was last in its lane
    distance_m: float = 0.0
    set_out: bool = False  # moved away after the start
    faults: tuple[Fault, ...] = ()

    def count(self, kind: FaultKind) -> int:
        """Return how many faults of a kind there were."""
        return sum(fault.kind is kind for fault in self.faults)

    def at_fault(self, kind: FaultKind) -> "Watch":
        """Return the watch with one more fault."""
        return replace(self, faults=(*self.faults, Fault(kind=kind, time_s=self.now.time_s)))
