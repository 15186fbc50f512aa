"""The three qualities: frames a second at 640x480, one camera and two, each in a process of its own, taking turns.

Usage: python benchmarks/qualities.py [--rounds 5]

A frame is colours and labels read back, no lens or noise; all three draw on the processor. first frame s: from the
start of the process, imports, arena and the compiling of shaders included.
"""

import argparse
import statistics
import sys
from collections.abc import Iterator
from contextlib import ExitStack

from turns import HERE, Worker, machine_line, table

SIZE = ("640", "480")
FRAMES = {"fast": 24, "standard": 6, "raytraced": 2}  # in a turn


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with ExitStack() as stack:
        print(machine_line(), flush=True)
        workers = [(*case, stack.enter_context(worker)) for *case, worker in start()]
        means_s: dict[str, list[float]] = {worker.name: [] for _, _, worker in workers}
        for _ in range(options.rounds):
            for quality, _, worker in workers:
                means_s[worker.name].append(worker.turn(FRAMES[quality]))
    rows = [("quality", "cameras", "ms a frame", "frames/s", "first frame s")]
    for quality, cameras, worker in workers:
        frame_s = statistics.median(means_s[worker.name]) / cameras
        rows.append((quality, str(cameras), f"{1000 * frame_s:.1f}", f"{1 / frame_s:.1f}", f"{worker.ready_s:.2f}"))
    print(f"\n{table(*rows)}")


def start() -> Iterator[tuple[str, int, Worker]]:
    """Start a worker for every quality and number of cameras."""
    for quality in FRAMES:
        for cameras in (1, 2):
            command = (sys.executable, str(HERE / "workers" / "ours.py"), *SIZE, "raw", quality, str(cameras))
            yield quality, cameras, Worker(f"{quality}, {cameras} cameras", *command)


if __name__ == "__main__":
    main()
