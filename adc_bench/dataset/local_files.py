"""A store's files in a folder of this machine: written under a temporary name, made safe on the disk, then renamed."""

import fcntl
import os
import shutil
import socket
import tempfile
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from adc_bench.errors import InputError

LOCK = ".lock"


class LocalFiles:
    """The files below a folder. Raises OSError."""

    def __init__(self, root: str) -> None:
        self._root = Path(root)

    def path(self, name: str) -> str:
        """Return a file's full name."""
        return str(self._root / name)

    def is_empty(self) -> bool:
        """Return whether the folder is missing or holds nothing but hidden files."""
        return not self._root.is_dir() or all(path.name.startswith(".") for path in self._root.iterdir())

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes, None if there is no such file."""
        path = self._root / name
        return path.stat().st_size if path.is_file() else None

    def sizes(self, pattern: str) -> dict[str, int]:
        """Return the files that match a pattern, without hidden ones, and their sizes."""
        found = [path for path in self._root.glob(pattern) if not path.name.startswith(".") and path.is_file()]
        return {path.relative_to(self._root).as_posix(): path.stat().st_size for path in found}

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading."""
        return (self._root / name).open("rb")

    def read(self, name: str, start: int, end: int | None) -> bytes:
        """Return a file's bytes from `start` up to `end`."""
        # One open, read and close a picture: no descriptor is kept that a fork or a thread could share.
        descriptor = os.open(f"{self._root}/{name}", os.O_RDONLY | os.O_CLOEXEC)
        try:
            until = os.fstat(descriptor).st_size if end is None else end
            return _read(descriptor, start, until)
        finally:
            os.close(descriptor)

    def read_many(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of each file."""
        return [self.read(name, 0, None) for name in names]

    def write(self, name: str, data: bytes) -> None:
        """Write a file."""
        with self.writing(name) as stream:
            stream.write(data)

    def write_many(self, files: Mapping[str, bytes]) -> None:
        """Write small files without waiting for the disk."""
        for name, data in files.items():
            with _appearing(self._root / name) as stream:
                stream.write(data)

    @contextmanager
    def writing(self, name: str) -> Iterator[BinaryIO]:
        """Give a file that gets its name when the context ends without an error."""
        path = self._root / name
        with _appearing(path) as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        _sync_folder(path.parent)

    @contextmanager
    def scratch(self) -> Iterator[BinaryIO]:
        """Give a file without a name on the folder's own disk: the system's place for them may be memory."""
        with tempfile.TemporaryFile(dir=self._root) as stream:
            yield stream

    def delete(self, name: str) -> None:
        """Delete a file; one that is not there is no error."""
        (self._root / name).unlink(missing_ok=True)

    def delete_folder(self, name: str) -> None:
        """Delete a folder; one that is not there is no error."""
        if (self._root / name).is_dir():
            shutil.rmtree(self._root / name)

    def sweep(self) -> None:
        """Delete files half written."""
        for path in self._root.glob("**/*.tmp"):
            path.unlink(missing_ok=True)

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Hold the folder's lock: a kernel lock on a file that names its owner and goes with it.

        Raises:
            InputError: another process holds it.
        """
        self._root.mkdir(parents=True, exist_ok=True)
        descriptor = _locked(self._root)
        try:
            os.ftruncate(descriptor, 0)
            os.pwrite(descriptor, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
            yield
        finally:
            self.delete(LOCK)
            os.close(descriptor)


@contextmanager
def _appearing(path: Path) -> Iterator[BinaryIO]:
    """Give a file under a temporary name, renamed when the context ends without an error and deleted otherwise."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{uuid.uuid4().hex}.tmp")
    try:
        with temporary.open("wb") as stream:
            yield stream
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def _locked(root: Path) -> int:
    """Return the descriptor of the lock file, locked."""
    path = root / LOCK
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.pread(descriptor, 200, 0).decode(errors="replace") or "another process"
            os.close(descriptor)
            raise _in_use(root, owner) from None
        except OSError:
            return (
                descriptor  # a file system without locks: files still appear whole, and equal plans write equal bytes
            )
        # Whoever held the lock before may have deleted the file between the two calls: then the lock is on nothing.
        if path.exists() and os.path.samestat(path.stat(), os.fstat(descriptor)):
            return descriptor
        os.close(descriptor)


def _in_use(root: Path, owner: str) -> InputError:
    return InputError(
        where=str(root),
        found=f"{owner} is writing to this folder",
        wanted="one writer at a time",
        todo="wait until it has ended, or choose another folder",
    )


def _read(descriptor: int, start: int, end: int) -> bytes:
    """Return the bytes between two positions, fewer where the file ends before."""
    data = os.pread(descriptor, end - start, start)
    while data and len(data) < end - start:  # the kernel reads at most 2 GiB at once
        more = os.pread(descriptor, end - start - len(data), start + len(data))
        if not more:
            break
        data += more
    return data


def _sync_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
