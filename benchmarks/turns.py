"""Programs in processes of their own that take turns at being timed, so that what else a machine does hits all alike.

A worker calls `serve(step)`; the benchmark starts it as a `Worker` and asks for turns. Standard library only: the
peers' workers run it under their own Python.
"""

import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
MARK = "turn:"  # before every line of ours: peers print what they like
SETTLE_S = 0.2  # before a turn: threads of the one before spin on for a while, on the cores that the next one needs


def serve(step: Callable[[], object], **facts: object) -> None:
    """Say that the first step is done, then time as many steps as each line of stdin asks for."""
    _say(facts)
    for line in sys.stdin:
        marks_s = [time.perf_counter()]
        for _ in range(int(line)):
            step()
            marks_s.append(time.perf_counter())
        _say({"mean_s": (marks_s[-1] - marks_s[0]) / (len(marks_s) - 1)})


def _say(message: Mapping[str, object]) -> None:
    sys.stdout.write(f"\n{MARK}{json.dumps(message)}\n")
    sys.stdout.flush()


class Worker:
    """A running worker; it idles between its turns. `ready_s`: from its start to its first step done."""

    def __init__(self, name: str, *command: str, env: Mapping[str, str] | None = None) -> None:
        """Start it and wait for its first step. Raises RuntimeError with its last words if it ends before."""
        self.name, start_s = name, time.perf_counter()
        self._folder = tempfile.TemporaryDirectory()
        with self._errors.open("w", encoding="utf-8") as errors:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env={**os.environ, "PYTHONPATH": str(HERE), **(env or {})},
            )
        self.facts = self._hear()
        self.ready_s = time.perf_counter() - start_s

    def turn(self, steps: int) -> float:
        """Return the mean time of a step over so many."""
        assert self._process.stdin
        self._process.stdin.write(f"{steps}\n")
        self._process.stdin.flush()
        return float(self._hear()["mean_s"])

    def _hear(self) -> dict[str, Any]:
        assert self._process.stdout
        for line in self._process.stdout:
            if line.startswith(MARK):
                return dict(json.loads(line.removeprefix(MARK)))
        words = self._errors.read_text(encoding="utf-8", errors="replace")
        raise RuntimeError(f"{self.name} ended:\n{words[-2000:]}")

    @property
    def _errors(self) -> Path:
        return Path(self._folder.name) / "errors.txt"

    def __enter__(self) -> "Worker":
        return self

    def __exit__(self, *error: object) -> None:
        self._process.communicate()  # closes its stdin, which ends it
        self._folder.cleanup()


def take_turns(workers: Sequence[Worker], rounds: int, steps: int) -> dict[str, list[float]]:
    """Return every worker's mean time of a step, one figure a round; each round begins with another worker."""
    for worker in workers:
        worker.turn(max(steps // 4, 1))  # warm caches
    found: dict[str, list[float]] = {worker.name: [] for worker in workers}
    for number in range(rounds):
        first = number % len(workers)
        for worker in (*workers[first:], *workers[:first]):
            time.sleep(SETTLE_S)
            found[worker.name].append(worker.turn(steps))
    return found


def ratio(slower: Sequence[float], faster: Sequence[float]) -> float:
    """Return the median over the rounds of how many times longer the one took."""
    return statistics.median(a / b for a, b in zip(slower, faster, strict=True))


def machine_line(**facts: str) -> str:
    """Return a line on this machine: its processor, how many of its cores are ours, what is used, how busy it was."""
    models = [line.split(":", 1)[1].strip() for line in _cpu_lines() if line.startswith("model name")]
    cores = len(os.sched_getaffinity(0))
    model = models[0] if models else platform.machine()
    named = "".join(f"; {name} {value}" for name, value in facts.items())
    busy = f"load {os.getloadavg()[0]:.2f} at the start"
    return f"Machine: {model}, {cores} cores, Python {platform.python_version()}{named}; {busy}."


def _cpu_lines() -> list[str]:
    path = Path("/proc/cpuinfo")
    return path.read_text(encoding="utf-8").splitlines() if path.exists() else []


def table(*rows: Sequence[str]) -> str:
    """Return a markdown table; the first row is its head."""
    head, *body = (f"| {' | '.join(row)} |" for row in rows)
    return "\n".join([head, "|---" * len(rows[0]) + "|", *body])
