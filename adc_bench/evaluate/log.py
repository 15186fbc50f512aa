"""The log of a run: one JSON line an observation between a header and an ending. Every score is computed from it.

Floats are written in their shortest exact form, so that a score from the log equals the score of the drive.
"""

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.ending import Ending
from adc_bench.evaluate.recorded_log import (
    Covariance,
    DetectionHeader,
    DetectionRow,
    Encoders,
    LocalizationHeader,
    LocalizationRow,
)
from adc_bench.evaluate.run_header import RunHeader
from adc_bench.evaluate.suite import Suite
from adc_bench.geometry import Pose2
from adc_bench.world.categories import PanelSign, SignCategory
from adc_bench.world.layout import Layout
from adc_bench.world.look import Look
from adc_bench.world.signs import VerticalSign


class Header(RunHeader, frozen=True, kw_only=True, tag="driver"):
    """The first line of a drive's log: which run this is, with the truths that the score needs."""

    look: Look
    start_pose: Pose2
    start_step: int  # the panels show stop before it, the first order from it on
    orders: tuple[PanelSign, ...]  # of the panels, see `Programme`
    layout: Layout
    signs: tuple[VerticalSign, ...]
    wheel_separation_m: float  # the true one

    @property
    def suite(self) -> Suite:
        """The suite that the run is of."""
        assert isinstance(self.run.suite, Suite)
        return self.run.suite


class Hit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A contact of the robot with something that is not the floor."""

    time_s: float
    with_name: str = msgspec.field(name="with")
    impulse_ns: float


class Drive(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A submission's answer: what it orders, where it believes it is at the row's time, and the sign it reports."""

    v_mps: float
    omega_radps: float
    estimate: Pose2
    covariance: Covariance | None = None
    sign: SignCategory | None = None


class Row(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The truth at one observation, what the sensors said since the one before, and the answer (none at the end)."""

    step: int
    time_s: float
    truth: Pose2
    v_mps: float
    omega_radps: float
    panel: PanelSign
    encoders: Encoders
    hits: tuple[Hit, ...]
    answer: Drive | None


class EpisodeLog(msgspec.Struct, frozen=True, kw_only=True):
    """A whole drive."""

    header: Header
    rows: tuple[Row, ...]
    ending: Ending


class LocalizationLog(msgspec.Struct, frozen=True, kw_only=True):
    """A recorded drive, as a localiser followed it."""

    header: LocalizationHeader
    rows: tuple[LocalizationRow, ...]
    ending: Ending


class DetectionLog(msgspec.Struct, frozen=True, kw_only=True):
    """A set of pictures, as a detector saw them."""

    header: DetectionHeader
    rows: tuple[DetectionRow, ...]
    ending: Ending


AnyHeader = Header | LocalizationHeader | DetectionHeader
AnyRow = Row | LocalizationRow | DetectionRow
AnyLog = EpisodeLog | LocalizationLog | DetectionLog
KINDS: Mapping[type[AnyHeader], tuple[type[AnyRow], type[AnyLog]]] = {
    Header: (Row, EpisodeLog),
    LocalizationHeader: (LocalizationRow, LocalizationLog),
    DetectionHeader: (DetectionRow, DetectionLog),
}


class Seal(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The last line: the ending, and the digest of all lines before it."""

    ending: Ending
    sha256: str


def log_bytes(header: AnyHeader, rows: Sequence[AnyRow], ending: Ending) -> bytes:
    """Return the file of a finished run."""
    lines = b"".join(msgspec.json.encode(line) + b"\n" for line in (header, *rows))
    seal = Seal(ending=ending, sha256=hashlib.sha256(lines).hexdigest())
    return lines + msgspec.json.encode(seal) + b"\n"


def write_log(path: Path, header: AnyHeader, rows: Sequence[AnyRow], ending: Ending) -> None:
    """Write a finished run; nothing is there before it is complete."""
    write_file(path, log_bytes(header, rows, ending))


def read_log(path: Path) -> AnyLog:
    """Return the run in a file.

    Raises:
        InputError: a line is not what it should be or was altered, or the file ends before its ending.
    """
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    if len(lines) < 2:
        raise damaged(path, "fewer than two lines")
    header = _line(path, lines, 1, AnyHeader)
    row_type, log_type = KINDS[type(header)]
    rows = tuple(_line(path, lines, number, row_type) for number in range(2, len(lines)))
    seal = _line(path, lines, len(lines), Seal)
    if hashlib.sha256(whole[: -len(lines[-1])]).hexdigest() != seal.sha256:
        raise damaged(path, "other lines than were written")
    log: AnyLog = log_type(header=header, rows=rows, ending=seal.ending)
    return log


def read_header(path: Path) -> AnyHeader:
    """Return the first line of a log.

    Raises:
        InputError: it is no header.
    """
    with path.open("rb") as file:
        try:
            header: AnyHeader = msgspec.json.decode(file.readline(), type=AnyHeader)
        except msgspec.DecodeError as error:
            raise damaged(path, f"line 1: {error}") from None
    return header


def _line(path: Path, lines: Sequence[bytes], number: int, kind: Any) -> Any:
    """Return line `number`, from 1."""
    try:
        return msgspec.json.decode(lines[number - 1], type=kind)
    except msgspec.DecodeError as error:
        raise damaged(path, f"line {number} of {len(lines)}: {error}") from None


def damaged(path: Path, found: str) -> InputError:
    """Return the error of a log that cannot be read."""
    return InputError(
        where=str(path),
        found=f"a damaged episode log: {found}",
        wanted="a header, one row an observation and an ending, as JSON lines",
        todo="delete the file and run `adc-bench evaluate submission` on the folder again: it drives what is missing",
    )
