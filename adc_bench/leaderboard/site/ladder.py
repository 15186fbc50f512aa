"""The ablation ladder of a driver: as it is, and with the truth in place of one of its layers."""

from html import escape

from adc_bench.evaluate.submission import SubmissionId
from adc_bench.leaderboard.figures import interval, label, shown, unit_of
from adc_bench.leaderboard.records import Standing, SuiteRanking, entry_name
from adc_bench.leaderboard.site.text import DASH

RUNGS = (None, "detections", "pose")
METRICS = ("points", "completion", "lap_time_s", "cross_track_rmse_m", "position_rmse_m")


def ladder(submission: SubmissionId, suite: str, ranking: SuiteRanking) -> str:
    """Return a driver's rungs, from none to the pose, as a section; nothing if it has but one."""
    rungs = [standing for standing in ranking.standings if standing.submission.name == submission.name]
    if len(rungs) < 2:
        return ""
    rungs.sort(key=lambda standing: RUNGS.index(standing.submission.privileged))
    head = "".join(f'<th scope="col">{label(metric)}</th>' for metric in METRICS)
    return (
        "<section><h2>Ladder</h2><p>The same driver with the truth in place of one of its layers: what that layer "
        'costs. Such entries have no place.</p><div class="wide" tabindex="0" role="region" aria-label="Ladder"><table>'
        f'<thead><tr><th scope="col">true layer</th>{head}</tr></thead>'
        f"<tbody>{''.join(_rung(rung, submission, suite) for rung in rungs)}</tbody></table></div></section>"
    )


def _rung(rung: Standing, submission: SubmissionId, suite: str) -> str:
    name = escape(rung.submission.privileged or "none")
    link = f'<a href="{entry_name(rung.submission, suite)}.html">{name}</a>'
    cells = "".join(_cell(rung, metric) for metric in METRICS)
    return f'<tr><th scope="row">{name if rung.submission == submission else link}</th>{cells}</tr>'


def _cell(rung: Standing, metric: str) -> str:
    figure = rung.summary.get(metric)
    if figure is None:
        return f"<td>{DASH}</td>"
    value = f"{shown(metric, figure, figure.mean)} {unit_of(metric, figure)}"
    return f"<td><b>{value}</b><small>{interval(metric, figure)}</small></td>"
