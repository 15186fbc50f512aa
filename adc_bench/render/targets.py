"""What is labelled in a scenario: ids in the label picture, categories, shapes and where they are now."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3
from adc_bench.render.artwork.canvas import arc
from adc_bench.render.meshes import SIDES
from adc_bench.render.other_ids import TARGET_ID_MAX
from adc_bench.world.categories import CATEGORY_ID, PanelSign
from adc_bench.world.course import Course
from adc_bench.world.scenario import Scenario
from adc_bench.world.signs import VerticalSign, board_outline
from adc_bench.world.solids import Body, Solid

Array = NDArray[np.float64]
CROSSWALK_ID = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class Target:
    """An object that is labelled.

    Attributes:
        label_id: its id in the label picture, 1..199 (`other_ids.py` has what else is in there).
        pose_world_object: where it is. Its own frame has x along the way it faces (crosswalk: the starting direction).
        faces: corners (n, 3) in its own frame of each of its convex pieces, flat ones or solid ones; their union is
            the object.
        front: the side (3,) from which it is seen, None if from all round.
        keypoints: corners (4, 3) in its own frame, in the order of `Label.keypoints_px`, if it has some.
    """

    label_id: int
    category_id: int
    instance: str
    pose_world_object: Pose3
    faces: tuple[Array, ...]
    front: tuple[float, float, float] | None = None
    keypoints: Array | None = None

    @cached_property
    def figures(self) -> tuple[float, float, float, float, float, float, float]:
        """Where it is as seven figures."""
        return self.pose_world_object.figures()

    @cached_property
    def middle(self) -> Array:
        """The mean (3,) of its corners, in its own frame."""
        mean: Array = np.concatenate(self.faces).mean(axis=0)
        return mean


def label_ids(scenario: Scenario) -> dict[str, int]:
    """Return each labelled object's id by its name: crosswalk, panels, signs, then bodies that have a category."""
    panels = [solid.name for solid in scenario.solids if solid.kind == "panel"]
    signs = [sign.name for sign in scenario.signs]
    bodies = [body.name for body in scenario.bodies if body.category]
    names = ["crosswalk", *panels, *signs, *bodies]
    assert len(names) <= TARGET_ID_MAX, "as many boxes and cones do not stand on the road"
    return {name: label_id for label_id, name in enumerate(names, start=CROSSWALK_ID)}


def targets_of(
    scenario: Scenario, shown: PanelSign, body_poses: Mapping[str, Pose3] | None = None
) -> tuple[Target, ...]:
    """Return what is labelled, in the order of `label_ids`: the panels by the sign that they show, the bodies where
    they are now, or where the scenario put those that `body_poses` does not name.
    """
    ids, poses = label_ids(scenario), body_poses or {}
    solids = {solid.name: solid for solid in scenario.solids if solid.name in ids}
    panels = [solid for solid in solids.values() if solid.kind == "panel"]
    return (
        _crosswalk(scenario.course, ids["crosswalk"]),
        *(_panel(solid, ids[solid.name], shown) for solid in panels),
        *(_sign(sign, solids[sign.name], ids[sign.name]) for sign in scenario.signs),
        *(_body(body, ids[body.name], poses.get(body.name)) for body in scenario.bodies if body.category),
    )


# Targets are asked for with every frame; those that stand where they stood are made once.
@lru_cache(maxsize=16)
def _crosswalk(course: Course, label_id: int) -> Target:
    x_m, y_m = course.crosswalk_corners.mean(axis=0)
    corners = np.column_stack([course.crosswalk_corners - (x_m, y_m), np.zeros(4)])
    return Target(
        label_id=label_id,
        category_id=CATEGORY_ID["crosswalk"],
        instance="crosswalk",
        pose_world_object=Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=0.0).to_pose3(),
        faces=(corners,),
        front=(0.0, 0.0, 1.0),
        keypoints=corners,
    )


@lru_cache(maxsize=64)
def _panel(solid: Solid, label_id: int, shown: PanelSign) -> Target:
    _, width, height = solid.size_m
    screen = np.array([[-width, -height], [width, -height], [width, height], [-width, height]]) / 2
    return _board(solid, label_id, f"panel_{shown}", screen)


@lru_cache(maxsize=256)
def _sign(sign: VerticalSign, solid: Solid, label_id: int) -> Target:
    return _board(solid, label_id, sign.sign, board_outline(sign))


def _board(solid: Solid, label_id: int, category: str, outline: Array) -> Target:
    """Return what is shown on a solid's +x side: an outline (n, 2), x right and y up seen from the front."""
    x_m, (low, high) = solid.size_m[0] / 2, (outline.min(axis=0), outline.max(axis=0))
    square = np.array([(low[0], high[1]), high, (high[0], low[1]), low])
    return Target(
        label_id=label_id,
        category_id=CATEGORY_ID[category],
        instance=solid.name,
        pose_world_object=solid.pose_world_solid(),
        faces=(np.insert(outline, 0, x_m, axis=1),),
        front=(1.0, 0.0, 0.0),
        keypoints=np.insert(square, 0, x_m, axis=1),
    )


@lru_cache(maxsize=256)
def _body(body: Body, label_id: int, pose: Pose3 | None) -> Target:
    assert body.category
    return Target(
        label_id=label_id,
        category_id=CATEGORY_ID[body.category],
        instance=body.name,
        pose_world_object=pose or body.pose.to_pose3(),
        faces=tuple(_hull_corners(part) for part in body.parts),
    )


@lru_cache(maxsize=256)
def _hull_corners(part: Solid) -> Array:
    """Return corners (n, 3), in the body's frame, whose hull is the part."""
    circle = arc((0.0, 0.0), 0.5, 0.0, 360.0, SIDES + 1)[:-1]
    square = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])
    base = square if part.shape == "box" else circle
    top = np.zeros((1, 2)) if part.shape == "cone" else base
    unit = np.concatenate([np.insert(base, 2, -0.5, axis=1), np.insert(top, 2, 0.5, axis=1)])
    corners = part.pose_world_solid().transform(unit * part.size_m)
    corners.setflags(write=False)
    return corners
