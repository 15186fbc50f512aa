"""Samples on their way from a sensor to whoever reads it."""

from collections import deque
from typing import Generic, TypeVar

Sample = TypeVar("Sample")

_SAME_S = 1e-9  # times that differ by less are one


class Delivery(Generic[Sample]):
    """Holds each sample back until its sensor's latency has passed; in order of sampling."""

    def __init__(self, latency_s: float) -> None:
        self._latency_s = latency_s
        self._waiting: deque[tuple[float, Sample]] = deque()

    def put(self, time_s: float, sample: Sample) -> None:
        """Send off a sample taken at a time not before the one before."""
        self._waiting.append((time_s + self._latency_s, sample))

    def take(self, now_s: float) -> list[Sample]:
        """Return what has arrived since the last call."""
        arrived = []
        while self._waiting and self._waiting[0][0] <= now_s + _SAME_S:
            arrived.append(self._waiting.popleft()[1])
        return arrived
