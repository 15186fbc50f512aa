"""Where a dataset's files lie: a folder."""

from pathlib import Path
from typing import BinaryIO


class Store:
    """A folder of files, named by their paths inside it; every file is whole or absent."""

    def __init__(self, root: Path | str) -> None:
        self.root = Path(root)

    def path(self, name: str) -> str:
        """Return a file's full name, for messages."""
        return str(self.root / name)

    def exists(self, name: str) -> bool:
        """Return whether there is such a file."""
        return (self.root / name).is_file()

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes, None if there is no such file."""
        path = self.root / name
        return path.stat().st_size if path.is_file() else None

    def names(self, pattern: str = "**/*") -> list[str]:
        """Return the files that match a pattern, in order."""
        return sorted(str(path.relative_to(self.root)) for path in self.root.glob(pattern) if path.is_file())

    def open(self, name: str) -> BinaryIO:
        """Return a file opened for reading; raises FileNotFoundError."""
        return (self.root / name).open("rb")

    def read(self, name: str, start: int = 0, end: int | None = None) -> bytes:
        """Return a file's bytes from `start` up to `end`; raises FileNotFoundError."""
        with self.open(name) as stream:
            stream.seek(start)
            return stream.read() if end is None else stream.read(end - start)

    def write(self, name: str, data: bytes) -> None:
        """Write a file: under a temporary name, then renamed."""
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_name(path.name + ".tmp")
        temporary.write_bytes(data)
        temporary.replace(path)

    def delete(self, name: str) -> None:
        """Delete a file; one that is not there is no error."""
        (self.root / name).unlink(missing_ok=True)
