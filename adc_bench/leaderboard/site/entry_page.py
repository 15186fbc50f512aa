"""An entry's page: its figures, its runs, and each run's path, errors and events, to be played again."""

import json
from collections.abc import Sequence
from html import escape

from adc_bench.evaluate.statistics import Statistic
from adc_bench.evaluate.summary import METRICS
from adc_bench.leaderboard.figures import interval, label, shown, unit_of
from adc_bench.leaderboard.records import Entry, Standing, SuiteRanking, title
from adc_bench.leaderboard.site.charts import SIGMAS, charts
from adc_bench.leaderboard.site.course_map import course_symbol, run_map
from adc_bench.leaderboard.site.ladder import ladder
from adc_bench.leaderboard.site.run_data import RunData
from adc_bench.leaderboard.site.runs_table import runs_table
from adc_bench.leaderboard.site.text import DASH, page, plural
from adc_bench.world.course import Course

LEGEND = (
    ("truth", "driven"),
    ("estimate", "where the submission believed to be"),
    ("fault", "fault"),
)


def entry_page(entry: Entry, ranking: SuiteRanking, runs: Sequence[RunData], course: Course) -> bytes:
    """Return the page of an entry with its runs, and its place in its suite's ranking."""
    submission, suite = entry.result.submission, entry.result.suite
    name = title(submission)
    standing = next(standing for standing in ranking.standings if standing.submission == submission)
    body = (
        f'<header><nav><a href="../index.html#{escape(suite)}">Leaderboard</a></nav>'
        f"<h1>{escape(name)} <small>on {escape(suite)}</small></h1>"
        f"{_about(entry, standing, ranking.ranked_by)}</header>"
        f'<main id="content"><section><h2>Runs</h2>{runs_table(entry.result.episodes)}</section>{_replay(runs, course)}'
        f"<section><h2>Figures</h2>{_figures(standing)}</section>{ladder(submission, suite, ranking)}</main>"
    )
    return page(f"{name} on {suite}: adc-bench leaderboard", body, root="../", script="replay.js")


def _replay(runs: Sequence[RunData], course: Course) -> str:
    """Return the runs to be played again; nothing where there is no path."""
    if not runs:
        return ""
    options = "".join(f'<option value="run-{run.scenario}">{escape(run.choice)}</option>' for run in runs)
    return (
        '<section class="replay"><h2 id="replay">Replay</h2><form class="bar script"><label>run <select name="run">'
        f"{options}</select></label></form>{course_symbol(course)}"
        f"{''.join(_run(run, course) for run in runs)}</section>"
    )


def _about(entry: Entry, standing: Standing, ranked_by: str) -> str:
    best = standing.summary[ranked_by]
    submission, latency = entry.result.submission, entry.latency
    measured = "" if latency.measured_p95_s is None else f", measured {1000 * latency.measured_p95_s:.0f} ms (p95)"
    facts = {
        "place": str(standing.rank or "not ranked"),
        label(ranked_by): f"{shown(ranked_by, best, best.mean)} {unit_of(ranked_by, best)} {interval(ranked_by, best)}",
        "authors": ", ".join(submission.authors),
        "kind": submission.kind,
        "latency": f"declared {1000 * latency.declared_s:.0f} ms{measured}",
        "isolation": entry.isolation,
        "software": ", ".join(f"{name} {version}" for name, version in sorted(standing.software.items())),
        "submission": submission.sha256[:12],
        "rules": f"{entry.result.rules.id} {entry.result.rules.sha256[:12]}",
    }
    return f'<dl class="about">{"".join(_fact(term, told) for term, told in facts.items())}</dl>'


def _fact(term: str, told: str) -> str:
    return f"<div><dt>{escape(term)}</dt><dd>{escape(told)}</dd></div>"


def _run(run: RunData, course: Course) -> str:
    scenario = escape(run.scenario)
    return (
        f'<article class="run" id="run-{scenario}" aria-labelledby="head-{scenario}"><h3 id="head-{scenario}">'
        f"{scenario} <small>{escape(run.outcome)}</small></h3>{_detail(run)}<figure>{run_map(run, course)}"
        f"<figcaption>{_legend(run)}</figcaption></figure>{_player(run)}{_told(run)}{charts(run)}{_events(run)}"
        f'<script type="application/json">{_data(run)}</script></article>'
    )


def _detail(run: RunData) -> str:
    detail = run.trace.detail
    return f'<pre class="detail" tabindex="0">{escape(detail)}</pre>' if detail else ""


def _legend(run: RunData) -> str:
    kinds = [(kind, told) for kind, told in LEGEND if (kind != "estimate" or run.error is not None)]
    return "".join(f'<span class="key {kind}">{told}</span>' for kind, told in kinds)


def _player(run: RunData) -> str:
    end_s = run.trace.end_s
    return (
        '<div class="player script"><button type="button" class="play">Play</button>'
        f'<input type="range" min="0" max="{end_s:g}" step="0.05" value="0" aria-label="Time in the run">'
        '<label>speed <select><option value="1">1×</option><option value="4" selected>4×</option>'
        '<option value="16">16×</option></select></label><span class="now"></span></div>'
    )


def _told(run: RunData) -> str:
    if run.error is None:
        return '<p class="told">The submission never said where it was.</p>'
    band = "" if run.sd is None else f", over the band of its own {SIGMAS:g} standard deviations"
    return f'<p class="told">Errors of the estimate as seen from the robot{band}.</p>'


def _events(run: RunData) -> str:
    rows = "".join(
        f'<li class="{event.kind}"><button type="button" data-at="{event.time_s:g}">{event.time_s:.2f} s</button> '
        f"{escape(event.text)}</li>"
        for event in run.trace.events
    )
    count = plural(len(run.trace.events), "event")
    return f'<details open><summary>{count}</summary><ol class="events">{rows}</ol></details>'


def _data(run: RunData) -> str:
    """Return what the script needs of a run; `<` is written as an escape, for the text stands in a script element."""
    trace = run.trace
    columns: dict[str, object] = {"x": trace.x_mm, "y": trace.y_mm, "yaw": trace.yaw_mrad}
    if trace.estimate is not None:
        columns |= {"ahead": trace.estimate.ahead_um, "left": trace.estimate.left_um, "turn": trace.estimate.turn_urad}
    data = {"period": trace.period_s, "end": trace.end_s, **columns}
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")


def _figures(standing: Standing) -> str:
    rows = "".join(
        f'<tr><th scope="row">{label(name)} <small>{unit_of(name, figure)}</small></th>'
        f"<td><b>{shown(name, figure, figure.mean)}</b></td><td>{interval(name, figure)}</td>"
        f"<td>{shown(name, figure, figure.median)}</td>"
        f"<td>{DASH if figure.sd is None else shown(name, figure, figure.sd)}</td><td>{figure.n}</td></tr>"
        for name, figure in _in_order(standing)
    )
    head = "".join(f'<th scope="col">{name}</th>' for name in ("", "mean", "95 % interval", "median", "sd", "runs"))
    return (
        f'{_consistency(standing)}<div class="wide" tabindex="0" role="region" aria-label="Figures">'
        f'<table class="figures"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
    )


def _in_order(standing: Standing) -> list[tuple[str, Statistic]]:
    summary = standing.summary
    return [(name, summary[name]) for name in METRICS[standing.submission.kind] if name in summary]


def _consistency(standing: Standing) -> str:
    nees = standing.nees
    if nees is None:
        return ""
    meaning = {
        "consistent": "its covariances can be believed",
        "overconfident": "it believes itself more exact than it is",
        "overcautious": "it is more exact than it believes",
    }[nees.verdict]
    return (
        f'<p>The estimates are <b class="verdict">{nees.verdict}</b>: {meaning}. Their mean NEES over '
        f"{plural(nees.n, 'run')} is {nees.mean:.2f}; a filter that knows its errors lies between {nees.low:.2f} and "
        f"{nees.high:.2f} in 95&nbsp;% of such suites (chi-square).</p>"
    )
