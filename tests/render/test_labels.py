"""Which objects are labelled, under what names, and which are ignore regions."""

from collections.abc import Callable

import cv2
import numpy as np
import pycocotools.mask
import pytest
from label_views import (
    by_opencv,
    camera_of,
    only,
    pose_towards,
    ray_cast,
)

from adc_bench.dataset.sampling import draw_frame, draw_scenario
from adc_bench.dataset.split import load_split
from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.render import ArenaRenderer
from adc_bench.render.labels import labels_of
from adc_bench.render.runs import regions
from adc_bench.render.targets import Target, label_ids, targets_of
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID, PANEL_SIGNS, PanelSign
from adc_bench.world.scenario import Scenario
from adc_bench.world.signs import BOARD_M


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
