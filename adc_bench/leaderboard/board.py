"""A leaderboard's folder: results added, everything in it checked.

entries/<submission>-<suite>.json  traces/<submission>-<suite>.jsonl, and made of them README.md  leaderboard.json
schema.json
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.folder import ResultFolder
from adc_bench.evaluate.log import DetectionLog
from adc_bench.evaluate.results import Result, Timing, timing_of, to_json
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.run import result_in
from adc_bench.evaluate.suite import RulesId, load_suite, rules_id
from adc_bench.evaluate.summary import summary_of
from adc_bench.leaderboard.ranking import ranking
from adc_bench.leaderboard.records import Entry, Leaderboard, entry_name
from adc_bench.leaderboard.table import schema, table
from adc_bench.leaderboard.traces import Trace, read_traces, trace_of, write_traces

Record = TypeVar("Record", bound=msgspec.Struct)


def add(folder: Path, board: Path, *, unranked: bool = False) -> Entry:
    """Add a result folder to the leaderboard, in place of the submission's entry on that suite if there is one.

    `unranked` entries stand below the others, without a place: they need not be eligible, only whole.

    Raises:
        InputError: the folder holds no whole, eligible result of these rules, the submission was not shut away or
            slower than it says, the figures are not what the logs say, or the logs are not those of the planned runs,
            each once, by one version of everything.
    """
    path = folder / "result.json"
    result, timing = _read(path, Result), _read(folder / "timing.json", Timing)
    wanted_runs = len(load_suite(result.suite).seeds)
    if result.completed < wanted_runs or not (unranked or result.eligible):
        found = f"a result that is not eligible ({result.completed} of {wanted_runs} runs)"
        wanted = "every run of a ranked suite, without --set and --privileged"
        raise _refused(path, found, wanted, "drive the whole suite as shipped; a whole result can be shown --unranked")
    if not unranked:
        _check_timing(folder / "timing.json", timing, result)
    _check_rules(path, result.suite, result.rules)
    if to_json(result_in(folder)) != to_json(result):
        found, wanted = "figures that the logs do not give", "those of `adc-bench rescore`"
        raise _refused(path, found, wanted, f"run `adc-bench rescore {folder}`")
    return _add(board, result, timing, _traces(folder, result), ranked=not unranked)


def _traces(folder: Path, result: Result) -> list[Trace]:
    logs = ResultFolder(folder).logs([episode.scenario for episode in result.episodes])
    pairs = zip(logs, result.episodes, strict=True)
    return [trace_of(log, episode) for log, episode in pairs if not isinstance(log, DetectionLog)]


def _add(board: Path, result: Result, timing: Timing, traces: list[Trace], *, ranked: bool) -> Entry:
    name = entry_name(result.submission, result.suite)
    others = _entries([path for path in _entry_paths(board) if path.stem != name])
    entry = Entry(
        ranked=ranked,
        result=result,
        latency=timing.latency,
        isolation=timing.isolation,
        traces_sha256=write_traces(traces_path(board, name), traces) if traces else None,
    )
    write_file(board / "entries" / f"{name}.json", to_json(entry))
    for file, content in _made_of(ranking([*others, entry])).items():
        write_file(board / file, content)
    return entry


def _made_of(board: Leaderboard) -> Mapping[str, bytes]:
    """Return the files that are made of the entries."""
    return {"README.md": table(board), "leaderboard.json": to_json(board), "schema.json": schema()}


def check(board: Path) -> Leaderboard:
    """Return the ranking after checking every entry, its traces, and the files made of them.

    Raises:
        InputError: something does not stand as `add` would have written it.
    """
    entries = entries_in(board)
    ranked = ranking(entries)
    for entry in entries:
        traces_in(board, entry)
    for name, wanted in _made_of(ranked).items():
        path = board / name
        if not path.is_file() or path.read_bytes() != wanted:
            raise _refused(path, "another text", "the one that goes with the entries", "add an entry again")
    return ranked


def entries_in(board: Path) -> list[Entry]:
    """Return the leaderboard's entries, in order of their files' names.

    Raises:
        InputError: there is no such folder, or an entry is broken, misnamed, incomplete or of other rules.
    """
    if not board.is_dir():
        raise _refused(board, "no such folder", "a leaderboard's folder", "name one with --leaderboard")
    return _entries(_entry_paths(board))


def _entry_paths(board: Path) -> list[Path]:
    return sorted((board / "entries").glob("*.json"))


def _entries(paths: Sequence[Path]) -> list[Entry]:
    entries = [_read(path, Entry) for path in paths]
    for path, entry in zip(paths, entries, strict=True):
        _check_entry(path, entry)
    return entries


def _check_entry(path: Path, entry: Entry) -> None:
    result = entry.result
    if path.stem != entry.name:
        raise _refused(path, "a misnamed entry", f"{entry.name}.json", "rename the file")
    _check_rules(path, result.suite, result.rules)
    seeds = load_suite(result.suite).seeds
    if tuple(episode.seed for episode in result.episodes) != seeds:
        raise _refused(path, "other runs than the suite's", f"one run of each of seeds {seeds}", "add the result again")
    if to_json(summary_of(result.submission.kind, result.episodes)) != to_json(result.summary):
        raise _refused(path, "a summary that its runs do not give", "their statistics", "add the result again")


def traces_in(board: Path, entry: Entry) -> list[Trace]:
    """Return the traces of an entry's runs, in order of its runs; a detector's runs have none.

    Raises:
        InputError: they are missing or changed.
    """
    if entry.traces_sha256 is None:
        return []
    return read_traces(traces_path(board, entry.name), entry.traces_sha256)


def traces_path(board: Path, name: str) -> Path:
    """Return where the traces of an entry are."""
    return board / "traces" / f"{name}.jsonl"


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
    own = rules_id(load_suite(suite))
    if rules != own:
        found = f"rules {rules.id} {rules.sha256[:12]}"
        wanted = f"rules {own.id} {own.sha256[:12]} of suite {suite}"
        raise _refused(path, found, wanted, "drive the suite again; take an older entry out of the leaderboard")


def _check_timing(path: Path, timing: Timing, result: Result) -> None:
    """Raise InputError unless the submission was shut away, and as quick as it says, in each of its runs."""
    latency = timing.latency
    if timing.isolation != "bubblewrap":
        found, wanted = f"isolation {timing.isolation}", "bubblewrap: a submission shut away from the simulator"
        raise _refused(path, found, wanted, "drive again without --in-process; `adc-bench doctor` tells of bubblewrap")
    if latency.verdict == "exceeded":
        found = f"steps of {latency.measured_p95_s:.3f} s (95th percentile)"
        wanted = f"at most {latency.allowed_s:.3f} s"
        raise _refused(path, found, wanted, "declare a larger latency_s, or drive on an idle machine")
    runs = {episode.scenario for episode in result.episodes}
    if timing.episodes.keys() != runs:
        found = f"the times of other runs ({len(runs & timing.episodes.keys())} of {len(runs)} are the result's)"
        raise _refused(path, found, "those of each of its runs", "drive the suite into one folder")
    if timing != timing_of(timing.episodes, result.submission.latency_s, RULES.control_period_s):
        found, wanted = "a verdict that the runs' times do not give", "the one that the drive wrote"
        raise _refused(path, found, wanted, "drive again")


def _refused(path: Path, found: str, wanted: str, todo: str) -> InputError:
    return InputError(where=str(path), found=found, wanted=wanted, todo=todo)
