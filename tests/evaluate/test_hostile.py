"""What becomes of submissions that harm, break rules or break down: each ends in its own way, and harms nothing."""

import os
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from made_hostile import hostile_submission
from test_agent_process import MISSION, made_sensed

from adc_bench.evaluate.agent_side import AgentFailedError
from adc_bench.evaluate.ending import STATUS_OF, Ending, Reason
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.sandbox import sandbox_fault
from adc_bench.evaluate.submission import Submission

LIMITS = Limits(
    load_s=20.0,
    start_s=2.0,
    step_s=1.0,
    total_s=1.5,
    memory_bytes=384 * 2**20,
    processes=10,
    tmp_bytes=4 * 2**20,
    printed_bytes=10_000,
)
PATIENT = msgspec.structs.replace(LIMITS, step_s=60.0, total_s=120.0)
TOO_LATE = (Reason.STEP_TIMEOUT, Reason.TOTAL_TIMEOUT)
STEPS = 6
walled = pytest.mark.skipif(bool(sandbox_fault()), reason=f"no sandbox: {sandbox_fault()}")


@pytest.fixture
def hostile(tmp_path: Path) -> Callable[..., Submission]:
    def make(factory: str, target: Path = Path("/nowhere")) -> Submission:
        return hostile_submission(tmp_path / factory.lower(), factory, target)

    return make


def meet(submission: Submission, limits: Limits = PATIENT) -> tuple[Ending | None, str]:
    """Talk with a submission for some steps; return how it failed, None if it did not, and what it printed."""
    ending = None
    process = AgentProcess(submission.load, RULES.rig, limits)
    try:
        with process as agent:
            agent.wait_loaded()
            agent.start(MISSION)
            for step in range(STEPS):
                agent.ask(made_sensed(step))
                agent.answer()
    except AgentFailedError as failure:
        ending = failure.ending
    return ending, process.printed.decode(errors="replace")


@pytest.mark.parametrize(
    ("factory", "reason", "detail"),
    [
        ("Raises", Reason.STEP_RAISED, "ValueError: no way on"),
        ("SaysNan", Reason.NOT_FINITE, "v_mps=nan"),
        ("SaysInf", Reason.NOT_FINITE, "x_m=inf"),
        ("SaysHuge", Reason.OUT_OF_RANGE, "x_m=1e+300"),
        ("WrongShape", Reason.NOT_A_COMMAND, "`array` of length 9"),
        ("Sleeps", Reason.STEP_TIMEOUT, "no answer within 1 s"),
        ("BusyLoop", Reason.STEP_TIMEOUT, "no answer within 1 s"),
        ("IsAlwaysSlow", Reason.TOTAL_TIMEOUT, "thought for more than 1.5 s in all"),
        ("Exits", Reason.DIED, "exit status 3"),
        ("Segfaults", Reason.DIED, "killed by SIGSEGV"),
        ("EatsMemory", Reason.STEP_RAISED, "MemoryError"),
        ("SendsGarbage", Reason.BAD_MESSAGE, "malformed"),
        ("SendsDeepNesting", Reason.NOT_A_COMMAND, "Expected `object`, got `array`"),
        ("SendsTooMuch", Reason.BAD_MESSAGE, "a message of 2147483648 bytes; at most 65536 are taken"),
        ("SendsHalf", Reason.STEP_TIMEOUT, "no answer within 1 s"),
        ("AnswersTwice", Reason.OUT_OF_TURN, "a command for step 2 where the command for step 3 was due"),
        ("HangsUp", Reason.DIED, "it closed its connection"),
    ],
)
def test_how_it_ends(hostile: Callable[..., Submission], factory: str, reason: Reason, detail: str) -> None:
    ending, _ = meet(hostile(factory), LIMITS if reason in TOO_LATE else PATIENT)
    assert ending is not None and ending.reason is reason, ending
    assert detail in ending.detail
    assert STATUS_OF[reason] in ("agent-failed", "invalid")


@walled
@pytest.mark.parametrize(
    ("factory", "reason", "detail"),
    [
        ("ForkBomb", Reason.STEP_RAISED, "BlockingIOError"),
        ("EatsMemoryInMany", Reason.MEMORY, "its processes held more than 384 MiB"),
        ("FillsTmp", Reason.STEP_RAISED, "No space left on device"),
        ("FillsSharedMemory", Reason.STEP_RAISED, "No space left on device"),
        ("OpensSocket", Reason.STEP_RAISED, "Network is unreachable"),
        ("WritesSystem", Reason.STEP_RAISED, "Read-only file system"),
        ("ChangesItself", Reason.STEP_RAISED, "Read-only file system"),
        ("BecomesRoot", Reason.STEP_RAISED, "os.setuid(0)"),
        ("KillsAll", Reason.DIED, "killed by SIGKILL"),
    ],
)
def test_how_it_ends_behind_walls(
    hostile: Callable[..., Submission], factory: str, reason: Reason, detail: str
) -> None:
    ending, _ = meet(hostile(factory))
    assert ending is not None and ending.reason is reason, ending
    assert detail in ending.detail


def test_of_a_gigabyte_printed_little_is_kept(hostile: Callable[..., Submission]) -> None:
    ending, printed = meet(hostile("PrintsMuch"))
    assert ending is None, "printing is no fault"
    assert printed.endswith(f"\n({2**30 - 10_000} bytes more were not kept)\n")
    assert len(printed) < 10_100


@walled
def test_files_outside_are_out_of_sight(hostile: Callable[..., Submission], tmp_path: Path) -> None:
    suite = Path(__file__).parents[2] / "splits" / "suites" / "d1.toml"
    assert suite.is_file()
    ending, printed = meet(hostile("ReadsOutside", suite))
    assert ending is not None and "FileNotFoundError" in ending.detail
    assert printed == ""
    mine = tmp_path / "mine.txt"
    mine.write_text("mine")
    ending, _ = meet(hostile("WritesOutside", mine))
    assert ending is not None and ending.reason is Reason.STEP_RAISED
    assert mine.read_text() == "mine"


@walled
def test_other_processes_and_their_environments_are_out_of_sight(
    hostile: Callable[..., Submission], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ADC_BENCH_SALT", "salt of the organiser, private")
    _, printed = meet(hostile("ReadsOtherProcesses"))
    assert "organiser" not in printed
    assert "pytest" not in printed
    assert 2 <= printed.count("cmdline") + printed.count("b'") <= 8, "bwrap, and itself"
    assert str(os.getpid()) not in printed


def test_what_it_did_to_its_files_is_gone(hostile: Callable[..., Submission]) -> None:
    submission = hostile("ChangesItself")
    before = (Path(submission.load.folder or "") / "hostile.py").read_bytes()
    meet(submission)
    assert (Path(submission.load.folder or "") / "hostile.py").read_bytes() == before
