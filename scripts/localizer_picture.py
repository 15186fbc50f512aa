"""Draw docs/pictures/stack/edges.png: how the reference's localiser reads a picture, step by step.

Usage: python scripts/localizer_picture.py DRIVES [--frames 7:200 2:150 0:80] [--out docs/pictures/stack/edges.png]

DRIVES is a folder of `adc-bench render --kind drives --split val`; a frame is DRIVE:PICTURE of the road camera. The
estimate is set beside the truth, so that there is something to see.
"""

import argparse
import math
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from adc_bench.dataset.drives import DriveDataset
from adc_bench.geometry import Pose2
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.edge_fit import EdgeFitParams, fit_edges, offset_jacobian
from adc_bench.stack.edge_search import EdgeSearchParams, expect_edges, find_edges
from adc_bench.stack.paint_edges import PaintEdges, paint_edges
from adc_bench.stack.pose_filter import Estimate, StartSpread, start_estimate, widened

matplotlib.use("Agg")
ASIDE = Pose2(x_m=0.04, y_m=-0.03, yaw_rad=math.radians(1.5))
TITLES = ("expected, 5 cm and 1.5° beside the truth", "sought across each edge, and found", "after the fit")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("drives", type=Path)
    parser.add_argument("--frames", nargs="+", default=["7:200", "2:150", "0:80"])
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/stack/edges.png"))
    options = parser.parse_args()
    drives = DriveDataset(options.drives)
    figure = Figure(figsize=(13.5, 3.05 * len(options.frames)), dpi=100, layout="constrained")
    for row, frame in zip(np.atleast_2d(figure.subplots(len(options.frames), 3)), options.frames, strict=True):
        drive, picture = map(int, frame.split(":"))
        draw(row, drives, drive, picture)
    for axes, title in zip(figure.axes, TITLES, strict=False):
        axes.set_title(title)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(options.out)


def draw(row: np.ndarray, drives: DriveDataset, drive: int, picture: int) -> None:
    """Draw one picture three times."""
    road, scenario, log = drives.pictures(drive, "road"), drives.scenario(drive), drives.drive(drive)
    step = int(np.argmin(np.abs(log.truth["time_s"] - road.time_s[picture])))
    x_m, y_m, _, *turned = log.truth["pose_world_robot"][step]
    truth = Pose2(x_m=float(x_m), y_m=float(y_m), yaw_rad=float(Rotation.from_quat(turned).as_euler("ZYX")[0]))
    rgb = drives.frames.picture(int(road.frame[picture]))
    mount, edges, search = scenario.rig.camera("road"), paint_edges(scenario.course), EdgeSearchParams()
    estimate = widened(start_estimate(truth @ ASIDE, StartSpread()), 0.03, math.radians(1.0))
    eye = BirdsEye(mount=mount)
    expected = expect_edges(eye, edges.seen_from(estimate.belief.pose), search)
    jacobian = offset_jacobian(expected, eye, estimate.belief.pose.yaw_rad)
    spread = np.sqrt(np.einsum("ni,ij,nj->n", jacobian, estimate.covariance, jacobian))
    found, offsets = find_edges(rgb, expected, spread, search)
    seen = expected.of(found)
    fit = fit_edges(estimate, seen, offsets, jacobian[found], 1.0, EdgeFitParams())
    for axes in row:
        axes.imshow(cv2.convertScaleAbs(rgb, alpha=0.75), interpolation="nearest")
        axes.set(xlim=(0, mount.width_px), ylim=(mount.height_px, 30), xticks=[], yticks=[])
    row[0].plot(*expected.pixels_px.T - 0.5, ".", color="gold", markersize=3)
    ends = seen.pixels_px + seen.across_px * (offsets * seen.scale_px_pm)[:, None]
    row[1].plot(*np.stack([seen.pixels_px, ends]).transpose(2, 0, 1) - 0.5, "-", color="gold", linewidth=1)
    row[1].plot(*ends.T - 0.5, ".", color="cyan", markersize=3)
    draw_fit(row[2], fit.estimate, truth, eye, edges.seen_from(fit.estimate.belief.pose), search)


def draw_fit(
    axes: Axes, estimate: Estimate, truth: Pose2, eye: BirdsEye, edges: PaintEdges, search: EdgeSearchParams
) -> None:
    """Draw where the fitted estimate has the edges, and how far it is from the truth."""
    tilted = BirdsEye(mount=eye.mount, tilt_rad=estimate.tilt_rad)
    axes.plot(*expect_edges(tilted, edges, search).pixels_px.T - 0.5, ".", color="lime", markersize=3)
    error = truth.inverse() @ estimate.belief.pose
    text = f"{1e3 * math.hypot(error.x_m, error.y_m):.1f} mm, {math.degrees(abs(error.yaw_rad)):.2f}° from the truth"
    axes.text(4, 234, text, color="white", backgroundcolor=(0, 0, 0, 0.6), fontsize=9)


if __name__ == "__main__":
    main()
