"""The command line's frame: exit codes, error blocks, help that loads nothing heavy."""

import errno
import os
import subprocess
import sys

import pytest
import typer

from adc_bench import __version__
from adc_bench.cli.main import main
from adc_bench.errors import AdcBenchError, InputError, MachineError, UsageError

BLOCK = """error: {headline}
  where:      a place
  found:      one thing
  wanted:     another
  what to do: change it
"""


def commands_that_raise(error: BaseException) -> typer.Typer:
    commands = typer.Typer(pretty_exceptions_enable=False, rich_markup_mode=None)

    @commands.command()
    def fail() -> None:
        raise error

    return commands


def exit_code(*words: str, commands: typer.Typer | None = None) -> object:
    with pytest.raises(SystemExit) as exit_info:
        main(words, commands) if commands else main(words)
    return exit_info.value.code or 0


@pytest.mark.parametrize(
    ("kind", "code", "headline"),
    [
        (AdcBenchError, 1, "adc-bench failed"),
        (UsageError, 2, "wrong usage"),
        (InputError, 3, "bad input"),
        (MachineError, 4, "this machine lacks something"),
    ],
)
def test_an_error_is_one_block_with_its_exit_code(
    kind: type[AdcBenchError], code: int, headline: str, capsys: pytest.CaptureFixture[str]
) -> None:
    error = kind(where="a place", found="one thing", wanted="another", todo="change it")
    assert exit_code(commands=commands_that_raise(error)) == code
    assert capsys.readouterr() == ("", BLOCK.format(headline=headline))


def test_a_fault_of_ours_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(commands=commands_that_raise(ValueError("no"))) == 1
    assert capsys.readouterr().err == "error: ValueError: no (a fault of adc-bench; --debug shows where)\n"


def test_debug_shows_the_traceback_wherever_it_stands(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("--debug", commands=commands_that_raise(ValueError("no"))) == 1
    text = capsys.readouterr().err
    assert "Traceback (most recent call last)" in text
    assert "in fail" in text


def test_a_full_disk_is_the_machines_lack(capsys: pytest.CaptureFixture[str]) -> None:
    full = OSError(errno.ENOSPC, "No space left on device", "out/shard-00000.h5")
    assert exit_code(commands=commands_that_raise(full)) == 4
    assert "found:      no space left on device" in capsys.readouterr().err


def test_ctrl_c_is_quiet(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(commands=commands_that_raise(KeyboardInterrupt())) == 130
    assert capsys.readouterr() == ("", "")


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("--version") == 0
    assert capsys.readouterr().out == f"adc-bench {__version__}\n"


@pytest.mark.parametrize("words", [["no-such-command"], ["render", "--no-such-option"], ["render"]])
def test_wrong_usage_exits_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*words) == 2
    assert "Error: " in capsys.readouterr().err


COMMANDS = (
    "doctor",
    "render",
    "dataset check",
    "dataset stats",
    "dataset preview",
    "train-detector",
    "evaluate detector",
    "evaluate submission",
    "hide",
    "rescore",
    "leaderboard export",
)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*command.split(), "--help") == 0
    assert "Usage: adc-bench" in capsys.readouterr().out


def test_the_command_line_loads_nothing_heavy() -> None:
    heavy = {"numpy", "torch", "sapien", "cv2", "h5py", "matplotlib", "rich"}
    code = f"import adc_bench.cli.main, sys; print(sorted({heavy!r} & set(sys.modules)))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout == "[]\n"


@pytest.mark.parametrize(("given", "threads"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "2"}, "2")])
def test_linear_algebra_has_one_thread_unless_it_was_given_more(given: dict[str, str], threads: str) -> None:
    code = (
        "import atexit, os\n"
        "from adc_bench.cli.main import main\n"
        "def told():\n"
        "    import numpy\n"
        "    print(os.environ['OPENBLAS_NUM_THREADS'], len(os.listdir('/proc/self/task')))\n"
        "atexit.register(told)\n"
        "main(['--version'])"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"} | given
    said = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    set_to, running = said.stdout.split()[-2:]
    assert set_to == threads and int(running) <= int(threads)
