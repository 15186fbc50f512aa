"""A result in words: a line a run, and the means that the leaderboard shows of its kind."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from adc_bench.evaluate.results import Result
    from adc_bench.evaluate.summary import AnyEpisode


def print_result(result: "Result", out: Path, as_json: bool) -> None:
    """Print a result, as JSON or for people; `out` is where it lies."""
    if as_json:
        from adc_bench.evaluate.results import to_json

        typer.echo(to_json(result).decode(), nl=False)
        return
    from adc_bench.leaderboard.figures import SHOWN, interval, label, shown, unit_of

    typer.echo(f"{out}: {result.submission.name} on {result.suite}, {result.completed} of {result.planned} runs")
    for run in result.episodes:
        typer.echo(f"  {run.scenario}: {run.status} ({run.reason}), {_told(run)}")
    for name in SHOWN[result.submission.kind]:
        if figure := result.summary.get(name):
            mean, unit = shown(name, figure, figure.mean), unit_of(name, figure)
            typer.echo(f"  {label(name) + ':':<24}{mean} {interval(name, figure)} {unit}".rstrip())


def _told(run: "AnyEpisode") -> str:
    from adc_bench.evaluate.detection_score import DetectionEpisode
    from adc_bench.evaluate.localization_score import LocalizationEpisode

    if isinstance(run, DetectionEpisode):
        found = run.detection
        return f"{run.objects} objects on {run.pictures} pictures, mAP {found.map:.3f}, AP50 {found.map50:.3f}"
    place = f"position RMSE {run.localization.position_rmse_m:.3f} m" if run.localization else "no estimate"
    if isinstance(run, LocalizationEpisode):
        how = f"{run.mission} ({run.behaviour})".replace("_", " ")
        return f"{how}, {run.light_level}, {run.distance_m:.1f} m, {place}"
    laps = ", ".join(f"{lap_s:.2f} s" for lap_s in run.laps_s) or "no lap"
    faults = f"{run.driving.line_touches} line touches, {len(run.collisions)} collisions"
    return f"{laps}, completion {run.completion:.3f}, {place}, {faults}"
