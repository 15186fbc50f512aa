"""Where a dataset's files lie: a folder, or an address of any file system that fsspec knows (`s3://bucket/data`)."""

import errno
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from adc_bench.dataset.local_files import LocalFiles
from adc_bench.dataset.remote_files import RemoteFiles
from adc_bench.errors import AdcBenchError, InputError, MachineError

_LOCAL_SCHEMES = ("file://", "local://")
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_NO_FOLDER = (errno.EEXIST, errno.ENOTDIR)
_FORBIDDEN = (errno.EACCES, errno.EPERM, errno.EROFS)


class Writing:
    """A file being written: counts its bytes and works out their digest."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream, self._digest = stream, hashlib.sha256()
        self.size_bytes = 0

    def write(self, data: bytes) -> None:
        """Add to the file's end."""
        self._stream.write(data)
        self._digest.update(data)
        self.size_bytes += len(data)

    @property
    def sha256(self) -> str:
        """The digest of what has been written so far."""
        return self._digest.hexdigest()


class Store:
    """A folder of files, named by their paths inside it; every file is whole or absent.

    Safe to hand to forked and spawned processes: nothing stays open. Hidden files (a lock, files half written) are none
    of the store's files.

    Raises:
        InputError: fsspec knows no such kind of address.
        MachineError: the driver for this kind of address is not installed.
    """

    def __init__(self, root: Path | str) -> None:
        text = str(root)
        for scheme in _LOCAL_SCHEMES:
            text = text.removeprefix(scheme)
        self.root = text
        self._files: LocalFiles | RemoteFiles = RemoteFiles(text) if "://" in text else LocalFiles(text)

    def __reduce__(self) -> tuple[type["Store"], tuple[str]]:
        return Store, (self.root,)

    def path(self, name: str) -> str:
        """Return a file's full name, for messages."""
        return self._files.path(name)

    @property
    def is_local(self) -> bool:
        """Whether it is a folder of this machine, where reading all is cheap."""
        return isinstance(self._files, LocalFiles)

    def is_empty(self) -> bool:
        """Return whether the root is missing or holds neither files nor folders, hidden ones aside."""
        return self._files.is_empty()

    def exists(self, name: str) -> bool:
        """Return whether there is such a file."""
        return self.size(name) is not None

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes, None if there is no such file."""
        return self._files.size(name)

    def sizes(self, pattern: str = "**/*") -> dict[str, int]:
        """Return the files that match a pattern and their sizes in bytes, in order of names; one listing."""
        return dict(sorted(self._files.sizes(pattern).items()))

    def names(self, pattern: str = "**/*") -> list[str]:
        """Return the files that match a pattern, in order."""
        return list(self.sizes(pattern))

    def open(self, name: str) -> BinaryIO:
        """Return a file opened for reading; raises FileNotFoundError."""
        return self._files.open(name)

    def read(self, name: str, start: int = 0, end: int | None = None) -> bytes:
        """Return a file's bytes from `start` up to `end`; raises FileNotFoundError."""
        return self._files.read(name, start, end)

    def read_many(self, names: Sequence[str]) -> Mapping[str, bytes]:
        """Return the bytes of small files, from an object store many at a time; raises FileNotFoundError."""
        return dict(zip(names, self._files.read_many(names), strict=True))

    def sha256(self, name: str) -> str:
        """Return a file's digest; raises FileNotFoundError."""
        digest = hashlib.sha256()
        with self.open(name) as stream:
            while piece := stream.read(2**20):
                digest.update(piece)
        return digest.hexdigest()

    def write(self, name: str, data: bytes) -> None:
        """Write a file, whole or not at all.

        Raises:
            MachineError: the disk is full, writing is forbidden, or an object store does not answer.
            InputError: what is named is no folder.
        """
        with self._told(name):
            self._files.write(name, data)

    def write_many(self, files: Mapping[str, bytes]) -> None:
        """Write small files that can be made again, to an object store many at a time.

        Each is whole or absent, whenever this process is killed; a power cut may take the last ones.

        Raises:
            MachineError, InputError: as `write`.
        """
        with self._told(""):
            self._files.write_many(files)

    @contextmanager
    def writing(self, name: str) -> Iterator[Writing]:
        """Write a large file piece by piece: it appears, whole, when the context ends without an error.

        Raises:
            MachineError, InputError: as `write`.
        """
        with self._told(name), self._files.writing(name) as stream:
            yield Writing(stream)

    @contextmanager
    def scratch(self) -> Iterator[BinaryIO]:
        """Give a file without a name, to write and read again, gone when the context ends.

        Raises:
            MachineError, InputError: as `write`.
        """
        with self._told(""), self._files.scratch() as stream:
            yield stream

    def delete(self, name: str) -> None:
        """Delete a file; one that is not there is no error."""
        with self._told(name):
            self._files.delete(name)

    def delete_folder(self, name: str) -> None:
        """Delete a folder and all in it; one that is not there is no error."""
        with self._told(name):
            self._files.delete_folder(name)

    def sweep(self) -> None:
        """Delete what writers that were cut off had half written."""
        with self._told(""):
            self._files.sweep()

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Be the only writer of a local folder meanwhile; the folder is made. The kernel frees the lock of a dead one.

        Object stores have no locks and need none: a file appears in one piece, and two writers of one plan write equal
        bytes.

        Raises:
            InputError: another process writes there.
            MachineError: as `write`.
        """
        with ExitStack() as stack:
            with self._told(""):
                if isinstance(self._files, LocalFiles):
                    stack.enter_context(self._files.lock())
            yield

    @contextmanager
    def _told(self, name: str) -> Iterator[None]:
        try:
            yield
        except AdcBenchError:
            raise
        except OSError as error:
            raise _unwritable(self.path(name), error) from None


def _unwritable(where: str, error: OSError) -> AdcBenchError:
    found = (error.strerror or str(error) or type(error).__name__).lower()
    if error.errno in _FULL:
        todo = "make room and run the same command again, it resumes; or choose another folder"
        return MachineError(where=where, found=found, wanted="room for the whole file", todo=todo)
    if error.errno in _FORBIDDEN:
        todo = "choose another folder, or give yourself the right to write there"
        return MachineError(where=where, found=found, wanted="permission to write there", todo=todo)
    if error.errno in _NO_FOLDER:
        found = "a file where a folder should be"
    return InputError(where=where, found=found, wanted="a folder to write to", todo="choose another folder")
