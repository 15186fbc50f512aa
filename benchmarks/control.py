"""Two laps by each pilot on the simulated robot with its true pose, and against the fastest laps that there can be.

Usage: python benchmarks/control.py [--seeds 20] [--plot FILE.png]

No pictures: this is what control alone costs. The robots are those of the seeds; poses are true, or carry white noise
of 2 cm and 0.5 deg. The fastest laps are found by other means than the pilots': a dynamic programme over place and
speed on the middle of the lane, and a linear programme over the lines whose wheels stay off the lane's lines.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.optimize import linprog

from adc_bench.evaluate.wheels import patch_points
from adc_bench.stack.pilots import HeadingPilot, LinePilot, Pilot, TrajectoryPilot, timetable_of
from adc_bench.stack.reference_line import ReferenceLine, line_through
from adc_bench.stack.timetable import SpeedLimits
from adc_bench.world.robot import RobotParams

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "stack"))
from bellman import least_time_s
from driven_robot import COURSE, Driven, drive, mission, noisy, simulation, truth

Array = NDArray[np.float64]
LAP = COURSE.lap
FINISH_M = 2 * LAP.length_m
ROBOT = RobotParams()
NOISE = 0.02, math.radians(0.5)
FINE_M = 0.05
RESERVE = 0.97  # of bends, for what the second order leaves out
PILOTS: dict[str, Callable[[Any], Pilot[Any]]] = {
    "PID on the heading, 1.0 m/s": lambda task: HeadingPilot(mission=task, speed_mps=1.0),
    "PID on the heading, 1.5 m/s": lambda task: HeadingPilot(mission=task, speed_mps=1.5),
    "PID on the heading, 2.2 m/s": lambda task: HeadingPilot(mission=task, speed_mps=2.2),
    "feedback linearisation, 1.0 m/s": lambda task: TrajectoryPilot(mission=task, speed_mps=1.0),
    "feedback linearisation, 2.0 m/s": lambda task: TrajectoryPilot(mission=task, speed_mps=2.0),
    "feedback linearisation, 2.2 m/s": lambda task: TrajectoryPilot(mission=task, speed_mps=2.2),
    "line at the limit": lambda task: LinePilot(mission=task, speed_mps=2.2),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--plot", type=Path)
    options = parser.parse_args()
    fastest_s = print_fastest()
    print(
        "| pilot | poses | finished | two laps, s | second lap / fastest on the middle | cross-track max, cm ", end=""
    )
    print(" | RMS, cm | a wheel to a line, cm | CPU ms a step |\n|---|---|---|---|---|---|---|---|---|")
    for name in PILOTS:
        for poses in ("true", "noisy"):
            print_pilot(name, poses, options.seeds, fastest_s)
    if options.plot:
        plot(drive_one("line at the limit", "true", 1)[0], options.plot)


def drive_one(name: str, poses: str, seed: int) -> tuple[Driven, float]:
    """Return a drive of two laps, and the pilot's CPU time a step in seconds (its foresight not included)."""
    task, spent = mission(), []

    class Timed:
        def __init__(self) -> None:
            self._pilot = PILOTS[name](task)

        def start(self) -> Any:
            return self._pilot.start()

        def steer(self, *given: Any) -> Any:
            begun_s = time.process_time()
            answer = self._pilot.steer(*given)
            spent.append(time.process_time() - begun_s)
            return answer

    seconds = FINISH_M / float(name.split()[-2] if "m/s" in name else 2.2) + 3.0
    told = truth if poses == "true" else noisy(seed, *NOISE)
    return drive(Timed(), task, simulation(seed), seconds, told), float(np.median(spent))


def print_pilot(name: str, poses: str, seeds: int, fastest_s: float) -> None:
    drives, spent = zip(*(drive_one(name, poses, seed) for seed in range(1, seeds + 1)), strict=True)
    whole = [driven for driven in drives if math.isfinite(driven.crossed_s(FINISH_M))]
    print(f"| {name} | {poses} | {len(whole)} of {seeds} |", end=" ")
    if not whole:
        print("| | | | |")
        return
    runs = np.array([driven.crossed_s(FINISH_M) for driven in whole])
    laps = np.array([driven.crossed_s(FINISH_M) - driven.crossed_s(LAP.length_m) for driven in whole])
    worst = np.array([np.abs(driven.offset_m).max() for driven in whole])
    rms = np.sqrt(np.mean([np.mean(driven.offset_m**2) for driven in whole]))
    print(
        f"{runs.mean():.2f} [{runs.min():.2f}, {runs.max():.2f}] | {laps.mean() / fastest_s:.3f} "
        f"| {100 * np.median(worst):.1f}, worst {100 * worst.max():.1f} | {100 * rms:.2f} "
        f"| {min(map(line_gap_m, whole)) * 100:.1f} | {1000 * np.median(spent):.2f} |",
        flush=True,
    )


def line_gap_m(driven: Driven) -> float:
    """Return how near a wheel came to an edge line's paint; negative on it."""
    patches = patch_points(driven.poses, ROBOT.wheel_separation_m, ROBOT.wheel_width_m).reshape(-1, 2)
    return float(COURSE.distance_to_edge_lines_m(patches).min()) - COURSE.spec.edge_line_width_m / 2


def print_fastest() -> float:
    """Print the fastest laps by the robot's bare limits; return the flying lap on the middle of the lane."""
    limits = SpeedLimits.of(ROBOT, steering_share=1.0)
    timetable = timetable_of(mission(), ROBOT.speed_max_mps)
    to_finish = timetable.line.path_s_m <= FINISH_M
    run_s = least_time_s(cut(timetable.line, to_finish), limits, start_mps=0.0)
    middle_s = LAP.length_m / min(ROBOT.speed_max_mps, limits.rim_speed_mps / (1 + 0.165 / 1.8375))
    print(f"two laps from standstill on the reference's line by dynamic programme: {run_s:.2f} s;", end=" ")
    print(f"its own timetable {np.interp(FINISH_M, timetable.line.path_s_m, timetable.time_s):.2f} s")
    print(f"a flying lap on the middle of the lane, were its bends no jumps: {middle_s:.2f} s")
    for margin_m in (0.05, wheel_room_m()):
        line = shortest_lap(margin_m, limits)
        lap_s = least_time_s(line, limits, start_mps=ROBOT.speed_max_mps)
        bound_s = line.length_m / ROBOT.speed_max_mps
        print(f"a flying lap within {100 * margin_m:.1f} cm of it: {line.length_m:.2f} m,", end=" ")
        print(f"{lap_s:.2f} s, and no less than {bound_s:.2f} s")
    return middle_s


def wheel_room_m() -> float:
    """Return how far the robot may be beside the middle of the lane before a wheel touches the lane's line."""
    spec = COURSE.spec
    half_lane_m = (spec.radius_outer_m - spec.radius_centre_m) / 2
    return half_lane_m - (ROBOT.wheel_separation_m + ROBOT.wheel_width_m + spec.edge_line_width_m) / 2


def cut(line: ReferenceLine, kept: NDArray[np.bool_]) -> ReferenceLine:
    """Return the line's samples that are kept."""
    return ReferenceLine(**{name: values[kept] for name, values in vars(line).items()})


def shortest_lap(margin_m: float, limits: SpeedLimits) -> ReferenceLine:
    """Return the shortest closed line within a margin of the lane's middle that can be driven at full speed.

    To second order in its offsets d its length is the lap's plus int (d'^2 / 2 - kappa d) ds, its curvature
    kappa + d'' + kappa^2 d. A linear programme finds the least, d'^2 as the highest of its tangents.
    """
    count = round(LAP.length_m / FINE_M)
    step_m = LAP.length_m / count
    s_m = np.linspace(0.0, LAP.length_m, count + 1)[:-1]
    middle = LAP.poses(s_m)
    bend = bends_of(middle[:, :2], step_m)
    bend_max = (limits.rim_speed_mps / limits.speed_mps - 1) / limits.half_separation_m
    sharp_max = limits.turn_acceleration_radps2 / limits.speed_mps**2
    same, after = sparse.eye_array(count), sparse.csr_array(np.roll(np.eye(count), 1, axis=1))
    slope = (after - same) / step_m
    second = -(slope.T @ slope) + sparse.diags_array(bend**2)
    third, nothing = slope @ second, sparse.csr_array((count, count))
    rows, bounds = [], []
    for matrix, now, most in ((second, bend, bend_max), (third, slope @ bend, sharp_max)):
        rows += [sparse.hstack([matrix, nothing]), sparse.hstack([-matrix, nothing])]
        bounds += [most * RESERVE - now, most * RESERVE + now]
    for tangent in np.linspace(-0.4, 0.4, 17):
        rows.append(sparse.hstack([2 * tangent * slope, -same]))
        bounds.append(np.full(count, tangent**2))
    found = linprog(
        step_m * np.concatenate([-bend, np.full(count, 0.5)]),
        A_ub=sparse.vstack(rows),
        b_ub=np.concatenate(bounds),
        bounds=[(-margin_m, margin_m)] * count + [(0.0, None)] * count,
    )
    normals = np.column_stack([-np.sin(middle[:, 2]), np.cos(middle[:, 2])])
    points = middle[:, :2] + found.x[:count, None] * normals
    around = np.concatenate([points, points[:1]])
    return line_through(around, np.append(s_m, LAP.length_m))


def bends_of(points: Array, step_m: float) -> Array:
    """Return the curvature (n,) at the points (n, 2) of a closed line, from its chords."""
    chords = np.roll(points, -1, axis=0) - points
    yaw = np.arctan2(chords[:, 1], chords[:, 0])
    turn = yaw - np.roll(yaw, 1)
    return (turn + math.pi) % (2 * math.pi) / step_m - math.pi / step_m


def plot(driven: Driven, path: Path) -> None:
    """Draw speed over arc length, and the way with its offset twentyfold."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    timetable = timetable_of(mission(), ROBOT.speed_max_mps)
    figure, (over, beside, above) = pyplot.subplots(3, 1, figsize=(11, 12), height_ratios=(1, 1, 2))
    over.plot(timetable.line.path_s_m, timetable.speed_mps, label="timetable")
    moved = np.hypot(*np.diff(driven.poses[:, :2], axis=0).T) / np.diff(driven.time_s)
    over.plot(driven.s_m[1:], moved, label="driven")
    over.set(ylabel="speed, m/s", xlabel="arc length, m")
    over.legend()
    beside.plot(driven.s_m, 100 * driven.offset_m)
    beside.set(ylabel="cross-track error, cm", xlabel="arc length, m")
    for points in COURSE.edge_lines.values():
        above.plot(*points.T, color="0.6")
    above.plot(*LAP.sample(0.05)[:, :2].T, color="0.8", linewidth=0.8)
    aside = 20 * driven.offset_m[:, None] * np.column_stack([-np.sin(driven.poses[:, 2]), np.cos(driven.poses[:, 2])])
    above.plot(*(driven.poses[:, :2] + aside).T, color="C3", linewidth=0.9, label="driven, its error 20 times as large")
    above.set_aspect("equal")
    above.legend(loc="upper center")
    figure.tight_layout()
    figure.savefig(path, dpi=80)


if __name__ == "__main__":
    main()
