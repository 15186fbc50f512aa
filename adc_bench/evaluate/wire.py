"""What passes between the episode loop and a submission's process: length-prefixed msgpack over a socket pair.

No message can hold the truth: the child gets the mission and observations, and answers with commands.
"""

import socket
import struct
import time
from typing import Any, TypeVar

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.api import (
    Command,
    EncoderSamples,
    ImuSamples,
    LaserScan,
    Mission,
    Observation,
    Picture,
    SeenObject,
)
from adc_bench.world.picture import decode_picture

Message = TypeVar("Message")
LENGTH = struct.Struct("!I")
LONGEST_MESSAGE_BYTES = 16 * 2**20
RANGES = np.dtype("<f8")


class Load(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """Make the agent: `entry` is module:factory inside `folder`, or without a folder a built-in driver's name."""

    folder: str | None
    entry: str
    options: dict[str, str]


class Begin(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """Call `start`."""

    mission: Mission


class Sense(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """Call `step`: an observation with its pictures as the rig's JPEG bytes, (time_s, jpeg) by camera.

    The laser's scan is (time_s, its ranges as little-endian float64).
    """

    step: int
    time_s: float
    pictures: dict[str, tuple[float, bytes]]
    encoder_time_s: list[float]
    left_ticks: list[int]
    right_ticks: list[int]
    imu_time_s: list[float]
    yaw_rate_radps: list[float]
    acceleration_x_mps2: list[float]
    laser: tuple[float, bytes] | None
    objects: tuple[SeenObject, ...]


class Done(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """The agent is made, or has started."""


class Answer(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """The agent's command and the wall time it took, decoding of the pictures included."""

    command: Command
    compute_s: float


class Fault(msgspec.Struct, frozen=True, kw_only=True, tag=True):
    """What went wrong in the child, in the words of an error block."""

    is_command: bool  # the agent answered, but not with a command
    where: str
    found: str
    wanted: str
    todo: str


Order = Load | Begin | Sense
Reply = Done | Answer | Fault


class ClosedError(Exception):
    """The other end is gone."""


class Channel:
    """One end of the socket pair."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end

    def send(self, message: msgspec.Struct) -> None:
        """Send a message; numpy scalars and arrays in it become numbers and lists.

        Raises:
            TypeError: the message holds something that msgpack has no form for.
            ClosedError: the other end is gone.
        """
        body = msgspec.msgpack.encode(message, enc_hook=_plain)
        try:
            self._end.sendall(LENGTH.pack(len(body)) + body)
        except OSError:
            raise ClosedError from None

    def receive(self, message_type: Any, budget_s: float | None = None) -> Any:
        """Return the next message, an instance of the type (or union).

        Raises:
            TimeoutError: it did not come within the budget.
            ClosedError: the other end is gone.
            msgspec.DecodeError: it is not such a message.
        """
        deadline = None if budget_s is None else time.monotonic() + budget_s
        (length,) = LENGTH.unpack(self._read(LENGTH.size, deadline))
        if length > LONGEST_MESSAGE_BYTES:
            raise msgspec.DecodeError(f"a message of {length} bytes")
        return msgspec.msgpack.decode(self._read(length, deadline), type=message_type)

    def _read(self, count: int, deadline: float | None) -> bytes:
        parts = bytearray()
        while len(parts) < count:
            self._end.settimeout(None if deadline is None else max(deadline - time.monotonic(), 1e-3))
            try:
                part = self._end.recv(count - len(parts))
            except ConnectionError:
                part = b""
            if not part:
                raise ClosedError
            parts += part
        return bytes(parts)


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a command cannot hold {value!r}")


def sense(
    step: int,
    time_s: float,
    pictures: dict[str, tuple[float, bytes]],
    encoders: EncoderSamples,
    imu: ImuSamples,
    *,
    laser: LaserScan | None = None,
    objects: tuple[SeenObject, ...] = (),
) -> Sense:
    """Return the message of an observation."""
    return Sense(
        step=step,
        time_s=time_s,
        pictures=pictures,
        encoder_time_s=encoders.time_s.tolist(),
        left_ticks=encoders.left_ticks.tolist(),
        right_ticks=encoders.right_ticks.tolist(),
        imu_time_s=imu.time_s.tolist(),
        yaw_rate_radps=imu.yaw_rate_radps.tolist(),
        acceleration_x_mps2=imu.acceleration_x_mps2.tolist(),
        laser=(laser.time_s, laser.ranges_m.astype(RANGES).tobytes()) if laser else None,
        objects=objects,
    )


def observation(message: Sense) -> Observation:
    """Return the observation of a message, its pictures decoded to rgb."""
    return Observation(
        step=message.step,
        time_s=message.time_s,
        pictures={
            name: Picture(time_s=taken_s, rgb=_decoded(jpeg)) for name, (taken_s, jpeg) in message.pictures.items()
        },
        encoders=EncoderSamples(
            time_s=np.array(message.encoder_time_s, dtype=np.float64),
            left_ticks=np.array(message.left_ticks, dtype=np.int64),
            right_ticks=np.array(message.right_ticks, dtype=np.int64),
        ),
        imu=ImuSamples(
            time_s=np.array(message.imu_time_s, dtype=np.float64),
            yaw_rate_radps=np.array(message.yaw_rate_radps, dtype=np.float64),
            acceleration_x_mps2=np.array(message.acceleration_x_mps2, dtype=np.float64),
        ),
        laser=_scan(*message.laser) if message.laser else None,
        objects=message.objects,
    )


def _scan(time_s: float, ranges: bytes) -> LaserScan:
    return LaserScan(time_s=time_s, ranges_m=np.frombuffer(ranges, dtype=RANGES).astype(np.float64))


def _decoded(jpeg: bytes) -> NDArray[np.uint8]:
    rgb = decode_picture(jpeg)
    assert rgb is not None, "the renderer's own JPEG"
    return rgb
