"""A Python submission's object made by its factory, and asked; what it raised, in words that name no place of this
machine.
"""

import importlib
import sys
import traceback
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType

from adc_bench.api import Agent, Kind, Observation, PictureDetector
from adc_bench.errors import AdcBenchError
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.protocol import Fault

Loaded = Agent | PictureDetector
CONTRACT: Mapping[Kind, str] = {
    "driver": "an object with start(mission) and step(observation) -> Command",
    "localizer": "an object with start(mission) and step(observation) -> Command",
    "detector": "an object with start(mission) and detect(rgb) -> list of Detection",
}
METHODS: Mapping[Kind, tuple[str, str]] = {
    "driver": ("start", "step"),
    "localizer": ("start", "step"),
    "detector": ("start", "detect"),
}
TRACEBACK_LINES = 12
ROOM = Path(__file__).parent


def load_agent(load: Load, folder: Path) -> Loaded:
    """Return the object that a submission's factory makes; its files lie in `folder`, whose modules come first.

    Raises:
        Exception: whatever the submission's code raises; AdcBenchError where the contract is broken.
    """
    if load.folder is None:
        from adc_bench.reference import OF_KIND

        built_in: Loaded = OF_KIND[load.kind][load.entry](load.options)
        return built_in
    module_name, factory_name = load.entry.split(":")
    sys.path.insert(0, str(folder))
    factory = getattr(importlib.import_module(module_name), factory_name, None)
    if not callable(factory):
        raise _broken(load, f"no function {factory_name} in module {module_name}", f"a function {factory_name}()")
    agent = factory()
    lacking = [name for name in METHODS[load.kind] if not callable(getattr(agent, name, None))]
    if lacking:
        raise _broken(load, f"{type(agent).__name__} without {' and '.join(lacking)}", CONTRACT[load.kind])
    assert isinstance(agent, Agent | PictureDetector)
    return agent


def asked(kind: Kind, agent: Loaded, observation: Observation) -> object:
    """Return what a submission answers: a detector is asked about the observation's one picture."""
    if kind == "detector":
        assert isinstance(agent, PictureDetector)
        (picture,) = observation.pictures.values()
        return agent.detect(picture.rgb)
    assert isinstance(agent, Agent)
    return agent.step(observation)


def _broken(load: Load, found: str, wanted: str) -> AdcBenchError:
    return AdcBenchError(where=load.entry, found=found, wanted=wanted, todo="mend the submission's code or its entry")


def fault_of(error: Exception, load: Load, folder: Path) -> Fault:
    """Return the fault that tells of an exception: an error block as it is, anything else by its traceback's end."""
    if isinstance(error, AdcBenchError):
        return Fault(where=error.where, found=error.found, wanted=error.wanted, todo=error.todo)
    return Fault(found=told(error, folder), wanted=CONTRACT[load.kind], todo="mend the submission's code")


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
