"""What a Ray cluster costs beside local processes: the same tasks by both, in turns, on this machine.

Usage: python benchmarks/ray_overhead.py [--frames 1024] [--rounds 3]

Both have two workers; the cluster has two nodes of one CPU, started before. Empty tasks show what handing one out
costs; rendering (160x120, 64 frames a shard) shows what is left of that. Each is a process of its own, as a user's is:
the whole command counts its start, too. Medians over the rounds.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EMPTY_TASKS = 400
ENVIRONMENT = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_DISABLE_DOCKER_CPU_WARNING": "1"}
ENGINES = ("local", "ray")
COLUMNS = ("s an empty task", "s of rendering", "s of the whole command")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=1024)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--empty", choices=ENGINES, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.empty:
        print(json.dumps(empty_task_s(options.empty)))
        return
    from turns import machine_line, ratio, table

    print(machine_line(frames=str(options.frames), rounds=str(options.rounds)), flush=True)
    found = in_turns(options.frames, options.rounds)
    columns = {engine: list(zip(*rounds, strict=True)) for engine, rounds in found.items()}
    rows = [(name, *(f"{statistics.median(column):.4g}" for column in columns[name])) for name in ENGINES]
    ratios = [f"{ratio(ray, local):.2f}" for local, ray in zip(columns["local"], columns["ray"], strict=True)]
    print(f"\n{table(('engine', *COLUMNS), *rows, ('ray / local', *ratios))}")


def in_turns(frames: int, rounds: int) -> dict[str, list[tuple[float, float, float]]]:
    """Return each engine's figures (`COLUMNS`), a tuple a round, measured on a cluster that lives meanwhile."""
    found: dict[str, list[tuple[float, float, float]]] = {engine: [] for engine in ENGINES}
    node = {"num_cpus": 1, "object_store_memory": 80 * 2**20}
    with tempfile.TemporaryDirectory(prefix="ray") as scratch:
        os.environ.update(ENVIRONMENT, RAY_TMPDIR=scratch)
        from ray.cluster_utils import Cluster

        cluster = Cluster(initialize_head=True, head_node_args={"include_dashboard": False, **node})
        cluster.add_node(**node)
        os.environ["RAY_ADDRESS"] = cluster.address
        for number in range(rounds):
            for engine in ENGINES if number % 2 == 0 else ENGINES[::-1]:
                empty_s = float(run([__file__, "--empty", engine]))
                found[engine].append((empty_s, *rendered_s(engine, frames)))
        cluster.shutdown()
    return found


def rendered_s(engine: str, frames: int) -> tuple[float, float]:
    """Return the seconds of a run, and of the whole command."""
    code = "from adc_bench.cli.main import main; main()"
    words = ["--split", "train", "--size", "160x120", "--frames-per-shard", "64", "--frames", str(frames), "--json"]
    with tempfile.TemporaryDirectory() as folder:
        begun_s = time.perf_counter()
        out = str(Path(folder) / "out")
        report = run(["-c", code, "render", "--out", out, "--engine", engine, "--workers", "2", *words])
        return float(json.loads(report)["elapsed_s"]), time.perf_counter() - begun_s


def empty_task_s(engine: str) -> float:
    """Return the time of an empty task, the workers being there."""
    from adc_bench.engine import run_tasks

    marks_s: list[float] = []
    run_tasks(abs, range(EMPTY_TASKS), engine=engine, workers=2, done=lambda _: marks_s.append(time.perf_counter()))
    half = EMPTY_TASKS // 2
    return (marks_s[-1] - marks_s[half]) / (EMPTY_TASKS - 1 - half)


def run(words: list[str]) -> str:
    return subprocess.run([sys.executable, *words], check=True, stdout=subprocess.PIPE, text=True).stdout


if __name__ == "__main__":
    main()
