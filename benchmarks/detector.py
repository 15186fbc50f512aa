"""What the detector costs beside Ultralytics' smallest models: a picture of 320x240, and a training step.

Usage: python benchmarks/detector.py [--weights FILE] [--threads 2] [--rounds 9] [--peers build/peers]

Ours is the whole call: preparing, network, decoding, suppression, corners; theirs is the graph alone at 320x256, as
`benchmarks/workers/yolo_train.py` exports it to PEERS/MODEL/weights/best.onnx (models without such a file are left
out). Training is forward, loss, backward and step of a batch of 16 at 320 (theirs 320x320, their default). Processes
take turns; medians over the rounds.
"""

import argparse
import statistics
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from turns import HERE, Worker, machine_line, ratio, table, take_turns

from adc_bench.detector import shipped_weights

MODELS = ("yolo26n", "yolo11n", "yolov8n")
PEER_PYTHON = HERE.parent / ".peers/ultralytics/bin/python"
BATCH = 16


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--weights", type=Path, default=shipped_weights())
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--peers", type=Path, default=HERE.parent / "build/peers")
    options = parser.parse_args()
    print(machine_line(threads=str(options.threads)), "\n")
    calling, training = calls(options.weights, options.peers, options.threads), trainings(options.threads)
    show("ms a picture", calling, options.threads, options.rounds, steps=30)
    show("ms a training step of 16", training, options.threads, options.rounds, steps=1)


def calls(weights: Path, peers: Path, threads: int) -> dict[str, list[str]]:
    """Commands by name, ours first."""
    ours, theirs = str(HERE / "workers/detector_ours.py"), str(HERE / "workers/detector_yolo.py")
    commands = {
        f"adc-bench, {runtime}": [sys.executable, ours, "call", str(weights), runtime, str(threads)]
        for runtime in ("onnx", "torch")
    }
    graphs = {model: peers / model / "weights/best.onnx" for model in MODELS}
    for model, graph in graphs.items():
        if graph.exists():
            commands[f"{model}, graph alone, onnx"] = [sys.executable, theirs, "graph", str(graph), str(threads)]
    return commands


def trainings(threads: int) -> dict[str, list[str]]:
    """Commands by name, ours first."""
    ours, theirs = str(HERE / "workers/detector_ours.py"), str(HERE / "workers/detector_yolo.py")
    commands = {"adc-bench": [sys.executable, ours, "train", str(threads), str(BATCH)]}
    if PEER_PYTHON.exists():
        commands |= {
            model: [str(PEER_PYTHON), theirs, "train", model, str(threads), str(BATCH)] for model in MODELS[:2]
        }
    return commands


def show(unit: str, commands: dict[str, list[str]], threads: int, rounds: int, steps: int) -> None:
    env = {"OMP_NUM_THREADS": str(threads)}
    with ExitStack() as stack:
        workers = [stack.enter_context(Worker(name, *command, env=env)) for name, command in commands.items()]
        found = take_turns(workers, rounds, steps)
    first = next(iter(found))
    print(table(("", unit, f"over {first}"), *(row(name, times, found[first]) for name, times in found.items())), "\n")


def row(name: str, times_s: Sequence[float], first_s: Sequence[float]) -> tuple[str, str, str]:
    return name, f"{1000 * statistics.median(times_s):.1f}", f"{ratio(times_s, first_s):.2f}"


if __name__ == "__main__":
    main()
