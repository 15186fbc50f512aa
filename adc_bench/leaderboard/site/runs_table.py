"""The table of an entry's runs: what each kind of run is worth telling of."""

from collections import Counter
from collections.abc import Sequence
from html import escape

from adc_bench.evaluate.detection_score import DetectionEpisode
from adc_bench.evaluate.localization_score import LocalizationEpisode
from adc_bench.evaluate.metrics import Localization
from adc_bench.evaluate.score import Episode
from adc_bench.evaluate.summary import AnyEpisode
from adc_bench.leaderboard.site.text import DASH

DRIVING = ("run", "ended", "light", "points", "driving score", "completion", "run time", "position RMSE", "faults")
LOCALIZATION = ("run", "ended", "light", "driven", "how", "way", "position RMSE", "95th percentile", "NEES", "coverage")
DETECTION = ("run", "ended", "pictures", "objects", "mAP", "AP50", "precision", "recall", "corner error")

HEADS = {Episode: DRIVING, LocalizationEpisode: LOCALIZATION, DetectionEpisode: DETECTION}
IN_WORDS = ("run", "ended", "light", "driven", "how", "faults")


def runs_table(episodes: Sequence[AnyEpisode]) -> str:
    """Return the table; a run with a path links to its replay."""
    cells = "".join(f'<th scope="col"{_style(name)}>{name}</th>' for name in HEADS[type(episodes[0])])
    return (
        '<div class="wide" tabindex="0" role="region" aria-label="Runs"><table class="runs">'
        f"<thead><tr>{cells}</tr></thead><tbody>{''.join(map(_row, episodes))}</tbody></table></div>"
    )


def _row(episode: AnyEpisode) -> str:
    name = escape(episode.scenario)
    if not isinstance(episode, DetectionEpisode):
        name = f'<a href="#run-{name}">{name}</a>'
    ended = f'<td class="words"><span class="status {_grade(episode)}">{escape(_words(episode.reason))}</span></td>'
    told = zip(HEADS[type(episode)][2:], _cells(episode), strict=True)
    cells = "".join(f"<td{_style(head)}>{escape(cell)}</td>" for head, cell in told)
    return f'<tr><th scope="row">{name}</th>{ended}{cells}</tr>'


def _style(head: str) -> str:
    return ' class="words"' if head in IN_WORDS else ""


def _words(name: str) -> str:
    return name.replace("-", " ").replace("_", " ")


def _grade(episode: AnyEpisode) -> str:
    """Return how good an ending is: the task done, a drive that ended before, a program that broke."""
    if episode.failed:
        return "broken"
    return "short" if isinstance(episode, Episode) and episode.completion < 1.0 else "done"


def _cells(episode: AnyEpisode) -> tuple[str, ...]:
    if isinstance(episode, Episode):
        return _driving(episode)
    if isinstance(episode, LocalizationEpisode):
        return _localization(episode)
    found = episode.detection
    shares = (found.map, found.map50, found.precision, found.recall)
    return (
        str(episode.pictures),
        str(episode.objects),
        *(DASH if share is None else f"{100 * share:.1f} %" for share in shares),
        DASH if found.corner_error_px is None else f"{found.corner_error_px:.2f} px",
    )


def _driving(episode: Episode) -> tuple[str, ...]:
    return (
        episode.light_level,
        f"{episode.points:.1f}",
        f"{episode.driving_score:.1f}",
        f"{100 * episode.completion:.1f} %",
        DASH if episode.run_time_s is None else f"{episode.run_time_s:.2f} s",
        _position(episode.localization),
        _faults(episode),
    )


def _localization(episode: LocalizationEpisode) -> tuple[str, ...]:
    errors = episode.localization
    return (
        episode.light_level,
        _words(episode.mission),
        _words(episode.behaviour),
        f"{episode.distance_m:.1f} m",
        _position(errors),
        DASH if errors is None else f"{errors.position_p95_m:.4f} m",
        DASH if errors is None or errors.nees_mean is None else f"{errors.nees_mean:.2f}",
        DASH if errors is None or errors.coverage is None else f"{100 * errors.coverage:.1f} %",
    )


def _position(errors: Localization | None) -> str:
    return DASH if errors is None else f"{errors.position_rmse_m:.4f} m"


def _faults(episode: Episode) -> str:
    counts = Counter(_words(fault.kind) for fault in episode.faults)
    return ", ".join(f"{count} × {kind}" for kind, count in counts.items()) or "none"
