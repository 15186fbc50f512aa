"""Wall time over simulated time of a closed-loop drive, the submission's own time a step, and peak memory.

Usage: python benchmarks/drive.py [--submission thesis] [--suite d1] [--episodes 3] [--set KEY=VALUE ...]

The submission runs in its child process as in scoring; medians over the episodes.
"""

import argparse
import resource
import statistics
import tempfile
from pathlib import Path

from adc_bench.evaluate.folder import ResultFolder
from adc_bench.evaluate.run import evaluate_submission
from adc_bench.evaluate.submission import load_submission
from adc_bench.evaluate.suite import load_suite


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--submission", default="thesis")
    parser.add_argument("--suite", default="d1")
    parser.add_argument("--episodes", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    options = parser.parse_args()
    submission = load_submission(options.submission, dict(pair.split("=", 1) for pair in options.set))
    with tempfile.TemporaryDirectory() as folder:
        evaluate_submission(submission, load_suite(options.suite), Path(folder), episodes=options.episodes)
        timings = ResultFolder(Path(folder)).timings().values()
    print("| submission | suite | episodes | simulated s | wall / simulated | step p50 ms | step p95 ms |", end="")
    print(" simulator peak MB | submission peak MB |\n|---|---|---|---|---|---|---|---|---|")
    ratio = statistics.median(timing.wall_per_sim for timing in timings)
    p50, p95 = (
        statistics.median(1000 * (value or 0.0) for value in values)
        for values in ([t.agent_p50_s for t in timings], [t.agent_p95_s for t in timings])
    )
    ours, theirs = (
        resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    simulated_s = sum(timing.sim_time_s for timing in timings)
    print(
        f"| {options.submission} | {options.suite} | {len(timings)} | {simulated_s:.0f} | {ratio:.2f} | {p50:.1f} "
        f"| {p95:.1f} | {ours:.0f} | {theirs:.0f} |"
    )


if __name__ == "__main__":
    main()
