"""What a submission's sandbox costs: each step, and once a run.

Usage: python benchmarks/isolation.py [--steps 2000]

The same driver (examples/circle_driver) answers the same observations, each with both cameras' pictures and a scan, in
the loop's own process and in its sandbox, in turns of 100 steps. The loop does nothing else meanwhile; told are wall
times from the observation's going to the command's coming, decoding of the pictures included. On a machine with other
work the lowest twentieth is what tells: the rest waits for a processor.
"""

import argparse
import statistics
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np
from turns import machine_line, table

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan
from adc_bench.evaluate.agent_side import AgentSide
from adc_bench.evaluate.driving import agent_side
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.sensed import Sensed
from adc_bench.evaluate.submission import Submission, load_submission
from adc_bench.evaluate.suite import load_suite, mission_for

DRIVER = Path(__file__).parents[1] / "examples" / "circle_driver"
TURN = 100
WANTED_MS = 1.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=2000)
    steps = parser.parse_args().steps
    print(machine_line(), flush=True)
    submission = load_submission(str(DRIVER), {})
    times_s = measure(submission, steps)
    rows = [("where", "steps", "5 % below ms", "median ms", "95 % below ms")]
    low_s = {}
    for name, found in times_s.items():
        twentieths = statistics.quantiles(found, n=20)
        low_s[name] = twentieths[0]
        rows.append((name, str(len(found)), *(f"{twentieths[k] * 1e3:.3f}" for k in (0, 9, 18))))
    print(f"\n{table(*rows)}")
    overhead_ms = 1e3 * (low_s["sandbox"] - low_s["in process"])
    print(f"\na step's overhead, lowest twentieths: {overhead_ms:.3f} ms (wanted: at most {WANTED_MS:g} ms)")
    print(f"start, to the first message: {statistics.median(starts_s(submission)):.2f} s (median of 5)")


def measure(submission: Submission, steps: int) -> dict[str, list[float]]:
    """Return the times of the steps by where the driver was."""
    mission = mission_for(load_suite("dev"), latency_s=0.0, options={})
    times_s: dict[str, list[float]] = {"in process": [], "sandbox": []}
    with ExitStack() as stack:
        sides: dict[str, AgentSide] = {
            name: stack.enter_context(agent_side(submission.load, RULES, in_process=name == "in process"))
            for name in times_s
        }
        for side in sides.values():
            side.wait_loaded()
            side.start(mission)
        for first in range(0, steps, TURN):
            for name, side in sides.items():
                times_s[name] += [step_s(side, sensed) for sensed in made(first, TURN)]
    return times_s


def step_s(side: AgentSide, sensed: Sensed) -> float:
    """Return how long a step took."""
    begun_s = perf_counter()
    side.ask(sensed)
    side.answer()
    return perf_counter() - begun_s


def starts_s(submission: Submission) -> Iterator[float]:
    """Yield how long a start took, five times."""
    for _ in range(5):
        begun_s = perf_counter()
        with agent_side(submission.load, RULES, in_process=False) as side:
            side.wait_loaded()
            yield perf_counter() - begun_s


def made(first: int, count: int) -> Iterator[Sensed]:
    """Yield observations as large as those of a drive."""
    noise = np.random.default_rng(1)
    jpegs = {
        mount.name: cv2.imencode(".jpg", noise.integers(90, 110, (mount.height_px, mount.width_px, 3), np.uint8))[1]
        for mount in RULES.rig.cameras
    }
    for step in range(first, first + count):
        time_s = step * RULES.control_period_s + np.arange(5) / 100
        yield Sensed(
            step=step,
            time_s=float(time_s[0]),
            pictures={name: (float(time_s[0]), jpeg.tobytes()) for name, jpeg in jpegs.items()},
            encoders=EncoderSamples(time_s=time_s, left_ticks=np.arange(5), right_ticks=np.arange(5)),
            imu=ImuSamples(time_s=time_s, yaw_rate_radps=np.zeros(5), acceleration_x_mps2=np.zeros(5)),
            laser=LaserScan(time_s=float(time_s[0]), ranges_m=noise.uniform(0.1, 3.0, 338)),
        )


if __name__ == "__main__":
    main()
