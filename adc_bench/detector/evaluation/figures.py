"""Figures of an evaluation."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from adc_bench.detector.evaluation.corners import KINDS, errors_px, kind_of
from adc_bench.detector.evaluation.evaluation import DetectionReport, Evaluation
from adc_bench.detector.evaluation.operating import CROSSWALK
from adc_bench.detector.evaluation.score import RECALLS
from adc_bench.pages.drawing import COLOURS, Draw
from adc_bench.world.look import LIGHT_LEVELS

GOALS_CM = ((0.5, 2.0, 2.0), (2.0, 4.0, 5.0))  # from, to in metres, the median error wanted there


def drawings(evaluation: Evaluation, report: DetectionReport) -> dict[str, Draw]:
    """Return the figures by their titles."""
    return {
        "Precision and recall, overlap 0.50": lambda figure: _curves(figure, evaluation),
        "Calibration": lambda figure: _calibration(figure, report),
        "Crosswalks by distance": lambda figure: _by_distance(figure, evaluation),
        "Corner errors in the picture": lambda figure: _corner_errors(figure, evaluation),
        "Crosswalk corners on the floor": lambda figure: _floor(figure, evaluation),
    }


def draw_approach(
    figure: Figure,
    places_m: NDArray[np.float64],
    scores: Mapping[str, Mapping[str, NDArray[np.float64]]],
    threshold: float,
) -> None:
    """Draw the scores (n,) of the surest crosswalk at places (n,) along a drive, a panel for each camera, a line for
    each arena.
    """
    panels = figure.subplots(len(scores), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (camera, by_arena) in zip(panels, scores.items(), strict=True):
        for name, of_arena in by_arena.items():
            axes.plot(places_m, of_arena, linewidth=1.2, label=name)
        axes.axhline(threshold, color=mpl.rcParams["text.color"], linestyle="--", linewidth=0.8, alpha=0.5)
        axes.set(ylabel=f"score, {camera} camera", ylim=(-0.02, 1.02))
    panels[-1].set(xlabel="robot's x in m; the crosswalk's middle is at 0")


def _curves(figure: Figure, evaluation: Evaluation) -> None:
    axes = figure.subplots()
    styles = {"crosswalk": (COLOURS[0], 2.5), "panel": (COLOURS[1], 1.2), "sign": (COLOURS[2], 0.8)}
    told: set[str] = set()
    for name, curve in evaluation.curves().items():
        kind = name.split("_")[0]
        colour, width = styles.get(kind, (COLOURS[3 if kind == "box" else 4], 1.5))
        label = None if kind in told else kind if name == kind else f"{kind}s"
        told.add(kind)
        axes.plot(RECALLS, curve.precision, color=colour, linewidth=width, label=label)
    axes.set(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02))


def _calibration(figure: Figure, report: DetectionReport) -> None:
    axes, counts = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    bins = [each for each in report.calibration.bins if each.count]
    axes.plot([0, 1], [0, 1], "--", color=mpl.rcParams["text.color"], linewidth=0.8, alpha=0.5)
    axes.plot([each.mean_score for each in bins], [each.right for each in bins], "o-")
    axes.set(ylabel="share that are right", ylim=(0, 1.02))
    counts.bar([(each.low + each.high) / 2 for each in bins], [each.count for each in bins], width=0.09)
    counts.set(xlabel="score", ylabel="detections", xlim=(0, 1))


def _by_distance(figure: Figure, evaluation: Evaluation) -> None:
    axes, matches = figure.subplots(), evaluation.matches
    rows = [k for k in np.flatnonzero(matches.asked).tolist() if matches.labels[k].category_id == CROSSWALK]
    levels = [evaluation.source.conditions(int(matches.label_picture[k])).light_level for k in rows]
    scores = np.maximum(matches.found_score(), 0)
    for level in LIGHT_LEVELS:
        own = [k for k, found_level in zip(rows, levels, strict=True) if found_level == level]
        axes.plot([matches.labels[k].distance_m for k in own], scores[own], ".", markersize=4, alpha=0.6, label=level)
    axes.axhline(evaluation.threshold, color=mpl.rcParams["text.color"], linestyle="--", linewidth=0.8, alpha=0.5)
    axes.set(xlabel="distance of the crosswalk's middle from the camera in m", ylabel="score", ylim=(-0.02, 1.02))


def _corner_errors(figure: Figure, evaluation: Evaluation) -> None:
    axes, corners, matches = figure.subplots(), evaluation.corners, evaluation.matches
    off = np.hypot(*np.moveaxis(errors_px(matches, corners), -1, 0))
    kinds = np.array([kind_of(matches.category_ids[k]) for k in corners.detection])
    for kind in KINDS:
        errors = np.sort(off[kinds == kind][corners.seen[kinds == kind]])
        axes.plot(errors, np.arange(1, len(errors) + 1) / max(len(errors), 1), label=kind)
    axes.set(xlabel="error in px", ylabel="share of the seen corners", xlim=(0, 6), ylim=(0, 1.02))


def _floor(figure: Figure, evaluation: Evaluation) -> None:
    axes, errors = figure.subplots(), evaluation.floor
    for name, errors_m, colour in (
        ("nominal mount", errors.found_nominal_m, COLOURS[1]),
        ("true pose", errors.found_m, COLOURS[0]),
    ):
        axes.plot(errors.distance_m, 100 * errors_m, ".", color=colour, label=name, markersize=3, alpha=0.5)
    for low_m, high_m, goal_cm in GOALS_CM:
        axes.plot([low_m, high_m], [goal_cm, goal_cm], color=mpl.rcParams["text.color"], linewidth=2)
    axes.set(
        xlabel="distance along the floor in m (lines: medians wanted)",
        ylabel="error on the floor in cm",
        yscale="log",
        ylim=(0.1, 300),
        xlim=(0, 7),
    )
