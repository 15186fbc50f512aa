import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_answers import perfect_answers

from adc_bench.dataset import FrameDataset
from adc_bench.detector.evaluation import Evaluation
from adc_bench.detector.evaluation.corners import true_corners
from adc_bench.detector.evaluation.floor import on_floor
from adc_bench.geometry import ROTATION_BODY_OPTICAL, Camera, Pose3, rotation_zyx
from adc_bench.world.frame import KEYPOINT_VISIBLE, Detections

CAMERA = Camera.from_hfov(width_px=320, height_px=240, hfov_rad=math.radians(70), k1=-0.12, k2=0.015)


def _pose(yaw: float, pitch: float, roll: float, x: float, y: float, z: float) -> Pose3:
    return Pose3(rotation=rotation_zyx(yaw, pitch, roll) @ ROTATION_BODY_OPTICAL, translation_m=np.array([x, y, z]))


POSES = st.builds(
    _pose,
    st.floats(-3, 3),
    st.floats(0.2, 0.8),
    st.floats(-0.1, 0.1),
    st.floats(-5, 5),
    st.floats(-3, 3),
    st.floats(0.3, 1.0),
)


@settings(max_examples=50, deadline=None)
@given(pose=POSES, u=st.floats(10, 310), v=st.floats(120, 230))
def test_the_floor_below_a_pixel_is_where_a_step_by_step_search_along_its_ray_finds_it(
    pose: Pose3, u: float, v: float
) -> None:
    """OpenCV's ray, followed until it is below the floor."""
    coefficients = np.array([CAMERA.k1, CAMERA.k2, 0, 0])
    x, y = cv2.undistortPoints(
        np.array([[[u, v]]]), CAMERA.matrix(), coefficients, criteria=(cv2.TERM_CRITERIA_COUNT, 200, 0)
    )[0, 0]
    direction = pose.rotation @ (x, y, 1.0)
    low, high = 0.0, 1.0
    while pose.translation_m[2] + high * direction[2] > 0:
        high *= 2
        if high > 500:
            return  # beyond the range that this speaks of
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if pose.translation_m[2] + middle * direction[2] < 0 else (middle, high)
    point = (pose.translation_m + low * direction)[:2]
    if low * np.linalg.norm(direction) < 20:
        np.testing.assert_allclose(on_floor(CAMERA, pose, [[u, v]])[0], point, atol=2e-5 * (1 + low) ** 2)


@settings(max_examples=50, deadline=None)
@given(pose=POSES, along=st.floats(0.5, 5), aside=st.floats(-1, 1))
def test_a_point_on_the_floor_is_found_again(pose: Pose3, along: float, aside: float) -> None:
    ahead = pose.rotation @ (aside, 0, along)
    point = np.array([pose.translation_m[0] + ahead[0], pose.translation_m[1] + ahead[1], 0.0])
    pixel = CAMERA.project(pose.inverse().transform([point]))
    if np.isfinite(pixel).all() and (pixel >= 0).all() and (pixel < (320, 240)).all():
        np.testing.assert_allclose(on_floor(CAMERA, pose, pixel)[0], point[:2], atol=1e-6)


def test_a_ray_above_the_horizon_ends_far_away_and_is_still_a_figure() -> None:
    away = on_floor(CAMERA, _pose(0.3, 0.0, 0.0, 0.0, 0.0, 0.7), [[160.0, 20.0]])[0]
    assert 30 < np.hypot(*away) < 50 and math.atan2(away[1], away[0]) == pytest.approx(0.3, abs=0.02)


def test_true_corners_are_those_of_the_course(validation: FrameDataset) -> None:
    """Cast through the true pose they are the crosswalk's corners in the world, the far ones farther than the near."""
    corners, k, checked = true_corners(validation), 0, 0
    for i in range(len(validation)):
        matrix = validation.pose_world_camera(i)
        pose = Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())
        for label in validation.annotations(i):
            if label.category_id == 1:
                seen = corners[k, :, 2] == KEYPOINT_VISIBLE
                points = on_floor(validation.mount(i).camera(), pose, corners[k, :, :2])
                course = validation.scenario(i).course.crosswalk_corners
                gaps = np.linalg.norm(points[:, None] - course, axis=-1)[seen]
                assert (gaps.min(axis=1) < 0.02).all()
                away = np.linalg.norm(points - pose.translation_m[:2], axis=1)
                if seen.all():
                    assert min(away[:2]) > max(away[2:]) - 1.0
                checked += seen.sum()
            k += 1
    assert checked > 10


def _shifted(answers: list[Detections], shift: np.ndarray, sigma: float) -> list[Detections]:
    changed = []
    for answer in answers:
        fields = {name: getattr(answer, name) for name in Detections.__dataclass_fields__}
        fields["keypoints_px"] = answer.keypoints_px + shift.astype(np.float32)
        fields["keypoint_sigma_px"] = np.full_like(answer.keypoint_sigma_px, sigma)
        changed.append(Detections(**fields))
    return changed


def test_true_corners_have_no_error_but_the_mount_s(validation: FrameDataset) -> None:
    report = Evaluation(validation, perfect_answers(validation)).report()
    assert report.corners["crosswalk"].error_px.count > 10
    for score in report.corners.values():
        assert score.error_px.p95 == 0.0 and score.within_one_sigma == 1.0
        assert score.said_right == score.seen_said == 1.0
    ranges = [score for score in report.floor.values() if score.found.count]
    assert ranges
    for score in ranges:
        assert score.found.p95 == 0.0 and score.found_nominal == score.nominal
        assert 0.002 < score.nominal.median < 0.5


def test_a_known_shift_is_the_error_and_sigma_is_judged_along_each_axis(validation: FrameDataset) -> None:
    answers = _shifted(perfect_answers(validation), np.array([3.0, 4.0]), sigma=3.5)
    score = Evaluation(validation, answers).report().corners["crosswalk"]
    assert score.error_px.median == pytest.approx(5.0, abs=1e-4)
    assert {round(each.median, 3) for each in score.each_px.values() if each.count} == {5.0}
    assert score.within_one_sigma == 0.5 and score.within_two_sigma == 1.0


def test_corners_are_judged_of_what_is_believed_only(validation: FrameDataset) -> None:
    report = Evaluation(validation, perfect_answers(validation, score=0.2), threshold=0.25).report()
    score = report.corners["crosswalk"]
    assert score.error_px.count == 0 and score.error_px.median is None and score.within_one_sigma is None
    assert report.operating.recall == 0.0 and report.overall.map > 0.99
