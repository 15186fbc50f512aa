"""The conversation with a submission's process, in the episode loop's words: held to its budgets, every fault named."""

import time
from types import TracebackType

import msgspec

from adc_bench.api import Mission
from adc_bench.errors import InputError
from adc_bench.evaluate.agent_side import AgentFailedError, Answered, Isolation, Load, content, sound
from adc_bench.evaluate.arrival import ArrivalClock
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.launch import Launched
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.protocol import (
    ANSWER,
    NOT_AN_ANSWER,
    VERSION,
    AnswerMessage,
    Fault,
    Hello,
    MissionMessage,
    Ready,
    Reply,
    kind_of,
)
from adc_bench.evaluate.sensed import Sensed, message_of
from adc_bench.evaluate.wire import Channel, ClosedError, MessageError, ShapeError
from adc_bench.world.sensors import SensorRig

POLL_S = 0.05


class AgentProcess:
    """A context manager: the process lives inside it and is killed, with all it started, at its end.

    Entering returns at once; the submission loads meanwhile.
    """

    def __init__(self, load: Load, rig: SensorRig, limits: Limits) -> None:
        self._load, self._rig, self._limits = load, rig, limits
        self._thought_s = self._asked_s = 0.0
        self._step = -1
        self._channel: Channel | None = None

    def __enter__(self) -> "AgentProcess":
        self._child = Launched(self._load, self._rig, self._limits)
        self._load_until = time.monotonic() + self._limits.load_s
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._channel:
            self._clock.stop()
            self._socket.close()
        self._child.close()

    @property
    def isolation(self) -> Isolation:
        """How far the submission is kept from the rest."""
        return self._child.isolation

    @property
    def printed(self) -> bytes:
        """What the submission has printed; whole once the context is left."""
        return self._child.watch.printed

    def wait_loaded(self) -> None:
        """Wait until the submission is loaded.

        Raises:
            InputError: it cannot be loaded; nothing can be scored.
        """
        try:
            self._connect()
            assert self._channel is not None
            reply = self._channel.receive(Reply, max(self._load_until - time.monotonic(), 0.0))
        except TimeoutError:
            raise self._unloadable(f"still loading after {self._limits.load_s:g} s") from None
        except ClosedError:
            raise self._unloadable(f"its process ended while loading ({self._child.how_it_ended()})") from None
        except MessageError as error:
            raise self._unloadable(f"a message that is none: {error}") from None
        if isinstance(reply, Fault):
            wanted, todo = reply.wanted or "a submission that loads", reply.todo or "mend it"
            raise InputError(where=reply.where or self._where, found=reply.found, wanted=wanted, todo=todo)
        if not isinstance(reply, Hello) or reply.protocol != VERSION:
            found = f"protocol {reply.protocol}" if isinstance(reply, Hello) else f"a {kind_of(reply)} at first"
            raise self._unloadable(f"{found}, where hello with protocol {VERSION} was due")

    @property
    def _where(self) -> str:
        return f"submission entry {self._load.name}"

    def _unloadable(self, found: str) -> InputError:
        lines = self.printed.decode(errors="replace").strip().splitlines()[-8:]
        said = "".join(f"\n    | {line}" for line in lines)
        todo = "mend the submission; `adc-bench validate` tries it quickly"
        return InputError(where=self._where, found=found + said, wanted="a submission that loads", todo=todo)

    def _connect(self) -> None:
        """Wait for the submission to connect; nobody can a second time."""
        self._child.listener.settimeout(POLL_S)
        while True:
            try:
                self._socket, _ = self._child.listener.accept()
                break
            except TimeoutError:
                if self._child.has_ended:
                    raise ClosedError from None
                if time.monotonic() > self._load_until:
                    raise
        self._child.listener.close()
        self._channel = Channel(self._socket, self._limits.message_bytes)
        self._clock = ArrivalClock(self._socket)

    def start(self, mission: Mission) -> None:
        """Tell the mission and wait until the submission is ready.

        Raises:
            AgentFailedError: it gave up, took too long, or its process died.
        """
        self._send(MissionMessage(mission=mission))
        reply = self._receive(self._limits.start_s, Reason.START_TIMEOUT, Reason.START_RAISED)
        if not isinstance(reply, Ready):
            raise _failed(Reason.OUT_OF_TURN, f"a {kind_of(reply)} where ready was due")

    def ask(self, sensed: Sensed) -> None:
        """Hand over an observation; returns at once.

        Raises:
            AgentFailedError: the process died, or takes no messages.
        """
        message = message_of(sensed, self._child.shelf)
        self._step = sensed.step
        self._asked_s = time.perf_counter()
        self._send(message)

    def answer(self) -> Answered:
        """Wait for the answer to the last observation; the budget counts from now.

        Raises:
            AgentFailedError: the submission gave up, took too long, died, or answered with what is no answer.
        """
        kind = self._load.kind
        reply = self._receive(self._limits.step_s, Reason.STEP_TIMEOUT, Reason.STEP_RAISED)
        took_s = self._took_s()
        self._thought_s += took_s
        if not isinstance(reply, AnswerMessage) or not isinstance(reply, ANSWER[kind]) or reply.step != self._step:
            which = f" for step {reply.step}" if isinstance(reply, AnswerMessage) else ""
            due = f"the {ANSWER[kind].__struct_config__.tag} for step {self._step} was due"
            raise _failed(Reason.OUT_OF_TURN, f"a {kind_of(reply)}{which} where {due}")
        if self._thought_s > self._limits.total_s:
            raise _failed(Reason.TOTAL_TIMEOUT, f"thought for more than {self._limits.total_s:g} s in all")
        return Answered(answer=sound(content(reply), self._limits), compute_s=took_s)

    def _took_s(self) -> float:
        arrived_s, now_s = self._clock.last_s, time.perf_counter()
        return (arrived_s if arrived_s > self._asked_s else now_s) - self._asked_s

    def _send(self, order: msgspec.Struct) -> None:
        assert self._channel is not None
        try:
            self._channel.send(order, self._limits.step_s)
        except ClosedError:
            raise AgentFailedError(self._end()) from None
        except TimeoutError:
            raise _failed(Reason.STEP_TIMEOUT, f"took no message within {self._limits.step_s:g} s") from None

    def _receive(self, budget_s: float, too_late: Reason, raised: Reason) -> Hello | Ready | AnswerMessage:
        assert self._channel is not None
        try:
            reply: Reply = self._channel.receive(Reply, budget_s)
        except TimeoutError:
            raise _failed(too_late, f"no answer within {budget_s:g} s") from None
        except ClosedError:
            raise AgentFailedError(self._end()) from None
        except ShapeError as error:
            raise _failed(Reason(NOT_AN_ANSWER[self._load.kind]), str(error)) from None
        except MessageError as error:
            raise _failed(Reason.BAD_MESSAGE, str(error)) from None
        if isinstance(reply, Fault):
            raise _failed(raised if reply.kind == "raised" else Reason(reply.kind), reply.found)
        return reply

    def _end(self) -> Ending:
        how = self._child.how_it_ended()
        return self._child.watch.verdict or Ending(reason=Reason.DIED, detail=how)


def _failed(reason: Reason, detail: str) -> AgentFailedError:
    return AgentFailedError(Ending(reason=reason, detail=detail))
