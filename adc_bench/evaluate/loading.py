"""A Python submission's agent made by its factory, and what it raised in words that name no place of this machine."""

import importlib
import sys
import traceback
from pathlib import Path
from types import TracebackType

from adc_bench.api import Agent
from adc_bench.errors import AdcBenchError
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.protocol import Fault

AGENT = "an object with start(mission) and step(observation) -> Command"
TRACEBACK_LINES = 12
ROOM = Path(__file__).parent


def load_agent(load: Load, folder: Path) -> Agent:
    """Return the agent that a submission's factory makes; its files lie in `folder`, whose modules come first.

    Raises:
        Exception: whatever the submission's code raises; AdcBenchError where the contract is broken.
    """
    if load.folder is None:
        from adc_bench.reference import BUILT_IN

        built_in: Agent = BUILT_IN[load.entry](load.options)
        return built_in
    module_name, factory_name = load.entry.split(":")
    sys.path.insert(0, str(folder))
    factory = getattr(importlib.import_module(module_name), factory_name, None)
    if not callable(factory):
        raise _broken(load, f"no function {factory_name} in module {module_name}", f"a function {factory_name}()")
    agent = factory()
    lacking = [name for name in ("start", "step") if not callable(getattr(agent, name, None))]
    if lacking:
        raise _broken(load, f"{type(agent).__name__} without {' and '.join(lacking)}", AGENT)
    assert isinstance(agent, Agent)
    return agent


def _broken(load: Load, found: str, wanted: str) -> AdcBenchError:
    return AdcBenchError(where=load.entry, found=found, wanted=wanted, todo="mend the submission's code or its entry")


def fault_of(error: Exception, folder: Path) -> Fault:
    """Return the fault that tells of an exception: an error block as it is, anything else by its traceback's end."""
    if isinstance(error, AdcBenchError):
        return Fault(where=error.where, found=error.found, wanted=error.wanted, todo=error.todo)
    return Fault(found=told(error, folder), wanted=AGENT, todo="mend the submission's code")


def told(error: Exception, folder: Path) -> str:
    """Return the last lines of a traceback, from the submission's own code on; files are named from `folder`."""
    lines = "".join(traceback.format_exception(type(error), error, _beyond_us(error.__traceback__))).rstrip()
    return "\n".join(lines.replace(f"{folder}/", "").splitlines()[-TRACEBACK_LINES:])


def _beyond_us(frame: TracebackType | None) -> TracebackType | None:
    """Return the traceback from the first frame that is neither this room's nor the import system's."""
    while frame is not None:
        name = frame.tb_frame.f_code.co_filename
        if Path(name).parent != ROOM and "importlib" not in name:
            return frame
        frame = frame.tb_next
    return None
