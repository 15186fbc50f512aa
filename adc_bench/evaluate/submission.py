"""A submission: what its `submission.toml` says, or a built-in driver, and the digest of all that drives."""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from adc_bench.errors import InputError
from adc_bench.evaluate.wire import Load
from adc_bench.world.records import load_record

Name = Annotated[str, msgspec.Meta(pattern=r"^[a-z0-9][a-z0-9_-]*$", max_length=60)]
Entry = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z_][\w.]*:[A-Za-z_]\w*$")]
Latency = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
PACKAGE = Path(__file__).parents[1]


class SubmissionFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`submission.toml`: `entry` is module:factory, the factory takes nothing and returns the agent."""

    name: Name
    authors: tuple[str, ...]
    kind: Literal["driver"]
    entry: Entry
    latency_s: Latency = 0.0


class SubmissionId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Who drove; sha256 covers the submission's files and those its options name."""

    name: Name
    authors: tuple[str, ...]
    kind: Literal["driver"]
    sha256: str
    latency_s: Latency
    options: dict[str, str]


@dataclass(frozen=True, kw_only=True)
class Submission:
    """A submission ready to be started."""

    id: SubmissionId
    load: Load


def load_submission(source: str, options: Mapping[str, str]) -> Submission:
    """Return the submission in a folder, or else the built-in one of that name. Its code is not run here.

    Raises:
        InputError: there is no such submission, or its submission.toml holds something unusable.
    """
    folder, options = Path(source), dict(options)
    if not (folder / "submission.toml").is_file():
        return _built_in(source, options)
    file = load_record(folder / "submission.toml", SubmissionFile)
    load = Load(folder=str(folder.resolve()), entry=file.entry, options=_absolute(options))
    return _submission(file, folder, load, options)


def _built_in(name: str, options: dict[str, str]) -> Submission:
    from adc_bench.reference import BUILT_IN

    if name not in BUILT_IN:
        raise InputError(
            where=f"submission {name}",
            found="a folder without submission.toml" if Path(name).is_dir() else "no such folder",
            wanted=f"a folder with submission.toml, or one of {', '.join(sorted(BUILT_IN))}",
            todo="name a submission's folder or a built-in one",
        )
    file = SubmissionFile(name=name, authors=("adc-bench",), kind="driver", entry="reference:built_in")
    return _submission(file, PACKAGE, Load(folder=None, entry=name, options=_absolute(options)), options)


def _submission(file: SubmissionFile, folder: Path, load: Load, options: dict[str, str]) -> Submission:
    return Submission(
        id=SubmissionId(
            name=file.name,
            authors=file.authors,
            kind=file.kind,
            sha256=digest(folder, options),
            latency_s=file.latency_s,
            options=options,
        ),
        load=load,
    )


def _absolute(options: Mapping[str, str]) -> dict[str, str]:
    """Return the options with files named by their full path: the child runs in another folder."""
    return {key: str(Path(value).resolve()) if Path(value).is_file() else value for key, value in options.items()}


def digest(folder: Path, options: Mapping[str, str]) -> str:
    """Return the sha256 over the folder's files (hidden ones and compiled Python left out) and the options' files."""
    whole = hashlib.sha256()
    for name, path in (*_files(folder), *((key, Path(v)) for key, v in sorted(options.items()) if Path(v).is_file())):
        content = path.read_bytes()
        whole.update(f"{name}\n{len(content)}\n".encode() + content)
    return whole.hexdigest()


def _files(folder: Path) -> Iterator[tuple[str, Path]]:
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        hidden = any(part.startswith(".") or part == "__pycache__" for part in name.parts)
        if path.is_file() and not hidden:
            yield name.as_posix(), path
