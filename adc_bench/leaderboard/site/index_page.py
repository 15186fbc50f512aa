"""The first page: a table for each suite, sortable and filtered, and who differs from whom."""

from collections.abc import Iterable
from html import escape

from adc_bench.evaluate.recorded_suite import LocalizationSuite
from adc_bench.evaluate.statistics import Statistic
from adc_bench.evaluate.suite import AnySuite, Suite, load_suite
from adc_bench.leaderboard.figures import columns_of, interval, label, shown, unit_of
from adc_bench.leaderboard.records import Leaderboard, Pair, Standing, SuiteRanking, entry_name, title
from adc_bench.leaderboard.site.text import DASH, page, plural

SIGNIFICANT = 0.05


def index_page(board: Leaderboard) -> bytes:
    """Return the page with every suite's table."""
    kinds = sorted({s.submission.kind for ranking in board.suites.values() for s in ranking.standings})
    body = (
        "<header><h1>adc-bench leaderboard</h1><p>Programs that drive a simulated robot over the figure-eight of the "
        "Autonomous Driving Competition, say where it is, or what its cameras see. A place is earned by the mean over "
        "a suite’s runs: of points, of the position’s error, of the average precision; entries whose "
        '95&nbsp;% intervals overlap share it. All of this as data: <a href="leaderboard.json">leaderboard.json</a> '
        '(<a href="schema.json">schema</a>).</p></header>'
        f'<form class="bar" id="filters">{_filter("suite", board.suites)}{_filter("kind", kinds)}'
        '<output aria-live="polite"></output></form>'
        f'<main id="content">{"".join(_suite(suite, ranking) for suite, ranking in board.suites.items())}</main>'
    )
    return page("adc-bench leaderboard", body, root="", script="board.js")


def _filter(name: str, values: Iterable[str]) -> str:
    options = "".join(f"<option>{escape(value)}</option>" for value in values)
    return f'<label>{name} <select name="{name}"><option value="">all</option>{options}</select></label>'


def _suite(name: str, ranking: SuiteRanking) -> str:
    suite = load_suite(name)
    columns = columns_of(ranking)
    metrics = list(columns)
    head = _head("place", "ascending") + _head("submission", "ascending")
    head += "".join(_metric_head(metric, figure) for metric, figure in columns.items()) + _head(
        "failed runs", "ascending"
    )
    most = max((s.summary[metrics[0]].ci95[1] for s in ranking.standings if metrics[0] in s.summary), default=1.0)
    rows = "".join(_row(name, standing, metrics, most) for standing in ranking.standings)
    told = f"{plural(len(suite.seeds), 'run')} {_task(suite)}. Rules {ranking.rules.id}"
    return (
        f'<section class="suite" id="{escape(name)}" data-suite="{escape(name)}"><h2>{escape(name)}</h2>'
        f'<p class="told">{escape(told)} <code title="digest of rules and suite">{ranking.rules.sha256[:12]}</code></p>'
        f'<div class="wide" tabindex="0" role="region" aria-label="Ranking of {escape(name)}"><table class="sortable">'
        f"<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{_pairs(ranking)}</section>"
    )


def _task(suite: AnySuite) -> str:
    """Return what the runs of a suite are, in words."""
    if isinstance(suite, Suite):
        parking = (f"{suite.parking} parking",) if suite.parking else ()
        task = ", ".join((*(element.replace("_", " ") for element in suite.elements), *parking)) or "driving alone"
        return f"of up to {suite.time_limit_s:g} s: {task}"
    if isinstance(suite, LocalizationSuite):
        return f"of up to {suite.split.drives.duration_s[1]:g} s: recorded drives, to be located in"
    return f"of {suite.pictures} pictures: what is on them, and where"


def _head(text: str, first: str, unit: str = "") -> str:
    told = f" <small>{escape(unit)}</small>" if unit else ""
    return f'<th scope="col" data-first="{first}"><button type="button">{escape(text)}{told}</button></th>'


def _metric_head(metric: str, figure: Statistic) -> str:
    return _head(label(metric), "descending" if figure.higher_is_better else "ascending", unit_of(metric, figure))


def _row(suite: str, standing: Standing, metrics: list[str], most: float) -> str:
    name, kind = title(standing.submission), standing.submission.kind
    place = str(standing.rank) if standing.rank else DASH
    unranked = "" if standing.rank else ", not ranked"
    cells = "".join(_cell(metric, standing.summary.get(metric), most, metrics[0]) for metric in metrics)
    return (
        f'<tr data-kind="{kind}"><td data-value="{standing.rank or ""}" class="place">{place}</td>'
        f'<th scope="row" data-value="{escape(name)}"><a href="entries/{entry_name(standing.submission, suite)}.html">'
        f"{escape(name)}</a><small>{kind}{unranked}</small></th>{cells}"
        f'<td data-value="{standing.failed}">{standing.failed} of {standing.runs}</td></tr>'
    )


def _cell(metric: str, figure: Statistic | None, most: float, ranked_by: str) -> str:
    if figure is None:
        return f'<td data-value="">{DASH}</td>'
    bar = _whisker(figure, most) if metric == ranked_by else ""
    return (
        f'<td data-value="{figure.mean!r}"><b>{shown(metric, figure, figure.mean)}</b> '
        f"<small>{interval(metric, figure)}</small>{bar}</td>"
    )


def _whisker(figure: Statistic, most: float) -> str:
    """Return the mean and its interval as a mark on a line from 0 to the suite's largest."""
    low, mean, high = (100.0 * value / max(most, 1e-9) for value in (figure.ci95[0], figure.mean, figure.ci95[1]))
    return (
        f'<span class="whisker" aria-hidden="true"><i style="left:{low:.2f}%;width:{max(high - low, 0.0):.2f}%"></i>'
        f'<b style="left:{mean:.2f}%"></b></span>'
    )


def _pairs(ranking: SuiteRanking) -> str:
    if not ranking.pairs:
        return ""
    metric, figure = ranking.ranked_by, ranking.standings[0].summary[ranking.ranked_by]
    rows, runs = "".join(_pair(pair, metric, figure) for pair in ranking.pairs), ranking.pairs[0].difference.n
    apart = f"{label(metric)} apart {unit_of(metric, figure)}".strip()
    least = 2.0 ** (1 - runs)
    return (
        "<details><summary>Compared in pairs, seed by seed</summary>"
        '<div class="wide" tabindex="0" role="region" aria-label="Comparisons in pairs"><table><thead><tr>'
        '<th scope="col">better</th><th scope="col">worse</th><th scope="col">'
        f'{apart}</th><th scope="col">p</th>'
        f"</tr></thead><tbody>{rows}</tbody></table></div><p>p is the probability of a mean difference at least so "
        f"large if neither is better (sign-flip test over {plural(runs, 'seed')}, two-sided, not corrected for "
        "many comparisons). "
        f"With so many seeds it cannot be below {least:.3f}.</p></details>"
    )


def _pair(pair: Pair, metric: str, figure: Statistic) -> str:
    difference = pair.difference
    mean, low, high = (shown(metric, figure, value) for value in (difference.mean_difference, *difference.ci95))
    sure = "" if difference.p_value <= SIGNIFICANT else ' class="unsure"'
    return (
        f"<tr{sure}><td>{escape(pair.first)}</td><td>{escape(pair.second)}</td><td><b>{mean}</b> "
        f"<small>[{low}, {high}]</small></td><td>{difference.p_value:.3f}</td></tr>"
    )
