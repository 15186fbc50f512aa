"""How well the detector finds what it was trained for, beside Ultralytics' smallest models after as many pictures.

Usage: for each of train, val and test: adc-bench dataset export DATA/SPLIT --format yolo --out YOLO
       python benchmarks/detector_accuracy.py --data DATA --yolo YOLO --out DIR [--pictures-seen 24000]

All are trained from scratch on DATA/train, validated on DATA/val and scored on DATA/test; YOLO holds the same pictures
as Ultralytics reads them. Ours by its recipe `n`, theirs at their defaults at 320 px, each on one thread: 15 to 40
minutes a model. Run again on DIR it goes on where it stopped. All answers from a score of 0.01 up are scored alike, by
pycocotools with the labels' ignore regions, which YOLO's form of the labels cannot say.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from turns import HERE, machine_line, table

from adc_bench.dataset import FrameDataset
from adc_bench.detector import Detector
from adc_bench.detector.decode import TO_BE_SCORED
from adc_bench.detector.evaluation.score import CocoScorer, DetectionScore
from adc_bench.world.frame import Detections

MODELS = ("yolo11n", "yolo26n")
PEER_PYTHON = HERE.parent / ".peers/ultralytics/bin/python"
SIZE_PX = 320


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--yolo", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--pictures-seen", type=int, default=24_000)
    options = parser.parse_args()
    test = FrameDataset(options.data / "test")
    print(machine_line(), "\n")
    rows = [row("adc-bench n", test, ours(options.data, test, options.out / "n", options.pictures_seen))]
    for model in MODELS:
        rows.append(row(model, test, theirs(model, options.yolo, options.out / model, options.pictures_seen)))
    print(table(("", "mAP50-95", "AP50", "crosswalk AP50", "panels' AP50", "signs' AP50"), *rows))


def ours(data: Path, test: FrameDataset, run: Path, seen: int) -> Iterator[Detections]:
    """Train the recipe `n`; yield what its best weights find in each picture."""
    weights = run / "weights.safetensors"
    if not (run / "report.html").exists():
        epochs = round(seen / len(FrameDataset(data / "train")))
        command = [
            str(Path(sys.executable).with_name("adc-bench")),
            "train-detector",
            "--out",
            str(run),
            "--config",
            "n",
        ]
        command += ["--train", str(data / "train"), "--val", str(data / "val"), "--epochs", str(epochs)]
        subprocess.run([*command, *(["--resume"] if run.exists() else [])], check=True)
    detector = Detector.load(weights, config=TO_BE_SCORED)
    return (detector(test.picture(i)) for i in range(len(test)))


def theirs(model: str, yolo: Path, run: Path, seen: int) -> Iterator[Detections]:
    """Train one of their models; yield what its best weights find in each picture."""
    if not (run / "finished").exists():
        peer("yolo_train.py", model, yolo / "data.yaml", run, seen, SIZE_PX, 1)
    answers = run / "test.jsonl"
    peer("yolo_predict.py", run / "weights/best.pt", yolo / "images/test", answers, SIZE_PX, TO_BE_SCORED.score_min)
    for line in answers.read_text().splitlines():
        answer = json.loads(line)
        count = len(answer["scores"])
        yield Detections(
            boxes_px=np.reshape(np.asarray(answer["boxes_px"], dtype=np.float32), (count, 4)),
            category_ids=np.asarray(answer["category_ids"], dtype=np.int64),
            scores=np.asarray(answer["scores"], dtype=np.float32),
            keypoints_px=np.zeros((count, 4, 2), dtype=np.float32),
            keypoint_sigma_px=np.zeros((count, 4), dtype=np.float32),
            keypoint_scores=np.zeros((count, 4), dtype=np.float32),
        )


def peer(program: str, *arguments: object) -> None:
    """Run a worker under the peer's Python."""
    command = [str(PEER_PYTHON), str(HERE / "workers" / program), *map(str, arguments)]
    subprocess.run(command, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"})


def row(name: str, test: FrameDataset, found: Iterator[Detections]) -> tuple[str, ...]:
    """Return a row's cells: means over categories."""
    labels = [test.annotations(i) for i in range(len(test))]
    score = CocoScorer(test.image_ids, labels, list(found)).score()
    panels, signs = mean_ap50(score, "panel_"), mean_ap50(score, "sign_")
    return name, f"{score.map:.3f}", f"{score.map50:.3f}", f"{score.categories['crosswalk'].ap50:.3f}", panels, signs


def mean_ap50(score: DetectionScore, prefix: str) -> str:
    """Return the mean AP50 of the categories whose names begin so."""
    return f"{np.mean([each.ap50 for name, each in score.categories.items() if name.startswith(prefix)]):.3f}"


if __name__ == "__main__":
    main()
