"""A submission's process, seen from the episode loop: started fresh, given orders, held to its budgets, ended."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

import msgspec

from adc_bench.api import Mission
from adc_bench.errors import InputError
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.wire import Answer, Begin, Channel, ClosedError, Done, Fault, Load, Reply, Sense

# In words, for timing.json: the child shares the machine, the user and the file system with the simulator.
ISOLATION = "none (child process)"

# All that a child sees of the environment, and one thread for every library that would choose its own number.
ENVIRONMENT_KEPT = ("PATH", "HOME", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "PYTHONPATH", "TMPDIR")
ENVIRONMENT_SET = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "PYTHONHASHSEED": "0",
    "PYTHONUNBUFFERED": "1",
    "PYTHONDONTWRITEBYTECODE": "1",
}


class AgentFailedError(Exception):
    """The submission failed as a program; `ending` says how."""

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending.reason)
        self.ending = ending


class AgentProcess:
    """A context manager: the process lives inside it and is killed, with all it started, at its end.

    `log_path` receives what the submission prints. Entering returns at once; the submission loads meanwhile.
    """

    def __init__(self, load: Load, log_path: Path, rules: Rules) -> None:
        self._load, self._log_path, self._rules = load, log_path, rules

    def __enter__(self) -> "AgentProcess":
        ours, theirs = socket.socketpair()
        with self._log_path.open("wb") as log, theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-X", "faulthandler", "-m", "adc_bench.evaluate.child", str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                pass_fds=[theirs.fileno()],
                cwd=self._load.folder or self._log_path.parent,
                env={key: os.environ[key] for key in ENVIRONMENT_KEPT if key in os.environ} | ENVIRONMENT_SET,
                start_new_session=True,
            )
        self._socket, self._channel = ours, Channel(ours)
        self._load_until = time.monotonic() + self._rules.load_budget_s
        self._channel.send(self._load)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._socket.close()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def wait_loaded(self) -> None:
        """Wait until the submission is loaded.

        Raises:
            InputError: it cannot be loaded; nothing can be scored.
        """
        budget_s = max(self._load_until - time.monotonic(), 0.0)
        where, wanted = f"submission entry {self._load.entry}", "a submission that loads"
        try:
            reply = self._channel.receive(Reply, budget_s)
        except TimeoutError:
            found = f"still loading after {self._rules.load_budget_s:g} s"
            raise InputError(where=where, found=found, wanted=wanted, todo="load less, or in start()") from None
        except (ClosedError, msgspec.DecodeError):
            found = f"its process ended while loading ({self._how_it_ended()})"
            todo = f"read {self._log_path}, which holds what it printed"
            raise InputError(where=where, found=found, wanted=wanted, todo=todo) from None
        if isinstance(reply, Fault):
            raise InputError(where=reply.where or where, found=reply.found, wanted=reply.wanted, todo=reply.todo)
        assert isinstance(reply, Done)

    def start(self, mission: Mission) -> None:
        """Call the agent's `start`.

        Raises:
            AgentFailedError: it raised, took too long, or its process died.
        """
        self._order(Begin(mission=mission))
        self._reply(self._rules.start_budget_s, Reason.START_TIMEOUT, Reason.START_RAISED)

    def ask(self, sense: Sense) -> None:
        """Hand over an observation; returns at once.

        Raises:
            AgentFailedError: the process died.
        """
        self._order(sense)

    def answer(self) -> Answer:
        """Wait for the command to the last observation; the budget counts from now.

        Raises:
            AgentFailedError: the agent raised, took too long, died, or answered with something that is no command.
        """
        reply = self._reply(self._rules.step_budget_s, Reason.STEP_TIMEOUT, Reason.STEP_RAISED)
        if not isinstance(reply, Answer):
            raise AgentFailedError(Ending(reason=Reason.NOT_A_COMMAND, detail="an answer out of turn"))
        return reply

    def _order(self, order: Begin | Sense) -> None:
        try:
            self._channel.send(order)
        except ClosedError:
            raise AgentFailedError(Ending(reason=Reason.DIED, detail=self._how_it_ended())) from None

    def _reply(self, budget_s: float, too_late: Reason, raised: Reason) -> Done | Answer:
        try:
            reply: Done | Answer | Fault = self._channel.receive(Reply, budget_s)
        except TimeoutError:
            raise AgentFailedError(Ending(reason=too_late, detail=f"no answer within {budget_s:g} s")) from None
        except ClosedError:
            raise AgentFailedError(Ending(reason=Reason.DIED, detail=self._how_it_ended())) from None
        except msgspec.DecodeError as error:
            raise AgentFailedError(Ending(reason=Reason.NOT_A_COMMAND, detail=str(error))) from None
        if isinstance(reply, Fault):
            raise AgentFailedError(
                Ending(reason=Reason.NOT_A_COMMAND if reply.is_command else raised, detail=reply.found)
            )
        return reply

    def _how_it_ended(self) -> str:
        try:
            code = self._process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            return "it closed its connection"
        return f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit status {code}"
