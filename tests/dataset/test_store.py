import hashlib
import importlib.util
import multiprocessing
import os
import pickle
import signal
import stat
import subprocess
import sys
import uuid
from pathlib import Path

import fsspec
import pytest

from adc_bench.dataset.store import Store
from adc_bench.errors import InputError, MachineError


@pytest.fixture(params=["folder", "file", "memory"])
def root(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """A folder, the same by its address, and a place in a store of objects."""
    name = uuid.uuid4().hex
    return {"folder": str(tmp_path / name), "file": f"file://{tmp_path}/{name}", "memory": f"memory://{name}/x"}[
        request.param
    ]


def test_what_is_written_is_read_back(root: str) -> None:
    store = Store(root)
    assert store.is_empty() and store.names() == [] and store.size("a.bin") is None and not store.exists("a.bin")
    data = os.urandom(100_000)
    store.write("a.bin", data)
    store.write("deep/er/b.txt", b"b")
    store.write_many({"deep/c.txt": b"cc", "deep/d.txt": b""})
    assert not store.is_empty() and store.exists("a.bin") and store.size("a.bin") == len(data)
    assert store.names() == ["a.bin", "deep/c.txt", "deep/d.txt", "deep/er/b.txt"]
    assert store.names("*.bin") == ["a.bin"] and store.sizes("deep/*.txt") == {"deep/c.txt": 2, "deep/d.txt": 0}
    assert store.read("a.bin") == data and store.read("a.bin", 10, 20) == data[10:20]
    assert store.read("a.bin", 99_990, 100_010) == data[99_990:]
    assert store.read_many(["deep/er/b.txt", "a.bin"]) == {"deep/er/b.txt": b"b", "a.bin": data}
    assert store.sha256("a.bin") == hashlib.sha256(data).hexdigest()
    with store.open("a.bin") as stream:
        stream.seek(50_000)
        assert stream.read(7) == data[50_000:50_007]
    store.write("a.bin", b"new")
    assert store.read("a.bin") == b"new" and store.size("a.bin") == 3
    store.delete("a.bin")
    store.delete("a.bin")
    store.delete_folder("deep")
    store.delete_folder("deep")
    assert store.names() == []
    with pytest.raises(FileNotFoundError):
        store.read("a.bin")
    with pytest.raises(FileNotFoundError):
        store.open("a.bin")


def test_a_large_file_appears_whole_or_not_at_all(root: str) -> None:
    store = Store(root)
    with store.writing("sub/big") as out:
        out.write(b"one")
        assert not store.exists("sub/big")
        out.write(b"two")
    assert store.read("sub/big") == b"onetwo" and out.size_bytes == 6
    assert out.sha256 == hashlib.sha256(b"onetwo").hexdigest()
    with pytest.raises(ZeroDivisionError), store.writing("sub/big") as out:
        out.write(b"half")
        _ = 1 / 0
    assert store.read("sub/big") == b"onetwo" and store.names() == ["sub/big"]
    assert store.path("sub/big").endswith("sub/big")


def test_a_scratch_file_leaves_nothing(root: str) -> None:
    store = Store(root)
    store.write("a", b"")
    with store.scratch() as scratch:
        scratch.write(b"some")
        scratch.seek(0)
        assert scratch.read() == b"some" and store.names() == ["a"]
    assert store.names() == ["a"]


def test_a_store_travels_to_other_processes(tmp_path: Path) -> None:
    store = Store(f"file://{tmp_path}")
    store.write("a", b"here")
    assert pickle.loads(pickle.dumps(store)).read("a") == b"here"
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(store.read, ("a",)) == b"here"


def test_what_was_half_written_is_swept_away(tmp_path: Path) -> None:
    begin = (
        "import sys, time\nfrom adc_bench.dataset.store import Store\n"
        "with Store(sys.argv[1]).writing('sub/a') as out:\n"
        "    out.write(bytes(10**6)); print(flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", begin, str(tmp_path)], stdout=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline()
    process.kill()
    process.communicate()
    store = Store(tmp_path)
    assert len(list(tmp_path.glob("sub/.a.*.tmp"))) == 1 and store.names() == []
    store.sweep()
    assert list(tmp_path.glob("sub/.*")) == []


def test_written_files_have_the_usual_rights(tmp_path: Path) -> None:
    Store(tmp_path).write("a", b"")
    (tmp_path / "b").write_bytes(b"")
    assert stat.filemode((tmp_path / "a").stat().st_mode) == stat.filemode((tmp_path / "b").stat().st_mode)


HOLD = (
    "import sys, time\nfrom adc_bench.dataset.store import Store\n"
    "with Store(sys.argv[1]).locked():\n    print(flush=True); time.sleep(60)"
)


def test_one_writer_at_a_time_and_a_dead_one_does_not_count(tmp_path: Path) -> None:
    root = tmp_path / "new"
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(root)], stdout=subprocess.PIPE)
    assert process.stdout is not None and process.stdout.readline()
    with (
        pytest.raises(InputError, match=rf"process {process.pid} on \S+ is writing to this folder"),
        Store(root).locked(),
    ):
        pass
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    with Store(root).locked():
        assert f"process {os.getpid()}" in (root / ".lock").read_text()
        with pytest.raises(InputError, match=f"process {os.getpid()}"), Store(root).locked():
            pass
    assert list(root.iterdir()) == []


def test_a_store_of_objects_needs_no_lock() -> None:
    with Store("memory://locked").locked(), Store("memory://locked").locked():
        pass


def test_a_missing_driver_is_named_with_its_package() -> None:
    if importlib.util.find_spec("s3fs"):
        pytest.skip("the driver is installed here")
    with pytest.raises(MachineError) as caught:
        Store("s3://bucket/x")
    assert caught.value.exit_code == 4
    assert caught.value.where == "s3://bucket/x" and caught.value.todo == "install it: pip install s3fs"


def test_an_unknown_kind_of_address_is_refused() -> None:
    with pytest.raises(InputError, match="an unknown kind of address, floppy://"):
        Store("floppy://a/x")


def test_a_store_that_fails_is_told_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("no credentials")

    monkeypatch.setattr(fsspec.get_filesystem_class("memory"), "pipe_file", fail)
    with pytest.raises(MachineError) as caught:
        Store("memory://broken").write("a", b"")
    assert caught.value.where == "memory://broken/a" and "no credentials" in caught.value.found


def test_a_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    with pytest.raises(InputError, match="a folder to write to"):
        Store(tmp_path / "file").write("a", b"")
    with pytest.raises(InputError, match="a folder to write to"), Store(tmp_path / "file").locked():
        pass
