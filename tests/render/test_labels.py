"""Labels against brute force on pictures made by hand, and against a projection written again."""

from collections.abc import Callable

import numpy as np
import pytest

from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.render.labels import Target, labels_of, projected_outline, tight_box
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig


def test_the_tight_box_is_the_brute_force_one() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        mask = rng.random((24, 32)) < 0.02
        mask[5, 7] = True
        rows, columns = np.nonzero(mask)
        assert tight_box(mask) == (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)


def test_labels_of_visible_objects_only() -> None:
    mount = SensorRig().camera("road")
    pose = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0).to_pose3() @ mount.pose_robot_camera()
    square = np.array([[1.5, 0.2, 0], [1.9, 0.2, 0], [1.9, -0.2, 0], [1.5, -0.2, 0]])
    targets = [
        Target(label_id=1, category_id=1, instance="seen", corners_world=square),
        Target(label_id=2, category_id=1, instance="hidden", corners_world=square),
    ]
    ids = np.zeros((240, 320), np.uint8)
    ids[100:120, 150:190] = 1
    labels = labels_of(ids, targets, mount.camera(), pose)
    assert [label.instance for label in labels] == ["seen"]
    assert labels[0].box_px == (150, 100, 190, 120) and labels[0].visible_px == 800


def test_an_outline_behind_the_camera_is_cut_at_the_near_plane() -> None:
    camera = SensorRig().camera("road").camera()
    corners = np.array([[-0.5, 0.5, 2.0], [0.5, 0.5, 2.0], [0.5, 0.5, -1.0], [-0.5, 0.5, -1.0]])
    outline = projected_outline(corners, camera)
    assert outline.is_valid and outline.area > camera.width_px * camera.height_px
    assert projected_outline(corners - [0, 0, 5], camera).is_empty


def _crosswalk_by_hand(scenario: Scenario, renderer: ArenaRenderer, pose: Pose2) -> np.ndarray:
    """Project a dense grid over the crosswalk's rectangle and keep what falls into the picture."""
    corners = scenario.course.crosswalk_corners
    x, y = np.meshgrid(np.linspace(*corners[[0, 1], 0], 200), np.linspace(*corners[[1, 2], 1], 400))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    camera_pose = renderer.pose_world_camera("road", pose.to_pose3())
    in_camera = (points - camera_pose.translation_m) @ camera_pose.rotation
    in_camera = in_camera[in_camera[:, 2] > 0.02]
    camera = scenario.rig.camera("road").camera()
    u = camera.fx_px * in_camera[:, 0] / in_camera[:, 2] + camera.cx_px
    v = camera.fy_px * in_camera[:, 1] / in_camera[:, 2] + camera.cy_px
    inside = (u > 0) & (u < 320) & (v > 0) & (v < 240)
    return np.column_stack([u, v])[inside]


@pytest.mark.parametrize("s_m", [37.2, 38.4, 39.0, 39.6, 19.0, 20.6])
def test_the_crosswalk_box_is_where_an_independent_projection_puts_it(
    renderer: ArenaRenderer, scenario_of: Callable[..., Scenario], s_m: float
) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    pose = scenario.course.lap.pose(s_m)
    frame = renderer.frame(0, "road", pose.to_pose3())
    label = next(label for label in frame.labels if label.category_id == CATEGORY_ID["crosswalk"])
    points = _crosswalk_by_hand(scenario, renderer, pose)
    expected = (*points.min(axis=0), *points.max(axis=0))
    assert label.amodal_box_px == pytest.approx(expected, abs=1.0)
    assert label.visible_fraction > 0.9
    assert label.box_px == pytest.approx(expected, abs=1.5) or label.visible_fraction < 1.0
    assert 0.0 <= label.truncation < 1.0


def test_a_post_before_the_crosswalk_lowers_its_visible_fraction_only(
    renderer: ArenaRenderer, scenario_of: Callable[..., Scenario]
) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    beside_post = Pose2(x_m=0.0, y_m=-3.75, yaw_rad=np.pi / 2).to_pose3()
    label = next(x for x in renderer.frame(0, "road", beside_post).labels if x.instance == "crosswalk")
    assert 0.5 < label.visible_fraction < 0.99
