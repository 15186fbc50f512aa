"""Tight boxes once more from geometry alone: rays through all pixels against every surface, and no label picture.

A label is compared if no ray to its object meets anything else before it. The objects' shapes are put together here
from what the world says of them, the lens is OpenCV's.

The camera's picture is made of rays that stand in the even grid of a picture without a lens; a pixel's id is that
of the ray nearest to its middle, up to half a pixel aside (docs/labels.md). `sampled` is the box of these rays' hits,
`middle` that of rays through the pixels' very middles: they differ where an object ends in a tip thinner than a pixel.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.dataset.sampling import draw_frame, draw_scenario, scenario_number
from adc_bench.dataset.split import load_split
from adc_bench.geometry import Camera, Pose2, Pose3, rotation_zyx
from adc_bench.render import ArenaRenderer
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.frame import Frame, Label
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import BOARD_CENTRE_Z_M, BOARD_M, BOARD_THICKNESS_M, POST_M, SQUARES, TRIANGLES
from adc_bench.world.solids import Body, Solid
from adc_bench.world.works import BOX_SIZE_M, CONE_FOOT_M, CONE_SIZE_M, TAPE_HEIGHT_M, TAPE_WIDTH_M

Array = NDArray[np.float64]
# (origin (3,), directions (n, 3)) in the world -> how many directions away the surface is (n,), inf where it is missed
Surface = Callable[[Array, Array], Array]
BOXES = 500
AROUND_PX = 4  # rays are cast so far around a label's box
CLEAR = 0.9  # visible fraction from which a label is looked at


@dataclass(frozen=True, kw_only=True, eq=False)
class Compared:
    """A label's box and those of its rays, (4,) each."""

    category: str
    box: Array
    sampled: Array
    middle: Array


def test_five_hundred_boxes_are_those_of_rays(compared: list[Compared]) -> None:
    from_sampled = np.array([np.abs(one.box - one.sampled) for one in compared])
    from_middle = np.array([np.abs(one.box - one.middle) for one in compared])
    for name, away in (("rays of the picture's grid", from_sampled), ("pixels' middles", from_middle)):
        worst = away.max(axis=1)
        print(f"{name}: sides {away.mean():.3f} px, worst {worst.max():.1f} px, {(worst <= 1).sum()} boxes within 1 px")
    assert len(compared) == BOXES
    assert from_sampled.max() <= 1.0
    assert from_sampled.mean() < 0.05
    assert (from_middle.max(axis=1) <= 1.0).mean() > 0.95
    assert from_middle.mean() < 0.3


def test_boxes_of_all_kinds_were_compared(compared: list[Compared]) -> None:
    count = Counter(one.category for one in compared)
    assert {"crosswalk", "box", "cone"} <= set(count)
    assert len([category for category in count if category.startswith("panel")]) == 6
    assert len([category for category in count if category.startswith("sign")]) == 12


@pytest.fixture(scope="module")
def compared(renderer: ArenaRenderer) -> list[Compared]:
    """The first `BOXES` labels that nothing covers."""
    found: list[Compared] = []
    for arena, frame in frames(renderer):
        camera = renderer.rig.camera(frame.camera).camera()
        for label in frame.labels:
            if label.visible_fraction > CLEAR and not label.ignore:
                one = arena.compared(label, camera, frame.pose_world_camera)
                found += [one] if one else []
        if len(found) >= BOXES:
            return found[:BOXES]
    raise AssertionError("too few frames")


def frames(renderer: ArenaRenderer) -> Iterator[tuple["Arena", Frame]]:
    """Yield frames of the training split, each with its arena; the tapes hang in every other arena."""
    split, rig = load_split("train"), SensorRig()
    for number in range(40):
        scenario, torn = draw_scenario(split, number, rig), number % 2 == 0
        renderer.load(scenario)
        renderer.place({}, [tape.name for tape in scenario.tapes] if torn else [])
        arena = Arena.of(scenario, torn=torn)
        for index in range(number * split.frames_per_scenario, (number + 1) * split.frames_per_scenario):
            assert scenario_number(split, index) == number
            plan = draw_frame(split, scenario, index)
            renderer.set_panel(plan.panel_sign)
            yield arena, renderer.frame(index, plan.camera, plan.pose_world_robot, plan.motion)


@dataclass(frozen=True, kw_only=True, eq=False)
class Block:
    """A thing that covers what is behind it, as the box around it; whose it is."""

    owner: str
    pose_world_block: Pose3
    half_m: Array

    def entry(self, origin: Array, ways: Array) -> Array:
        return enter_box(self.pose_world_block, self.half_m, origin, ways)


@dataclass(frozen=True, kw_only=True, eq=False)
class Arena:
    """A scenario's objects by name, and everything that may stand before them."""

    objects: dict[str, Surface]
    blocks: tuple[Block, ...]

    @classmethod
    def of(cls, scenario: Scenario, *, torn: bool) -> "Arena":
        tapes = [] if torn else list(tape_blocks(scenario))
        solids = [block_of(solid, solid.name) for solid in scenario.solids]
        parts = [block_of(part, body.name, body.pose) for body in scenario.bodies for part in body.parts]
        return cls(objects=objects_of(scenario), blocks=(*solids, *parts, *tapes))

    def compared(self, label: Label, camera: Camera, pose: Pose3) -> Compared | None:
        """Return a label's box and those of its rays; None if something covers one of them."""
        x0, y0, x1, y1 = (int(edge) for edge in label.box_px)
        columns = np.arange(max(0, x0 - AROUND_PX), min(camera.width_px, x1 + AROUND_PX))
        rows = np.arange(max(0, y0 - AROUND_PX), min(camera.height_px, y1 + AROUND_PX))
        pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        through_middle = rays(np.asarray(pixels + 0.5, np.float64), camera)
        boxes = []
        for through in (sampled_rays(through_middle, camera), through_middle):
            origin, ways = pose.translation_m, through @ pose.rotation.T
            away = self.objects[label.instance](origin, ways)
            hit = np.isfinite(away)
            if self._is_covered(label.instance, origin, ways[hit], away[hit]):
                return None
            boxes.append(box_around(pixels[hit]))
        sampled, middle = boxes
        return Compared(
            category=CATEGORIES[label.category_id - 1], box=np.array(label.box_px), sampled=sampled, middle=middle
        )

    def _is_covered(self, instance: str, origin: Array, ways: Array, away: Array) -> bool:
        reach_m = float((away * np.linalg.norm(ways, axis=1)).max())
        return any(
            bool((block.entry(origin, ways) < away - 1e-9).any())
            for block, distance_m in zip(self.blocks, self._distances_m(origin), strict=True)
            if block.owner != instance and distance_m < reach_m
        )

    def _distances_m(self, point_world: Array) -> Array:
        """Return how far each block is from a point."""
        turned, at, half_m = self._places
        inside = np.einsum("ki,kij->kj", point_world - at, turned)
        return np.asarray(np.linalg.norm(np.maximum(np.abs(inside) - half_m, 0.0), axis=1))

    @cached_property
    def _places(self) -> tuple[Array, Array, Array]:
        """The blocks' rotations (n, 3, 3), middles and half sizes (n, 3)."""
        poses = [block.pose_world_block for block in self.blocks]
        return (
            np.stack([pose.rotation for pose in poses]),
            np.stack([pose.translation_m for pose in poses]),
            np.stack([block.half_m for block in self.blocks]),
        )


def box_around(pixels: NDArray[np.int64]) -> Array:
    return np.concatenate([pixels.min(axis=0), pixels.max(axis=0) + 1]).astype(np.float64)


def rays(points_px: Array, camera: Camera) -> Array:
    """Return OpenCV's directions (n, 3), z = 1, through points (n, 2) of the picture."""
    lens, exact = np.array([camera.k1, camera.k2, 0.0, 0.0]), (cv2.TERM_CRITERIA_COUNT, 25, 0.0)
    flat = cv2.undistortImagePoints(points_px[:, None], camera.matrix(), lens, arg1=exact).reshape(-1, 2)
    return np.column_stack([(flat - (camera.cx_px, camera.cy_px)) / (camera.fx_px, camera.fy_px), np.ones(len(flat))])


def sampled_rays(directions: Array, camera: Camera) -> Array:
    """Return the directions (n, 3) of the picture's grid nearest to others: one apart by 1/f, even about the axis."""
    f_px = np.array([camera.fx_px, camera.fy_px])
    grid = (np.floor(directions[:, :2] * f_px) + 0.5) / f_px
    return np.column_stack([grid, np.ones(len(grid))])


def enter_box(pose: Pose3, half_m: Array, origin: Array, ways: Array) -> Array:
    """Return how many directions away rays enter a box, by slabs."""
    inside = pose.inverse()
    start, along = inside.transform(origin[None])[0], ways @ inside.rotation.T + 1e-15
    one, other = (-half_m - start) / along, (half_m - start) / along
    enter, leave = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return np.where((enter < leave) & (leave > 0), np.maximum(enter, 0.0), np.inf)


def enter_flat(pose: Pose3, covers: Callable[[Array, Array], NDArray[np.bool_]], origin: Array, ways: Array) -> Array:
    """Return how many directions away rays meet, from the side of +x, what `covers` of the plane x = 0 (y, z)."""
    inside = pose.inverse()
    start, along = inside.transform(origin[None])[0], ways @ inside.rotation.T
    away = -start[0] / np.where(along[:, 0] == 0, 1e-15, along[:, 0])
    meets = covers(start[1] + away * along[:, 1], start[2] + away * along[:, 2])
    return np.where((start[0] > 0) & (away > 0) & meets, away, np.inf)


def enter_cone(pose: Pose3, foot_m: float, top_m: float, radius_m: float, origin: Array, ways: Array) -> Array:
    """Return how many directions away rays enter the side of an upright cone, its foot and tip at heights of `pose`.

    With h the height below the tip, the side is x^2 + y^2 = (slope h)^2: a quadratic equation along a ray.
    """
    inside = pose.inverse()
    start, along = inside.transform(origin[None])[0] - (0.0, 0.0, top_m), ways @ inside.rotation.T
    slope = radius_m / (top_m - foot_m)
    weight = np.array([1.0, 1.0, -(slope**2)])
    a, b, c = along**2 @ weight, (along * start) @ weight, float(start**2 @ weight)
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    best = np.full(len(ways), np.inf)
    for away in ((-b - root) / a, (-b + root) / a):
        height = start[2] + away * along[:, 2]
        on_side = (b * b >= a * c) & (away > 0) & (height <= 0) & (height >= foot_m - top_m)
        best = np.where(on_side & (away < best), away, best)
    return best


def objects_of(scenario: Scenario) -> dict[str, Surface]:
    low, high = scenario.course.crosswalk_corners.min(axis=0), scenario.course.crosswalk_corners.max(axis=0)
    # the plane x = 0 laid on the floor: its y is the world's x, its z the world's y
    floor = Pose3(rotation=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), translation_m=np.zeros(3))

    def on_crosswalk(x: Array, y: Array) -> NDArray[np.bool_]:
        within: NDArray[np.bool_] = (x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1])
        return within

    surfaces: dict[str, Surface] = {"crosswalk": lambda o, w: enter_flat(floor, on_crosswalk, o, w)}
    for solid in scenario.solids:
        if solid.kind == "panel":
            surfaces[solid.name] = panel_surface(solid)
    for sign in scenario.signs:
        surfaces[sign.name] = board_surface(sign.sign, Pose2(x_m=sign.x_m, y_m=sign.y_m, yaw_rad=sign.yaw_rad))
    for body in scenario.bodies:
        if body.category:
            surfaces[body.name] = body_surface(body)
    return surfaces


def panel_surface(solid: Solid) -> Surface:
    depth, width, height = solid.size_m
    rotation = rotation_zyx(solid.yaw_rad, solid.pitch_rad, 0.0)
    middle = np.array(solid.centre_m) + rotation @ (depth / 2, 0.0, 0.0)
    pose = Pose3(rotation=rotation, translation_m=middle)
    return lambda o, w: enter_flat(pose, lambda y, z: (np.abs(y) <= width / 2) & (np.abs(z) <= height / 2), o, w)


def board_surface(sign: str, foot: Pose2) -> Surface:
    half = BOARD_M / 2
    (middle,) = foot.transform([(POST_M / 2 + BOARD_THICKNESS_M, 0.0)])
    pose = Pose3(rotation=rotation_zyx(foot.yaw_rad, 0.0, 0.0), translation_m=np.array([*middle, BOARD_CENTRE_Z_M]))

    def covers(y: Array, z: Array) -> NDArray[np.bool_]:
        if sign in SQUARES:
            return (np.abs(y) <= half) & (np.abs(z) <= half)
        if sign in TRIANGLES:  # as wide as high, the tip at the top
            return (np.abs(z) <= half) & (np.abs(y) <= (half - z) / 2)
        return np.hypot(y, z) <= half

    return lambda o, w: enter_flat(pose, covers, o, w)


def body_surface(body: Body) -> Surface:
    pose = body.pose.to_pose3()
    if body.category == "box":
        return lambda o, w: enter_box(raised(pose, BOX_SIZE_M[2] / 2), np.array(BOX_SIZE_M) / 2, o, w)
    foot = np.array([CONE_SIZE_M[0], CONE_SIZE_M[1], CONE_FOOT_M]) / 2
    radius = 0.8 * CONE_SIZE_M[0] / 2
    return lambda o, w: np.minimum(
        enter_box(raised(pose, CONE_FOOT_M / 2), foot, o, w),
        enter_cone(pose, CONE_FOOT_M, CONE_SIZE_M[2], radius, o, w),
    )


def raised(pose: Pose3, z_m: float) -> Pose3:
    return pose @ Pose3(rotation=np.eye(3), translation_m=np.array([0.0, 0.0, z_m]))


def block_of(solid: Solid, owner: str, pose: Pose2 | None = None) -> Block:
    placed = Pose3(rotation=rotation_zyx(solid.yaw_rad, solid.pitch_rad, 0.0), translation_m=np.array(solid.centre_m))
    whole = pose.to_pose3() @ placed if pose else placed
    return Block(owner=owner, pose_world_block=whole, half_m=np.array(solid.size_m) / 2)


def tape_blocks(scenario: Scenario) -> Iterator[Block]:
    """Yield tapes as boards from cone to cone, as deep as they may sag."""
    places = {body.name: body.pose for body in scenario.bodies}
    for tape in scenario.tapes:
        a, b = places[tape.first], places[tape.second]
        length, sag = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m), 0.05
        middle = np.array([(a.x_m + b.x_m) / 2, (a.y_m + b.y_m) / 2, TAPE_HEIGHT_M - sag / 2])
        yaw = math.atan2(b.y_m - a.y_m, b.x_m - a.x_m)
        yield Block(
            owner=tape.name,
            pose_world_block=Pose3(rotation=rotation_zyx(yaw, 0.0, 0.0), translation_m=middle),
            half_m=np.array([length / 2, 0.002, (TAPE_WIDTH_M + sag) / 2]),
        )
