"""Outlines of objects, whole, hidden and cut off, against OpenCV, rays through the pixels and rendered pictures."""

import numpy as np
import pytest
from label_views import (
    LENSES,
    by_opencv,
    camera_of,
    edge_points,
    only,
    pose_towards,
    ray_cast,
    road_mount,
)

from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.render import ArenaRenderer
from adc_bench.render.labels import labels_of
from adc_bench.render.outlines import Pieces, outlines_of
from adc_bench.render.targets import Target
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.scenario import Scenario


def test_a_cone_is_as_large_as_it_should_be(targets: dict[str, Target]) -> None:
    corners = np.concatenate(targets["cone_left_0"].faces)
    assert np.ptp(corners, axis=0) == pytest.approx([0.15, 0.15, 0.23])
    tip = corners[corners[:, 2] > 0.229]
    assert np.allclose(tip[:, :2], 0.0)


@pytest.mark.parametrize(("k1", "k2"), LENSES)
@pytest.mark.parametrize("instance", ["crosswalk", "panel_facing_west", "sign_3", "box_1", "cone_left_1"])
def test_a_whole_objects_outline_is_opencvs(targets: dict[str, Target], instance: str, k1: float, k2: float) -> None:
    target, camera = targets[instance], camera_of(k1, k2)
    rng = np.random.default_rng(7)
    front = np.array(target.front or (0.0, 0.0, 1.0))
    compared = 0
    while compared < 12:
        offset = rng.uniform(0.6, 4.0) * (front + rng.uniform(-0.8, 0.8, 3))
        pose = pose_towards(target, offset, rng.uniform(-1, 1)) @ Pose3(
            rotation=rotation_zyx(0.0, *rng.uniform(-0.35, 0.35, 2)), translation_m=np.zeros(3)
        )
        points = edge_points(target)
        if (pose.inverse().transform(points)[:, 2] < 0.1).any():
            continue
        pixels = by_opencv(points, camera, pose)
        if (pixels < 0).any() or (pixels > (320, 240)).any():
            continue
        inverse = pose.inverse() @ target.pose_world_object
        found = outlines_of(Pieces.of([[inverse.transform(face) for face in target.faces]]), camera)
        assert found.truncations == pytest.approx([0.0], abs=1e-9)
        assert found.boxes_px[0] == pytest.approx((*pixels.min(axis=0), *pixels.max(axis=0)), abs=0.1)
        assert found.boxes_whole_px[0] == found.boxes_px[0]
        compared += 1


@pytest.mark.parametrize(
    ("k1", "k2", "size_px"), [*((*lens, (320, 240)) for lens in LENSES), (-0.12, 0.015, (640, 480))]
)
def test_an_object_in_the_open_is_wholly_visible_and_half_of_it_by_half(
    targets: dict[str, Target], k1: float, k2: float, size_px: tuple[int, int]
) -> None:
    target, camera = targets["box_1"], camera_of(k1, k2, *size_px)
    low, high = np.array([-0.3, -0.3, 0.0]), np.array([0.3, 0.3, 0.3])
    rng = np.random.default_rng(3)
    for _ in range(3):
        pose = pose_towards(target, np.array([*rng.uniform(-1.5, 1.5, 2), 0.8]))
        ids = ray_cast(target, low, high, camera, pose)
        label = only(labels_of(ids, [target], camera, pose))
        assert label.visible_px == np.count_nonzero(ids)
        assert label.visible_fraction > 0.97
        assert label.box_px == pytest.approx(label.amodal_box_px, abs=1.01)
        columns = np.flatnonzero(np.cumsum((ids > 0).sum(axis=0)) >= label.visible_px / 2)
        hidden = ids.copy()
        hidden[:, : columns[0]] = 0
        half = only(labels_of(hidden, [target], camera, pose))
        assert half.visible_fraction == pytest.approx(0.5, abs=0.03)
        assert half.amodal_box_px == label.amodal_box_px and half.truncation == label.truncation
        assert half.box_px[0] == columns[0]


def test_an_object_at_the_picture_border_is_truncated_by_its_share_outside() -> None:
    camera, middle = camera_of(), np.array([160.0, 120.0])
    for share in (0.25, 0.5, 0.75):
        half = 20.0
        centre = np.array([320 - half + 2 * half * share, 120.0])
        corners_px = centre + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        corners = np.column_stack([(corners_px - middle) / camera.fx_px, np.ones(4)]) * 2.0
        found = outlines_of(Pieces.of([[corners]]), camera)
        assert found.truncations == pytest.approx([share])
        assert found.boxes_px[0] == pytest.approx((centre[0] - half, 100, 320, 140))
        assert found.boxes_whole_px[0] == pytest.approx((centre[0] - half, 100, centre[0] + half, 140))


@pytest.mark.parametrize(("k1", "k2"), LENSES)
@pytest.mark.parametrize("s_m", [37.2, 38.4, 39.0, 39.6, 19.0, 20.6])
def test_the_crosswalk_is_where_rays_through_the_pixels_meet_it(
    scenario: Scenario, targets: dict[str, Target], s_m: float, k1: float, k2: float
) -> None:
    target, camera = targets["crosswalk"], camera_of(k1, k2)
    pose = scenario.course.lap.pose(s_m).to_pose3() @ road_mount(scenario).pose_robot_camera()
    half = np.abs(target.faces[0][0])
    thin = np.array([0.0, 0.0, 1e-6])
    ids = ray_cast(target, -half - thin, half, camera, pose)
    label = only(labels_of(ids, [target], camera, pose))
    # a sharp corner misses the middle of its last pixels
    assert label.amodal_box_px == pytest.approx(label.box_px, abs=2.0)
    assert label.visible_fraction > 0.98
    assert 0.0 <= label.truncation < 1.0


def test_an_object_through_the_camera_plane_is_cut_there() -> None:
    camera = camera_of()
    corners = np.array([[-0.5, 0.5, 2.0], [0.5, 0.5, 2.0], [0.5, 0.5, -1.0], [-0.5, 0.5, -1.0]])
    found = outlines_of(Pieces.of([[corners]]), camera)
    # a strip half a metre under the camera, 1 m wide: it ends 2 m ahead, and leaves the picture's foot 120 px to
    # either side of the middle, which lies 120 px over the foot
    horizon_px = 120 + camera.fy_px / 4
    assert found.boxes_px[0] == pytest.approx((40.0, horizon_px, 280.0, 240.0))
    # one picture further down it is three times as wide there: 360 px to either side
    assert found.boxes_whole_px[0] == pytest.approx((-200.0, horizon_px, 520.0, 480.0))
    assert found.truncations[0] > 0.9
    behind = outlines_of(Pieces.of([[corners - [0, 0, 5]]]), camera)
    assert behind.boxes_px[0] is None and behind.boxes_whole_px[0] is None and behind.truncations == [0.0]


@pytest.mark.parametrize(("k1", "k2"), [*LENSES, (-0.2, 0.0)])
def test_whole_boxes_follow_opencv_out_to_a_picture_beside_the_picture(
    targets: dict[str, Target], k1: float, k2: float
) -> None:
    """A box seen from near by, partly far outside: the box of its edges' points in the window, lens and all."""
    target, camera, rng = targets["box_1"], camera_of(k1, k2), np.random.default_rng(11)
    fold = np.sqrt(-1 / (3 * k1)) if k1 and not k2 else np.inf  # where s(r) r = r + k1 r^3 ends to rise
    compared = 0
    while compared < 10:
        pose = pose_towards(target, np.array([*rng.uniform(-1.2, 1.2, 2), rng.uniform(0.4, 1.0)])) @ Pose3(
            rotation=rotation_zyx(0.0, *rng.uniform(-0.9, 0.9, 2)), translation_m=np.zeros(3)
        )
        inverse = pose.inverse()
        points = inverse.transform(edge_points(target))
        if points[:, 2].min() < 0.05 or (np.hypot(*points[:, :2].T) / points[:, 2]).max() > 0.95 * fold:
            continue
        pixels = by_opencv(edge_points(target), camera, pose)
        if (
            not ((pixels > 0) & (pixels < (320, 240))).all(axis=1).any()
            or (np.abs(pixels - (160, 120)) > (480, 360)).any()
        ):
            continue
        found = outlines_of(
            Pieces.of([[(inverse @ target.pose_world_object).transform(face) for face in target.faces]]), camera
        )
        assert found.boxes_whole_px[0] == pytest.approx((*pixels.min(axis=0), *pixels.max(axis=0)), abs=0.5)
        compared += int((pixels < 0).any() or (pixels > (320, 240)).any())


@pytest.mark.parametrize(("k1", "k2"), [*LENSES, (-0.2, 0.0)])
def test_what_surrounds_the_camera_fills_picture_and_window(k1: float, k2: float) -> None:
    """A plane that passes near the camera reaches behind it; a lens that folds shows it to where it folds."""
    camera = camera_of(k1, k2)
    floor = np.array([[-50.0, 0.2, -50.0], [50.0, 0.2, -50.0], [50.0, 0.2, 50.0], [-50.0, 0.2, 50.0]])
    found = outlines_of(Pieces.of([[floor]]), camera)
    x0, y0, x1, y1 = found.boxes_px[0] or (0, 0, 0, 0)
    assert (x0, x1, y1) == (0, 320, 240) and 119.9 < y0 < 122
    wx0, _, wx1, wy1 = found.boxes_whole_px[0] or (0, 0, 0, 0)
    if k2 or not k1:
        assert (wx0, wx1, wy1) == pytest.approx((-320, 640, 480), abs=1e-3)
    else:
        reach_px = camera.fx_px * np.sqrt(-1 / (3 * k1)) * 2 / 3  # s(r) r at the fold
        assert (wx0, wx1) == pytest.approx((160 - reach_px, 160 + reach_px), abs=0.5)
        assert wy1 == pytest.approx(min(480, 120 + reach_px), abs=0.5)


VIEWS = [
    ("road", -0.8, -2.5, 0.0),
    ("panel", -1.2, -2.5, 0.0),
    ("road", 7.6, 2.2, 0.6),
    ("road", -1.6, -2.4, 0.2),
    ("panel", 1.5, -2.6, 0.0),
]


@pytest.mark.parametrize(("camera", "x_m", "y_m", "yaw_rad"), VIEWS)
def test_rendered_objects_fill_their_outlines(
    renderer: ArenaRenderer, scenario: Scenario, camera: str, x_m: float, y_m: float, yaw_rad: float
) -> None:
    renderer.load(scenario)
    frame = renderer.frame(0, camera, Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad).to_pose3())
    clear = [label for label in frame.labels if label.visible_px > 80 and label.visible_fraction > 0.97]
    assert len(clear) >= 2
    for label in clear:
        tape_before_it = label.category_id == CATEGORY_ID["cone"]  # hides the tip
        wrong = np.abs(np.subtract(label.box_px, label.amodal_box_px))
        assert (wrong[[0, 2, 3] if tape_before_it else slice(None)] < 2.0).all(), label.instance
    for label in frame.labels:
        x0, y0, x1, y1 = label.amodal_box_px
        assert 0 <= x0 < x1 <= 320 and 0 <= y0 < y1 <= 240
