"""Runs under .peers/ultralytics: trains one of Ultralytics' models from scratch, everything at its defaults.

usage: yolo_train.py MODEL DATA_YAML OUT PICTURES_SEEN SIZE_PX THREADS

Run again after a break, it goes on with the last epoch that was saved. OUT gets `weights/best.pt`, `weights/best.onnx`
and `seconds.json`, the time of every epoch.
"""

import csv
import json
import sys
from pathlib import Path

import torch
from ultralytics import YOLO

model, data, out, seen, size_px, threads = sys.argv[1:7]
folder = Path(out).resolve()
torch.set_num_threads(int(threads))
pictures = len(list((Path(data).parent / "images" / "train").iterdir()))
last = folder / "weights" / "last.pt"
if last.exists() and not (folder / "finished").exists():
    YOLO(last).train(resume=True)
elif not last.exists():
    YOLO(f"{model}.yaml").train(
        data=str(Path(data).resolve()),
        epochs=round(int(seen) / pictures),
        imgsz=int(size_px),
        device="cpu",
        pretrained=False,
        workers=0,
        project=str(folder.parent),
        name=folder.name,
        exist_ok=True,
        plots=False,
    )
(folder / "finished").touch()
with (folder / "results.csv").open() as file:
    seconds = [float(row["time"]) for row in csv.DictReader(file)]
(folder / "seconds.json").write_text(json.dumps(seconds))
YOLO(folder / "weights" / "best.pt").export(format="onnx", imgsz=[256, 320] if int(size_px) == 320 else int(size_px))
