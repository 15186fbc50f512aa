"""The thesis' figures beside ours."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.detector.decode import DecodeConfig
from adc_bench.reproduce.filters import Estimate, Seen
from adc_bench.reproduce.laps import COURSE, Lap
from adc_bench.reproduce.results import Results, lap_name
from adc_bench.reproduce.settings import Controller, Settings

DECIMALS = 6  # the last bits of a sum differ between machines
THESIS_LAPS_S = {"pid-0.5": 86.9, "pid-1.0": 44.2, "pid-1.5": 30.4, "pid-2.0": 23.5, "linearisation-1.0": 50.3}
CONTROLLERS: dict[Controller, str] = {"pid": "PID on the heading", "linearisation": "feedback linearisation"}
THESIS_BAND_M = 0.10  # twice the thesis' sigma
GAP_LEAST_S = 0.5


class Row(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One figure; `thesis` is None where the thesis has none, `ours` where the experiment did not get that far."""

    what: str
    unit: str
    thesis: float | str | None
    ours: float | str | None


class Table(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Figures of one kind, and a note on what they are and why ours differ."""

    title: str
    rows: tuple[Row, ...]
    note: str


class Tables(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All tables; `tables.json`."""

    settings: Settings
    tables: tuple[Table, ...]


def tables_of(results: Results) -> Tables:
    """Return the tables of the experiments."""
    tables = (
        _laps(results),
        _odometry(results),
        _innovations("EKF with simulated landmarks", results.filtered, SIMULATED_NOTE, "over 95 %"),
        _innovations("EKF from pixels", results.pixels, PIXELS_NOTE, None),
        _gaps(results),
        _crosswalk(results),
        _avoidance(results),
    )
    return Tables(settings=results.settings, tables=tables)


LAPS_NOTE = (
    "True pose, no pictures. At one speed the thesis' times give a lap of 43 to 47 m; the middle of the lane of "
    "the real course, which is driven here, is 40.46 m long, so our times are shorter at the same speed. Our PID "
    "is also fed the lane's curvature, and steers from where the robot will be when the command acts. As in the "
    "thesis it follows closely up to 1.5 m/s and not at 2 m/s. The thesis lets the speed vary in its lap by "
    "feedback linearisation; ours keeps a timetable with at most 1 m/s."
)
ODOMETRY_NOTE = (
    "Encoders alone from a known start, over the first lap. What odometry loses is decided by how far a robot's "
    "wheels and track are from their nominal figures, so the median and the worst of several drawn robots are "
    "told too."
)
SIMULATED_NOTE = (
    "As in the thesis: the true relative position of a near landmark with sigma = 5 cm, over the first lap. "
    "Innovations are counted before the gate. The noise alone puts 95.4 % of them inside 10 cm; what the belief "
    "itself is off after a stretch without a landmark comes on top. White noise has no correlation from one "
    "innovation to the next."
)
PIXELS_NOTE = (
    "What the thesis could not do: loop centres from the lane's lines and crosswalk corners from the detector, on "
    "rendered pictures, in a lap that is driven by this estimate. Innovations of points alone, counted before the "
    "gate. Each picture shows much the same paint as the one before, so they are not white, and the filter counts "
    "eight as one."
)
GAPS_NOTE = (
    "From the crosswalk on: half a second or more without a loop's centre or a crosswalk corner. The thesis' lap "
    "is some 10 % longer. From pixels the filter also takes straight lines, so that its place across the lane is "
    "never without a landmark for as long."
)
CROSSWALK_NOTE = (
    "Pictures of the road camera along the starting lane, in arenas that the detector was not trained on. Behind "
    "the crosswalk there is nothing to be found."
)
AVOIDANCE_NOTE = (
    "True pose and laser. The rule of the thesis, its distance counted from 35 cm off so that the robot's body has "
    "room, and the side chosen by the lane; the PID at its own speed between the boxes. Least distance of the robot's "
    "outline to a box."
)


def _laps(results: Results) -> Table:
    rows: list[Row] = []
    for controller, speed_mps in results.settings.laps:
        name = lap_name(controller, speed_mps)
        lap, told = results.laps[name], f"{CONTROLLERS[controller]}, {speed_mps:.1f} m/s"
        inside = _inside(lap)
        offsets_m = np.abs(np.array(lap.offset_m)[inside])
        rows += [
            _row(f"{told}: lap", "s", THESIS_LAPS_S.get(name), lap.lap_s),
            _row(f"{told}: largest deviation", "cm", None, 100 * float(offsets_m.max())),
            _row(f"{told}: root mean square deviation", "cm", None, 100 * _rms(offsets_m)),
        ]
    return Table(title="Laps", rows=tuple(rows), note=LAPS_NOTE)


def _inside(lap: Lap) -> NDArray[np.bool_]:
    s_m = np.array(lap.s_m)
    return (s_m >= 0) & (s_m <= COURSE.lap.length_m)


def _odometry(results: Results) -> Table:
    worst_cm = 100 * np.array([np.abs(each.error_m).max(axis=0) for each in results.reckoned])
    median, most = np.median(worst_cm, axis=0), worst_cm.max(axis=0)
    rows = [
        row
        for axis, thesis_cm, k in (("x", 34.0, 0), ("y", 20.0, 1))
        for row in (
            _row(f"worst error in {axis}", "cm", thesis_cm, worst_cm[0, k]),
            _row(f"the same, median of {len(worst_cm)} robots", "cm", None, median[k]),
            _row(f"the same, worst of {len(worst_cm)} robots", "cm", None, most[k]),
        )
    ]
    return Table(title="Odometry alone", rows=tuple(rows), note=ODOMETRY_NOTE)


def points(seen: Sequence[Seen]) -> list[Seen]:
    """Return what was seen of point landmarks."""
    return [each for each in seen if each.kind != "line"]


def _innovations(title: str, estimate: Estimate, note: str, thesis_share: str | None) -> Table:
    seen = points(estimate.seen)
    residuals_m = np.array([each.residual for each in seen]).reshape(-1, 2)
    sds_m = np.array([each.sd for each in seen]).reshape(-1, 2)
    rows = [_row("innovations", "", None, float(len(seen)))]
    for k, axis in enumerate(("x", "y") if len(seen) > 1 else ()):
        own = residuals_m[:, k]
        rows += [
            _row(f"{axis}: inside 10 cm", "%", thesis_share, 100 * float(np.mean(np.abs(own) < THESIS_BAND_M))),
            _row(
                f"{axis}: inside the filter's own 2 sigma",
                "%",
                None,
                100 * float(np.mean(np.abs(own) < 2 * sds_m[:, k])),
            ),
            _row(f"{axis}: mean", "cm", "zero" if thesis_share else None, 100 * float(own.mean())),
            _row(f"{axis}: correlation with the next", "", "white" if thesis_share else None, _correlation(own)),
        ]
    error_m = estimate.error_m
    rows += [
        _row("position error, root mean square", "cm", None, 100 * _rms(np.hypot(*error_m.T))),
        _row("worst error in x", "cm", None, 100 * float(np.abs(error_m[:, 0]).max())),
        _row("worst error in y", "cm", None, 100 * float(np.abs(error_m[:, 1]).max())),
    ]
    return Table(title=title, rows=tuple(rows), note=note)


def _gaps(results: Results) -> Table:
    first = results.laps[lap_name(*results.settings.laps[0])]
    begun_s = first.crossed_s(0.0) or 0.0
    left_s = _passed_s(results.pixels)
    rows = (
        _row(
            "simulated landmarks",
            "s",
            "0-7, 18.6-23.2, 24.4-27.6, 44.5-45.1",
            _told(gaps(results.filtered.seen, begun_s, first.time_s[-1])),
        ),
        _row("points from pixels", "s", None, _told(gaps(points(results.pixels.seen), *left_s))),
    )
    return Table(title="Stretches of a lap without a landmark", rows=rows, note=GAPS_NOTE)


def _passed_s(estimate: Estimate) -> tuple[float, float]:
    """Return when a drive first passed the crosswalk's middle, and when it ended."""
    passed = [time_s for time_s, pose in zip(estimate.time_s, estimate.truth, strict=True) if pose.x_m >= 0]
    return (passed[0] if passed else estimate.time_s[-1]), estimate.time_s[-1]


def gaps(seen: Sequence[Seen], begun_s: float, ended_s: float) -> Iterator[tuple[float, float]]:
    """Yield the stretches of time without a sighting, counted from `begun_s`."""
    times = [each.time_s for each in seen if begun_s <= each.time_s <= ended_s]
    for low_s, high_s in zip((begun_s, *times), (*times, ended_s), strict=True):
        if high_s - low_s >= GAP_LEAST_S:
            yield low_s - begun_s, high_s - begun_s


def _told(stretches: Iterator[tuple[float, float]]) -> str:
    return ", ".join(f"{low_s:.1f}-{high_s:.1f}" for low_s, high_s in stretches) or "none"


def _crosswalk(results: Results) -> Table:
    approach, threshold = results.approach, DecodeConfig().score_min
    places_m, rows = np.array(approach.places_m), []
    for level in results.settings.approach_lights:
        scores = np.array(approach.scores[level])
        hits_m = places_m[(scores >= threshold) & (places_m < 0)]
        rows += [
            _row(f"{level}: found from x =", "m", None, float(hits_m[0]) if len(hits_m) else None),
            _row(f"{level}: to x =", "m", None, float(hits_m[-1]) if len(hits_m) else None),
            _row(
                f"{level}: found behind it, pictures", "", 0.0, float(((scores >= threshold) & (places_m > 0.5)).sum())
            ),
        ]
    return Table(title="The crosswalk's detection", rows=tuple(rows), note=CROSSWALK_NOTE)


def _avoidance(results: Results) -> Table:
    rows: list[Row] = []
    for run in results.avoidances:
        count = len(run.boxes)
        told = "one box" if count == 1 else f"{count} boxes"
        begun = sum(now and not before for before, now in zip(run.avoiding, run.avoiding[1:], strict=False))
        rows += [
            _row(f"{told}: passed", "", "yes", "yes" if run.passed else "no"),
            _row(f"{told}: contacts", "", 0.0, float(run.contacts)),
            _row(f"{told}: least distance", "cm", None, 100 * min(run.clearance_m)),
            _row(f"{told}: begins of the behaviour", "", None, float(begun)),
        ]
    return Table(title="Going round boxes", rows=tuple(rows), note=AVOIDANCE_NOTE)


def _correlation(values: NDArray[np.float64]) -> float | None:
    """Return the correlation of each value with the next one."""
    away = values - values.mean()
    square = float(away @ away)
    return float(away[:-1] @ away[1:]) / square if square > 0 else None


def _rms(values: NDArray[Any]) -> float:
    return math.sqrt(float(np.mean(np.square(values))))


def _row(what: str, unit: str, thesis: float | str | None, ours: float | str | None) -> Row:
    figure = round(float(ours), DECIMALS) + 0.0 if isinstance(ours, (int, float)) else ours
    return Row(what=what, unit=unit, thesis=thesis, ours=figure)
