"""What each layer of the built-in drivers costs: whole drives from pixels, with true detections, with the true pose.

Usage: python benchmarks/ladder.py --out DIR [--suite d1] [--runs 4] [--first-seed 601] [--submissions reference thesis]
       [--rungs none detections pose] [--workers 1]

The suite's trials and looks on arenas of no suite: seeds from `--first-seed` on, whose light levels take turns. A row
is a driver with one true layer, its figures the means over the runs with their 95 % intervals; the last three columns
are of all runs. SUITE is a suite's name or file: `benchmarks/suites` has short ones, a lap past boxes and one through
road-works. Run again on DIR it goes on where it stopped. With `--rungs none --runs 50` it says how well a driver does
as shipped.
"""

import argparse
import math
from collections.abc import Callable
from pathlib import Path

import msgspec
from turns import table

from adc_bench.evaluate.results import Result
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.score import Episode
from adc_bench.evaluate.statistics import Statistic
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import Suite, load_suite
from adc_bench.evaluate.witness import Privilege

RUNGS: dict[str, Privilege | None] = {"none": None, "detections": "detections", "pose": "pose"}
FIGURES = (  # heading, name in the summary, factor, decimals
    ("position RMSE, cm", "position_rmse_m", 100, 2),
    ("heading RMSE, deg", "heading_rmse_rad", math.degrees(1), 3),
    ("NEES", "nees_mean", 1, 2),
    ("cross-track RMSE, cm", "cross_track_rmse_m", 100, 2),
    ("cross-track max, cm", "cross_track_max_m", 100, 1),
    ("lap, s", "lap_time_s", 1, 2),
    ("run time, s", "run_time_s", 1, 2),
    ("points", "points", 1, 1),
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--suite", default="d1")
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--first-seed", type=int, default=601)
    parser.add_argument("--submissions", nargs="+", default=["reference", "thesis"])
    parser.add_argument("--rungs", nargs="+", choices=tuple(RUNGS), default=list(RUNGS))
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    seeds = tuple(range(options.first_seed, options.first_seed + options.runs))
    named = load_suite(options.suite)
    if not isinstance(named, Suite):
        parser.error(f"{options.suite} is not driven")
    suite = msgspec.structs.replace(named, seeds=seeds, ranked=False)
    rows = []
    for name in options.submissions:
        for rung in options.rungs:
            submission, out = load_submission(name, {}, RUNGS[rung]), options.out / f"{name}-{rung}"
            result = evaluate_submission(submission, suite, out, in_process=True, workers=options.workers)
            rows.append((name, rung, *figures(result)))
    print(
        table(("driver", "true layer", "finished", *(heading for heading, *_ in FIGURES), *(w for w, _ in ALL)), *rows)
    )


def drives(result: Result) -> list[Episode]:
    """Return the runs of a driver's result."""
    return [episode for episode in result.episodes if isinstance(episode, Episode)]


def figures(result: Result) -> tuple[str, ...]:
    """Return a row's cells behind its names."""
    finished = sum(episode.reason == "finished" for episode in drives(result))
    means = [shown(result.summary.get(name), factor, decimals) for _, name, factor, decimals in FIGURES]
    return (f"{finished} of {result.planned}", *means, *(over_all(result) for _, over_all in ALL))


def shown(figure: Statistic | None, factor: float, decimals: int) -> str:
    """Return a figure as its mean and interval; nothing where no run has it."""
    if figure is None:
        return ""
    mean, low, high = (f"{factor * value:.{decimals}f}" for value in (figure.mean, *figure.ci95))
    return f"{mean} [{low}, {high}]"


def worst_position(result: Result) -> str:
    """Return the largest position error of all runs."""
    errors = [episode.localization.position_max_m for episode in drives(result) if episode.localization]
    return f"{100 * max(errors):.1f}" if errors else ""


def touches(result: Result) -> str:
    """Return how many lines and things were touched in all runs."""
    return str(sum(episode.driving.line_touches + len(episode.collisions) for episode in drives(result)))


def clean(result: Result) -> str:
    """Return how many runs were complete and without any fault: every sign obeyed, nothing touched."""
    return str(sum(episode.reason == "finished" and episode.driving_score == 100 for episode in drives(result)))


ALL: tuple[tuple[str, Callable[[Result], str]], ...] = (
    ("worst position, cm", worst_position),
    ("touches", touches),
    ("clean runs", clean),
)


if __name__ == "__main__":
    main()
