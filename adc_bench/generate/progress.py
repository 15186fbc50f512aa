"""How far a run is: shards, frames, the rate, and which node did how much."""

from time import perf_counter

import msgspec

NODES_IN_TEXT = 4


class NodeWork(msgspec.Struct, frozen=True, kw_only=True):
    """What a node did: shards, frames in them, and the seconds that its workers spent on them."""

    shards: int = 0
    frames: int = 0
    worker_s: float = 0.0

    def plus(self, frames: int, elapsed_s: float) -> "NodeWork":
        """Return it with one shard more."""
        return NodeWork(shards=self.shards + 1, frames=self.frames + frames, worker_s=self.worker_s + elapsed_s)

    def __str__(self) -> str:
        return f"{self.shards} shards, {self.frames} frames in {self.worker_s:.1f} s of its workers"


class Progress(msgspec.Struct, frozen=True, kw_only=True):
    """Shards done, those kept from an earlier run included, of how many; frames of this run; what each node did."""

    done: int
    total: int
    frames: int
    elapsed_s: float
    nodes: dict[str, NodeWork]

    @property
    def frames_per_s(self) -> float:
        """The rate of this run so far."""
        return self.frames / self.elapsed_s if self.frames else 0.0

    @property
    def text(self) -> str:
        """One line for people: the rate, and the nodes if there are several."""
        names = sorted(self.nodes) if len(self.nodes) > 1 else []
        shown = [f"{name}: {self.nodes[name].shards} in {self.nodes[name].worker_s:.0f} s" for name in names]
        more = [f"{len(names) - NODES_IN_TEXT} nodes more"] if len(names) > NODES_IN_TEXT else []
        return " | ".join([f"{self.frames_per_s:.1f} frames/s", *shown[:NODES_IN_TEXT], *more])


class Count:
    """Counts shards as they come in."""

    def __init__(self, kept: int, total: int) -> None:
        self._begun_s = perf_counter()
        self._done, self._total, self._frames = kept, total, 0
        self._nodes: dict[str, NodeWork] = {}

    def add(self, node: str, frames: int, elapsed_s: float) -> None:
        """Count a shard that a node has made."""
        self._done += 1
        self._frames += frames
        self._nodes[node] = self._nodes.get(node, NodeWork()).plus(frames, elapsed_s)

    def now(self) -> Progress:
        """Return how far the run is."""
        return Progress(
            done=self._done,
            total=self._total,
            frames=self._frames,
            elapsed_s=perf_counter() - self._begun_s,
            nodes=dict(self._nodes),
        )
