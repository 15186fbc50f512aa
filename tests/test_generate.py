import math
from pathlib import Path

import cv2
import numpy as np
import pytest
import shapely

from adc_bench.dataset import FrameDataset, load_split
from adc_bench.errors import InputError, UsageError
from adc_bench.generate import render_split
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Label
from adc_bench.world.scenario import Scenario

VAL = load_split("val")
SIZE = (160, 120)


def _files(root: Path) -> dict[str, bytes]:
    return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file()}


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two full shards, made by two workers."""
    root = tmp_path_factory.mktemp("generate") / "two"
    render_split(VAL, root, count=128, size_px=SIZE, frames_per_shard=64, workers=2)
    return root


def test_a_frame_is_the_same_in_a_longer_dataset(rendered: Path, tmp_path: Path) -> None:
    render_split(VAL, tmp_path / "one", count=66, size_px=SIZE, frames_per_shard=64)
    assert (tmp_path / "one" / "shard-00000.h5").read_bytes() == (rendered / "shard-00000.h5").read_bytes()
    few, many = FrameDataset(tmp_path / "one"), FrameDataset(rendered)
    for i in (64, 65):
        assert few.jpeg(i) == many.jpeg(i) and few.annotations(i) == many.annotations(i)
        np.testing.assert_array_equal(few.pose_world_camera(i), many.pose_world_camera(i))


def test_a_folder_with_other_files_is_refused_even_to_overwrite(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("keep me")
    for overwrite in (False, True):
        with pytest.raises(InputError, match="a folder with other files"):
            render_split(VAL, tmp_path, count=2, size_px=SIZE, overwrite=overwrite)
    assert _files(tmp_path) == {"letter.txt": b"keep me"}


def test_overwrite_replaces_a_dataset_and_spares_the_rest(tmp_path: Path) -> None:
    render_split(VAL, tmp_path / "a", count=66, size_px=SIZE)
    (tmp_path / "a" / "notes.txt").write_text("mine")
    render_split(VAL, tmp_path / "a", count=2, size_px=SIZE, overwrite=True)
    render_split(VAL, tmp_path / "b", count=2, size_px=SIZE)
    assert _files(tmp_path / "a") == {**_files(tmp_path / "b"), "notes.txt": b"mine"}


def test_more_frames_than_seeds_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="1 to 3200000 frames"):
        render_split(VAL, tmp_path / "a", count=3_200_001)
    assert not (tmp_path / "a").exists()


def test_crosswalk_boxes_lie_where_the_stored_pose_projects_the_crosswalk(rendered: Path) -> None:
    """The whole chain against OpenCV's camera: sampling, rendering, labels, files."""
    dataset = FrameDataset(rendered)
    checked = 0
    for i in dataset.image_ids:
        for label in dataset.annotations(i):
            if label.category_id == 1 and _is_whole(label):
                x, y = _project_crosswalk(dataset.scenario(i), dataset.camera(i), dataset.pose_world_camera(i))
                np.testing.assert_allclose(label.amodal_box_px, (x.min(), y.min(), x.max(), y.max()), atol=0.01)
                # Something may hide a corner's last pixels: the tight box may lie further in, never further out
                # than the outline itself by more than the pixel that its edges are rounded to.
                box = np.array(label.box_px)
                assert np.all((box - _box_of_pixels(x, y)) * (1, 1, -1, -1) <= 3.0)
                assert np.all((box - (x.min(), y.min(), x.max(), y.max())) * (1, 1, -1, -1) > -1.0)
                checked += 1
    assert checked >= 10


def _project_crosswalk(scenario: Scenario, camera: str, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    corners = np.column_stack([scenario.course.crosswalk_corners, np.zeros(4)])
    ring = shapely.segmentize(shapely.LinearRing(corners), 0.01)
    mount, seen = scenario.rig.camera(camera), np.linalg.inv(pose)
    focal_px = SIZE[0] / 2 / math.tan(mount.hfov_rad / 2)
    matrix = np.array([[focal_px, 0.0, SIZE[0] / 2], [0.0, focal_px, SIZE[1] / 2], [0.0, 0.0, 1.0]])
    lens = np.array([mount.lens.k1, mount.lens.k2, 0.0, 0.0])
    points = shapely.get_coordinates(ring, include_z=True)
    pixels, _ = cv2.projectPoints(points, cv2.Rodrigues(seen[:3, :3])[0], seen[:3, 3], matrix, lens)
    return pixels[:, 0, 0], pixels[:, 0, 1]


def _box_of_pixels(x: np.ndarray, y: np.ndarray) -> tuple[float, float, float, float]:
    """Return the box of the pixels whose centres the polygon holds; sharp corners hold none."""
    columns, rows = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    inside = shapely.contains_xy(shapely.Polygon(np.column_stack([x, y])), columns + 0.5, rows + 0.5)
    return columns[inside].min(), rows[inside].min(), columns[inside].max() + 1, rows[inside].max() + 1


def test_panels_show_the_sign_of_their_category(rendered: Path) -> None:
    """The sign's colour in the picture agrees with its label: arrows are green, the stop cross is red."""
    dataset = FrameDataset(rendered)
    checked = 0
    for i in dataset.image_ids:
        for label in dataset.annotations(i):
            name = CATEGORIES[label.category_id - 1]
            if name in ("panel_up", "panel_left", "panel_right", "panel_stop") and _is_plain(label):
                x0, y0, x1, y1 = (int(value) for value in label.box_px)
                red, green, _ = dataset.picture(i)[y0:y1, x0:x1].reshape(-1, 3).astype(float).mean(axis=0)
                assert (red > green) == (name == "panel_stop")
                checked += 1
    assert checked >= 5


def _is_whole(label: Label) -> bool:
    return label.visible_fraction > 0.97 and label.truncation < 1e-6 and label.visible_px > 40


def _is_plain(label: Label) -> bool:
    return label.visible_px > 300 and label.visible_fraction > 0.9 and not label.ignore
