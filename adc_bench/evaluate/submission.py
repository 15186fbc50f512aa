"""A submission: what its `submission.toml` says, or a built-in one, and the digest of all that answers."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import msgspec

from adc_bench.api import Kind
from adc_bench.errors import InputError, UsageError
from adc_bench.evaluate.agent_side import Load
from adc_bench.evaluate.submission_files import digest
from adc_bench.evaluate.witness import Privilege
from adc_bench.world.records import load_record

Name = Annotated[str, msgspec.Meta(pattern=r"^[a-z0-9][a-z0-9_-]*$", max_length=60)]
Entry = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")]
Latency = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
PACKAGE = Path(__file__).parents[1]
ORACLE = "oracle"  # the reference with the true pose: how far a perfect localiser would come
# What a built-in driver's digest leaves out: the rooms above this one, which no drive can reach (a contract of the
# imports), and the suites' files, which lie in the package only where it is installed and have a digest of their own.
NOT_DRIVING = ("cli", "leaderboard", "reproduce", "splits")


class SubmissionFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`submission.toml`: `entry` is module:factory, the factory takes nothing and returns the agent; or in its place
    `command`, a program of the folder or the system with its arguments, which speaks the protocol.
    """

    name: Name
    authors: tuple[str, ...]
    kind: Kind
    entry: Entry | None = None
    command: Annotated[tuple[str, ...], msgspec.Meta(min_length=1)] | None = None
    latency_s: Latency = 0.0


class SubmissionId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Who drove; sha256 covers the submission's files and those its options name. `privileged` names the layer of a
    built-in driver in whose place it had the truth.
    """

    name: Name
    authors: tuple[str, ...]
    kind: Kind
    sha256: str
    latency_s: Latency
    options: dict[str, str]
    privileged: Privilege | None = None


@dataclass(frozen=True, kw_only=True)
class Submission:
    """A submission ready to be started."""

    id: SubmissionId
    load: Load


def load_submission(
    source: str, options: Mapping[str, str], privileged: Privilege | None = None, kind: Kind = "driver"
) -> Submission:
    """Return the submission in a folder, or else the built-in one of that name and kind. Its code is not run here.

    A built-in driver may be `privileged`; the oracle is.

    Raises:
        UsageError: a folder's submission, or what is no driver, cannot be privileged.
        InputError: there is no such submission, or its submission.toml holds something unusable.
    """
    folder, options = Path(source), dict(options)
    if not (folder / "submission.toml").is_file():
        return _built_in(source, options, privileged, kind)
    if privileged:
        raise UsageError(
            where=f"--privileged {privileged}",
            found=f"the submission in {source}",
            wanted="a built-in driver: the truth is lent to no other",
            todo="leave --privileged out, or name a built-in driver",
        )
    path = folder / "submission.toml"
    file = load_record(path, SubmissionFile)
    if (file.entry is None) == (file.command is None):
        found = "neither entry nor command" if file.entry is None else "both entry and command"
        wanted = 'entry = "module:factory", or command = ["program", "argument"]'
        raise InputError(where=str(path), found=found, wanted=wanted, todo="say one of the two")
    return _submission(file, folder, options, is_built_in=False)


def require_kind(submission: Submission, kind: Kind) -> None:
    """Raise InputError unless the submission is of a suite's kind."""
    if submission.id.kind != kind:
        raise InputError(
            where=f"submission {submission.id.name}",
            found=f"kind = {submission.id.kind!r}",
            wanted=f"kind = {kind!r}, which this suite is for",
            todo="choose a suite of the submission's kind: loc for localizers, det for detectors, others for drivers",
        )


def _built_in(name: str, options: dict[str, str], privileged: Privilege | None, kind: Kind) -> Submission:
    from adc_bench.reference import OF_KIND

    if name == ORACLE and kind == "driver":
        return _oracle(options, privileged)
    known = sorted(OF_KIND[kind])
    if name not in known:
        raise InputError(
            where=f"submission {name}",
            found="a folder without submission.toml" if Path(name).is_dir() else "no such folder",
            wanted=f"a folder with submission.toml, or one of {', '.join(known)}",
            todo="name a submission's folder or a built-in one",
        )
    if privileged and kind != "driver":
        raise UsageError(
            where=f"--privileged {privileged}",
            found=f"a {kind}",
            wanted="a built-in driver: the truth is lent to no other",
            todo="leave --privileged out, or name a suite that is driven",
        )
    file = SubmissionFile(name=name, authors=("adc-bench",), kind=kind, entry="reference:built_in")
    submission = _submission(file, PACKAGE, options, is_built_in=True)
    return replace(submission, id=msgspec.structs.replace(submission.id, privileged=privileged))


def _oracle(options: dict[str, str], privileged: Privilege | None) -> Submission:
    if privileged:
        raise UsageError(
            where=f"--privileged {privileged}",
            found="the oracle, which has the true pose",
            wanted="a driver with layers of its own",
            todo="leave --privileged out, or name the reference",
        )
    reference = _built_in("reference", options, "pose", "driver")
    return replace(reference, id=msgspec.structs.replace(reference.id, name=ORACLE))


def _submission(file: SubmissionFile, folder: Path, options: dict[str, str], *, is_built_in: bool) -> Submission:
    sha256 = digest(folder, options, NOT_DRIVING if is_built_in else ())
    return Submission(
        id=SubmissionId(
            name=file.name,
            authors=file.authors,
            kind=file.kind,
            sha256=sha256,
            latency_s=file.latency_s,
            options=options,
        ),
        load=Load(
            kind=file.kind,
            folder=None if is_built_in else str(folder.resolve()),
            entry=file.name if is_built_in else file.entry or "",
            command=file.command or (),
            options=_absolute(options),
            sha256=sha256,
        ),
    )


def _absolute(options: Mapping[str, str]) -> dict[str, str]:
    """Return the options with files named by their full path: the child runs in another folder."""
    return {key: str(Path(value).resolve()) if Path(value).is_file() else value for key, value in options.items()}
