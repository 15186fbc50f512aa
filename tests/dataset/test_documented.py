"""docs/dataset.md: its example runs, and it names every dataset of a shard, every COCO field and every file."""

import json
import re
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "dataset.md").read_text(encoding="utf-8")


def test_the_example_reads_a_shard(rendered: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    monkeypatch.chdir(rendered)
    found: dict = {}
    exec(code, found)
    assert len(code.strip().split("\n")) <= 14 and found["camera"] == "road"
    assert cv2.imdecode(np.frombuffer(found["jpeg"], np.uint8), cv2.IMREAD_COLOR).shape == (240, 320, 3)
    assert found["boxes_px"].shape == (len(found["category_id"]), 4) and len(found["wanted"]) == len(found["boxes_px"])


def test_every_dataset_of_a_shard_is_named(rendered: Path) -> None:
    with h5py.File(rendered / "shard-00000.h5") as file:
        names: list[str] = [*file.attrs]
        file.visit(names.append)
    assert [name for name in names if f"`{name.split('/')[-1]}`" not in PAGE] == []


def test_every_coco_field_and_file_is_named(rendered: Path) -> None:
    document = json.loads((rendered / "annotations" / "instances.json").read_bytes())
    cocos = {"id", "image_id", "category_id", "bbox", "file_name", "width", "height"}
    fields = {*document["images"][0], *document["annotations"][0]} - cocos
    assert [field for field in sorted(fields) if f"`{field}`" not in PAGE] == []
    files = [path.name for path in rendered.rglob("*") if path.is_file() and not path.name.startswith(("shard-", "."))]
    assert [name for name in files if name not in PAGE] == []
