"""Length-prefixed msgpack over a stream socket: four bytes, big-endian, then so many bytes of one message."""

import socket
import struct
import time
from typing import Any

import msgspec
import numpy as np

LENGTH = struct.Struct("!I")
LONGEST_MESSAGE_BYTES = 16 * 2**20


class ClosedError(Exception):
    """The other end is gone."""


class MessageError(Exception):
    """What came is no message."""


class ShapeError(MessageError):
    """What came is a message, but with other fields than it should have."""


class Channel:
    """One end of the connection; `longest_bytes` bounds the messages that it takes."""

    def __init__(self, end: socket.socket, longest_bytes: int = LONGEST_MESSAGE_BYTES) -> None:
        self._end, self._longest_bytes = end, longest_bytes

    def send(self, message: msgspec.Struct, budget_s: float | None = None) -> None:
        """Send a message; numpy scalars and arrays in it become numbers and lists.

        Raises:
            TypeError: the message holds something that msgpack has no form for.
            ClosedError: the other end is gone.
            TimeoutError: the other end did not take it within the budget.
        """
        body = encoded(message)
        self._end.settimeout(budget_s)
        try:
            self._end.sendall(LENGTH.pack(len(body)) + body)
        except TimeoutError:
            raise
        except OSError:
            raise ClosedError from None

    def receive(self, message_type: Any, budget_s: float | None = None) -> Any:
        """Return the next message, an instance of the type (or union).

        Raises:
            TimeoutError: it did not come within the budget.
            ClosedError: the other end is gone.
            MessageError: it is too long, or no msgpack.
            ShapeError: it is another message than that.
        """
        deadline = None if budget_s is None else time.monotonic() + budget_s
        (length,) = LENGTH.unpack(self._read(LENGTH.size, deadline))
        if length > self._longest_bytes:
            raise MessageError(f"a message of {length} bytes; at most {self._longest_bytes} are taken")
        return decoded(self._read(length, deadline), message_type)

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


def encoded(message: msgspec.Struct) -> bytes:
    """Return a message's bytes; numpy scalars and arrays in it become numbers and lists.

    Raises:
        TypeError: it holds something that msgpack has no form for.
    """
    return msgspec.msgpack.encode(message, enc_hook=_plain)


def decoded(body: bytes, message_type: Any) -> Any:
    """Return the message that the bytes hold, an instance of the type (or union).

    Raises:
        MessageError: they are no msgpack.
        ShapeError: they hold another message than that.
    """
    try:
        return msgspec.msgpack.decode(body, type=message_type)
    except msgspec.ValidationError as error:
        raise ShapeError(str(error)) from None
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise MessageError(str(error)) from None


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"an answer cannot hold {value!r}")
