"""What the semantic camera says, against poses reckoned by hand."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.render.semantic import objects_in_view
from adc_bench.render.targets import Target, targets_of
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import NO_KEYPOINTS, Label
from adc_bench.world.layout import BoxPlace, Layout
from adc_bench.world.scenario import Scenario
from adc_bench.world.signs import VerticalSign

BOX_YAW = 0.25


@pytest.fixture(scope="module")
def targets(scenario_of: Callable[..., Scenario]) -> tuple[Target, ...]:
    scenario = msgspec.structs.replace(
        scenario_of("normal"),
        layout=Layout(boxes=(BoxPlace(x_m=1.0, y_m=-1.0, yaw_rad=BOX_YAW),)),
        signs=(VerticalSign(name="sign_0", sign="sign_dip", x_m=0.0, y_m=1.0, yaw_rad=math.pi),),
    )
    return targets_of(scenario, "left")


def label_of(target: Target, *, ignore: bool = False) -> Label:
    return Label(
        category_id=target.category_id,
        instance=target.instance,
        box_px=(0, 0, 9, 9),
        amodal_box_px=(0, 0, 9, 9),
        amodal_box_whole_px=(0, 0, 9, 9),
        mask_rle=b"",
        visible_px=81,
        visible_fraction=1.0,
        truncation=0.0,
        distance_m=1.0,
        pose_world_object=target.figures,
        keypoints_px=NO_KEYPOINTS,
        ignore=ignore,
    )


# A robot at (-2, -1) that looks along +y: what lies dx, dy of it in the world is at (dy, -dx) for it.
ROBOT = Pose2(x_m=-2.0, y_m=-1.0, yaw_rad=math.pi / 2)
SIGN_AHEAD_M = (0.0305 + 0.01) / 2  # the board's middle before the foot's


def test_poses_are_the_ones_reckoned_by_hand(targets: tuple[Target, ...]) -> None:
    seen = objects_in_view([label_of(target) for target in targets], targets, ROBOT.to_pose3(), 10.0)
    found = {one.instance: one.pose_robot_object for one in seen}
    expected = {
        "crosswalk": (-2.225 + 1.0, -2.0, -math.pi / 2),
        "box_0": (0.0, -3.0, BOX_YAW - math.pi / 2),
        "sign_0": (2.0, -2.0 + SIGN_AHEAD_M, math.pi / 2),
    }
    for name, (x_m, y_m, yaw_rad) in expected.items():
        assert (found[name].x_m, found[name].y_m) == pytest.approx((x_m, y_m), abs=1e-9)
        assert math.cos(found[name].yaw_rad - yaw_rad) == pytest.approx(1.0)
    # the panel that +x traffic sees faces -x: to the left of this robot
    assert found["panel_facing_west"].yaw_rad == pytest.approx(math.pi / 2)
    assert found["panel_facing_east"].yaw_rad == pytest.approx(-math.pi / 2)
    assert [one.category for one in seen] == [CATEGORIES[target.category_id - 1] for target in targets]
    assert seen[1].category == "panel_left" and seen[3].category == "sign_dip"


def test_only_what_is_labelled_and_no_ignore_region(targets: tuple[Target, ...]) -> None:
    labels = [label_of(targets[0], ignore=True), label_of(targets[-1])]
    assert [one.instance for one in objects_in_view(labels, targets, ROBOT.to_pose3(), 10.0)] == ["box_0"]


def test_the_range_ends_where_it_says(targets: tuple[Target, ...]) -> None:
    labels = [label_of(target) for target in targets if target.instance == "box_0"]
    assert objects_in_view(labels, targets, ROBOT.to_pose3(), 2.99) == ()
    assert len(objects_in_view(labels, targets, ROBOT.to_pose3(), 3.01)) == 1


def test_a_nodding_robot_sees_the_same_poses(targets: tuple[Target, ...]) -> None:
    labels = [label_of(target) for target in targets]
    nodding = Pose3(rotation=rotation_zyx(math.pi / 2, 0.1, 0.0), translation_m=np.array([-2.0, -1.0, 0.05]))
    for nods, level in zip(
        objects_in_view(labels, targets, nodding, 10.0),
        objects_in_view(labels, targets, ROBOT.to_pose3(), 10.0),
        strict=True,
    ):
        a, b = nods.pose_robot_object, level.pose_robot_object
        assert (a.x_m, a.y_m, math.cos(a.yaw_rad - b.yaw_rad)) == pytest.approx((b.x_m, b.y_m, 1.0))
