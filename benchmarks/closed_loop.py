"""The closed loop without an agent, beside gym-duckietown's, taking turns: camera steps a second, and times real time.

Usage: python benchmarks/closed_loop.py [--rounds 7] [--steps 100]

Ours: an arena with everything in it; a control step of 50 ms with physics at 200 Hz, encoders at 50 Hz, gyro, laser at
10 Hz and one delivered picture (light and shadows, lens, blur, noise, JPEG). Theirs: one `env.step` with its picture,
on its default map and on its plainest, in its own environment (scripts/peers.sh). Medians over the rounds.
"""

import argparse
import statistics
import sys
from collections.abc import Iterator
from contextlib import ExitStack

from turns import HERE, Worker, machine_line, ratio, table, take_turns

SIZES = ((320, 240), (640, 480))
CONTROL_PERIOD_S = 0.05
PEER = HERE.parent / ".peers" / "duckietown" / "bin" / "python"
OURS, BLIND, THEIRS, PLAIN = "ours", "ours without the picture", "gym-duckietown", "gym-duckietown, small_loop"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--steps", type=int, default=100)
    options = parser.parse_args()
    print(machine_line(), flush=True)
    rows = [("size", "loop", "ms a step", "camera steps/s", "times real time")]
    ratios = [("size", "ratio of camera steps/s", "measured", "wanted")]
    for size in SIZES:
        name = f"{size[0]}x{size[1]}"
        with ExitStack() as stack:
            workers = [stack.enter_context(worker) for worker in start(size)]
            found = take_turns(workers, options.rounds, options.steps)
        for loop, each in found.items():
            mean_s = statistics.median(each)
            rate = "" if loop == BLIND else f"{1 / mean_s:.1f}"
            rows.append((name, loop, f"{1000 * mean_s:.2f}", rate, real_time(loop, mean_s)))
        ratios += [
            (name, f"{OURS} / {peer}", f"{ratio(found[peer], found[OURS]):.2f}", "over 1" if peer == THEIRS else "")
            for peer in (THEIRS, PLAIN)
            if peer in found
        ]
    print(f"\n{table(*rows)}\n\n{table(*ratios)}")


def real_time(loop: str, mean_s: float) -> str:
    """Return how many times faster than real time our loop runs; the promise is 4 or more at 320x240."""
    return f"{CONTROL_PERIOD_S / mean_s:.1f}" if loop in (OURS, BLIND) else ""


def start(size: tuple[int, int]) -> Iterator[Worker]:
    """Start the loops one after the other."""
    programs, (width, height) = HERE / "workers", map(str, size)
    for name, mode in ((OURS, "camera"), (BLIND, "blind")):
        yield Worker(name, sys.executable, str(programs / "drive_ours.py"), width, height, mode)
    if not PEER.exists():
        print("gym-duckietown is left out: run scripts/peers.sh first", flush=True)
        return
    for name, world in ((THEIRS, "udem1"), (PLAIN, "small_loop")):
        yield Worker(name, str(PEER), str(programs / "drive_duckietown.py"), width, height, world)


if __name__ == "__main__":
    main()
