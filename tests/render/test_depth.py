"""Depth and semantic masks against rays of the tests' own, against shapely, and against the instances' masks."""

import re
from dataclasses import dataclass

import msgspec
import numpy as np
import pycocotools.mask
import pytest
import shapely
from halls import hall
from numpy.typing import NDArray
from rays import CEILING, FLOOR, rays_through_pixels, seen

from adc_bench.geometry import Camera, Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.render.lens import Warp
from adc_bench.render.pixel_classes import floor_map
from adc_bench.world.arena import Tunnel
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.frame import Frame
from adc_bench.world.layout import BoxPlace
from adc_bench.world.scenario import Scenario
from adc_bench.world.semantics import CLASS_NAMES, SemanticClass, category_class
from adc_bench.world.sensors import PINHOLE, SensorRig

EXTRAS = ("depth", "semantic")
BOXES = (BoxPlace(x_m=1.5, y_m=-2.2, yaw_rad=0.4), BoxPlace(x_m=-2.0, y_m=2.0))
VIEWS = [  # camera, x, y, yaw
    ("road", -0.65, -2.6125, 0.0),
    ("panel", -0.65, -2.6125, 0.0),
    ("road", 6.4, 1.1, 1.2),
    ("road", -1.3, -3.2, -1.57),
    ("panel", 3.0, -2.4, 3.0),
    ("panel", 0.3, 2.8, 1.5),
]
CROSSWALK = category_class(CATEGORY_ID["crosswalk"])
KINDS = {"tunnel": "tunnel", "wall": "wall", "gantry": "gantry", "panel": "gantry", "ceiling": "wall", "box": "box"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Looked:
    """A frame of a view, its depth and classes, and what the tests' own rays say: how far, and which face."""

    frame: Frame
    camera: Camera
    depth_m: NDArray[np.float32]
    classes: NDArray[np.uint8]
    expected_m: NDArray[np.float64]
    face: NDArray[np.str_]


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return hall(boxes=BOXES, tunnel=Tunnel(start_s_m=8.0, length_m=5.0))


@pytest.fixture(scope="module")
def seeing(scenario: Scenario) -> ArenaRenderer:
    renderer = ArenaRenderer(SensorRig(), extras=EXTRAS)
    renderer.load(scenario)
    return renderer


@pytest.fixture(scope="module", params=VIEWS, ids=lambda view: f"{view[0]} at {view[1]}, {view[2]}")
def looked(request: pytest.FixtureRequest, seeing: ArenaRenderer, scenario: Scenario) -> Looked:
    frame, camera = frame_of(seeing, request.param)
    assert frame.depth_m is not None and frame.semantic is not None
    expected, face = seen(scenario, camera, frame.pose_world_camera)
    return Looked(
        frame=frame, camera=camera, depth_m=frame.depth_m, classes=frame.semantic, expected_m=expected, face=face
    )


def frame_of(renderer: ArenaRenderer, view: tuple[str, float, float, float]) -> tuple[Frame, Camera]:
    name, x_m, y_m, yaw_rad = view
    pose = Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad).to_pose3()
    return renderer.frame(0, name, pose), renderer.rig.camera(name).camera()


def inside(name: NDArray[np.str_]) -> NDArray[np.bool_]:
    """Return the pixels (h, w) that see the same face as all their neighbours."""
    same = np.ones(name.shape, bool)
    padded = np.pad(name, 1, mode="edge")
    height, width = name.shape
    for row in range(3):
        for column in range(3):
            same &= padded[row : row + height, column : column + width] == name
    return same


def test_depth_is_how_far_the_rays_go(looked: Looked) -> None:
    depth_m, expected_m = looked.depth_m, looked.expected_m
    assert depth_m.dtype == np.float32 and depth_m.shape == (240, 320)
    wrong_m, allowed_m = np.abs(depth_m - expected_m), np.maximum(0.01, 0.005 * expected_m)
    clear = inside(looked.face) & (looked.face != CEILING)  # lamps hang a centimetre under it
    assert (wrong_m < allowed_m)[clear].mean() > 0.9998  # the rest: strips of far floor two pixels high
    assert np.median(wrong_m[clear] / expected_m[clear]) < 1e-5
    assert (wrong_m < allowed_m).mean() > 0.98


def test_things_have_their_classes(looked: Looked) -> None:
    assert looked.classes.dtype == np.uint8
    clear = inside(looked.face)
    for face in np.unique(looked.face[clear]):
        classes = {CLASS_NAMES[known] for known in np.unique(looked.classes[clear & (looked.face == face)]).tolist()}
        if face == FLOOR:
            assert not classes & {*KINDS.values(), "sign_post", "furniture", "tape", "robot"}
        else:
            kind = KINDS[re.split("[_/]", face)[0]]
            assert classes <= ({"gantry", "panel_up"} if face.startswith("panel") else {kind})


def test_floor_classes_are_shapelys(looked: Looked, scenario: Scenario) -> None:
    rays = rays_through_pixels(looked.camera) @ looked.frame.pose_world_camera.rotation.T
    eye = looked.frame.pose_world_camera.translation_m
    labelled = looked.classes == CROSSWALK  # as its mask has it, pixel by pixel
    floor = np.flatnonzero((looked.face == FLOOR) & inside(looked.face) & ~labelled)
    chosen = np.random.default_rng(1).choice(floor, 1500)
    rays, found = rays.reshape(-1, 3)[chosen], looked.classes.ravel()[chosen]
    points = (eye + rays * (-eye[2] / rays[:, 2:]))[:, :2]
    classes, to_border_m = classes_by_shapely(scenario.course, points)
    agree = (found == classes) | (classes == CROSSWALK)
    assert agree[to_border_m > 0.005].all()  # the map's texels are a quarter of a centimetre
    assert agree.mean() > 0.99


def classes_by_shapely(course: Course, points: NDArray[np.float64]) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return the classes (n,) of floor points (n, 2), and how far (n,) the nearest border is."""
    bay = course.spec.bay
    around_bay = shapely.box(bay.near_x_m - bay.length_m, -9, bay.near_x_m, course.kerb_y_m - bay.gap_m)
    bottom = course.kerb_y_m - bay.gap_m - bay.depth_m
    bay_box = shapely.intersection(around_bay, shapely.box(-9, bottom, 9, 0))
    paint = shapely.union_all(course.paint)
    regions = [
        (SemanticClass.ROAD, course.road),
        (SemanticClass.PARALLEL_PLACE, shapely.Polygon(course.bulge_corners)),
        (SemanticClass.BAY_PLACE, bay_box),
        (SemanticClass.LANE_LINE, paint.difference(bay_box)),
        (SemanticClass.BAY_LINE, paint.intersection(bay_box)),
        (CROSSWALK, shapely.Polygon(course.crosswalk_corners)),
    ]
    classes, to_border = np.zeros(len(points), np.uint8), np.full(len(points), np.inf)
    dots = shapely.points(points)
    for known, region in regions:
        classes[shapely.contains_xy(region, points[:, 0], points[:, 1])] = known
        to_border = np.minimum(to_border, shapely.distance(region.boundary, dots))
    return classes, to_border


@pytest.mark.parametrize("course_set", COURSE_SETS)
def test_the_floor_map_is_shapelys_everywhere(course_set: str) -> None:
    spec = COURSE_SETS[course_set]
    points = np.random.default_rng(5).uniform((-9.5, -5.5), (9.5, 4.5), (3000, 2))
    crosswalk = shapely.Polygon(Course(spec=spec).crosswalk_corners)
    points = points[~shapely.contains_xy(crosswalk.buffer(0.01), points[:, 0], points[:, 1])]
    classes, to_border = classes_by_shapely(Course(spec=spec), points)
    found = floor_map(spec).at(points.T)
    assert (found == classes)[to_border > 0.004].all()
    assert {int(k) for k in np.unique(classes)} == set(range(6))


def test_a_category_s_class_is_its_instances_masks(seeing: ArenaRenderer, scenario: Scenario) -> None:
    covered = set()
    for full in (scenario, hall(full=True)):
        seeing.load(full)
        for view in (*VIEWS, ("road", 5.0, 4.3, -0.5), ("panel", 4.4, -2.7, 0.0)):
            frame, _ = frame_of(seeing, view)
            assert frame.semantic is not None
            for category_id, category in enumerate(CATEGORIES, start=1):
                masks = [label.mask_rle for label in frame.labels if label.category_id == category_id]
                whole = np.zeros(frame.semantic.shape, bool)
                for counts in masks:
                    whole |= pycocotools.mask.decode({"size": [240, 320], "counts": counts}).astype(bool)
                assert np.array_equal(frame.semantic == category_class(category_id), whole), category
                covered |= {category} if masks else set()
    seeing.load(scenario)
    assert {"crosswalk", "box", "cone", "panel_up"} <= covered and any(name.startswith("sign") for name in covered)


def test_pictures_and_labels_are_the_same_with_extras_and_without(renderer: ArenaRenderer, scenario: Scenario) -> None:
    with_extras = ArenaRenderer(SensorRig(), extras=EXTRAS)
    frames = []
    for one in (renderer, with_extras):
        one.load(scenario)
        frames.append(frame_of(one, VIEWS[0])[0])
    assert frames[0].jpeg == frames[1].jpeg and frames[0].labels == frames[1].labels
    assert frames[0].depth_m is None and frames[0].semantic is None


def test_a_drive_s_frames_have_them_too(seeing: ArenaRenderer) -> None:
    still, _ = frame_of(seeing, VIEWS[0])
    driven = seeing.drive_frame(3, "road", Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0).to_pose3(), time_s=0.1)
    assert driven.depth_m is not None and still.depth_m is not None and driven.semantic is not None
    assert driven.depth_m.tobytes() == still.depth_m.tobytes()
    assert still.semantic is not None and driven.semantic.tobytes() == still.semantic.tobytes()


def test_depth_without_a_lens_is_how_far_the_rays_go(scenario: Scenario) -> None:
    straight = tuple(msgspec.structs.replace(mount.resized(160, 120), lens=PINHOLE) for mount in SensorRig().cameras)
    renderer = ArenaRenderer(SensorRig(cameras=straight), extras=("depth",))
    renderer.load(scenario)
    frame, camera = frame_of(renderer, VIEWS[0])
    expected_m, face = seen(scenario, camera, frame.pose_world_camera)
    assert frame.depth_m is not None and frame.semantic is None
    wrong = np.abs(frame.depth_m / expected_m - 1)[inside(face)]
    assert (wrong < 0.001).mean() > 0.999


def test_depth_of_a_tilted_plane_through_a_strong_lens_is_exact() -> None:
    camera = Camera.from_hfov(width_px=96, height_px=64, hfov_rad=1.6, k1=-0.2, k2=0.03)
    pinhole = camera.covering_pinhole()
    v, u = np.mgrid[: pinhole.height_px, : pinhole.width_px] + 0.5
    plane = (0.4 + 0.002 * u + 0.003 * v).astype(np.float32)
    rays = rays_through_pixels(camera)
    flat = pinhole.project(rays.reshape(-1, 3)).reshape(64, 96, 2)
    expected = 0.4 + 0.002 * flat[..., 0] + 0.003 * flat[..., 1]
    assert Warp(camera, pinhole).affine(plane) == pytest.approx(expected, abs=1e-5)
    step = np.where(u < pinhole.width_px / 2, plane, plane + 5).astype(np.float32)
    stepped = Warp(camera, pinhole).affine(step)
    assert np.minimum(np.abs(stepped - expected), np.abs(stepped - expected - 5)).max() < 1e-5  # no mix of the two
