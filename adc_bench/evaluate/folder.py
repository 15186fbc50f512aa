"""A result folder: result.json, timing.json, paths.png, episodes/<scenario>.jsonl, logs/<scenario>.log,
failures/<scenario>/ with what a submission that failed was given last, films/<scenario>.mp4 of filmed drives.
"""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.log import AnyHeader, AnyLog, read_header, read_log
from adc_bench.evaluate.results import EpisodeTiming, Result, Timing
from adc_bench.evaluate.run_header import RunId

FILES = ("result.json", "timing.json", "paths.png")
SAME_RUN = "runs of one submission on one suite, with one version of everything"
FOLDERS = ("episodes", "logs", "failures", "films")


class ResultFolder:
    """The files of one submission on one suite."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.result_path, self.timing_path, self.paths_path = (root / name for name in FILES)

    def episode_path(self, scenario: str) -> Path:
        """Return where a run's log is."""
        return self.root / "episodes" / f"{scenario}.jsonl"

    def printed_path(self, scenario: str) -> Path:
        """Return where a run's submission prints to."""
        return self.root / "logs" / f"{scenario}.log"

    def film_path(self, scenario: str) -> Path:
        """Return where a run's film is."""
        return self.root / "films" / f"{scenario}.mp4"

    def open(self, run: RunId, *, overwrite: bool) -> None:
        """Make the folder ready for a run; with `overwrite`, without what another left there.

        Raises:
            InputError: it holds something else than a result, or, without `overwrite`, another run's.
        """
        names = {path.name.removesuffix(".tmp") for path in self.root.glob("*")}
        foreign = sorted(names - {*FILES, *FOLDERS})
        if foreign:
            raise self._occupied(f"a folder with {', '.join(foreign[:3])}", "choose another folder")
        if overwrite:
            self._clear()
        for path in self.episode_paths():
            header = read_header(path)
            if header.run != run:
                differing = [key for key in RunId.__struct_fields__ if getattr(header.run, key) != getattr(run, key)]
                found = f"the runs of another {' and '.join(differing)}"
                raise self._occupied(found, "choose another folder, or replace it with --overwrite")
        for name in FOLDERS:
            (self.root / name).mkdir(parents=True, exist_ok=True)

    def _clear(self) -> None:
        for name in FILES:
            (self.root / name).unlink(missing_ok=True)
        for name in FOLDERS:
            shutil.rmtree(self.root / name, ignore_errors=True)

    def _occupied(self, found: str, todo: str) -> InputError:
        return InputError(
            where=str(self.root), found=found, wanted="an empty folder, or one of the same run", todo=todo
        )

    def episode_paths(self) -> list[Path]:
        """Return the logs that are there, in order of name."""
        return sorted((self.root / "episodes").glob("*.jsonl"))

    def put_failure(self, scenario: str, files: Mapping[str, bytes]) -> None:
        """Write what a failed run was given last, in place of what an earlier try left."""
        folder = self.root / "failures" / scenario
        shutil.rmtree(folder, ignore_errors=True)
        for name, content in files.items():
            folder.mkdir(exist_ok=True)
            write_file(folder / name, content)

    def has(self, header: AnyHeader) -> bool:
        """Return whether this very run is there; one that this machine failed (host-error) counts as missing.

        Raises:
            InputError: its log is damaged.
        """
        path = self.episode_path(header.scenario)
        if not path.is_file():
            return False
        log = read_log(path)
        return log.header == header and log.ending.status != "host-error"

    def logs(self, scenarios: Sequence[str]) -> list[AnyLog]:
        """Return the logs of those scenarios that are there.

        Raises:
            InputError: one of them is damaged or of another scenario, there is one more, or they are of several runs.
        """
        paths = [self.episode_path(scenario) for scenario in scenarios]
        for path in self.episode_paths():
            if path not in paths:
                raise _misplaced(path, "the log of none of the planned runs", "one log for each planned run")
        found = {path: read_log(path) for path in paths if path.is_file()}
        for path, log in found.items():
            first = next(iter(found.values())).header
            if log.header.scenario != path.stem:
                raise _misplaced(path, f"the log of {log.header.scenario}, once more", "each planned run once")
            if log.header.run != first.run:
                raise _misplaced(path, f"another run than that of {first.scenario}", SAME_RUN)
        return list(found.values())

    def planned(self) -> int | None:
        """Return how many runs the result that is there was planned with; None if there is none."""
        try:
            return msgspec.json.decode(self.result_path.read_bytes(), type=Result).planned
        except (OSError, msgspec.DecodeError):
            return None

    def timings(self) -> dict[str, EpisodeTiming]:
        """Return the timings that are there, by scenario."""
        try:
            return msgspec.json.decode(self.timing_path.read_bytes(), type=Timing).episodes
        except (OSError, msgspec.DecodeError):
            return {}


def _misplaced(path: Path, found: str, wanted: str) -> InputError:
    return InputError(where=str(path), found=found, wanted=wanted, todo="move what does not belong out of the folder")
