"""The missions as legs. A function returns None where its draw makes no drive; the caller draws again."""

from collections.abc import Callable, Mapping

import numpy as np
from scipy.interpolate import PchipInterpolator

from adc_bench.dataset.drive_recipe import MissionName
from adc_bench.dataset.driving.floor import passes_m
from adc_bench.dataset.driving.leg import Knots, Leg, stations_m
from adc_bench.dataset.driving.parking import bay_parking, parallel_legs, parallel_parking
from adc_bench.dataset.driving.task import HALF_LAP_MIN_M, Task
from adc_bench.geometry import Path
from adc_bench.world.arena import road_centre
from adc_bench.world.categories import PanelSign
from adc_bench.world.layout import Place, Works
from adc_bench.world.route import Loop, Way, half_lap, route

BEFORE_THING_M = (2.5, 5.0)
IN_LANE_M = 0.6  # a box whose middle is nearer than this to a lane's stands in it
PASSING_M, SWERVE_M = 1.0, 1.6  # beside a box: the other lane before and after its middle, and the way there
SIGN_SEEN_M = 4.0  # before the crosswalk the panels change
STOP_BEFORE_M = 0.65  # the robot's origin before the crosswalk's middle, as at a run's start
STOPPED_S = (2.0, 4.0)
CORRIDOR_ENTRY_M = 2.2
WORKS_AHEAD_M = (2.5, 4.0)

Legs = tuple[Leg, ...]


def speed(task: Task) -> Legs | None:
    """Laps on the free road, either way round."""
    path = task.draw_route()
    return (task.free_leg(path, task.uniform(0.0, path.knots_m[3])),)


def tunnel(task: Task) -> Legs | None:
    """Through the tunnel."""
    there = task.scenario.tunnel
    assert there
    middle, lap = road_centre(task.course), task.course.lap
    x_m, y_m, _ = middle.poses((there.start_s_m + there.length_m / 2) / lap.length_m * middle.length_m)[0]
    path = task.draw_route()
    start_m = task.before(path, x_m, y_m, BEFORE_THING_M, within_m=1.0)
    return None if start_m is None else (task.free_leg(path, start_m),)


def obstacles(task: Task) -> Legs | None:
    """Round the boxes by the other lane, or into one of them."""
    boxes = task.scenario.layout.boxes
    box = boxes[int(task.rng.integers(len(boxes)))]
    path = task.draw_route()
    start_m = task.before(path, box.x_m, box.y_m, BEFORE_THING_M, within_m=1.2)
    if start_m is None:
        return None
    met = [hit for b in boxes for hit in passes_m(path, stations_m(path), b.x_m, b.y_m, 1.2) if hit[0] > start_m]
    bump = task.behaviour == "bump"
    return (task.free_leg(path, start_m, _into(met) if bump else _round(sorted(met), task.lane_width_m)),)


def _into(met: list[tuple[float, float]]) -> Knots:
    """Return the offsets that lead into the box met first."""
    at_m, aside_m = min(met)
    return ((at_m - 2.5, 0.0), (at_m - 1.0, aside_m))


def _round(met: list[tuple[float, float]], lane_width_m: float) -> Knots:
    """Return the offsets that lead round the boxes in the right lane by the left one."""
    knots: list[tuple[float, float]] = [(0.0, 0.0)]
    for at_m, aside_m in met:
        if abs(aside_m) > IN_LANE_M:
            continue
        if knots[-1][0] > at_m - PASSING_M - SWERVE_M:
            knots[-2:] = []  # stay in the left lane
        else:
            knots += [(at_m - PASSING_M - SWERVE_M, 0.0), (at_m - PASSING_M, lane_width_m)]
        knots += [(at_m + PASSING_M, lane_width_m), (at_m + PASSING_M + SWERVE_M, 0.0)]
    return knots


def works(task: Task) -> Legs | None:
    """Along the corridor of the road-works, in their driving order."""
    there = task.scenario.layout.works
    assert there
    path = task.draw_route(turns_share=0.0)
    outer = _outer_row(there)
    start_m = task.before(path, *outer[0], WORKS_AHEAD_M, within_m=1.6)
    if start_m is None:
        return None
    return (task.free_leg(path, start_m, _corridor(path, there, start_m)),)


def _outer_row(there: Works) -> tuple[Place, ...]:
    return max(there.left, there.right, key=len)


def _corridor(path: Path, there: Works, start_m: float) -> Knots:
    """Return the offsets along the corridor's middle: half its width inside the longer row of cones."""
    outer = np.array(_outer_row(there))
    inner = np.array(min(there.left, there.right, key=len))
    inwards = 1.0 if _outer_row(there) == there.right else -1.0
    reach_m = float(np.ptp(outer, axis=0).sum())
    middle_m, window_m = start_m + WORKS_AHEAD_M[1] + reach_m / 2, WORKS_AHEAD_M[1] + reach_m / 2
    s_m, aside_m = path.project(outer, around_s_m=middle_m, window_m=window_m)
    s_inner_m, aside_inner_m = path.project(inner, around_s_m=middle_m, window_m=window_m)
    row = PchipInterpolator(s_m, aside_m)
    width_m = float(np.abs(aside_inner_m - row(np.clip(s_inner_m, s_m[0], s_m[-1]))).mean())
    along = np.linspace(s_m[0], s_m[-1], 25)
    slope = row(along, 1)
    middle = row(along) + inwards * width_m / 2 * np.hypot(1.0, slope)
    return (
        (s_m[0] - CORRIDOR_ENTRY_M, 0.0),
        *zip(along.tolist(), middle.tolist(), strict=True),
        (s_m[-1] + CORRIDOR_ENTRY_M, 0.0),
    )


def signs(task: Task) -> Legs | None:
    """Obeys the panels at each crossing: straight on, round the other way, stop and go, at last park or the end."""
    first: Loop = "east" if task.rng.random() < 0.5 else "west"
    crossings = 1 + int(0.85 * task.reach_m / HALF_LAP_MIN_M)  # so that most drives come to the last
    loops: list[Loop] = [first] + [("east", "west")[(k + (first == "east")) % 2] for k in range(crossings)]
    ways: list[Way] = ["turn" if task.rng.random() < 0.4 else "straight" for _ in loops]
    if task.rng.random() < 0.5:
        ways[-1] = "straight"
    path = route(task.course, first, ways)
    ends_m = np.cumsum(
        [sum(p.length_m for p in half_lap(task.course, *half)) for half in zip(loops, ways, strict=True)]
    )
    start_m = float(ends_m[0]) - task.uniform(1.5, 5.0)
    return _crossings(task, path, start_m, ends_m[:-1].tolist(), list(zip(loops, ways, strict=True))[1:])


def _crossings(
    task: Task, path: Path, start_m: float, crossings_m: list[float], halves: list[tuple[Loop, Way]]
) -> Legs:
    """Cut a route at the crossings where the panels say stop, and at the last one."""
    legs: list[Leg] = []
    shown: list[tuple[float, PanelSign]] = [(0.0, "stop")]
    wait_s = (0.2, 0.6)
    for at_m, half in zip(crossings_m, halves, strict=True):
        order = _order(half)
        last = at_m == crossings_m[-1]
        if not (last or task.rng.random() < 0.4):
            shown.append((at_m - SIGN_SEEN_M, order))
            continue
        shown.append((at_m - SIGN_SEEN_M, _last_order(task, half) if last else "stop"))
        if shown[-1][1] == "park":
            return (*legs, *parallel_legs(task, path, start_m, at_m, wait_s=wait_s, signs=tuple(shown)))
        end_m = at_m - STOP_BEFORE_M
        legs.append(task.leg(path, start_m, end_m, wait_s=wait_s, signs=tuple(shown)))
        start_m, wait_s, shown = end_m, STOPPED_S, [(0.0, order)]
    return tuple(legs)


def _order(half: tuple[Loop, Way]) -> PanelSign:
    loop, way = half
    if way == "straight":
        return "up"
    return "left" if loop == "east" else "right"


def _last_order(task: Task, half: tuple[Loop, Way]) -> PanelSign:
    """Parking is beside the straight lane towards +x; else the drive is over."""
    can_park = half == ("east", "straight")
    return "park" if can_park and task.rng.random() < 0.7 else "end"


BUILDERS: Mapping[MissionName, Callable[[Task], Legs | None]] = {
    "speed": speed,
    "signs": signs,
    "obstacles": obstacles,
    "tunnel": tunnel,
    "works": works,
    "parallel_parking": parallel_parking,
    "bay_parking": bay_parking,
    "vertical_signs": speed,
}
