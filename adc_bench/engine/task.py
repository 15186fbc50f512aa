"""What every engine shares: the answer of a task, an error's way back from a worker, how often a death is forgiven."""

import logging
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import perf_counter
from typing import Any, Generic, TypeVar

from adc_bench.errors import AdcBenchError, MachineError

TRIES = 3  # of a task whose workers die; a task that kills three would kill the next
Result = TypeVar("Result")
LOG = logging.getLogger("adc_bench")


@dataclass(frozen=True, kw_only=True)
class Done(Generic[Result]):
    """A task that is done: its place among the tasks, what came of it, who did it, and how long that took."""

    index: int
    result: Result
    node: str
    elapsed_s: float


@dataclass(frozen=True, kw_only=True)
class Failure:
    """What a worker says of a task that raised: an error of the family by its parts, any other by its traceback."""

    kind: type[AdcBenchError] | None
    parts: dict[str, str]

    def raise_here(self) -> None:
        """Raise on this side what was raised on the other."""
        if self.kind is not None:
            raise self.kind(**self.parts)
        raise RuntimeError(f"a worker failed:\n{self.parts['traceback']}")


@dataclass(frozen=True, kw_only=True)
class Answer:
    """A worker's answer to a task: its result or a `Failure`, the worker's node, and the time it took."""

    content: Any
    node: str
    elapsed_s: float

    def done(self, index: int) -> Done[Any]:
        """Return the task's result; raise what the worker raised."""
        if isinstance(self.content, Failure):
            self.content.raise_here()
        return Done(index=index, result=self.content, node=self.node, elapsed_s=self.elapsed_s)


def answer(function: Callable[[Any], Any], task: Any, node: str) -> Answer:
    """Do a task in a worker."""
    begun = perf_counter()
    try:
        content = function(task)
    except AdcBenchError as error:
        parts = {"where": error.where, "found": error.found, "wanted": error.wanted, "todo": error.todo}
        content = Failure(kind=type(error), parts=parts)
    except Exception:  # whatever it was, it is told in full and raised again on the other side
        content = Failure(kind=None, parts={"traceback": traceback.format_exc()})
    return Answer(content=content, node=node, elapsed_s=perf_counter() - begun)


def died_too_often(index: int, how: str) -> MachineError:
    """Return the error of a task that no worker survives."""
    return MachineError(
        where=f"task {index}",
        found=f"its worker died {TRIES} times, the last time {how}",
        wanted="a worker that lives: most that die are killed by the kernel when memory runs out",
        todo="use fewer --workers or free some memory, then run the same command again: it goes on where it stopped",
    )


Numbered = Iterator[tuple[int, Any]]
