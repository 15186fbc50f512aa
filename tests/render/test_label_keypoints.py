"""Corners of objects, seen and covered, against OpenCV and polygons."""

import numpy as np
import pytest
from label_views import (
    FLAT,
    LENSES,
    by_opencv,
    camera_of,
    corners_of,
    filled,
    only,
    pose_towards,
    ring,
)

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Pose3
from adc_bench.render.labels import labels_of
from adc_bench.render.targets import Target
from adc_bench.world.frame import KEYPOINT_HIDDEN, KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, NO_KEYPOINTS
from adc_bench.world.scenario import Scenario


@pytest.mark.parametrize(("k1", "k2"), LENSES)
@pytest.mark.parametrize("instance", FLAT)
def test_keypoints_are_opencvs_and_all_are_seen_in_the_open(
    scenario: Scenario, targets: dict[str, Target], instance: str, k1: float, k2: float
) -> None:
    target, camera, rng = targets[instance], camera_of(k1, k2), np.random.default_rng(5)
    corners, front = corners_of(target, scenario), np.array(target.front)
    for _ in range(10):
        offset = rng.uniform(1.2, 3.0) * (front + rng.uniform(-0.7, 0.7, 3))
        pose = pose_towards(target, offset, rng.uniform(-1, 1))
        label = only(labels_of(filled(by_opencv(ring(target), camera, pose), target.label_id), [target], camera, pose))
        expected = by_opencv(corners, camera, pose)
        inside = ((expected >= 0) & (expected < (320, 240))).all(axis=1)
        for (u, v, seen), pixel, here in zip(label.keypoints_px, expected, np.atleast_1d(inside), strict=True):
            assert (u, v, seen) == (pytest.approx((*pixel, KEYPOINT_VISIBLE)) if here else (0.0, 0.0, KEYPOINT_OUTSIDE))


def test_bodies_have_no_keypoints(targets: dict[str, Target]) -> None:
    camera = camera_of()
    for name in ("box_0", "cone_left_0"):
        pose = pose_towards(targets[name], np.array([-2.0, 0.0, 0.5]))
        ids = np.full((240, 320), targets[name].label_id, np.uint8)
        assert only(labels_of(ids, [targets[name]], camera, pose)).keypoints_px == NO_KEYPOINTS


@pytest.mark.parametrize("instance", ["panel_facing_west", "sign_0", "sign_1", "sign_2", "sign_3"])
def test_covered_corners_are_hidden(targets: dict[str, Target], instance: str) -> None:
    """What covers the left half of a board hides its left corners, what covers its lower half the lower ones."""
    target, camera = targets[instance], camera_of(-0.12, 0.015)
    pose = pose_towards(target, np.array([0.8, 0.1, 0.05]))
    outline = by_opencv(ring(target), camera, pose)
    u, v = outline.mean(axis=0).astype(int)
    for cover, hidden in (((slice(None), slice(0, u)), {0, 3}), ((slice(v, None), slice(None)), {2, 3})):
        ids = filled(outline, target.label_id)
        ids[cover] = 200
        label = only(labels_of(ids, [target], camera, pose))
        assert {k for k, (_, _, seen) in enumerate(label.keypoints_px) if seen == KEYPOINT_HIDDEN} == hidden
        assert {k for k, (_, _, seen) in enumerate(label.keypoints_px) if seen == KEYPOINT_VISIBLE} == {
            0,
            1,
            2,
            3,
        } - hidden


def test_a_corner_of_the_crosswalk_is_hidden_by_what_stands_and_not_by_floor(targets: dict[str, Target]) -> None:
    target, camera = targets["crosswalk"], camera_of(-0.12, 0.015)
    pose = pose_towards(target, np.array([-2.6, 0.4, 0.5]))  # so far that the corners are slivers
    outline = by_opencv(ring(target), camera, pose)
    ids = filled(outline, target.label_id)
    assert [seen for _, _, seen in only(labels_of(ids, [target], camera, pose)).keypoints_px] == 4 * [KEYPOINT_VISIBLE]
    corner = by_opencv(target.pose_world_object.transform(target.faces[0][:1]), camera, pose)[0]
    u, v = corner.astype(int)
    for thing, state in ((0, KEYPOINT_VISIBLE), (202, KEYPOINT_HIDDEN)):
        before = ids.copy()
        before[v - 4 : v + 5, u - 4 : u + 5] = thing
        assert only(labels_of(before, [target], camera, pose)).keypoints_px[0][2] == state


def test_corners_behind_the_camera_are_outside(targets: dict[str, Target]) -> None:
    target, camera = targets["crosswalk"], camera_of(-0.12, 0.015)
    (eye,) = target.pose_world_object.transform(np.array([[-0.2, 0.0, 0.2]]))
    level = Pose3(rotation=ROTATION_BODY_OPTICAL, translation_m=eye)  # over the crosswalk, looking along x
    ids = np.full((240, 320), target.label_id, np.uint8)
    label = only(labels_of(ids, [target], camera, level))
    assert [label.keypoints_px[k] for k in (0, 3)] == 2 * [(0.0, 0.0, KEYPOINT_OUTSIDE)]
    assert label.truncation > 0.8 and label.amodal_box_px[3] == 240
    assert label.amodal_box_whole_px[3] == pytest.approx(480, abs=1e-3)
