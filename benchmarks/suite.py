"""What a whole suite takes: wall time by one worker, by two, and on Ray; and whether memory stays flat over many runs.

Usage: python benchmarks/suite.py time [--submission reference] [--suite d1]
       python benchmarks/suite.py memory [--runs 100]

`time` runs the command `adc-bench evaluate submission` once each way, its start included, and holds the results' bytes
against each other. The Ray cluster has two nodes of one CPU, started before. `memory` drives many short runs of d1, one
after the other, each with an arena and a process of the submission of its own.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import numpy as np
from memory import resident_mb
from turns import machine_line, table

WAYS = {"1 worker": ("--workers", "1"), "2 workers": ("--workers", "2"), "Ray, 2 nodes": ("--engine", "ray")}
ENVIRONMENT = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DISABLE_DOCKER_CPU_WARNING": "1"}
RUN_S, FIRST_SEED = 1.0, 910_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parts = parser.add_subparsers(dest="part", required=True)
    timed = parts.add_parser("time")
    timed.add_argument("--submission", default="reference")
    timed.add_argument("--suite", default="d1")
    parts.add_parser("memory").add_argument("--runs", type=int, default=100)
    options = parser.parse_args()
    if options.part == "time":
        print(machine_line(submission=options.submission, suite=options.suite), flush=True)
        print(f"\n{table(*times(options.submission, options.suite))}")
    else:
        print(machine_line(runs=str(options.runs)), flush=True)
        print(f"\n{table(*memory(options.runs))}")


def times(submission: str, suite: str) -> list[tuple[str, ...]]:
    """Return the rows of a table: the whole command by each way."""
    rows, taken_s, results = [], [], set()
    with tempfile.TemporaryDirectory() as folder, ray_cluster():
        for number, (way, words) in enumerate(WAYS.items()):
            out = Path(folder, str(number))
            begun_s = time.perf_counter()
            evaluate(submission, suite, out, *words)
            taken_s.append(time.perf_counter() - begun_s)
            runs = json.loads((out / "timing.json").read_bytes())["episodes"].values()
            simulated_s = sum(run["sim_time_s"] for run in runs)
            ratio, speed_up = taken_s[-1] / simulated_s, taken_s[0] / taken_s[-1]
            results.add((out / "result.json").read_bytes())
            rows.append((way, f"{simulated_s:.0f}", f"{taken_s[-1]:.0f}", f"{ratio:.2f}", f"{speed_up:.2f}"))
    assert len(results) == 1, "results differ"
    return [("by", "simulated s", "wall s", "wall / simulated", "times as fast"), *rows]


def evaluate(submission: str, suite: str, out: Path, *words: str) -> None:
    code = "from adc_bench.cli.main import main; main()"
    told = ("evaluate", "submission", submission, "--suite", suite, "--out", str(out), "--json", *words)
    subprocess.run([sys.executable, "-c", code, *told], check=True, stdout=subprocess.DEVNULL)


@contextmanager
def ray_cluster() -> Iterator[None]:
    """Keep a cluster of two nodes of one CPU, to which `--engine ray` goes."""
    node = {"num_cpus": 1, "object_store_memory": 80 * 2**20}
    with tempfile.TemporaryDirectory(prefix="ray") as scratch:
        os.environ.update(ENVIRONMENT, RAY_TMPDIR=scratch)
        from ray.cluster_utils import Cluster

        cluster = Cluster(initialize_head=True, head_node_args={"include_dashboard": False, **node})
        cluster.add_node(**node)
        os.environ["RAY_ADDRESS"] = cluster.address
        yield
        cluster.shutdown()


def memory(runs: int) -> list[tuple[str, ...]]:
    """Return the rows of a table: this process' resident size after runs of a suite."""
    from adc_bench.evaluate.run import evaluate_submission
    from adc_bench.evaluate.submission import load_submission
    from adc_bench.evaluate.suite import load_suite

    suite = msgspec.structs.replace(
        load_suite("d1"),
        name="short",
        ranked=False,
        seeds=tuple(range(FIRST_SEED, FIRST_SEED + runs)),
        start_delay_s=(0.5, 0.5),
        time_limit_s=RUN_S,
    )
    sizes_mb: list[float] = []
    with tempfile.TemporaryDirectory() as out:
        submission = load_submission("stand-still", {})
        evaluate_submission(submission, suite, Path(out), tell=lambda done: sizes_mb.append(resident_mb()))
    warm = np.array(sizes_mb[1 + runs // 5 :])  # the first tell comes before any run
    half, slope_mb = len(warm) // 2, np.polyfit(np.arange(len(warm)), warm, 1)[0]
    head = ("runs", "resident MB after a fifth", "greatest in the first half of the rest", "in the second", "slope")
    figures = (warm[0], warm[:half].max(), warm[half:].max())
    return [head, (str(runs), *(f"{mb:.1f}" for mb in figures), f"{slope_mb:+.3f} MB a run")]


if __name__ == "__main__":
    main()
