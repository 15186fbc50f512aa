"""The files that a submission consists of: their digest, and the copy that a run is driven with."""

import hashlib
import shutil
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from adc_bench.errors import InputError

EXECUTABLE = 0o111


def digest(folder: Path, options: Mapping[str, str], without: Collection[str] = ()) -> str:
    """Return the sha256 over the folder's files and the options' files, `without` some folders in it.

    Raises:
        InputError: there is a symbolic link among the folder's files.
    """
    whole = hashlib.sha256()
    named = ((key, Path(value)) for key, value in sorted(options.items()) if Path(value).is_file())
    for name, path in (*files_of(folder, without), *named):
        content = path.read_bytes()
        whole.update(f"{name}\n{len(content)}\n".encode() + content)
    return whole.hexdigest()


def stage(folder: Path, into: Path, options: Mapping[str, str], sha256: str) -> None:
    """Copy the submission's files, readable for every user: nothing else of the folder reaches a run.

    Raises:
        InputError: they are not those of the digest.
    """
    for name, path in files_of(folder):
        copy = into / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
        copy.chmod(0o755 if path.stat().st_mode & EXECUTABLE else 0o644)
    if digest(into, options) != sha256:
        raise InputError(
            where=str(folder),
            found="other files than when the run began",
            wanted="a submission that stays as it is while it is driven",
            todo="let nothing write there, and drive again",
        )


def files_of(folder: Path, without: Collection[str] = ()) -> Iterator[tuple[str, Path]]:
    """Yield name and path of each file, in order of name; hidden ones, compiled Python and the folders `without` are
    left out.

    Raises:
        InputError: a symbolic link is among them: it could name any file of this machine.
    """
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if name.parts[0] in without or any(part.startswith(".") or part == "__pycache__" for part in name.parts):
            continue
        if path.is_symlink():
            raise InputError(
                where=str(path),
                found="a symbolic link",
                wanted="files and folders of the submission's own",
                todo="put the file itself in its place",
            )
        if path.is_file():
            yield name.as_posix(), path
