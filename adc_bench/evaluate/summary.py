"""What is made of the runs of a suite: each figure's statistic, and the one by which a kind of submission is ranked."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import fmean
from typing import Any

import msgspec

from adc_bench.api import Kind
from adc_bench.evaluate.detection_score import DetectionEpisode, score_detections
from adc_bench.evaluate.localization_score import LocalizationEpisode, score_localization
from adc_bench.evaluate.log import AnyLog, DetectionLog, EpisodeLog, LocalizationLog
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.score import Episode, score
from adc_bench.evaluate.statistics import Statistic, summarise

AnyEpisode = Episode | LocalizationEpisode | DetectionEpisode
Values = Callable[[Any], Iterable[float | None]]


class Metric(msgspec.Struct, frozen=True, kw_only=True):
    """A figure of the summary: its unit and the values that a run contributes."""

    unit: str
    higher_is_better: bool
    values: Values


def _metric(unit: str, higher_is_better: bool, values: Values) -> Metric:
    return Metric(unit=unit, higher_is_better=higher_is_better, values=values)


def _of(part: str, name: str) -> Values:
    return lambda episode: (getattr(getattr(episode, part), name),) if getattr(episode, part) else ()


LOCALIZATION: Mapping[str, Metric] = {
    **{
        name: _metric("rad" if name.endswith("_rad") else "m", False, _of("localization", name))
        for name in (
            "position_rmse_m",
            "position_p95_m",
            "position_max_m",
            "heading_rmse_rad",
            "ate_rmse_m",
            "rpe_rmse_m",
            "rpe_rmse_rad",
            "dead_reckoning_rmse_m",
            "dead_reckoning_max_m",
        )
    },
    "nees_mean": _metric("", False, _of("localization", "nees_mean")),
    "coverage": _metric("", True, _of("localization", "coverage")),
}
METRICS: Mapping[Kind, Mapping[str, Metric]] = {
    "driver": {
        "driving_score": _metric("", True, lambda e: (e.driving_score,)),
        "points": _metric("", True, lambda e: (e.points,)),
        "completion": _metric("", True, lambda e: (e.completion,)),
        "run_time_s": _metric("s", False, lambda e: (e.run_time_s,)),
        "lap_time_s": _metric("s", False, lambda e: (fmean(e.laps_s),) if e.laps_s else ()),
        "distance_m": _metric("m", True, lambda e: (e.distance_m,)),
        "collisions": _metric("", False, lambda e: (float(len(e.collisions)),)),
        **LOCALIZATION,
        "cross_track_rmse_m": _metric("m", False, _of("driving", "cross_track_rmse_m")),
        "cross_track_max_m": _metric("m", False, _of("driving", "cross_track_max_m")),
        "line_touches": _metric("", False, _of("driving", "line_touches")),
        "off_track_s": _metric("s", False, _of("driving", "off_track_s")),
        "signs_obeyed": _metric("", True, _of("driving", "signs_obeyed")),
        "vertical_signs_read": _metric("", True, lambda e: (float(e.signs_read[0]),) if e.signs_read else ()),
    },
    "localizer": LOCALIZATION,
    "detector": {
        "map": _metric("", True, _of("share", "map")),
        "map50": _metric("", True, _of("share", "map50")),
        "precision": _metric("", True, _of("share", "precision")),
        "recall": _metric("", True, _of("share", "recall")),
        "corner_error_px": _metric("px", False, _of("share", "corner_error_px")),
    },
}
# By which submissions are ranked, and what decides where that is equal.
RANKED_BY: Mapping[Kind, tuple[str, str]] = {
    "driver": ("points", "driving_score"),
    "localizer": ("position_rmse_m", "heading_rmse_rad"),
    "detector": ("map", "map50"),
}


def scores_of(logs: Sequence[AnyLog], rules: Rules) -> tuple[AnyEpisode, ...]:
    """Return the scores of the runs of a suite of any kind."""
    drives = tuple(score(log, rules) for log in logs if isinstance(log, EpisodeLog))
    followed = tuple(score_localization(log, rules) for log in logs if isinstance(log, LocalizationLog))
    sets = [log for log in logs if isinstance(log, DetectionLog)]
    return (*drives, *followed, *(score_detections(sets, rules) if sets else ()))


def summary_of(kind: Kind, episodes: Sequence[AnyEpisode]) -> dict[str, Statistic]:
    """Return each metric's statistic over the runs that have it."""
    summary = {}
    for name, metric in METRICS[kind].items():
        values = [float(value) for episode in episodes for value in metric.values(episode) if value is not None]
        if values:
            summary[name] = summarise(name, values, unit=metric.unit, higher_is_better=metric.higher_is_better)
    return summary
