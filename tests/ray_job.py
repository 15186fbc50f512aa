"""Jobs for a Ray cluster, each in a process of its own: `python ray_job.py (squares | error | deaths | poison)`."""

import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from adc_bench.engine import Done, run_tasks
from adc_bench.errors import AdcBenchError, MachineError


def square(number: int) -> int:
    time.sleep(0.2)
    return number * number


def fail(number: int) -> int:
    raise MachineError(where="there", found="nothing", wanted="a driver", todo=f"install {number}")


def die_once(mark: str) -> str:
    if not Path(mark).exists():
        Path(mark).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return mark


def die(_: str) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def main(what: str, scratch: str) -> None:
    told: list[Done[object]] = []
    taken = 0

    def numbers() -> Iterator[int]:
        nonlocal taken
        for number in range(12):
            taken = number + 1
            yield number

    most_ahead = 0

    def tell(done: Done[object]) -> None:
        nonlocal most_ahead
        told.append(done)
        most_ahead = max(most_ahead, taken - len(told))

    jobs = {
        "squares": (square, numbers()),
        "error": (fail, [7]),
        "deaths": (die_once, [f"{scratch}/mark"]),
        "poison": (die, [scratch]),
    }
    function, tasks = jobs[what]
    try:
        run_tasks(function, tasks, engine="ray", done=tell)
    except AdcBenchError as error:
        print(json.dumps({"kind": type(error).__name__, "found": error.found, "todo": error.todo}))
        return
    results = [done.result for done in sorted(told, key=lambda done: done.index)]
    print(json.dumps({"results": results, "nodes": sorted({done.node for done in told}), "ahead": most_ahead}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
