"""A store's files at an address that fsspec knows: an object store, most of the time. A file is put in one piece."""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import BinaryIO

import fsspec
from fsspec.registry import known_implementations

from adc_bench.errors import AdcBenchError, InputError, MachineError

BLOCK_BYTES = 2**20


class RemoteFiles:
    """The files below an address.

    Raises:
        InputError: fsspec knows no such kind of address.
        MachineError: its driver is not installed, or it fails in another way than a file system does.
    """

    def __init__(self, root: str) -> None:
        self._root = root.rstrip("/")
        self._owner, self._system = os.getpid(), _file_system(root)
        self._inside: str = self._system._strip_protocol(self._root)

    def path(self, name: str) -> str:
        """Return a file's full address."""
        return f"{self._root}/{name}"

    def is_empty(self) -> bool:
        """Return whether nothing lies below the address."""
        with self._told(""):
            self._fs.invalidate_cache()
            try:
                return not self._fs.ls(self._inside, detail=False)
            except FileNotFoundError:
                return True

    def size(self, name: str) -> int | None:
        """Return a file's size in bytes, None if there is no such file."""
        with self._told(name):
            self._fs.invalidate_cache()  # another machine may have written it
            try:
                entry = self._fs.info(self._full(name))
            except FileNotFoundError:
                return None
            return int(entry["size"]) if entry["type"] == "file" else None

    def sizes(self, pattern: str) -> dict[str, int]:
        """Return the files that match a pattern, without hidden ones, and their sizes."""
        with self._told(""):
            self._fs.invalidate_cache()
            found = self._fs.glob(self._full(pattern), detail=True)
        names = {path[len(self._inside) :].lstrip("/"): e["size"] for path, e in found.items() if e["type"] == "file"}
        return {name: size for name, size in names.items() if not name.split("/")[-1].startswith(".")}

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading here and there in it."""
        with self._told(name):
            stream: BinaryIO = self._fs.open(self._full(name), "rb", block_size=BLOCK_BYTES, cache_type="blockcache")
            return stream

    def read(self, name: str, start: int, end: int | None) -> bytes:
        """Return a file's bytes from `start` up to `end`."""
        with self._told(name):
            data: bytes = self._fs.cat_file(self._full(name), start=start, end=end)
            return data

    def read_many(self, names: Sequence[str]) -> list[bytes]:
        """Return the bytes of each file, asked for at once where the driver can."""
        if not names:
            return []
        with self._told(""):
            found = self._fs.cat([self._full(name) for name in names])
            return [found[self._full(name)] for name in names]

    def write(self, name: str, data: bytes) -> None:
        """Write a file."""
        self.write_many({name: data})

    def write_many(self, files: Mapping[str, bytes]) -> None:
        """Write small files, at once where the driver can."""
        with self._told(next(iter(files), "")):
            self._put(list(files), lambda: self._fs.pipe({self._full(name): data for name, data in files.items()}))

    @contextmanager
    def writing(self, name: str) -> Iterator[BinaryIO]:
        """Give a local file that is put in its place when the context ends without an error."""
        with tempfile.TemporaryDirectory() as folder:
            local = Path(folder, "file")
            with local.open("wb") as stream:
                yield stream
            with self._told(name):
                self._put([name], lambda: self._fs.put_file(str(local), self._full(name)))

    @contextmanager
    def scratch(self) -> Iterator[BinaryIO]:
        """Give a local file without a name."""
        with tempfile.TemporaryFile() as stream:
            yield stream

    def delete(self, name: str) -> None:
        """Delete a file; one that is not there is no error."""
        with self._told(name):
            if self._fs.exists(self._full(name)):
                self._fs.rm_file(self._full(name))

    def delete_folder(self, name: str) -> None:
        """Delete a folder; one that is not there is no error."""
        with self._told(name):
            self._fs.invalidate_cache()
            if self._fs.exists(self._full(name)):
                self._fs.rm(self._full(name), recursive=True)

    def sweep(self) -> None:
        """Do nothing: an object store shows no file that is half written."""

    def _put(self, names: Sequence[str], put: Callable[[], None]) -> None:
        """Put files; where the store has folders, unlike one of objects, make those that are missing."""
        try:
            put()
        except FileNotFoundError:
            # Never the first part: in a store of objects it is the bucket, and a mistyped one is not to be made.
            folders = {part for name in names for part in list(PurePosixPath(self._full(name)).parents)[:-2]}
            for folder in sorted(str(folder) for folder in folders):
                if not self._fs.isdir(folder):
                    self._fs.mkdir(folder, create_parents=False)
            put()

    def _full(self, name: str) -> str:
        return f"{self._inside}/{name}"

    @property
    def _fs(self) -> fsspec.AbstractFileSystem:
        """The driver, of this process: one that was made before a fork does not work after it."""
        if self._owner != os.getpid():
            self._owner, self._system = os.getpid(), _file_system(self._root)
        return self._system

    @contextmanager
    def _told(self, name: str) -> Iterator[None]:
        try:
            yield
        except (OSError, AdcBenchError):
            raise
        except Exception as error:  # every driver has its own family of errors
            raise MachineError(
                where=self.path(name),
                found=f"{type(error).__name__}: {error}",
                wanted="a store that answers",
                todo="check the address, the network and the credentials, then run the same command again",
            ) from None


def _file_system(root: str) -> fsspec.AbstractFileSystem:
    scheme = root.split("://")[0]
    try:
        return fsspec.core.url_to_fs(root)[0]
    except ImportError as error:
        package = known_implementations[scheme]["class"].split(".")[0]
        raise MachineError(
            where=root,
            found=f"no driver for {scheme}:// addresses ({error})",
            wanted=f"the package {package}",
            todo=f"install it: pip install {package}",
        ) from None
    except ValueError:
        raise InputError(
            where=root,
            found=f"an unknown kind of address, {scheme}://",
            wanted="a folder, or an address that fsspec knows, such as s3://bucket/folder",
            todo="choose another place",
        ) from None
