"""Map idempotent tasks over this process or over local worker processes.

Workers are started afresh (spawn), so they share nothing with this process; a worker ends when this process is gone,
whatever became of it. Results come back in the order of the tasks.
"""

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from adc_bench.errors import AdcBenchError

Task = TypeVar("Task")
Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class _Failure:
    """What a worker says of a task that raised: an error of the family by its parts, any other by its traceback."""

    kind: type[AdcBenchError] | None
    parts: dict[str, str]

    def raise_here(self) -> None:
        if self.kind is not None:
            raise self.kind(**self.parts)
        raise RuntimeError(f"a worker failed:\n{self.parts['traceback']}")


def default_workers() -> int:
    """Return the number of processors this process may use."""
    return len(os.sched_getaffinity(0))


def run_tasks(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    workers: int = 1,
    done: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """Return `function(task)` for every task, in order; `done(index, result)` is told of each as it ends.

    With more than one worker, function, tasks and results travel between processes, so the function is one of a module.
    The first failure, or Ctrl-C, ends the workers at once: tasks leave whole files or none.

    Raises:
        AdcBenchError: as the function raised it.
        RuntimeError: the function raised anything else in a worker, or a worker was killed.
    """
    tell = done or (lambda index, result: None)
    if workers <= 1 or len(tasks) <= 1:
        return [_told(index, function(task), tell) for index, task in enumerate(tasks)]
    with _Crew(function, min(workers, len(tasks))) as crew:
        return crew.run(tasks, tell)


def _told(index: int, result: Result, tell: Callable[[int, Result], None]) -> Result:
    tell(index, result)
    return result


class _Crew:
    """Worker processes, each at the end of a pipe; leaving the context ends them."""

    def __init__(self, function: Callable[[Any], Any], count: int) -> None:
        context = multiprocessing.get_context("spawn")
        self._processes: dict[Connection, BaseProcess] = {}
        for _ in range(count):
            here, there = context.Pipe()
            process = context.Process(target=_work, args=(function, there), daemon=True)
            process.start()
            there.close()
            self._processes[here] = process

    def __enter__(self) -> "_Crew":
        return self

    def __exit__(self, *_: object) -> None:
        for connection, process in self._processes.items():
            process.kill()
            process.join()
            connection.close()

    def run(self, tasks: Sequence[Any], tell: Callable[[int, Any], None]) -> list[Any]:
        results: dict[int, Any] = {}
        queue = iter(range(len(tasks)))
        busy: dict[Connection, int] = {}
        for connection in self._processes:
            _hand_out(connection, queue, tasks, busy)
        while busy:
            for ready in wait(list(busy)):
                assert isinstance(ready, Connection)
                index = busy.pop(ready)
                results[index] = self._receive(ready)
                tell(index, results[index])
                _hand_out(ready, queue, tasks, busy)
        return [results[index] for index in range(len(tasks))]

    def _receive(self, connection: Connection) -> Any:
        try:
            answer = connection.recv()
        except EOFError:
            process = self._processes[connection]
            process.join()
            raise RuntimeError(f"a worker process ended with exit code {process.exitcode} in mid task") from None
        if isinstance(answer, _Failure):
            answer.raise_here()
        return answer


def _hand_out(to: Connection, queue: Iterator[int], tasks: Sequence[Any], busy: dict[Connection, int]) -> None:
    index = next(queue, None)
    if index is not None:
        to.send(tasks[index])
        busy[to] = index


def _work(function: Callable[[Any], Any], connection: Connection) -> None:
    """Answer tasks until the other end of the pipe, or the parent itself, is gone."""
    threading.Thread(target=_follow_parent, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent ends this process
    while True:
        try:
            connection.send(_answer(function, connection.recv()))
        except (EOFError, BrokenPipeError):
            return


def _follow_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _answer(function: Callable[[Any], Any], task: Any) -> Any:
    try:
        return function(task)
    except AdcBenchError as error:
        parts = {"where": error.where, "found": error.found, "wanted": error.wanted, "todo": error.todo}
        return _Failure(kind=type(error), parts=parts)
    except Exception:  # whatever it was, it is told in full and raised again on the other side
        return _Failure(kind=None, parts={"traceback": traceback.format_exc()})
