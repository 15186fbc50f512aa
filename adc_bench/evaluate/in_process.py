"""A Python submission in the loop's own process: quick to look into, held to nothing, never on a leaderboard."""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

import cv2

from adc_bench.api import Mission
from adc_bench.errors import AdcBenchError, InputError
from adc_bench.evaluate.agent_side import AgentFailedError, Answered, Isolation, Load, content, sound
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.loading import Loaded, asked, fault_of, load_agent, told
from adc_bench.evaluate.protocol import ANSWER, NOT_AN_ANSWER, AnswerMessage, answer_message
from adc_bench.evaluate.sensed import Sensed, observation_of
from adc_bench.evaluate.wire import ShapeError, decoded, encoded


class InProcessAgent:
    """A context manager; leaving it forgets the submission's modules, so that the next run starts afresh."""

    isolation: Isolation = "in-process"
    printed = b""

    def __init__(self, load: Load, limits: Limits, make: Callable[[Load, Path], Loaded] = load_agent) -> None:
        self._load, self._limits, self._folder, self._make = load, limits, Path(load.folder or "/"), make

    def __enter__(self) -> "InProcessAgent":
        self._threads = cv2.getNumThreads()
        cv2.setNumThreads(1)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        cv2.setNumThreads(self._threads)
        if self._load.folder is None:
            return
        if str(self._folder) in sys.path:
            sys.path.remove(str(self._folder))
        for name, module in list(sys.modules.items()):
            if Path(getattr(module, "__file__", None) or "/").is_relative_to(self._folder):
                del sys.modules[name]

    def wait_loaded(self) -> None:
        """Make the agent; raise InputError if that fails."""
        try:
            self._agent = self._make(self._load, self._folder)
        except AdcBenchError as error:
            raise InputError(where=error.where, found=error.found, wanted=error.wanted, todo=error.todo) from None
        except Exception as error:
            where, fault = f"submission entry {self._load.name}", fault_of(error, self._load, self._folder)
            raise InputError(where=where, found=fault.found, wanted=fault.wanted, todo=fault.todo) from None

    def start(self, mission: Mission) -> None:
        """Call `start`; raise AgentFailedError if it raises."""
        try:
            self._agent.start(mission)
        except Exception as error:
            raise self._failed(Reason.START_RAISED, error) from None

    def ask(self, sensed: Sensed) -> None:
        """Keep the observation for `answer`."""
        self._sensed = sensed

    def answer(self) -> Answered:
        """Call `step` or `detect`; raise AgentFailedError if it raises or returns what is no answer."""
        kind, observation = self._load.kind, observation_of(self._sensed)
        begun_s = time.perf_counter()
        try:
            answer = asked(kind, self._agent, observation)
        except Exception as error:
            raise self._failed(Reason.STEP_RAISED, error) from None
        took_s = time.perf_counter() - begun_s
        try:
            body = encoded(answer_message(kind, observation.step, answer))
            message: AnswerMessage = decoded(body, ANSWER[kind])
        except (TypeError, ShapeError) as error:
            raise AgentFailedError(Ending(reason=Reason(NOT_AN_ANSWER[kind]), detail=str(error))) from None
        return Answered(answer=sound(content(message), self._limits), compute_s=took_s)

    def _failed(self, reason: Reason, error: Exception) -> AgentFailedError:
        return AgentFailedError(Ending(reason=reason, detail=told(error, self._folder)))
