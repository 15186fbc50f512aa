"""The log of a run: one JSON line a control step between a header and an ending. Every score is computed from it.

Floats are written in their shortest exact form, so that a score from the log equals the score of the drive.
"""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import msgspec

from adc_bench.dataset.layout import write_file
from adc_bench.errors import InputError
from adc_bench.evaluate.ending import Ending
from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import RulesId, Suite
from adc_bench.geometry import Pose2
from adc_bench.world.categories import PanelSign, SignCategory
from adc_bench.world.layout import Layout
from adc_bench.world.look import Look
from adc_bench.world.signs import VerticalSign

Covariance = tuple[float, float, float, float, float, float, float, float, float]


class RunId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the runs of one result folder share."""

    schema: Literal["adc-bench-episode-2"] = "adc-bench-episode-2"
    suite: Suite
    rules: RulesId
    submission: SubmissionId
    software: dict[str, str]


class Header(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The first line: which run this is, with the truths that the score needs."""

    run: RunId
    scenario: str
    seed: int
    look: Look
    start_pose: Pose2
    start_step: int  # the panels show stop before it, the first order from it on
    orders: tuple[PanelSign, ...]  # of the panels, see `Programme`
    layout: Layout
    signs: tuple[VerticalSign, ...]
    wheel_separation_m: float  # the true one


class Encoders(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The encoder samples of one observation."""

    time_s: tuple[float, ...]
    left_ticks: tuple[int, ...]
    right_ticks: tuple[int, ...]


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
    """A whole run."""

    header: Header
    rows: tuple[Row, ...]
    ending: Ending


class Seal(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The last line: the ending, and the digest of all lines before it."""

    ending: Ending
    sha256: str


def log_bytes(header: Header, rows: Sequence[Row], ending: Ending) -> bytes:
    """Return the file of a finished run."""
    lines = b"".join(msgspec.json.encode(line) + b"\n" for line in (header, *rows))
    seal = Seal(ending=ending, sha256=hashlib.sha256(lines).hexdigest())
    return lines + msgspec.json.encode(seal) + b"\n"


def write_log(path: Path, header: Header, rows: Sequence[Row], ending: Ending) -> None:
    """Write a finished run; nothing is there before it is complete."""
    write_file(path, log_bytes(header, rows, ending))


def read_log(path: Path) -> EpisodeLog:
    """Return the run in a file.

    Raises:
        InputError: a line is not what it should be or was altered, or the file ends before its ending.
    """
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    if len(lines) < 2:
        raise damaged(path, "fewer than two lines")
    kinds = [Header, *[Row] * (len(lines) - 2), Seal]
    decoded = []
    for number, (line, kind) in enumerate(zip(lines, kinds, strict=True), start=1):
        try:
            decoded.append(msgspec.json.decode(line, type=kind))
        except msgspec.DecodeError as error:
            raise damaged(path, f"line {number} of {len(lines)}: {error}") from None
    if hashlib.sha256(whole[: -len(lines[-1])]).hexdigest() != decoded[-1].sha256:
        raise damaged(path, "other lines than were written")
    return EpisodeLog(header=decoded[0], rows=tuple(decoded[1:-1]), ending=decoded[-1].ending)


def damaged(path: Path, found: str) -> InputError:
    """Return the error of a log that cannot be read."""
    return InputError(
        where=str(path),
        found=f"a damaged episode log: {found}",
        wanted="a header, one row a control step and an ending, as JSON lines",
        todo="delete the file and run `adc-bench evaluate submission` on the folder again: it drives what is missing",
    )
