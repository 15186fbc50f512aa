"""The submission as the episode loop sees it, wherever it runs."""

import math
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import msgspec

from adc_bench.api import Command, Mission
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.sensed import Sensed

# How far the submission was kept from the rest: in a sandbox; in a process with limits only; in the loop's own process.
Isolation = Literal["bubblewrap", "none", "in-process"]


class Load(msgspec.Struct, frozen=True, kw_only=True):
    """What to start: `entry` is module:factory in `folder`, or without a folder a built-in driver's name; or, in place
    of an entry, a `command` with its arguments. `sha256` is the digest that the folder's files must have.
    """

    folder: str | None
    entry: str = ""
    command: tuple[str, ...] = ()
    options: dict[str, str]
    sha256: str

    @property
    def name(self) -> str:
        """The entry or the command, for messages."""
        return self.entry or " ".join(self.command)


class AgentFailedError(Exception):
    """The submission failed as a program; `ending` says how."""

    def __init__(self, ending: Ending) -> None:
        super().__init__(ending.reason)
        self.ending = ending


@dataclass(frozen=True, kw_only=True)
class Answered:
    """A command that can be carried out, and the wall time from the observation's going to its coming."""

    command: Command
    compute_s: float


@runtime_checkable
class AgentSide(Protocol):
    """One submission for one run, opened and closed as a context manager."""

    def wait_loaded(self) -> None:
        """Wait until the submission is loaded; raise InputError if it cannot be."""
        ...

    def start(self, mission: Mission) -> None:
        """Tell the mission and wait until the submission is ready; raise AgentFailedError if it fails."""
        ...

    def ask(self, sensed: Sensed) -> None:
        """Hand over an observation and return at once; raise AgentFailedError if the submission is gone."""
        ...

    def answer(self) -> Answered:
        """Wait for the command to the last observation; raise AgentFailedError if none comes, or one that is none."""
        ...


def sound(command: Command, limits: Limits) -> Command:
    """Return a command if its figures can be worked with.

    Raises:
        AgentFailedError: one is not finite, or too large.
    """
    pose = msgspec.structs.astuple(command.pose_world_robot)
    figures = (command.v_mps, command.omega_radps, *pose, *(command.covariance or ()))
    if not all(math.isfinite(figure) for figure in figures):
        raise AgentFailedError(Ending(reason=Reason.NOT_FINITE, detail=f"{command}"))
    if any(abs(figure) > limits.largest_figure for figure in figures):
        raise AgentFailedError(Ending(reason=Reason.OUT_OF_RANGE, detail=f"{command}"))
    return command
