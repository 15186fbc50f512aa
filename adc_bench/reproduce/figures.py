"""The thesis' figures, drawn from our experiments; named after those of the thesis."""

from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib as mpl
import msgspec
import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from adc_bench.detector.decode import DecodeConfig
from adc_bench.detector.evaluation.figures import draw_approach
from adc_bench.geometry import Pose2
from adc_bench.pages.drawing import COLOURS, INKS, Draw, png
from adc_bench.reproduce.avoidance import Avoidance
from adc_bench.reproduce.filters import LOOP_CENTRES, Estimate, Seen
from adc_bench.reproduce.laps import COURSE, Lap
from adc_bench.reproduce.results import Results, lap_name
from adc_bench.reproduce.settings import Controller
from adc_bench.reproduce.tables import CONTROLLERS, THESIS_BAND_M, points
from adc_bench.world.drawing import box_floor

LAP_FIGURES: dict[tuple[Controller, float], str] = {
    ("pid", 0.5): "7-15",
    ("pid", 1.0): "7-16",
    ("pid", 1.5): "7-17",
    ("pid", 2.0): "7-18",
    ("linearisation", 1.0): "7-19",
}
AVOIDANCE_FIGURES = ("7-20", "7-21", "7-22")
S_ROAD_CENTRES = ((COURSE.spec.s_road_centre_x_m, 0.0), (-COURSE.spec.s_road_centre_x_m, 0.0))  # seen, never simulated
INNOVATION_MOST_CM = 30.0


class Drawn(msgspec.Struct, frozen=True, kw_only=True):
    """How a figure is drawn, and what it is called."""

    title: str
    draw: Draw


def png_on_white(drawn: Drawn) -> bytes:
    """Return the figure as a file for any reader."""
    return png(drawn.draw, INKS["light"], paper="white")


def drawings(results: Results) -> dict[str, Drawn]:
    """Return the figures by their names, in the thesis' order."""
    simulated, pixels, reckoned = results.filtered, results.pixels, results.reckoned[0]
    both = {"simulated landmarks": simulated, "from pixels": pixels}
    figures = {
        "7-05-approach": Drawn(
            title="7.5 The crosswalk's score as the robot comes up to it",
            draw=lambda figure: _approach(figure, results),
        ),
        "7-07-landmarks-simulated": Drawn(
            title="7.7 Simulated landmarks where the estimate has them",
            draw=lambda figure: _landmarks(figure, simulated),
        ),
        "7-08-landmarks-pixels": Drawn(
            title="7.8 Landmarks from pixels where the estimate has them",
            draw=lambda figure: _landmarks(figure, pixels),
        ),
        "7-09-odometry-path": Drawn(
            title="7.9 A lap by odometry alone", draw=lambda figure: _paths(figure, {"odometry": reckoned})
        ),
        "7-10-odometry-error": Drawn(
            title="7.10 Its error", draw=lambda figure: _errors(figure, {"odometry": reckoned}, bands=False)
        ),
        "7-11-innovation-x": Drawn(title="7.11 Innovations in x", draw=lambda figure: _innovations(figure, both, 0)),
        "7-12-innovation-y": Drawn(title="7.12 Innovations in y", draw=lambda figure: _innovations(figure, both, 1)),
        "7-13-filter-path": Drawn(title="7.13 The EKF's path", draw=lambda figure: _paths(figure, both)),
        "7-14-filter-error": Drawn(
            title="7.14 The EKF's error, with its 2 sigma", draw=lambda figure: _errors(figure, both, bands=True)
        ),
    }
    laps = dict(_lap_figure(each, results) for each in results.settings.laps if each in LAP_FIGURES)
    runs = zip(AVOIDANCE_FIGURES, results.avoidances, strict=False)
    return figures | laps | dict(_avoidance_figure(number, run) for number, run in runs)


def _avoidance_figure(number: str, run: Avoidance) -> tuple[str, Drawn]:
    count = len(run.boxes)
    title = f"{number.replace('-', '.')} Going round {'a box' if count == 1 else f'{count} boxes'}"
    return f"{number}-boxes-{count}", Drawn(title=title, draw=lambda figure: _boxes(figure, run))


def _lap_figure(which: tuple[Controller, float], results: Results) -> tuple[str, Drawn]:
    controller, speed_mps = which
    name, number = lap_name(*which), LAP_FIGURES[which]
    title = f"{number.replace('-', '.')} A lap by {CONTROLLERS[controller]}, {speed_mps:.1f} m/s"
    lap = results.laps[name]
    return f"{number}-{name}", Drawn(title=title, draw=lambda figure: _lap(figure, lap))


def _approach(figure: Figure, results: Results) -> None:
    approach = results.approach
    scores: dict[str, Any] = {level: np.array(approach.scores[level]) for level in results.settings.approach_lights}
    draw_approach(figure, np.array(approach.places_m), {approach.camera: scores}, DecodeConfig().score_min)


def _landmarks(figure: Figure, estimate: Estimate) -> None:
    axes = figure.subplots()
    _course(axes)
    axes.plot(*_places(estimate.truth).T, color=COLOURS[0], linewidth=1.2, label="driven")
    seen = points(estimate.seen)
    axes.plot(*_seen_places(seen, believed=True).T, ".", color=COLOURS[2], markersize=3, alpha=0.6, label="seen")
    axes.plot(*_seen_places(seen, believed=False).T, ".", color=COLOURS[3], markersize=3, label="outside the gate")
    known = np.concatenate([LOOP_CENTRES, S_ROAD_CENTRES, COURSE.crosswalk_corners])
    axes.plot(*known.T, "+", color=mpl.rcParams["text.color"], markersize=9, label="landmark")


def _seen_places(seen: Iterable[Seen], *, believed: bool) -> Any:
    places = [each.place_world for each in seen if each.place_world is not None and each.believed == believed]
    return np.array(places, dtype=np.float64).reshape(-1, 2)


def _paths(figure: Figure, estimates: dict[str, Estimate]) -> None:
    panels = figure.subplots(len(estimates), 1, squeeze=False)[:, 0]
    for axes, (name, estimate) in zip(panels, estimates.items(), strict=True):
        _course(axes)
        axes.plot(*_places(estimate.truth).T, color=COLOURS[0], linewidth=1.4, label="driven")
        axes.plot(*_places(estimate.believed).T, color=COLOURS[1], linewidth=0.9, label=name)


def _errors(figure: Figure, estimates: dict[str, Estimate], *, bands: bool) -> None:
    grid = figure.subplots(2, len(estimates), sharex="col", sharey=True, squeeze=False)
    for column, (name, estimate) in zip(grid.T, estimates.items(), strict=True):
        sds = (estimate.sd_x_m, estimate.sd_y_m)
        for axes, axis, error_m, sd_m in zip(column, "xy", estimate.error_m.T, sds, strict=True):
            if bands:
                band_cm = 200 * np.array(sd_m)
                axes.fill_between(estimate.time_s, -band_cm, band_cm, color=COLOURS[1], alpha=0.25, linewidth=0)
            axes.plot(estimate.time_s, 100 * error_m, linewidth=0.9)
            axes.set(ylabel=f"error in {axis}, cm")
        column[0].set_title(name, fontsize="medium")
        column[-1].set(xlabel="time, s")


def _innovations(figure: Figure, estimates: dict[str, Estimate], k: int) -> None:
    panels = figure.subplots(len(estimates), 1, squeeze=False)[:, 0]
    for axes, (name, estimate) in zip(panels, estimates.items(), strict=True):
        seen = points(estimate.seen)
        for kind, colour in (("circle", COLOURS[0]), ("corner", COLOURS[2])):
            own = [each for each in seen if each.kind == kind]
            residuals_cm = [100 * each.residual[k] for each in own]
            axes.plot([each.time_s for each in own], residuals_cm, ".", color=colour, markersize=3, label=kind)
        for side in (-1, 1):
            axes.plot(
                [each.time_s for each in seen],
                [side * 200 * each.sd[k] for each in seen],
                ".",
                color=COLOURS[1],
                markersize=1,
                label="2 sigma of the filter" if side > 0 else None,
            )
            axes.axhline(side * 100 * THESIS_BAND_M, color=mpl.rcParams["text.color"], linestyle="--", linewidth=0.8)
        axes.set_title(name, fontsize="medium")
        axes.set(ylabel=f"{'xy'[k]}, cm", ylim=(-INNOVATION_MOST_CM, INNOVATION_MOST_CM))
    panels[-1].set(xlabel="time, s (dashed: the thesis' 2 sigma)")


def _lap(figure: Figure, lap: Lap) -> None:
    above, beside = figure.subplots(2, 1, height_ratios=(3, 1))
    _course(above)
    above.plot(*COURSE.lap.sample(0.05)[:, :2].T, color=COLOURS[1], linewidth=2, alpha=0.6, label="reference")
    above.plot(lap.x_m, lap.y_m, color=COLOURS[0], linewidth=0.9, label="driven")
    beside.plot(lap.s_m, 100 * np.array(lap.offset_m), color=COLOURS[0], linewidth=0.9)
    beside.set(xlabel="arc length from the crosswalk, m", ylabel="deviation, cm")


def _boxes(figure: Figure, run: Avoidance) -> None:
    axes = figure.subplots()
    _course(axes)
    for box in run.boxes:
        axes.fill(*np.asarray(box_floor(box).exterior.coords).T, color=COLOURS[2])
    places, steers = _places(run.truth), np.array(run.avoiding)
    axes.plot(*places.T, color=COLOURS[0], linewidth=1.2, label="driven")
    axes.plot(*places[steers].T, ".", color=COLOURS[1], markersize=2, label="going round")
    (low_x, low_y), (high_x, high_y) = places.min(axis=0) - 1.0, places.max(axis=0) + 1.0
    axes.set(xlim=(low_x, high_x), ylim=(low_y, high_y))


def _course(axes: Axes) -> None:
    """Draw the paint as one shape: it has islands, and a legend is quick to place beside one shape only."""
    marks = [shapely.geometry.polygon.orient(mark) for mark in COURSE.paint]
    rings = [Path(np.asarray(ring.coords)) for mark in marks for ring in (mark.exterior, *mark.interiors)]
    paint = Path.make_compound_path(*rings)
    axes.add_patch(PathPatch(paint, facecolor=mpl.rcParams["text.color"], alpha=0.2, linewidth=0))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set(xlabel="x, m", ylabel="y, m")


def _places(poses: Sequence[Pose2]) -> Any:
    return np.array([(pose.x_m, pose.y_m) for pose in poses], dtype=np.float64).reshape(-1, 2)
