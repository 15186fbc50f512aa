"""The process a submission lives in: started fresh, told by `wire` messages, answering each with one.

`python -m adc_bench.evaluate.child FD`; what the submission prints goes to standard output as usual.
"""

import importlib
import socket
import sys
import time
import traceback
from types import TracebackType

import cv2

from adc_bench.api import Agent, Command
from adc_bench.errors import AdcBenchError
from adc_bench.evaluate.wire import Answer, Begin, Channel, ClosedError, Done, Fault, Load, Order, Sense, observation

AGENT = "an object with start(mission) and step(observation) -> Command"
TRACEBACK_LINES = 12


def main() -> None:
    """Serve one agent until the other end closes."""
    cv2.setNumThreads(1)
    channel = Channel(socket.socket(fileno=int(sys.argv[1])))
    agent: Agent | None = None
    while True:
        try:
            order: Load | Begin | Sense = channel.receive(Order)
        except ClosedError:
            return
        try:
            match order:
                case Load():
                    agent = load_agent(order)
                    channel.send(Done())
                case Begin():
                    assert agent is not None
                    agent.start(order.mission)
                    channel.send(Done())
                case Sense():
                    assert agent is not None
                    _step(channel, agent, order)
        except ClosedError:
            return
        except Exception as error:  # whatever a submission raises is its own fault, told and scored
            channel.send(fault_of(error))


def _step(channel: Channel, agent: Agent, order: Sense) -> None:
    begun = time.perf_counter()
    command = agent.step(observation(order))
    compute_s = time.perf_counter() - begun
    try:
        if not isinstance(command, Command):
            raise TypeError(f"{type(command).__name__} in place of a Command")
        channel.send(Answer(command=command, compute_s=compute_s))
    except TypeError as error:
        wanted = "a Command of finite numbers"
        fault = Fault(is_command=True, where="step", found=str(error), wanted=wanted, todo="return a Command")
        channel.send(fault)


def load_agent(order: Load) -> Agent:
    """Return the agent that a submission's factory makes.

    Raises:
        Exception: whatever the submission's code raises; AdcBenchError where the contract is broken.
    """
    if order.folder is None:
        from adc_bench.reference import BUILT_IN

        built_in: Agent = BUILT_IN[order.entry](order.options)
        return built_in
    module_name, factory_name = order.entry.split(":")
    sys.path.insert(0, order.folder)
    factory = getattr(importlib.import_module(module_name), factory_name, None)
    if not callable(factory):
        raise _broken(order, f"no function {factory_name} in module {module_name}", f"a function {factory_name}()")
    agent = factory()
    lacking = [name for name in ("start", "step") if not callable(getattr(agent, name, None))]
    if lacking:
        raise _broken(order, f"{type(agent).__name__} without {' and '.join(lacking)}", AGENT)
    assert isinstance(agent, Agent)
    return agent


def _broken(order: Load, found: str, wanted: str) -> AdcBenchError:
    return AdcBenchError(where=order.entry, found=found, wanted=wanted, todo="mend the submission's code or its entry")


def fault_of(error: Exception) -> Fault:
    """Return the fault that tells of an exception: an error block as it is, anything else by its traceback's end."""
    if isinstance(error, AdcBenchError):
        return Fault(is_command=False, where=error.where, found=error.found, wanted=error.wanted, todo=error.todo)
    return Fault(
        is_command=False,
        where="",
        found="\n".join(_last_lines(error)),
        wanted=AGENT,
        todo="mend the submission's code",
    )


def _last_lines(error: Exception) -> list[str]:
    told = traceback.format_exception(type(error), error, _beyond_us(error.__traceback__))
    return "".join(told).rstrip().splitlines()[-TRACEBACK_LINES:]


def _beyond_us(frame: TracebackType | None) -> TracebackType | None:
    """Return the traceback from the first frame that is neither ours nor the import system's."""
    while frame is not None:
        name = frame.tb_frame.f_code.co_filename
        if name != __file__ and "importlib" not in name:
            return frame
        frame = frame.tb_next
    return None


if __name__ == "__main__":
    main()
