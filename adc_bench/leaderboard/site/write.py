"""The site's folder: index.html, entries/<submission>-<suite>.html, style and scripts, and the ranking as JSON."""

import shutil
from pathlib import Path

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.detection_score import DetectionEpisode
from adc_bench.evaluate.results import to_json
from adc_bench.evaluate.suite import load_suite, rules_for
from adc_bench.leaderboard.board import check, entries_in, traces_in
from adc_bench.leaderboard.records import Entry, Leaderboard
from adc_bench.leaderboard.site.entry_page import entry_page
from adc_bench.leaderboard.site.index_page import index_page
from adc_bench.leaderboard.site.run_data import run_data
from adc_bench.leaderboard.site.text import asset
from adc_bench.leaderboard.table import schema
from adc_bench.world.course import Course

ASSETS = ("style.css", "board.js", "replay.js")
PAGES = "entries"
FILES = ("index.html", "leaderboard.json", "schema.json", *ASSETS)


def write_site(board: Path, out: Path) -> int:
    """Write the site of a leaderboard, in place of one that is there, and return the number of its pages.

    Equal leaderboards give equal bytes.

    Raises:
        InputError: the leaderboard is not sound, or `out` holds something else than a site.
    """
    ranked = check(board)
    _claim(out)
    pages = {"index.html": index_page(ranked)}
    pages |= {f"{PAGES}/{entry.name}.html": _entry_page(board, ranked, entry) for entry in entries_in(board)}
    files = {
        "leaderboard.json": to_json(ranked),
        "schema.json": schema(),
        **{name: asset(name).encode() for name in ASSETS},
    }
    for name, content in (pages | files).items():
        write_file(out / name, content)
    return len(pages)


def _claim(out: Path) -> None:
    foreign = sorted({path.name for path in out.glob("*")} - {*FILES, PAGES})
    if foreign:
        raise InputError(
            where=str(out),
            found=f"a folder with {', '.join(foreign[:3])}",
            wanted="an empty folder, or one that holds a site",
            todo="choose another folder",
        )
    shutil.rmtree(out / PAGES, ignore_errors=True)


def _entry_page(board: Path, ranked: Leaderboard, entry: Entry) -> bytes:
    suite = load_suite(entry.result.suite)
    episodes = [episode for episode in entry.result.episodes if not isinstance(episode, DetectionEpisode)]
    pairs = zip(episodes, traces_in(board, entry), strict=True)
    runs = [run_data(suite, episode, trace) for episode, trace in pairs]
    return entry_page(entry, ranked.suites[entry.result.suite], runs, Course(spec=rules_for(suite).course))
