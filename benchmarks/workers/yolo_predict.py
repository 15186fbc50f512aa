"""Runs under .peers/ultralytics: what one of its models finds in the pictures of a folder, at its defaults.

usage: yolo_predict.py WEIGHTS.pt PICTURES OUT.jsonl SIZE_PX SCORE_MIN

A line a picture, in the order of the files' names: `boxes_px` (x0, y0, x1, y1), `category_ids` from 1 on, `scores`.
"""

import json
import sys
from pathlib import Path

from ultralytics import YOLO

weights, pictures, out, size_px, score_min = sys.argv[1:6]
model = YOLO(weights)
with Path(out).open("w") as file:
    for picture in sorted(Path(pictures).iterdir()):
        (found,) = model.predict(picture, imgsz=int(size_px), conf=float(score_min), device="cpu", verbose=False)
        boxes = found.boxes
        answer = {
            "boxes_px": boxes.xyxy.tolist(),
            "category_ids": [int(category) + 1 for category in boxes.cls],
            "scores": boxes.conf.tolist(),
        }
        file.write(json.dumps(answer) + "\n")
