"""The messages between the episode loop and a submission's process, version 1: msgpack maps, each with its `type`.

None can hold the truth: the submission gets the mission and observations, and answers with commands or detections.
`docs/submission.md` tells the order in which they pass, `docs/protocol.schema.json` is their JSON Schema.
"""

from collections.abc import Mapping
from typing import Literal

import msgspec

from adc_bench.api import Command, Detection, Kind, Mission, SeenObject
from adc_bench.evaluate.schemas import unwrapped

VERSION = 1


class Message(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="type"):
    """What all messages share: the field `type` names the message."""


class MissionMessage(Message, frozen=True, kw_only=True, tag="mission"):
    """To the submission, once: what it is to do."""

    mission: Mission


class PicturePlace(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a picture lies in the file of pictures: height x width x 3 bytes (rgb by rows) from the offset on."""

    time_s: float
    offset: int
    width: int
    height: int


class Scan(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A laser scan: ranges by beam, from the right to the left; the longest range where nothing is in reach."""

    time_s: float
    ranges_m: list[float]


class ObservationMessage(Message, frozen=True, kw_only=True, tag="observation"):
    """To the submission, once a control step: what the sensors delivered; `pictures` by the camera's name."""

    step: int
    time_s: float
    pictures: dict[str, PicturePlace]
    encoder_time_s: list[float]
    left_ticks: list[int]
    right_ticks: list[int]
    imu_time_s: list[float]
    yaw_rate_radps: list[float]
    acceleration_x_mps2: list[float]
    laser: Scan | None
    objects: tuple[SeenObject, ...]


class Hello(Message, frozen=True, kw_only=True, tag="hello"):
    """From the submission, first of all: it has loaded, and speaks this version."""

    protocol: int


class Ready(Message, frozen=True, kw_only=True, tag="ready"):
    """From the submission, once: it has taken in the mission and may be driven."""


class CommandMessage(Message, frozen=True, kw_only=True, tag="command"):
    """From the submission, one for each observation, whose `step` it repeats."""

    step: int
    command: Command


class DetectionMessage(Message, frozen=True, kw_only=True, tag="detection"):
    """From a detector, one for each observation, whose `step` it repeats: what is on the observation's one picture."""

    step: int
    detections: tuple[Detection, ...]


NotAnAnswer = Literal["not-a-command", "not-detections"]


class Fault(Message, frozen=True, kw_only=True, tag="fault"):
    """From the submission, in place of any other: it gives up. `found` says why, and is kept."""

    found: str
    kind: Literal["raised", NotAnAnswer] = "raised"
    where: str = ""
    wanted: str = ""
    todo: str = ""


Order = MissionMessage | ObservationMessage
AnswerMessage = CommandMessage | DetectionMessage
Reply = Hello | Ready | AnswerMessage | Fault
ANSWER: Mapping[Kind, type[AnswerMessage]] = {
    "driver": CommandMessage,
    "localizer": CommandMessage,
    "detector": DetectionMessage,
}
NOT_AN_ANSWER: Mapping[Kind, NotAnAnswer] = {
    "driver": "not-a-command",
    "localizer": "not-a-command",
    "detector": "not-detections",
}


def answer_message(kind: Kind, step: int, answer: object) -> AnswerMessage:
    """Return the message of what a submission's `step` or `detect` returned.

    Raises:
        TypeError: it is nothing that this kind of submission answers with.
    """
    if kind != "detector":
        return command_message(step, answer)
    if not isinstance(answer, list | tuple):
        raise TypeError(f"{type(answer).__name__} in place of a list of Detections")
    strange = [type(each).__name__ for each in answer if not isinstance(each, Detection)]
    if strange:
        raise TypeError(f"{strange[0]} in place of a Detection")
    return DetectionMessage(step=step, detections=tuple(answer))


def command_message(step: int, command: object) -> CommandMessage:
    """Return the message of what a `step` returned.

    Raises:
        TypeError: it is no Command.
    """
    if not isinstance(command, Command):
        raise TypeError(f"{type(command).__name__} in place of a Command")
    return CommandMessage(step=step, command=command)


def kind_of(message: Message) -> str:
    """Return a message's type in the protocol's words."""
    return str(message.__struct_config__.tag)


def schema() -> bytes:
    """Return the JSON Schema of all messages; `to_submission` and `from_submission` are those of each direction."""
    (told, answered), definitions = msgspec.json.schema_components((Order, Reply), ref_template="#/$defs/{name}")
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"adc-bench agent protocol {VERSION}",
        "$defs": {**definitions, "to_submission": told, "from_submission": answered},
        "anyOf": [{"$ref": "#/$defs/to_submission"}, {"$ref": "#/$defs/from_submission"}],
    }
    return msgspec.json.format(msgspec.json.encode(unwrapped(whole), order="sorted"), indent=2) + b"\n"
