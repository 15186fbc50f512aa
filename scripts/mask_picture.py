"""Draw the picture of docs/masks.md: delivered pictures, their semantic masks and their depth.

Usage: python scripts/mask_picture.py [--out docs/pictures/masks.jpg]
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose2
from adc_bench.render import ArenaRenderer
from adc_bench.world.arena import ArenaSpec
from adc_bench.world.course import Course
from adc_bench.world.frame import Frame
from adc_bench.world.look import LookFamily, draw_look
from adc_bench.world.robot import ROBOTS
from adc_bench.world.scenario import Scenario
from adc_bench.world.semantics import CLASS_NAMES
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.streams import stream

Picture = NDArray[np.uint8]
Bgr = tuple[int, int, int]
SEED, QUALITY, NEAREST_M = 3, 85, 0.5
FAMILY = LookFamily(floors=("charcoal_vinyl",), walls=("brick",), light_sets=("window_left",), artworks=("barbed",))
VIEWS = (
    ("d3_v1", "road", Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)),
    ("v1", "panel", Pose2(x_m=-1.5, y_m=-2.75, yaw_rad=0.1)),
    ("b2_v1", "road", Pose2(x_m=-1.6, y_m=-2.5, yaw_rad=-1.3)),
    ("d4_v1", "road", Pose2(x_m=6.7, y_m=-2.35, yaw_rad=0.35)),
)
COLOURS: dict[str, Bgr] = {
    "floor": (40, 40, 40),
    "road": (110, 110, 110),
    "lane_line": (255, 255, 255),
    "parallel_place": (200, 120, 40),
    "bay_place": (170, 150, 60),
    "bay_line": (230, 220, 150),
    "tunnel": (60, 40, 90),
    "wall": (90, 120, 90),
    "gantry": (180, 180, 60),
    "sign_post": (60, 120, 160),
    "furniture": (130, 80, 150),
    "tape": (120, 120, 255),
    "robot": (0, 0, 160),
    "crosswalk": (60, 220, 250),
    "box": (60, 200, 60),
    "cone": (30, 130, 255),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/masks.jpg"))
    out = parser.parse_args().out
    renderer = ArenaRenderer(SensorRig(), extras=("depth", "semantic"))
    rows = []
    for layout, camera, pose in VIEWS:
        renderer.load(arena(layout))
        rows.append(row(renderer.frame(0, camera, pose.to_pose3())))
    sheet = np.concatenate(rows, axis=0)
    cv2.imwrite(str(out), sheet, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))


def arena(layout: str) -> Scenario:
    course = Course()
    return set_up(
        name=layout,
        seed=SEED,
        look=draw_look(FAMILY, stream(SEED, "look"), "bright"),
        panel_sign="left",
        layout=draw_layout(layout, course, stream(SEED, "layout")),
        course=course.spec,
        arena=ArenaSpec(),
        robot=ROBOTS["pioneer"],
        rig=SensorRig(),
    )


def row(frame: Frame) -> Picture:
    """Return the picture, its classes with their names, and its inverse depth, side by side."""
    assert frame.depth_m is not None and frame.semantic is not None
    taken = cv2.imdecode(np.frombuffer(frame.jpeg, np.uint8), cv2.IMREAD_COLOR)
    level = np.round(255 * np.clip(NEAREST_M / frame.depth_m, 0, 1)).astype(np.uint8)
    depth = cv2.applyColorMap(level, cv2.COLORMAP_TURBO)
    return np.asarray(np.concatenate([taken, named(frame.semantic), depth], axis=1), np.uint8)


def named(classes: Picture) -> Picture:
    """Return the classes (h, w) in colours, the largest patch of each with its name."""
    whole = np.zeros((*classes.shape, 3), np.uint8)
    names = {known: CLASS_NAMES[known] for known in np.unique(classes).tolist()}
    for known, name in names.items():
        whole[classes == known] = colour_of(known, name)
    for known, name in names.items():
        inside = cv2.distanceTransform(np.pad((classes == known).astype(np.uint8), 1), cv2.DIST_L2, 3)
        if inside.max() < 4:
            continue
        row, column = np.unravel_index(int(inside.argmax()), inside.shape)
        (wide, _), _ = cv2.getTextSize(name, cv2.FONT_HERSHEY_SIMPLEX, 0.3, 1)
        left = int(np.clip(column - wide // 2, 2, classes.shape[1] - wide - 2))
        for colour, thick in (((0, 0, 0), 2), ((255, 255, 255), 1)):
            cv2.putText(whole, name, (left, int(row) + 3), cv2.FONT_HERSHEY_SIMPLEX, 0.3, colour, thick, cv2.LINE_AA)
    return whole


def colour_of(known: int, name: str) -> Bgr:
    """Return a class' colour, for signs one that follows from its number."""
    if name in COLOURS:
        return COLOURS[name]
    ((blue, green, red),) = cv2.cvtColor(np.array([[[known * 53 % 180, 150, 240]]], np.uint8), cv2.COLOR_HSV2BGR)[0]
    return int(blue), int(green), int(red)


if __name__ == "__main__":
    main()
