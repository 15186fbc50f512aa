"""Result folders of runs made by hand, ready for a leaderboard."""

import json
from collections.abc import Sequence
from pathlib import Path

import msgspec
from made_runs import PERIOD_S, along_lap, header_of, log_of

from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.log import EpisodeLog, Hit, write_log
from adc_bench.evaluate.results import episode_timing, result_of, timing_of, to_json
from adc_bench.evaluate.suite import load_suite

COMPUTE_S = (0.005, 0.01, 0.01)  # of the steps of every run
SHOUT = 'ValueError: </script><img src="x" onerror="alert(1)">'
SPEED_MPS = 3.0


def make_result(folder: Path, name: str, half_laps: int) -> Path:
    """Make the result of a submission that drives so many half laps, and in each run a little farther."""
    return written(folder, [cut(log, 145 * half_laps + k) for k, log in enumerate(logs_of(name))])


def make_poor_result(folder: Path, name: str) -> Path:
    """Make the result of a slow submission that hits a cone in its second run and breaks in its third."""
    logs = [cut(log, 60) for log in logs_of(name)]
    rows = list(logs[1].rows)
    rows[50] = msgspec.structs.replace(
        rows[50], hits=(Hit(time_s=rows[50].time_s, with_name="cone_3", impulse_ns=1.25),)
    )
    logs[1] = msgspec.structs.replace(logs[1], rows=tuple(rows))
    logs[2] = msgspec.structs.replace(logs[2], ending=Ending(reason=Reason.STEP_RAISED, detail=SHOUT))
    return written(folder, logs)


def make_privileged_result(folder: Path, name: str) -> Path:
    """Make the result of a short drive by a submission that was lent the true pose."""
    logs = [cut(log, 20) for log in logs_of(name)]
    run = logs[0].header.run
    lent = msgspec.structs.replace(run, submission=msgspec.structs.replace(run.submission, privileged="pose"))
    return written(
        folder, [msgspec.structs.replace(log, header=msgspec.structs.replace(log.header, run=lent)) for log in logs]
    )


def logs_of(name: str) -> list[EpisodeLog]:
    """Return the same drive under each seed of d1."""
    suite = load_suite("d1")
    header = msgspec.structs.replace(header_of(suite, name=name), start_step=1)
    log = log_of(header, along_lap(header, SPEED_MPS))
    headers = [msgspec.structs.replace(header, seed=seed, scenario=suite.scenario_name(seed)) for seed in suite.seeds]
    return [msgspec.structs.replace(log, header=header) for header in headers]


def cut(log: EpisodeLog, steps: int) -> EpisodeLog:
    """Return the log as if the time had been up after so many steps."""
    rows = (*log.rows[:steps], msgspec.structs.replace(log.rows[steps], answer=None))
    return msgspec.structs.replace(log, rows=rows, ending=Ending(reason=Reason.TIME_LIMIT))


def written(folder: Path, logs: Sequence[EpisodeLog]) -> Path:
    for log in logs:
        write_log(folder / "episodes" / f"{log.header.scenario}.jsonl", log.header, log.rows, log.ending)
    runs = {log.header.scenario: episode_timing(9.0, log.rows[-1].time_s, COMPUTE_S, "bubblewrap") for log in logs}
    (folder / "timing.json").write_text(json.dumps(msgspec.to_builtins(timing_of(runs, 0.0, PERIOD_S))))
    (folder / "result.json").write_bytes(to_json(result_of(logs, len(logs))))
    return folder
