import contextlib
import io
import json
from pathlib import Path

import numpy as np
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
from scipy.spatial.transform import Rotation

from adc_bench.dataset import FrameDataset
from adc_bench.world.categories import CATEGORIES


def _coco(root: Path) -> COCO:
    with contextlib.redirect_stdout(io.StringIO()):
        return COCO(str(FrameDataset(root).coco_path))


def test_pycocotools_loads_it_with_all_categories(rendered: Path) -> None:
    coco = _coco(rendered)
    assert sorted(coco.imgs) == FrameDataset(rendered).image_ids
    assert [coco.cats[k + 1]["name"] for k in range(21)] == list(CATEGORIES)
    assert len(set(coco.anns)) == len(coco.dataset["annotations"]) and min(coco.anns) == 1
    assert coco.imgs[65]["file_name"] == "shard-00001.h5#1" and coco.imgs[65]["camera"] == "panel"


def test_boxes_lie_inside_their_pictures_and_repeat_the_labels(rendered: Path) -> None:
    dataset, coco = FrameDataset(rendered), _coco(rendered)
    assert len(coco.getAnnIds(catIds=[1], iscrowd=False)) >= 20
    for i in dataset.image_ids:
        found = coco.loadAnns(coco.getAnnIds(imgIds=[i]))
        assert [annotation["instance"] for annotation in found] == [lb.instance for lb in dataset.annotations(i)]
        for annotation, label in zip(found, dataset.annotations(i), strict=True):
            x, y, width, height = annotation["bbox"]
            assert (x, y, x + width, y + height) == label.box_px
            assert x >= 0 and y >= 0 and width > 0 and height > 0 and x + width <= 320 and y + height <= 240
            assert annotation["iscrowd"] == label.ignore and annotation["area"] == width * height


def test_a_perfect_detector_scores_one(rendered: Path) -> None:
    coco = _coco(rendered)
    answers = [
        {"image_id": a["image_id"], "category_id": a["category_id"], "bbox": a["bbox"], "score": 1.0}
        for a in coco.dataset["annotations"]
        if not a["iscrowd"]
    ]
    with contextlib.redirect_stdout(io.StringIO()):
        score = COCOeval(coco, coco.loadRes(answers), "bbox")
        score.evaluate()
        score.accumulate()
        score.summarize()
    assert score.stats[0] == 1.0


def test_tum_files_hold_the_camera_poses(rendered: Path) -> None:
    dataset = FrameDataset(rendered)
    seen = []
    for camera in ("road", "panel"):
        for row in np.loadtxt(rendered / "poses" / f"{camera}.tum"):
            i = int(row[0])
            seen.append(i)
            assert dataset.camera(i) == camera
            np.testing.assert_allclose(row[1:4], dataset.pose_world_camera(i)[:3, 3], atol=1e-8)
            np.testing.assert_allclose(
                Rotation.from_quat(row[4:]).as_matrix(), dataset.pose_world_camera(i)[:3, :3], atol=1e-7
            )
    assert sorted(seen) == dataset.image_ids


def test_ignore_regions_are_crowds(rendered: Path) -> None:
    document = json.loads(FrameDataset(rendered).coco_path.read_bytes())
    dataset = FrameDataset(rendered)
    ignored = sum(label.ignore for i in dataset.image_ids for label in dataset.annotations(i))
    assert ignored == sum(annotation["iscrowd"] for annotation in document["annotations"])
