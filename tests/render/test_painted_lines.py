"""Lane lines against OpenCV's projection of the course, and against the paint in real pictures."""

from collections.abc import Callable

import cv2
import msgspec
import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose2, Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.render.lane_lines import END_STEPS, RANGE_M, STEP_M, lane_lines_of
from adc_bench.render.other_ids import OtherId
from adc_bench.render.targets import CROSSWALK_ID, label_ids
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.frame import LaneLine
from adc_bench.world.layout import BoxPlace, Layout
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig

Array = NDArray[np.float64]
FLOOR = np.zeros((240, 320), np.uint8)
NAMES = {"outer", "bulge", "drop_east", "drop_west", "centre_east", "centre_west", "bulge_dashes"}


def drawn_lines(course: Course) -> dict[str, shapely.LineString]:
    lines = {name: shapely.LineString(points) for name, points in course.edge_lines.items()}
    for name, path in zip(("centre_east", "centre_west", "bulge_dashes"), course.dashed_lines, strict=True):
        lines[name] = shapely.LineString(path.sample(0.005)[:, :2])
    return lines


def looks(course: Course) -> list[tuple[Camera, Pose3]]:
    """Return cameras of the rig, on the lap and off it, looking both ways."""
    rng, mounts = np.random.default_rng(2), SensorRig().cameras
    found = []
    for k in range(24):
        aside = Pose2(x_m=0.0, y_m=float(rng.normal(0, 0.4)), yaw_rad=float(rng.normal(0, 0.6) + np.pi * (k % 3 == 0)))
        robot = course.lap.pose(float(rng.uniform(0, course.lap.length_m))) @ aside
        mount = mounts[k % 2]
        found.append((mount.camera(), robot.to_pose3() @ mount.pose_robot_camera(0.01, -0.02)))
    return found


def by_opencv(points_world: Array, camera: Camera, pose: Pose3) -> Array:
    """Return the pixels (n, 2) of floor points (n, 2); nan behind the camera."""
    points = pose.inverse().transform(np.column_stack([points_world, np.zeros(len(points_world))]))
    lens = np.array([camera.k1, camera.k2, 0.0, 0.0])
    pixels, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix(), lens)
    return np.where(points[:, 2:] > 0, pixels.reshape(-1, 2), np.nan)


def in_view(points_world: Array, camera: Camera, pose: Pose3) -> NDArray[np.bool_]:
    pixels = by_opencv(points_world, camera, pose)
    shown = ((pixels >= 0) & (pixels < (camera.width_px, camera.height_px))).all(axis=1)
    near: NDArray[np.bool_] = shown & (np.hypot(*(points_world - pose.translation_m[:2]).T) <= RANGE_M)
    return near


@pytest.mark.parametrize("course", [Course(spec=spec) for spec in COURSE_SETS.values()], ids=list(COURSE_SETS))
def test_lines_are_the_courses_and_in_the_picture_where_opencv_puts_them(course: Course) -> None:
    lines, seen = drawn_lines(course), set()
    for camera, pose in looks(course):
        for line in lane_lines_of(FLOOR, course, camera, pose):
            seen.add(line.name)
            points = line.points_world.astype(np.float64)
            assert shapely.distance(lines[line.name], shapely.points(points)).max() < 1e-3
            assert np.hypot(*np.diff(points, axis=0).T).max() <= STEP_M + 1e-6
            assert len(points) >= 2 and line.visible.all()
            assert line.points_px == pytest.approx(by_opencv(points, camera, pose), abs=0.05)
            assert in_view(points, camera, pose)[1:-1].all()
    assert seen == NAMES


def test_no_stretch_is_left_out_or_ends_early() -> None:
    """Points every centimetre that OpenCV puts into the picture have a line point beside them."""
    course = Course()
    dense = {
        name: shapely.get_coordinates(line.interpolate(np.arange(0.0, line.length, 0.01)))
        for name, line in drawn_lines(course).items()
    }
    for camera, pose in looks(course):
        found = lane_lines_of(FLOOR, course, camera, pose)
        for name, every_cm in dense.items():
            shown = every_cm[in_view(every_cm, camera, pose)]
            stretches = [shapely.LineString(x.points_world) for x in found if x.name == name]
            away = shapely.distance(shapely.MultiLineString(stretches), shapely.points(shown)) if len(shown) else [0.0]
            # clipped corners of the picture may hold less of a line than lies between two points
            assert np.mean(np.array(away) > STEP_M / END_STEPS + 0.002) < 0.02 or len(shown) < 12


def test_the_bulges_corners_are_points_of_its_line() -> None:
    course, camera = Course(), SensorRig().camera("road").camera()
    corner = course.bulge_corners[2]
    pose = Pose2(x_m=float(corner[0]) - 1.5, y_m=float(corner[1]) + 0.4, yaw_rad=-0.2).to_pose3()
    lines = lane_lines_of(FLOOR, course, camera, pose @ SensorRig().camera("road").pose_robot_camera())
    (bulge,) = [line for line in lines if line.name == "bulge"]
    assert np.hypot(*(bulge.points_world - corner).T).min() < 1e-5


def test_points_are_visible_where_the_picture_shows_floor_or_crosswalk() -> None:
    course = Course()
    camera, pose = looks(course)[1]
    open_floor = lane_lines_of(FLOOR, course, camera, pose)
    for standing in (7, OtherId.TUNNEL, OtherId.WALL, OtherId.TAPE, OtherId.ROBOT):
        ids = FLOOR.copy()
        ids[:, :160], ids[:, 160:] = CROSSWALK_ID, standing
        for line, whole in zip(lane_lines_of(ids, course, camera, pose), open_with_left(open_floor), strict=True):
            assert (line.points_px == whole.points_px).all()
            assert (line.visible == (whole.points_px[:, 0] < 160)).all()
        assert lane_lines_of(np.full_like(FLOOR, standing), course, camera, pose) == ()


def open_with_left(lines: tuple[LaneLine, ...]) -> list[LaneLine]:
    return [line for line in lines if (line.points_px[:, 0] < 160).any()]


def test_a_camera_that_sees_no_floor_has_no_lines() -> None:
    mount = SensorRig().camera("panel")
    up = Pose2(x_m=0.0, y_m=-2.6, yaw_rad=0.0).to_pose3() @ mount.pose_robot_camera(-1.2, 0.0)
    assert lane_lines_of(FLOOR, Course(), mount.camera(), up) == ()


def test_the_crosswalk_has_its_id(scenario_of: Callable[..., Scenario]) -> None:
    assert label_ids(scenario_of("normal"))["crosswalk"] == CROSSWALK_ID


def test_visible_points_lie_on_paint_and_a_box_hides_its_own(
    renderer: ArenaRenderer, scenario_of: Callable[..., Scenario]
) -> None:
    course = Course()
    on_dashes = course.dashed_lines[0].pose(8.0)
    box = BoxPlace(x_m=on_dashes.x_m, y_m=on_dashes.y_m, yaw_rad=on_dashes.yaw_rad)
    scenario = msgspec.structs.replace(scenario_of("normal"), layout=Layout(boxes=(box,)))
    renderer.load(scenario)
    robot = course.lap.pose(7.0).to_pose3()
    frame = renderer.frame(0, "road", robot)
    grey = cv2.cvtColor(renderer.raw("road", robot)[0][..., :3], cv2.COLOR_RGB2GRAY)
    solid = [line for line in frame.lane_lines if line.name in ("outer", "drop_east")]
    near = [line.points_px[line.visible & (line.points_px[:, 1] > 100)].astype(int) for line in solid]
    on_line = np.concatenate(near)
    assert len(on_line) > 10
    brighter = [grey[v, u] > 1.3 * np.median(grey[v, max(0, u - 25) : u + 25]) for u, v in on_line]
    assert np.mean(brighter) > 0.9
    (centre,) = [line for line in frame.lane_lines if line.name == "centre_east"]
    inside = Pose2(x_m=box.x_m, y_m=box.y_m, yaw_rad=box.yaw_rad).to_pose3().inverse()
    places = inside.transform(np.column_stack([centre.points_world, np.zeros(len(centre.visible))]))
    under_box = (np.abs(places[:, :2]) < 0.28).all(axis=1)
    assert under_box.sum() > 3 and not centre.visible[under_box].any()
    assert centre.visible[places[:, 0] < -0.4].all()
