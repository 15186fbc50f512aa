"""The three qualities: frames a second at 640x480, with one camera and two, each in a process of its own.

Usage: python benchmarks/qualities.py [--rounds 5]

fast and standard take turns; raytraced, a minute or two a frame, is timed once, with one camera. A frame is colours
and labels read back, no lens or noise; all three draw on the processor. first frame s: from the start of the process,
imports, arena and the compiling of shaders included.
"""

import argparse
import statistics
import sys
from contextlib import ExitStack

from turns import HERE, Worker, machine_line, table

SIZE = ("640", "480")
CASES = (("fast", 1, 24), ("fast", 2, 24), ("standard", 1, 6), ("standard", 2, 6))  # quality, cameras, frames a turn


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    print(machine_line(), flush=True)
    rows = [("quality", "cameras", "ms a frame", "frames/s", "first frame s")]
    with ExitStack() as stack:
        workers = [stack.enter_context(start(quality, cameras)) for quality, cameras, _ in CASES]
        turns = [[w.turn(case[2]) for case, w in zip(CASES, workers, strict=True)] for _ in range(options.rounds)]
    for (quality, cameras, _), worker, means_s in zip(CASES, workers, zip(*turns, strict=True), strict=True):
        rows.append(row(quality, cameras, statistics.median(means_s), worker.ready_s))
    with start("raytraced", 1) as worker:
        rows.append(row("raytraced", 1, worker.turn(1), worker.ready_s))
    print(f"\n{table(*rows)}")


def row(quality: str, cameras: int, step_s: float, ready_s: float) -> tuple[str, ...]:
    frame_s = step_s / cameras
    return quality, str(cameras), f"{1000 * frame_s:.1f}", f"{1 / frame_s:.2f}", f"{ready_s:.2f}"


def start(quality: str, cameras: int) -> Worker:
    command = (sys.executable, str(HERE / "workers" / "ours.py"), *SIZE, "raw", quality, str(cameras))
    return Worker(f"{quality}, {cameras} cameras", *command)


if __name__ == "__main__":
    main()
