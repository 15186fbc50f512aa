"""Local worker processes.

Workers are started afresh (spawn), so they share nothing with this process; a worker ends when this process is gone,
whatever became of it.
"""

import multiprocessing
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from adc_bench.engine.task import LOG, TRIES, Done, Numbered, answer, died_too_often


def run_in_processes(
    function: Callable[[Any], Any], tasks: Numbered, count: int, node: str, tell: Callable[[Done[Any]], None]
) -> None:
    """Do the tasks in `count` processes (fewer if there are fewer tasks); `tell` is told of each as it ends."""
    with _Crew(function, node) as crew:
        for index, task in tasks:
            crew.hand_out(crew.hire() if len(crew.busy) < count else crew.free(tell), index, task)
        while crew.busy:
            crew.free(tell)


class _Crew:
    """Worker processes, each at the end of a pipe; leaving the context ends them."""

    def __init__(self, function: Callable[[Any], Any], node: str) -> None:
        self._context = multiprocessing.get_context("spawn")
        self._function, self._node = function, node
        self._processes: dict[Connection, BaseProcess] = {}
        self._deaths: Counter[int] = Counter()
        self.busy: dict[Connection, tuple[int, Any]] = {}

    def __enter__(self) -> "_Crew":
        return self

    def __exit__(self, *_: object) -> None:
        for connection, process in self._processes.items():
            process.kill()
            process.join()
            connection.close()

    def hire(self) -> Connection:
        """Start a worker."""
        here, there = self._context.Pipe()
        process = self._context.Process(target=_work, args=(self._function, self._node, there), daemon=True)
        process.start()
        there.close()
        self._processes[here] = process
        return here

    def hand_out(self, to: Connection, index: int, task: Any) -> None:
        """Give a worker a task; one that has died meanwhile is found out when its answer is awaited."""
        self.busy[to] = index, task
        with suppress(BrokenPipeError, ConnectionResetError):
            to.send(task)

    def free(self, tell: Callable[[Done[Any]], None]) -> Connection:
        """Wait for a task to end, tell of it, and return the worker that is free now."""
        while True:
            ready = wait(list(self.busy))[0]
            assert isinstance(ready, Connection)
            index, task = self.busy.pop(ready)
            try:
                said = ready.recv()
            except (EOFError, ConnectionResetError):
                self._try_again(ready, index, task)
                continue
            tell(said.done(index))
            return ready

    def _try_again(self, dead: Connection, index: int, task: Any) -> None:
        """Replace a worker that died and give its task to the new one."""
        process = self._processes.pop(dead)
        dead.close()
        process.join()
        how = _way(process.exitcode or 0)
        self._deaths[index] += 1
        if self._deaths[index] == TRIES:
            raise died_too_often(index, how)
        LOG.warning("a worker died %s; its task (%d) is tried again", how, index)
        self.hand_out(self.hire(), index, task)


def _way(exit_code: int) -> str:
    return f"of {signal.Signals(-exit_code).name}" if exit_code < 0 else f"with exit code {exit_code}"


def _work(function: Callable[[Any], Any], node: str, connection: Connection) -> None:
    """Answer tasks until the other end of the pipe, or the parent itself, is gone."""
    threading.Thread(target=_follow_parent, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent ends this process
    while True:
        try:
            connection.send(answer(function, connection.recv(), node))
        except (EOFError, BrokenPipeError):
            return


def _follow_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
