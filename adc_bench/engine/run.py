"""The one door: tasks in, results told as they come."""

import os
from collections.abc import Callable, Iterable
from time import perf_counter
from typing import Any, Literal, TypeVar, get_args

from adc_bench.engine.local import run_in_processes
from adc_bench.engine.task import Done

Engine = Literal["local", "ray"]
ENGINES: tuple[Engine, ...] = get_args(Engine)
HERE = "this machine"
Task = TypeVar("Task")
Result = TypeVar("Result")


def default_workers() -> int:
    """Return the number of processors this process may use."""
    return len(os.sched_getaffinity(0))


def run_tasks(
    function: Callable[[Task], Result],
    tasks: Iterable[Task],
    *,
    engine: Engine = "local",
    workers: int | None = None,
    done: Callable[[Done[Result]], None],
) -> None:
    """Tell `done` of `function(task)` for every task, in the order in which they end; only tasks in flight are held.

    `workers` is how many run at once: of the processors of this machine (all if None; 1 is this process itself), or of
    the CPUs of the Ray cluster. Beyond one process, function, tasks and results travel, so the function is one of a
    module. A task whose worker dies is tried again, `TRIES` times in all; one that raises is not. The first failure, or
    Ctrl-C, ends the workers at once: tasks leave whole files or none.

    Raises:
        AdcBenchError: as the function raised it.
        RuntimeError: the function raised anything else in a worker.
        MachineError: a task's workers died too often; Ray is not installed, or has no cluster running.
    """
    numbered = enumerate(tasks)
    if engine == "ray":
        from adc_bench.engine.ray import run_on_ray

        run_on_ray(function, numbered, workers, done)
    elif (workers or default_workers()) == 1:
        for index, task in numbered:
            done(_done_here(function, index, task))
    else:
        run_in_processes(function, numbered, workers or default_workers(), HERE, done)


def _done_here(function: Callable[[Any], Any], index: int, task: Any) -> Done[Any]:
    begun = perf_counter()
    result = function(task)
    return Done(index=index, result=result, node=HERE, elapsed_s=perf_counter() - begun)
