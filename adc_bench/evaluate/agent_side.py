"""The submission as the episode loop sees it, wherever it runs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol, runtime_checkable

import msgspec

from adc_bench.api import Command, Detection, Kind, Mission
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.protocol import AnswerMessage, CommandMessage
from adc_bench.evaluate.sensed import Sensed

# How far the submission was kept from the rest: in a sandbox; in a process with limits only; in the loop's own process.
Isolation = Literal["bubblewrap", "none", "in-process"]
Answer = Command | tuple[Detection, ...]


class Load(msgspec.Struct, frozen=True, kw_only=True):
    """What to start, and what kind of submission it is: `entry` is module:factory in `folder`, or without a folder a
    built-in one's name; or, in place of an entry, a `command` with its arguments. `sha256` is the digest that the
    folder's files must have.
    """

    kind: Kind
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
    """An answer that can be worked with, and the wall time from the observation's going to its coming."""

    answer: Answer
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
        """Wait for the answer to the last observation; raise AgentFailedError if none comes, or one that is none."""
        ...


def content(message: AnswerMessage) -> Answer:
    """Return the answer that a message holds."""
    return message.command if isinstance(message, CommandMessage) else message.detections


def sound(answer: Answer, limits: Limits) -> Answer:
    """Return an answer if its figures can be worked with.

    Raises:
        AgentFailedError: one is not finite or too large, a score is no share, or there are too many detections.
    """
    if isinstance(answer, Command):
        _check_figures(answer, _command_figures(answer), limits)
        return answer
    if len(answer) > limits.detections:
        found = f"{len(answer)} detections on one picture; at most {limits.detections} are taken"
        raise AgentFailedError(Ending(reason=Reason.OUT_OF_RANGE, detail=found))
    for detection in answer:
        corners = (figure for corner in detection.corners_px or () for figure in corner)
        _check_figures(detection, (detection.score, *detection.box_px, *corners), limits)
        if not 0.0 <= detection.score <= 1.0:
            raise AgentFailedError(Ending(reason=Reason.OUT_OF_RANGE, detail=f"{detection}"))
    return answer


def _command_figures(command: Command) -> tuple[float, ...]:
    pose = msgspec.structs.astuple(command.pose_world_robot)
    return (command.v_mps, command.omega_radps, *pose, *(command.covariance or ()))


def _check_figures(answer: Command | Detection, figures: Sequence[float], limits: Limits) -> None:
    if not all(math.isfinite(figure) for figure in figures):
        raise AgentFailedError(Ending(reason=Reason.NOT_FINITE, detail=f"{answer}"))
    if any(abs(figure) > limits.largest_figure for figure in figures):
        raise AgentFailedError(Ending(reason=Reason.OUT_OF_RANGE, detail=f"{answer}"))
