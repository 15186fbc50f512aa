"""The leaderboard: one validated JSON file an entry, ranked, exported, and shown as a table in Markdown."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.results import Latency, Result, Timing, to_json
from adc_bench.evaluate.run import result_in
from adc_bench.evaluate.statistics import Statistic
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import RulesId, load_suite, rules_id

Record = TypeVar("Record", bound=msgspec.Struct)

# Heading, metric of the summary, decimals.
COLUMNS = (
    ("driving score", "driving_score", 1),
    ("points", "points", 1),
    ("completion", "completion", 3),
    ("lap time [s]", "lap_time_s", 2),
    ("position RMSE [m]", "position_rmse_m", 3),
    ("dead reckoning [m]", "dead_reckoning_rmse_m", 3),
    ("line touches", "line_touches", 1),
    ("collisions", "collisions", 1),
)


class Entry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A submission's result on a suite, as it stands in `entries/<submission>-<suite>.json`."""

    schema: Literal["adc-bench-entry-1"] = "adc-bench-entry-1"
    suite: str
    rules: RulesId
    submission: SubmissionId
    software: dict[str, str]
    runs: int
    summary: dict[str, Statistic]
    latency: Latency
    isolation: str
    result_sha256: str

    @property
    def file_name(self) -> str:
        """The name that the entry's file must have."""
        return f"{self.submission.name}-{self.suite}.json"


class Ranked(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An entry with its place, from 1."""

    rank: int
    entry: Entry


class Leaderboard(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`leaderboard.json`: for each suite its entries, best first."""

    schema: Literal["adc-bench-leaderboard-1"] = "adc-bench-leaderboard-1"
    suites: dict[str, tuple[Ranked, ...]]


def add(folder: Path, board: Path) -> Entry:
    """Add a result folder to the leaderboard, in place of the submission's entry on that suite if there is one.

    Raises:
        InputError: the folder holds no whole, eligible result of these rules, or its figures are not what its logs say.
    """
    result, timing = _read(folder / "result.json", Result), _read(folder / "timing.json", Timing)
    if not result.eligible:
        found = f"a result that is not eligible ({result.completed} of {result.planned} runs)"
        wanted = "every run of a ranked suite, without --set"
        raise _refused(folder / "result.json", found, wanted, "drive the whole suite as shipped")
    _check_rules(folder / "result.json", result.suite, result.rules)
    if to_json(result_in(folder)) != to_json(result):
        found, wanted = "figures that the logs do not give", "those of `adc-bench rescore`"
        raise _refused(folder / "result.json", found, wanted, f"run `adc-bench rescore {folder}`")
    entry = Entry(
        suite=result.suite,
        rules=result.rules,
        submission=result.submission,
        software=result.software,
        runs=result.completed,
        summary=result.summary,
        latency=timing.latency,
        isolation=timing.isolation,
        result_sha256=hashlib.sha256(to_json(result)).hexdigest(),
    )
    write_file(board / "entries" / entry.file_name, to_json(entry))
    write_file(board / "schema.json", schema())
    write_file(board / "README.md", table(ranking(entries_in(board))))
    return entry


def check(board: Path) -> Leaderboard:
    """Return the ranking after checking every entry, the schema and the table.

    Raises:
        InputError: something does not stand as `add` would have written it.
    """
    ranked = ranking(entries_in(board))
    for name, wanted in (("schema.json", schema()), ("README.md", table(ranked))):
        path = board / name
        if not path.is_file() or path.read_bytes() != wanted:
            raise _refused(path, "another text", "the one that goes with the entries", "add an entry again")
    return ranked


def entries_in(board: Path) -> list[Entry]:
    """Return the leaderboard's entries, in order of their files' names.

    Raises:
        InputError: there is no such folder, or an entry is broken, misnamed or of other rules.
    """
    if not board.is_dir():
        raise _refused(board, "no such folder", "a leaderboard's folder", "name one with --leaderboard")
    entries = []
    for path in sorted((board / "entries").glob("*.json")):
        entry = _read(path, Entry)
        if path.name != entry.file_name:
            raise _refused(path, "a misnamed entry", entry.file_name, "rename the file")
        _check_rules(path, entry.suite, entry.rules)
        entries.append(entry)
    return entries


def ranking(entries: Sequence[Entry]) -> Leaderboard:
    """Return the entries ranked by mean driving score, then by mean run time."""
    suites = sorted({entry.suite for entry in entries})
    return Leaderboard(
        suites={
            suite: tuple(
                Ranked(rank=rank, entry=entry)
                for rank, entry in enumerate(sorted((e for e in entries if e.suite == suite), key=_merit), start=1)
            )
            for suite in suites
        }
    )


def _merit(entry: Entry) -> tuple[float, float, str]:
    run_time = entry.summary.get("run_time_s")
    score = entry.summary["driving_score"].mean
    return (-score, run_time.mean if run_time else float("inf"), entry.submission.name)


def schema() -> bytes:
    """Return the JSON Schema of `leaderboard.json`; an entry's own is among its definitions."""
    return to_json(_unwrapped(msgspec.json.schema(Leaderboard)))


def _unwrapped(node: Any) -> Any:
    """Return a schema with its descriptions on one line: Pythons differ in how they indent docstrings."""
    if isinstance(node, dict):
        return {
            key: " ".join(value.split()) if key == "description" and isinstance(value, str) else _unwrapped(value)
            for key, value in node.items()
        }
    return [_unwrapped(value) for value in node] if isinstance(node, list) else node


def table(board: Leaderboard) -> bytes:
    """Return the ranking as Markdown, one table a suite."""
    lines = ["# Leaderboard", "", "Means over a suite's runs, with the bootstrap 95 % interval of the mean.", ""]
    lines += ["Written by `adc-bench leaderboard add DIR`; do not edit.", ""]
    for suite, ranked in board.suites.items():
        head = ["rank", "submission", *(heading for heading, _, _ in COLUMNS), "latency"]
        lines += [f"## {suite}", "", _line(head), _line(["---"] * len(head))]
        lines += [_line([str(place.rank), *_cells(place.entry)]) for place in ranked]
        lines += ["", f"Rules `{ranked[0].entry.rules.id}` `{ranked[0].entry.rules.sha256[:12]}`.", ""]
    return "\n".join(lines).rstrip().encode() + b"\n"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _cells(entry: Entry) -> list[str]:
    figures = [_figure(entry.summary.get(metric), decimals) for _, metric, decimals in COLUMNS]
    return [entry.submission.name, *figures, entry.latency.verdict]


def _figure(figure: Statistic | None, decimals: int) -> str:
    if figure is None:
        return "-"
    low, high = figure.ci95
    return f"{figure.mean:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"


def _read(path: Path, kind: type[Record]) -> Record:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except FileNotFoundError:
        raise _refused(path, "no such file", f"a {path.name}", "name a result folder that is complete") from None
    except msgspec.DecodeError as error:
        wanted = f"JSON of the schema of {kind.__name__}"
        raise _refused(path, str(error), wanted, "write it with adc-bench, not by hand") from None


def _check_rules(path: Path, suite: str, rules: RulesId) -> None:
    """Raise InputError unless the rules are this version's for the shipped suite of that name."""
    wanted = rules_id(load_suite(suite))
    if rules != wanted:
        found = f"rules {rules.id} {rules.sha256[:12]}"
        raise _refused(path, found, f"rules {wanted.id} {wanted.sha256[:12]} of suite {suite}", "drive the suite again")


def _refused(path: Path, found: str, wanted: str, todo: str) -> InputError:
    return InputError(where=str(path), found=found, wanted=wanted, todo=todo)
