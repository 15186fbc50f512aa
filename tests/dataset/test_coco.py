import contextlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
from scipy.spatial.transform import Rotation

from adc_bench.dataset import FrameDataset
from adc_bench.dataset import layout as files
from adc_bench.geometry import Pose3
from adc_bench.world.categories import CATEGORIES


@pytest.fixture(scope="module")
def dataset(rendered: Path) -> FrameDataset:
    return FrameDataset(rendered)


@pytest.fixture(scope="module")
def coco(rendered: Path) -> COCO:
    with contextlib.redirect_stdout(io.StringIO()):
        return COCO(str(rendered / files.COCO))


def test_pycocotools_loads_it_with_all_categories(coco: COCO, dataset: FrameDataset) -> None:
    assert sorted(coco.imgs) == list(dataset.image_ids)
    assert [coco.cats[k + 1]["name"] for k in range(21)] == list(CATEGORIES)
    assert sorted(coco.anns) == list(range(1, len(coco.dataset["annotations"]) + 1))
    assert coco.imgs[65]["file_name"] == "shard-00001.h5#1" and coco.imgs[65]["camera"] == "panel"


def test_annotations_repeat_the_labels(coco: COCO, dataset: FrameDataset) -> None:
    assert len(coco.getAnnIds(catIds=[1], iscrowd=False)) >= 20
    for i in dataset.image_ids:
        labels, camera = dataset.annotations(i), dataset.pose_world_camera(i)
        found = coco.loadAnns(coco.getAnnIds(imgIds=[i]))
        assert [annotation["instance"] for annotation in found] == [label.instance for label in labels]
        for annotation, label in zip(found, labels, strict=True):
            x, y, width, height = annotation["bbox"]
            assert (x, y, x + width, y + height) == label.box_px
            assert annotation["iscrowd"] == label.ignore and annotation["category_id"] == label.category_id
            x, y, width, height = annotation["amodal_bbox_whole"]
            np.testing.assert_allclose((x, y, x + width, y + height), label.amodal_box_whole_px, atol=2e-3)
            np.testing.assert_allclose(annotation["pose_world_object"], label.pose_world_object, atol=1e-6)
            seen = np.linalg.inv(camera) @ Pose3.from_figures(label.pose_world_object).matrix()
            again = Pose3.from_figures(annotation["pose_camera_object"]).matrix()
            np.testing.assert_allclose(again, seen, atol=1e-5)


def test_images_carry_their_conditions(coco: COCO, dataset: FrameDataset) -> None:
    for i in dataset.image_ids:
        conditions = dataset.conditions(i)
        for name in conditions.__struct_fields__:
            assert coco.imgs[i][name] == getattr(conditions, name)


def test_masks_have_the_area_and_the_box_of_their_annotation(coco: COCO) -> None:
    for annotation in coco.dataset["annotations"]:
        mask = coco.annToMask(annotation)
        assert mask.shape == (240, 320) and mask.sum() == annotation["area"] == annotation["visible_px"]
        v, u = np.nonzero(mask)
        x, y, width, height = annotation["bbox"]
        assert (u.min(), v.min(), u.max() + 1, v.max() + 1) == (x, y, x + width, y + height)


def test_keypoints_are_triplets_and_boxes_and_cones_have_none(coco: COCO, dataset: FrameDataset) -> None:
    with_corners = 0
    for i in dataset.image_ids:
        for annotation, label in zip(coco.loadAnns(coco.getAnnIds(imgIds=[i])), dataset.annotations(i), strict=True):
            triplets = np.reshape(annotation["keypoints"], (4, 3))
            for (u, v, seen), wanted in zip(triplets, label.keypoints_px, strict=True):
                assert seen == wanted[2] and (u, v) == (pytest.approx(wanted[:2], abs=1e-3) if seen else (0, 0))
            assert annotation["num_keypoints"] == np.count_nonzero(triplets[:, 2])
            category = coco.cats[label.category_id]
            assert ("keypoints" in category) == (category["name"] not in ("box", "cone"))
            with_corners += annotation["num_keypoints"] > 0
            assert "keypoints" in category or annotation["num_keypoints"] == 0
    assert with_corners > 20


@pytest.mark.parametrize("kind", ["bbox", "segm", "keypoints"])
def test_a_perfect_detector_scores_one(coco: COCO, kind: str) -> None:
    found: list[dict[str, Any]] = [
        {"score": 1.0, **{key: a[key] for key in ("image_id", "category_id", "bbox", "segmentation", "keypoints")}}
        for a in coco.dataset["annotations"]
        if not a["iscrowd"] and (kind != "keypoints" or a["num_keypoints"])
    ]
    answers = [{key: value for key, value in a.items() if kind == "segm" or key != "segmentation"} for a in found]
    if kind == "segm":
        answers = [{key: value for key, value in a.items() if key != "bbox"} for a in answers]
    with contextlib.redirect_stdout(io.StringIO()):
        score = COCOeval(coco, coco.loadRes(answers), kind)
        score.params.kpt_oks_sigmas = np.full(4, 0.05)
        score.evaluate()
        score.accumulate()
        score.summarize()
    assert score.stats[0] == 1.0


def test_tum_files_hold_the_camera_poses(rendered: Path, dataset: FrameDataset) -> None:
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
    assert sorted(seen) == list(dataset.image_ids)


def test_ignore_regions_are_crowds(rendered: Path, dataset: FrameDataset) -> None:
    document = json.loads((rendered / files.COCO).read_bytes())
    ignored = sum(label.ignore for i in dataset.image_ids for label in dataset.annotations(i))
    assert ignored == sum(annotation["iscrowd"] for annotation in document["annotations"]) > 0
