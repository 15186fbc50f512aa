"""Labels against brute force on pictures made by hand, and against OpenCV's projection through the lens."""

from collections.abc import Callable

import cv2
import msgspec
import numpy as np
import pycocotools.mask
import pytest
from numpy.typing import NDArray
from rays import rays_through_pixels

from adc_bench.dataset.sampling import draw_frame, draw_scenario
from adc_bench.dataset.split import load_split
from adc_bench.geometry import ROTATION_BODY_OPTICAL, Camera, Pose2, Pose3, rotation_zyx
from adc_bench.render import ArenaRenderer
from adc_bench.render.labels import labels_of
from adc_bench.render.outlines import Pieces, outlines_of
from adc_bench.render.runs import regions
from adc_bench.render.targets import Target, label_ids, targets_of
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID, PANEL_SIGNS, PanelSign
from adc_bench.world.course import CourseSpec
from adc_bench.world.frame import KEYPOINT_HIDDEN, KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, NO_KEYPOINTS, Label
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount
from adc_bench.world.signs import BOARD_M, draw_signs
from adc_bench.world.streams import stream

Array = NDArray[np.float64]
LENSES = [(0.0, 0.0), (-0.12, 0.015), (-0.276, 0.045)]
LAYOUT = Layout(
    boxes=(BoxPlace(x_m=2.0, y_m=-2.2), BoxPlace(x_m=3.0, y_m=-3.0, yaw_rad=0.4)),
    works=Works(left=((8.5, 3.5), (9.3, 2.5)), right=((7.7, 3.0), (8.5, 2.1))),
)


@pytest.fixture(scope="module")
def scenario(scenario_of: Callable[..., Scenario]) -> Scenario:
    signs = draw_signs(CourseSpec(), stream(1, "signs"))
    return msgspec.structs.replace(scenario_of("normal"), layout=LAYOUT, signs=signs)


@pytest.fixture(scope="module")
def targets(scenario: Scenario) -> dict[str, Target]:
    return {target.instance: target for target in targets_of(scenario, "up")}


def road_mount(scenario: Scenario) -> CameraMount:
    return scenario.rig.camera("road")


def camera_of(k1: float = 0.0, k2: float = 0.0, width_px: int = 320, height_px: int = 240) -> Camera:
    return Camera.from_hfov(width_px=width_px, height_px=height_px, hfov_rad=np.radians(70), k1=k1, k2=k2)


def pose_towards(target: Target, offset_object: Array, roll_rad: float = 0.0) -> Pose3:
    """Return a camera at a point of the target's frame that looks at its origin."""
    (eye,) = target.pose_world_object.transform(offset_object[None])
    ahead = target.pose_world_object.translation_m - eye
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    upright = np.column_stack([right, np.cross(ahead, right), ahead])
    rolled = upright @ rotation_zyx(roll_rad, 0.0, 0.0)
    return Pose3(rotation=rolled, translation_m=eye)


def by_opencv(points_world: Array, camera: Camera, pose_world_camera: Pose3) -> Array:
    """Return pixels (n, 2), the first pixel's middle at one half as everywhere here."""
    inverse = pose_world_camera.inverse()
    turn, _ = cv2.Rodrigues(inverse.rotation)
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    pixels, _ = cv2.projectPoints(points_world, turn, inverse.translation_m, camera.matrix(), lens)
    return np.asarray(pixels.reshape(-1, 2), np.float64)


def edge_points(target: Target) -> Array:
    """Return points (n, 3) in the world on all lines between two corners of a piece: its edges are among them."""
    share = np.linspace(0.0, 1.0, 8 if len(target.faces[0]) > 20 else 60)[:, None, None, None]
    lines = [(face[:, None] * share + face[None] * (1 - share)).reshape(-1, 3) for face in target.faces]
    return target.pose_world_object.transform(np.concatenate(lines))


def ray_cast(target: Target, low: Array, high: Array, camera: Camera, pose: Pose3) -> NDArray[np.uint8]:
    """Return the label picture of an upright box (in the target's frame) alone, by slabs."""
    inside = target.pose_world_object.inverse() @ pose
    way = rays_through_pixels(camera) @ inside.rotation.T + 1e-12
    near, far = (low - inside.translation_m) / way, (high - inside.translation_m) / way
    enter, leave = np.minimum(near, far).max(axis=-1), np.maximum(near, far).min(axis=-1)
    return np.where((enter < leave) & (leave > 0), target.label_id, 0).astype(np.uint8)


def only(labels: tuple[Label, ...]) -> Label:
    (label,) = labels
    return label


@pytest.mark.parametrize("kinds", [2, 4, 90])
def test_regions_are_numpys_and_pycocotools(kinds: int) -> None:
    """Pictures of blots and of noise; ids that touch the first and the last pixel are among them."""
    rng = np.random.default_rng(kinds)
    for size in ((1, 1), (1, 40), (40, 1), (24, 32), (61, 17)):
        for blot in (1, 7):
            ids = np.kron(rng.integers(0, kinds, size), np.ones((blot, blot))).astype(np.uint8)
            wanted = range(1, kinds)
            found = regions(ids, wanted)
            assert list(found) == [int(k) for k in np.unique(ids) if k in wanted]
            for label_id, region in found.items():
                mask = ids == label_id
                rows, columns = np.nonzero(mask)
                assert region.box_px == (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
                assert region.visible_px == mask.sum()
                assert region.mask_rle == pycocotools.mask.encode(np.asfortranarray(mask, np.uint8))["counts"]
                coded = {"counts": region.mask_rle, "size": list(ids.shape)}
                assert (pycocotools.mask.decode(coded) == mask).all()


def test_there_is_no_region_without_pixels() -> None:
    assert regions(np.full((3, 4), 9, np.uint8), [1, 2]) == {}
    assert regions(np.full((3, 4), 9, np.uint8), []) == {}


def test_ids_go_by_crosswalk_panels_signs_bodies(scenario: Scenario, targets: dict[str, Target]) -> None:
    ids = label_ids(scenario)
    assert list(ids)[:4] == ["crosswalk", "panel_facing_west", "panel_facing_east", "sign_0"]
    assert list(ids)[14:] == [
        "sign_11",
        "box_0",
        "box_1",
        *(f"cone_{s}_{k}" for s in ("left", "right") for k in (0, 1)),
    ]
    assert list(ids.values()) == list(range(1, len(ids) + 1))
    assert {name: target.label_id for name, target in targets.items()} == ids
    for sign in scenario.signs:
        assert CATEGORIES[targets[sign.name].category_id - 1] == sign.sign


@pytest.mark.parametrize("shown", PANEL_SIGNS)
def test_both_panels_are_labelled_by_the_sign_shown(scenario: Scenario, shown: PanelSign) -> None:
    for target in targets_of(scenario, shown)[1:3]:
        assert target.category_id == CATEGORY_ID[f"panel_{shown}"]


def test_a_pushed_body_is_labelled_where_it_is(scenario: Scenario, targets: dict[str, Target]) -> None:
    pushed = Pose3(rotation=rotation_zyx(0.3, 0.1, 0.0), translation_m=np.array([2.5, -2.0, 0.1]))
    now = {target.instance: target for target in targets_of(scenario, "up", {"box_0": pushed})}
    assert now["box_0"].pose_world_object is pushed
    assert np.allclose(now["box_1"].pose_world_object.matrix(), targets["box_1"].pose_world_object.matrix())


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


@pytest.mark.parametrize("instance", ["sign_0", "sign_5", "sign_9", "panel_facing_west", "panel_facing_east"])
def test_nothing_is_labelled_from_behind(targets: dict[str, Target], instance: str) -> None:
    target, camera = targets[instance], camera_of(-0.12, 0.015)
    ids = np.full((240, 320), target.label_id, np.uint8)
    for sideways in (-0.8, 0.0, 0.8):
        before = pose_towards(target, np.array([1.0, sideways, 0.1]))
        assert only(labels_of(ids, [target], camera, before)).instance == instance
        behind = pose_towards(target, np.array([-1.0, sideways, 0.1]))
        assert labels_of(ids, [target], camera, behind) == ()


def test_a_board_seen_along_its_plane_is_an_ignore_region(targets: dict[str, Target]) -> None:
    target, camera = targets["sign_0"], camera_of()
    pose = pose_towards(target, np.array([target.faces[0][0, 0] + 1e-9, 1.0, 0.0]))
    ids = np.zeros((240, 320), np.uint8)
    ids[110:130, 160] = target.label_id
    label = only(labels_of(ids, [target], camera, pose))
    assert label.ignore and 0.0 <= label.truncation <= 1.0


def corners_of(target: Target, scenario: Scenario) -> Array:
    """Return the four corners (4, 3) in the world, put together from what the world says of the object."""
    if target.instance == "crosswalk":
        return np.column_stack([scenario.course.crosswalk_corners, np.zeros(4)])
    solid = next(solid for solid in scenario.solids if solid.name == target.instance)
    clockwise = np.array([[1, -1, 1], [1, 1, 1], [1, 1, -1], [1, -1, -1]])  # who sees +x has +y on the right
    return solid.pose_world_solid().transform(clockwise * solid.size_m / 2)


def filled(points_px: Array, label_id: int, size_px: tuple[int, int] = (320, 240)) -> NDArray[np.uint8]:
    """Return the label picture of a polygon (n, 2) alone."""
    ids = np.zeros((size_px[1], size_px[0]), np.uint8)
    cv2.fillPoly(ids, [np.round((points_px - 0.5) * 256).astype(np.int32)], label_id, shift=8)
    return ids


def ring(target: Target) -> Array:
    """Return points (n, 3) in the world around a flat target."""
    face = target.faces[0]
    share = np.linspace(0.0, 1.0, 20, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in zip(face, np.roll(face, -1, axis=0), strict=True)]
    return target.pose_world_object.transform(np.concatenate(sides))


FLAT = ["crosswalk", "panel_facing_west", "panel_facing_east", *(f"sign_{k}" for k in range(12))]


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


def test_labels_of_visible_objects_only(targets: dict[str, Target]) -> None:
    camera, pose = camera_of(), pose_towards(targets["crosswalk"], np.array([-2.0, 0.0, 1.0]))
    ids = np.zeros((240, 320), np.uint8)
    ids[100:120, 150:190] = targets["crosswalk"].label_id
    label = only(labels_of(ids, list(targets.values()), camera, pose))
    assert label.instance == "crosswalk"
    assert label.box_px == (150, 100, 190, 120) and label.visible_px == 800
    assert labels_of(np.zeros_like(ids), list(targets.values()), camera, pose) == ()


@pytest.mark.parametrize(("size_px", "least_px"), [((320, 240), 40), ((640, 480), 160)])
def test_small_things_are_ignore_regions(targets: dict[str, Target], size_px: tuple[int, int], least_px: int) -> None:
    target, camera = targets["cone_left_0"], camera_of(0, 0, *size_px)
    pose = pose_towards(target, np.array([9.0, 0.0, 1.0]))
    for count, ignored in ((least_px - 1, True), (least_px, False)):
        ids = np.zeros((size_px[1], size_px[0]), np.uint8)
        ids.ravel()[:count] = target.label_id
        label = only(labels_of(ids, [target], camera, pose))
        assert label.visible_fraction > 0.2 and label.ignore == ignored


def test_things_mostly_hidden_are_ignore_regions(targets: dict[str, Target]) -> None:
    target, camera = targets["box_0"], camera_of()
    pose = pose_towards(target, np.array([-2.0, 0.0, 0.5]))
    box = ray_cast(target, np.array([-0.3, -0.3, 0]), np.array([0.3, 0.3, 0.3]), camera, pose).ravel()
    pixels = np.flatnonzero(box)
    for share, ignored in ((0.17, True), (0.23, False)):
        ids = np.zeros(240 * 320, np.uint8)
        ids[pixels[: round(share * len(pixels))]] = target.label_id
        label = only(labels_of(ids.reshape(240, 320), [target], camera, pose))
        assert label.visible_px > 40 and label.ignore == ignored


def test_a_corner_cut_off_by_the_border_is_an_ignore_region(targets: dict[str, Target]) -> None:
    """A box turned out of the picture step by step: a tenth of its area is the limit, however many pixels that is."""
    target, camera = targets["box_0"], camera_of()
    towards, low, high = pose_towards(target, np.array([-0.9, 0.0, 0.5])), np.full(3, -0.3), np.full(3, 0.3)
    low[2] = 0.0
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    seen = {True: 0, False: 0}
    for turn_rad in np.linspace(0.6, 1.0, 12):
        pose = Pose3(rotation=towards.rotation @ rotation_zyx(0.0, turn_rad, 0.0), translation_m=towards.translation_m)
        ids = ray_cast(target, low, high, camera, pose)
        hull = cv2.convexHull(by_opencv(target.pose_world_object.transform(corners), camera, pose).astype(np.float32))
        share_outside = 1 - np.count_nonzero(ids) / cv2.contourArea(hull)
        if np.count_nonzero(ids) >= 60 and abs(share_outside - 0.9) > 0.01:
            label = only(labels_of(ids, [target], camera, pose))
            assert label.visible_fraction > 0.8 and label.ignore == (share_outside > 0.9)
            seen[label.ignore] += 1
    assert min(seen.values()) >= 2


def test_a_board_is_as_far_as_its_middle(targets: dict[str, Target]) -> None:
    target, camera = targets["panel_facing_east"], camera_of()
    pose = pose_towards(target, np.array([2.0, 0.0, 0.0]))
    label = only(labels_of(np.full((240, 320), target.label_id, np.uint8), [target], camera, pose))
    assert label.distance_m == pytest.approx(2.0 - 0.02)
    assert np.ptp(targets["sign_0"].faces[0], axis=0) == pytest.approx([0.0, BOARD_M, BOARD_M])


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


def test_a_rendered_sign_has_no_label_on_its_back(
    renderer: ArenaRenderer, scenario: Scenario, targets: dict[str, Target]
) -> None:
    renderer.load(scenario)
    for sign in scenario.signs[:6]:
        for ahead_m, shows in ((0.9, True), (-0.9, False)):
            towards = sign.yaw_rad + (np.pi if shows else 0.0)
            foot = Pose2(x_m=sign.x_m, y_m=sign.y_m, yaw_rad=sign.yaw_rad)
            ((x_m, y_m),) = foot.transform([(ahead_m, 0.0)])
            robot = Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=towards).to_pose3()
            _, ids = renderer.raw("panel", robot)
            assert (ids == targets[sign.name].label_id).any() == shows


def test_a_post_before_the_crosswalk_lowers_its_visible_fraction_only(
    renderer: ArenaRenderer, scenario_of: Callable[..., Scenario]
) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    beside_post = Pose2(x_m=0.0, y_m=-3.75, yaw_rad=np.pi / 2).to_pose3()
    label = next(x for x in renderer.frame(0, "road", beside_post).labels if x.instance == "crosswalk")
    assert 0.5 < label.visible_fraction < 0.99


def test_labels_of_drawn_arenas_hold_together(renderer: ArenaRenderer) -> None:
    """Every layout of the training split: masks apart, boxes around them, within what whole objects may fill."""
    split, seen = load_split("train"), 0
    for number in range(1, 12, 2):
        drawn = draw_scenario(split, number, renderer.rig)
        renderer.load(drawn)
        for index in range(number * split.frames_per_scenario, number * split.frames_per_scenario + 10):
            plan = draw_frame(split, drawn, index)
            frame = renderer.frame(index, plan.camera, plan.pose_world_robot, plan.motion)
            taken = np.zeros((240, 320), np.bool_)
            for label in frame.labels:
                mask = pycocotools.mask.decode({"counts": label.mask_rle, "size": [240, 320]}).astype(bool)
                assert not (taken & mask).any() and mask.sum() == label.visible_px > 0
                taken |= mask
                rows, columns = np.nonzero(mask)
                assert label.box_px == (columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
                inwards = np.array([1, 1, -1, -1])
                assert ((np.subtract(label.box_px, label.amodal_box_px) * inwards) > -2.0).all(), label.instance
                assert ((np.subtract(label.amodal_box_px, label.amodal_box_whole_px) * inwards) > -0.01).all()
                assert 0.0 < label.visible_fraction <= 1.0 and 0.0 <= label.truncation <= 1.0
                hidden = label.visible_fraction < 0.2 or label.truncation > 0.9
                assert label.ignore == (label.visible_px < 40 or hidden)
                for u, v, state in label.keypoints_px:
                    assert (0 <= u < 320 and 0 <= v < 240) if state else (u, v) == (0.0, 0.0)
                seen += 1
    assert seen > 90


def test_a_far_cone_and_a_board_from_the_side_are_ignore_regions_in_a_real_picture(
    renderer: ArenaRenderer, scenario: Scenario
) -> None:
    renderer.load(scenario)
    far = Pose2(x_m=1.0, y_m=3.0, yaw_rad=0.0).to_pose3()  # 7 m before the cones
    cones = [x for x in renderer.frame(0, "panel", far).labels if CATEGORIES[x.category_id - 1] == "cone"]
    assert cones and all(label.ignore and label.visible_px < 40 for label in cones)
    sign = scenario.signs[0]
    beside = Pose2(x_m=sign.x_m, y_m=sign.y_m, yaw_rad=sign.yaw_rad) @ Pose2(x_m=0.035, y_m=1.2, yaw_rad=-np.pi / 2)
    labels = [x for x in renderer.frame(0, "panel", beside.to_pose3()).labels if x.instance == sign.name]
    assert all(label.ignore for label in labels)
