"""Splits, suites and layouts: TOML files read into frozen records, found by name or by path."""

import tomllib
from pathlib import Path
from typing import Literal, TypeVar

import msgspec

from adc_bench.errors import InputError

Record = TypeVar("Record", bound=msgspec.Struct)
Folder = Literal["splits", "splits/suites", "splits/layouts"]
KINDS: dict[Folder, str] = {"splits": "split", "splits/suites": "suite", "splits/layouts": "layout"}


def splits_folder() -> Path:
    """Return the `splits` folder: inside the installed package, or at the root of a checkout."""
    package = Path(__file__).parents[1]
    installed = package / "splits"
    return installed if installed.is_dir() else package.parent / "splits"


def known_records(folder: Folder) -> list[str]:
    """Return the names that `find_record` knows in this folder, in order."""
    return sorted(path.stem for path in _place(folder).glob("*.toml"))


def find_record(name_or_path: str, folder: Folder) -> Path:
    """Return the TOML file of a name in the folder, or of a path (with a slash or ending in .toml).

    Raises:
        InputError: there is no such file; the known names are listed.
    """
    is_path = "/" in name_or_path or name_or_path.endswith(".toml")
    path = Path(name_or_path) if is_path else _place(folder) / f"{name_or_path}.toml"
    if path.is_file():
        return path
    kind = KINDS[folder]
    raise InputError(
        where=f"{kind} {name_or_path!r}",
        found=f"no file {name_or_path}" if is_path else "an unknown name",
        wanted=f"one of {', '.join(known_records(folder))}, or the path of a {kind} file",
        todo=f"choose a known {kind}, or write one beside them in {folder}/",
    )


def load_record(path: Path, record_type: type[Record]) -> Record:
    """Return the record that a TOML file holds.

    Raises:
        InputError: the file is missing or unreadable, or as `parse_record`.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        found = error.strerror or "an unreadable file"
        raise _unusable(str(path), record_type, found, "name a file that exists") from None
    return parse_record(data, str(path), record_type)


def parse_record(data: bytes, where: str, record_type: type[Record]) -> Record:
    """Return the record that a TOML file's bytes hold; `where` names the file in errors.

    Raises:
        InputError: it is not TOML, has an unknown key or a value of the wrong type.
    """
    try:
        return msgspec.convert(tomllib.loads(data.decode()), record_type)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise _unusable(where, record_type, f"broken TOML: {error}", "mend the file") from None
    except msgspec.ValidationError as error:
        raise _unusable(where, record_type, str(error), "mend that key") from None


def _place(folder: Folder) -> Path:
    return splits_folder().joinpath(*folder.split("/")[1:])


def _unusable(where: str, record_type: type[msgspec.Struct], found: str, todo: str) -> InputError:
    fields = ", ".join(field.encode_name for field in msgspec.structs.fields(record_type))
    return InputError(where=where, found=found, wanted=f"TOML with the keys {fields}", todo=todo)
