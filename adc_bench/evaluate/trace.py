"""What a run leaves behind, however it ends."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from adc_bench.errors import AdcBenchError, InputError
from adc_bench.evaluate.agent_side import AgentFailedError, AgentSide
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.loading import told
from adc_bench.evaluate.log import AnyRow
from adc_bench.evaluate.sandbox import PACKAGE
from adc_bench.evaluate.sensed import Sensed

OneRow = TypeVar("OneRow", bound=AnyRow)


@dataclass(frozen=True, kw_only=True)
class Driven(Generic[OneRow]):
    """What a run left behind: its rows and ending, the loop's wall time, the submission's times by step, and the last
    observation that it was given.
    """

    rows: tuple[OneRow, ...]
    ending: Ending
    wall_s: float
    compute_s: tuple[float, ...]
    last_asked: Sensed | None

    @property
    def sim_time_s(self) -> float:
        """The simulated time at the end."""
        return self.rows[-1].time_s if self.rows else 0.0


class Trace(Generic[OneRow]):
    """What a run has left behind so far."""

    def __init__(self) -> None:
        self.rows: list[OneRow] = []  # those that have been answered
        self.unanswered: tuple[OneRow, ...] = ()  # those after them
        self.compute_s: list[float] = []
        self.begun_s = time.perf_counter()
        self.asked: Sensed | None = None

    def driven(self, ending: Ending) -> Driven[OneRow]:
        """Return the run as it ended now."""
        return Driven(
            rows=(*self.rows, *self.unanswered),
            ending=ending,
            wall_s=time.perf_counter() - self.begun_s,
            compute_s=tuple(self.compute_s),
            last_asked=self.asked,
        )


def to_its_end(trace: Trace[OneRow], run: Callable[[], Ending]) -> Driven[OneRow]:
    """Return a run; whatever goes wrong in it ends it and nothing else, and its ending says what.

    Raises:
        AdcBenchError: as the run raised it.
    """
    try:
        ending = run()
    except AdcBenchError:
        raise
    except AgentFailedError as failure:
        ending = failure.ending
    except (OSError, MemoryError) as error:
        ending = Ending(reason=Reason.HOST, detail=told(error, PACKAGE.parent))
    except Exception as error:  # the simulator's fault must not cost the suite's other runs
        ending = Ending(reason=Reason.SIMULATOR, detail=told(error, PACKAGE.parent))
    return trace.driven(ending)


def wait_loaded(trace: Trace[OneRow], agent: AgentSide) -> None:
    """Wait until a submission is loaded; the run's wall time counts from then on.

    Raises:
        AgentFailedError: it cannot be loaded, though it could before the first run.
    """
    try:
        agent.wait_loaded()
    except InputError as error:
        raise AgentFailedError(Ending(reason=Reason.LOAD_FAILED, detail=error.found)) from None
    trace.begun_s = time.perf_counter()
