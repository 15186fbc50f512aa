"""Draw the picture of docs/labels.md: labels and lane lines on six delivered pictures.

Usage: python scripts/label_picture.py [--out docs/pictures/labels.jpg]
"""

import argparse
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pycocotools.mask
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.categories import CATEGORIES
from adc_bench.world.course import Course
from adc_bench.world.frame import KEYPOINT_OUTSIDE, KEYPOINT_VISIBLE, Frame, Label, LaneLine
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

Picture = NDArray[np.uint8]
SIZE_PX, SCALE, QUALITY, SEED = (640, 480), 0.8, 80, 3
NAMED_PX = 24  # a box so high has its name written over it
FAMILY = LookFamily(floors=("charcoal_vinyl",), walls=("brick",), light_sets=("window_left",))
# Layout, camera, and where the robot stands.
VIEWS = (
    ("v1", "road", Pose2(x_m=-1.25, y_m=-2.5, yaw_rad=0.12)),
    ("v1", "panel", Pose2(x_m=-1.5, y_m=-2.75, yaw_rad=0.1)),
    ("d4_v1", "road", Pose2(x_m=6.7, y_m=-2.35, yaw_rad=0.35)),
    ("p2", "road", Pose2(x_m=0.3, y_m=-2.75, yaw_rad=-0.25)),
    ("v1", "panel", Pose2(x_m=4.2, y_m=-2.75, yaw_rad=-0.35)),
    ("v1", "road", Pose2(x_m=-0.25, y_m=-3.7, yaw_rad=1.5)),
)
BGR = tuple[int, int, int]
COLOURS: tuple[BGR, ...] = (
    (80, 220, 255),
    (255, 160, 60),
    (120, 255, 120),
    (220, 120, 255),
    (255, 255, 90),
    (90, 140, 255),
)
LINE: BGR = (60, 200, 60)
VISIBLE, HIDDEN = (60, 230, 60), (60, 60, 255)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/labels.jpg"))
    out = parser.parse_args().out
    rig = SensorRig()
    rig = msgspec.structs.replace(rig, cameras=tuple(mount.resized(*SIZE_PX) for mount in rig.cameras))
    renderer = ArenaRenderer(rig)
    drawn = [labelled(view(renderer, rig, layout, camera, pose)) for layout, camera, pose in VIEWS]
    sheet = np.concatenate([np.concatenate(drawn[k : k + 3], axis=1) for k in (0, 3)], axis=0)
    small = cv2.resize(sheet, None, fx=SCALE, fy=SCALE, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(out), small, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))


def view(renderer: ArenaRenderer, rig: SensorRig, layout: str, camera: str, pose: Pose2) -> Frame:
    renderer.load(scenario(layout, rig))
    return renderer.frame(0, camera, pose.to_pose3())


def scenario(layout: str, rig: SensorRig) -> Scenario:
    return set_up(
        name=layout,
        seed=SEED,
        layout=draw_layout(layout, Course(), stream(SEED, "layout")),
        look=draw_look(FAMILY, stream(SEED, "look"), "normal"),
        panel_sign="left",
        course=Course().spec,
        arena=ArenaSpec(),
        robot=ROBOTS["pioneer"],
        rig=rig,
    )


def labelled(frame: Frame) -> Picture:
    """Return the delivered picture with everything drawn on it, BGR (h, w, 3)."""
    picture = np.asarray(cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR), np.uint8)
    for line in frame.lane_lines:
        draw_line(picture, line)
    for label, colour in zip(frame.labels, COLOURS * len(frame.labels), strict=False):
        draw_label(picture, label, colour)
    return picture


def draw_line(picture: Picture, line: LaneLine) -> None:
    for point, visible in zip(line.points_px, line.visible, strict=True):
        cv2.circle(picture, at(point), 2, LINE if visible else HIDDEN, -1 if visible else 1, cv2.LINE_AA)


def draw_label(picture: Picture, label: Label, colour: BGR) -> None:
    mask = pycocotools.mask.decode({"counts": label.mask_rle, "size": list(picture.shape[:2])}).astype(bool)
    picture[mask] = (0.65 * picture[mask] + 0.35 * np.array(colour)).astype(np.uint8)
    x0, y0, x1, y1 = label.amodal_box_px
    dashed(picture, [(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    cv2.rectangle(picture, at(label.box_px[:2]), at(label.box_px[2:]), (128, 128, 128) if label.ignore else colour, 1)
    name = CATEGORIES[label.category_id - 1] + (" (ignore)" if label.ignore else f" {label.visible_fraction:.2f}")
    if label.box_px[3] - label.box_px[1] >= NAMED_PX:
        write(picture, name, (label.box_px[0], label.box_px[1] - 8), colour)
    for number, (u, v, state) in enumerate(label.keypoints_px):
        if state != KEYPOINT_OUTSIDE:
            cv2.circle(picture, at((u, v)), 4, VISIBLE if state == KEYPOINT_VISIBLE else HIDDEN, -1, cv2.LINE_AA)
            if label.box_px[2] - label.box_px[0] >= NAMED_PX:
                write(picture, str(number), (u + 5, v - 3), (255, 255, 255))


def dashed(picture: Picture, corners: list[tuple[float, float]]) -> None:
    """Draw a closed line of dashes through points."""
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        count = max(2, int(np.hypot(b[0] - a[0], b[1] - a[1]) / 6))
        points = np.linspace(a, b, count)
        for start, end in zip(points[:-1:2], points[1::2], strict=False):
            cv2.line(picture, at(start), at(end), (255, 255, 255), 1, cv2.LINE_AA)


def write(picture: Picture, text: str, place: tuple[float, float], colour: BGR) -> None:
    for shade, width in (((0, 0, 0), 3), (colour, 1)):
        cv2.putText(picture, text, at(place), cv2.FONT_HERSHEY_SIMPLEX, 0.4, shade, width, cv2.LINE_AA)


def at(point: tuple[float, ...] | NDArray[np.float32] | NDArray[np.float64]) -> tuple[int, int]:
    return round(float(point[0])), round(float(point[1]))


if __name__ == "__main__":
    main()
