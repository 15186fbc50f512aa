"""A dataset at an S3 address is equal, byte for byte, to one in a folder: rendered, killed, resumed, damaged, read.

`sh scripts/outside.sh` installs the server (moto) and fsspec's driver (s3fs) in an environment of its own.
"""

import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from adc_bench.dataset import FrameDataset, load_split
from adc_bench.generate import render_split

ROOT = Path(__file__).parents[2]
PEER = ROOT / ".peers" / "s3" / "bin"
ADDRESS = "s3://bucket/data/val"
RENDER = ["render", "--split", "val", "--frames", "24", "--size", "160x120", "--frames-per-shard", "4"]
COMMAND = "from adc_bench.cli.main import main; main()"
LIST = """
from adc_bench.dataset.store import Store
for name in Store("s3://bucket/data/val").names():
    print(name, Store("s3://bucket/data/val").sha256(name))
"""
READ = """
import hashlib
from adc_bench.dataset import FrameDataset
dataset = FrameDataset("s3://bucket/data/val")
for i in range(len(dataset)):
    print(hashlib.sha256(dataset.jpeg(i)).hexdigest(), len(dataset.annotations(i)))
"""

pytestmark = pytest.mark.slow


class Peer:
    """Runs Python against the server, with the driver at hand."""

    def __init__(self, port: int) -> None:
        self.environment = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "FSSPEC_S3_ENDPOINT_URL": f"http://127.0.0.1:{port}",
            "AWS_ACCESS_KEY_ID": "any",
            "AWS_SECRET_ACCESS_KEY": "any",
            "AWS_DEFAULT_REGION": "us-east-1",
        }

    def start(self, code: str, *words: str) -> subprocess.Popen[str]:
        command = [str(PEER / "python"), "-c", code, *words]
        return subprocess.Popen(
            command,
            env=self.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )

    def run(self, code: str, *words: str, exit_code: int = 0) -> str:
        """Return what was printed: on stdout after success, on stderr otherwise."""
        process = self.start(code, *words)
        out, err = process.communicate(timeout=200)
        assert process.returncode == exit_code, err
        return err if exit_code else out


@pytest.fixture(scope="module")
def peer() -> Iterator[Peer]:
    if not (PEER / "moto_server").exists():
        pytest.skip("no .peers/s3: sh scripts/outside.sh makes it")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen(
        [str(PEER / "moto_server"), "-H", "127.0.0.1", "-p", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        _wait_for(port)
        found = Peer(port)
        found.run("import s3fs; s3fs.S3FileSystem().mkdir('bucket')")
        yield found
    finally:
        server.kill()
        server.wait()


def _wait_for(port: int) -> None:
    for _ in range(300):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError(f"no server on port {port}")


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> FrameDataset:
    root = tmp_path_factory.mktemp("object_store") / "val"
    render_split(load_split("val"), root, count=24, size_px=(160, 120), frames_per_shard=4)
    return FrameDataset(root)


def test_killed_resumed_damaged_and_read(peer: Peer, local: FrameDataset) -> None:
    wanted = {name: local.store.sha256(name) for name in local.store.names()}
    process = peer.start(COMMAND, *RENDER, "--workers", "1", "--out", ADDRESS)
    while "shard-00001.h5" not in peer.run(LIST):
        assert process.poll() is None, process.communicate()
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    peer.run(COMMAND, *RENDER, "--workers", "2", "--out", ADDRESS)
    assert dict(line.split() for line in peer.run(LIST).splitlines()) == wanted
    peer.run(COMMAND, "dataset", "check", ADDRESS)
    lines = [line.split() for line in peer.run(READ).splitlines()]
    assert [int(labels) for _, labels in lines] == [len(local.annotations(i)) for i in range(24)]

    damage = "from adc_bench.dataset.store import Store\n" + f"store = Store({ADDRESS!r})\n"
    peer.run(damage + "store.delete('shard-00003.h5'); store.write('shard-00001.h5', b'short')")
    told = peer.run(COMMAND, "dataset", "check", ADDRESS, exit_code=3)
    assert f"{ADDRESS}/shard-00001.h5" in told and "a truncated file of 5 bytes" in told
    peer.run(COMMAND, *RENDER, "--workers", "2", "--out", ADDRESS)
    assert dict(line.split() for line in peer.run(LIST).splitlines()) == wanted
    told = peer.run(COMMAND, *RENDER, "--frames", "25", "--out", ADDRESS, exit_code=3)
    assert "a dataset of another run: count = 24" in told


def test_a_mistyped_bucket_is_told_and_not_made(peer: Peer) -> None:
    told = peer.run(COMMAND, *RENDER, "--workers", "1", "--out", "s3://buckett/val", exit_code=3)
    assert "s3://buckett/val/dataset.toml" in told and "bucket does not exist" in told
    assert peer.run("import s3fs; print(s3fs.S3FileSystem().ls(''))").strip() == "['bucket']"


def test_a_server_that_is_gone_is_told(peer: Peer) -> None:
    gone = Peer(1)
    gone.environment["AWS_MAX_ATTEMPTS"] = "1"
    told = gone.run(COMMAND, "dataset", "check", ADDRESS, exit_code=4)
    assert "a store that answers" in told and "Could not connect" in told
