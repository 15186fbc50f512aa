"""Draw docs/pictures/stack/stages.png: what the drivers make of one moment of a drive, stage by stage.

Usage: python scripts/stages_picture.py DRIVES [--moment 9:7.6] [--out docs/pictures/stack/stages.png]

DRIVES is a folder of `adc-bench render --kind drives --split val --frames 12`; a moment is DRIVE:SECONDS.
"""

import argparse
import math
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from adc_bench.api import LaserScan
from adc_bench.dataset.drives import DriveDataset
from adc_bench.detector import Detector, shipped_weights
from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.crosswalk import CrosswalkFinder
from adc_bench.stack.lane_lines import LaneLines, find_lane_lines
from adc_bench.stack.laser_clusters import clusters
from adc_bench.stack.paint import find_paint
from adc_bench.world.categories import CATEGORIES, CATEGORY_ID
from adc_bench.world.frame import Detections
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import LaserSpec

matplotlib.use("Agg")
Rgb = NDArray[np.uint8]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", type=Path)
    parser.add_argument("--moment", default="9:7.6")
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/stack/stages.png"))
    options = parser.parse_args()
    drive, time_s = options.moment.split(":")
    drives, index, at_s = DriveDataset(options.drives), int(drive), float(time_s)
    scenario, detect = drives.scenario(index), Detector.load(shipped_weights())
    road, panel = (picture_at(drives, index, camera, at_s) for camera in ("road", "panel"))
    figure = Figure(figsize=(13.5, 8.2), dpi=90, layout="constrained")
    axes = figure.subplots(2, 3).ravel()
    found = detect(road)
    draw_found(axes[0], road, found, "road camera, and what the detector finds")
    draw_found(axes[1], panel, detect(panel), "panels' camera, and what the detector finds")
    eye = BirdsEye(mount=scenario.rig.camera("road"))
    draw_floor(axes[2], eye.grey(road), eye, "the floor from above")
    draw_lanes(axes[3], eye, road, scenario)
    draw_crosswalk(axes[4], eye, road, found, scenario)
    draw_laser(axes[5], drives, index, at_s, scenario)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out)


def picture_at(drives: DriveDataset, drive: int, camera: str, time_s: float) -> Rgb:
    """Return a camera's picture (height, width, 3) that is nearest in time."""
    pictures = drives.pictures(drive, camera)
    return drives.frames.picture(int(pictures.frame[int(np.argmin(np.abs(pictures.time_s - time_s)))]))


def draw_found(axes: Axes, rgb: Rgb, found: Detections, title: str) -> None:
    """Draw boxes with names and scores, and the corners that are seen."""
    axes.imshow(rgb, interpolation="nearest")
    for box, category, score in zip(found.boxes_px, found.category_ids, found.scores, strict=True):
        (x0, y0, x1, y1), name = box, CATEGORIES[int(category) - 1]
        axes.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="gold", linewidth=1)
        axes.text(x0, y0 - 3, f"{name} {score:.2f}", color="gold", fontsize=8)
    seen = found.keypoint_scores > 0.5
    axes.plot(*found.keypoints_px[seen].T, "+", color="cyan", markersize=6)
    axes.set(xticks=[], yticks=[], title=title, xlim=(0, rgb.shape[1]), ylim=(rgb.shape[0], 0))


def draw_floor(axes: Axes, picture: NDArray[np.uint8], eye: BirdsEye, title: str) -> None:
    """Draw a floor picture in metres before the robot."""
    region = eye.region
    extent = (region.half_width_m, -region.half_width_m, region.x_near_m, region.x_far_m)
    axes.imshow(np.where(eye.seen, picture, 0), cmap="gray", extent=extent, interpolation="nearest", aspect="equal")
    axes.set(title=title, xlabel="to the left, m", ylabel="ahead, m")


def draw_lanes(axes: Axes, eye: BirdsEye, rgb: Rgb, scenario: Scenario) -> None:
    """Draw the paint and the lane's two lines found in it."""
    paint = find_paint(eye, rgb)
    draw_floor(axes, (255 * paint.mask).astype(np.uint8), eye, "paint, and the lane's lines in it (thesis)")
    spec = scenario.course.spec
    lines = find_lane_lines(LaneLines(), paint, (spec.radius_outer_m - spec.radius_centre_m) / 2)
    for line, colour in ((lines.right, "tomato"), (lines.left, "deepskyblue")):
        if line is not None:
            axes.plot(line.points_robot[:, 1], line.points_robot[:, 0], "o-", color=colour, markersize=3)


def draw_crosswalk(axes: Axes, eye: BirdsEye, rgb: Rgb, found: Detections, scenario: Scenario) -> None:
    """Draw the crosswalk's corners that the paint tells, behind the detector's box."""
    paint = find_paint(eye, rgb)
    draw_floor(axes, eye.grey(rgb), eye, "the crosswalk's near corners, to 2 sigma (thesis)")
    finder = CrosswalkFinder(spec=scenario.course.spec, birds_eye=eye)
    for box in found.boxes_px[found.category_ids == CATEGORY_ID["crosswalk"]]:
        x0, y0, x1, y1 = map(float, box)
        seen = finder.find((x0, y0, x1, y1), 0.0, paint)
        if seen is not None:
            sd_m = np.sqrt(np.diagonal(seen.covariances, axis1=1, axis2=2))
            x_m, y_m = seen.corners_robot.T
            axes.errorbar(y_m, x_m, 2 * sd_m[:, 0], 2 * sd_m[:, 1], fmt="o", color="cyan", markersize=4)


def draw_laser(axes: Axes, drives: DriveDataset, drive: int, time_s: float, scenario: Scenario) -> None:
    """Draw a scan's clusters over the course, at the true pose."""
    log, spec = drives.drive(drive), scenario.rig.laser
    assert isinstance(spec, LaserSpec)
    k = int(np.argmin(np.abs(log.laser["time_s"] - time_s)))
    pose = pose_at(log.truth, time_s)
    scan = LaserScan(time_s=time_s, ranges_m=np.asarray(log.laser["ranges_m"][k], dtype=np.float64))
    lap = scenario.course.lap.poses(np.arange(0.0, scenario.course.lap.length_m, 0.1))
    axes.plot(lap[:, 0], lap[:, 1], ":", color="silver")
    for number, cluster in enumerate(clusters(scan, spec)):
        axes.plot(*pose.transform(cluster.points_robot).T, ".", color=f"C{number % 10}", markersize=3)
    axes.arrow(pose.x_m, pose.y_m, 0.5 * math.cos(pose.yaw_rad), 0.5 * math.sin(pose.yaw_rad), width=0.06, color="k")
    axes.set(xlim=(pose.x_m - 3.5, pose.x_m + 3.5), ylim=(pose.y_m - 3.0, pose.y_m + 3.0), aspect="equal")
    axes.set(title="what the laser meets, by cluster", xlabel="x, m", ylabel="y, m")


def pose_at(truth: NDArray[np.void], time_s: float) -> Pose2:
    """Return the true pose that is nearest in time."""
    step = int(np.argmin(np.abs(truth["time_s"] - time_s)))
    x_m, y_m, _, *turned = truth["pose_world_robot"][step]
    return Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=float(Rotation.from_quat(turned).as_euler("ZYX")[0]))


if __name__ == "__main__":
    main()
