"""A submission's process without a simulator: observations made by hand."""

import time
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from made_runs import MakeSubmission

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan, SeenObject
from adc_bench.errors import InputError
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.isolation import AgentFailedError, AgentProcess
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.submission import Submission
from adc_bench.evaluate.suite import load_suite, mission_for
from adc_bench.evaluate.wire import Answer, Sense, observation, sense
from adc_bench.geometry import Pose2
from adc_bench.world.salt import VARIABLE

MISSION = mission_for(load_suite("dev"), latency_s=0.0, options={})


def made_sense(step: int) -> Sense:
    bgr = np.full((24, 32, 3), (200, 100, 10), dtype=np.uint8)
    jpeg = cv2.imencode(".jpg", bgr)[1].tobytes()
    time_s = np.array([step * 0.05])
    encoders = EncoderSamples(time_s=time_s, left_ticks=np.array([step]), right_ticks=np.array([step]))
    imu = ImuSamples(time_s=time_s, yaw_rate_radps=np.zeros(1), acceleration_x_mps2=np.zeros(1))
    return sense(step, step * 0.05, {"road": (step * 0.05, jpeg)}, encoders, imu)


SCAN = LaserScan(time_s=0.1, ranges_m=np.random.default_rng(1).uniform(0.06, 3.0, size=338))
SEEN = SeenObject(category="crosswalk", instance="crosswalk", pose_robot_object=Pose2(x_m=0.65, y_m=0.4, yaw_rad=0.0))


def test_scan_and_objects_pass_the_wire_to_the_last_bit() -> None:
    message = msgspec.structs.replace(made_sense(2), objects=(SEEN,))
    assert observation(message).laser is None
    encoders = EncoderSamples(time_s=np.zeros(0), left_ticks=np.zeros(0, np.int64), right_ticks=np.zeros(0, np.int64))
    imu = ImuSamples(time_s=np.zeros(0), yaw_rate_radps=np.zeros(0), acceleration_x_mps2=np.zeros(0))
    sent = sense(2, 0.1, {}, encoders, imu, laser=SCAN, objects=(SEEN,))
    back = observation(msgspec.msgpack.decode(msgspec.msgpack.encode(sent), type=Sense))
    assert back.laser is not None and back.laser.time_s == 0.1
    assert back.laser.ranges_m.tobytes() == SCAN.ranges_m.tobytes()
    assert back.laser.ranges_m.dtype == np.float64
    assert back.objects == (SEEN,)


def talk(submission: Submission, rules: Rules, log: Path, steps: int = 10) -> list[Answer]:
    with AgentProcess(submission.load, log, rules) as agent:
        agent.wait_loaded()
        agent.start(MISSION)
        answers = []
        for step in range(steps):
            agent.ask(made_sense(step))
            answers.append(agent.answer())
        return answers


def test_an_agent_sees_the_observation_and_one_thread(
    submission_of: MakeSubmission, hurried: Rules, tmp_path: Path
) -> None:
    answers = talk(submission_of("Tells"), hurried, tmp_path / "log", steps=3)
    last = answers[-1].command
    assert last.pose_world_robot.x_m == pytest.approx(10, abs=3), "red"
    assert last.pose_world_robot.y_m == pytest.approx(200, abs=3), "blue"
    assert last.pose_world_robot.yaw_rad == 0.1
    assert (last.v_mps, last.omega_radps) == (2.0, 1.0)
    assert all(0 <= answer.compute_s < 1 for answer in answers)


def test_numpy_numbers_make_a_command(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    (answer,) = talk(submission_of("Straight"), hurried, tmp_path / "log", steps=1)
    assert answer.command.v_mps == 1.5
    assert answer.command.covariance == (1, 0, 0, 0, 1, 0, 0, 0, 1)


def test_what_it_prints_goes_to_its_log(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    talk(submission_of("Prints"), hurried, tmp_path / "log", steps=3)
    lines = (tmp_path / "log").read_text().splitlines()
    assert lines == ["step 0", "to stderr", "step 1", "to stderr", "step 2", "to stderr"]


@pytest.mark.parametrize(
    ("factory", "reason", "detail", "step"),
    [
        ("RaisesAtSeven", Reason.STEP_RAISED, "ValueError: seven is too much", 7),
        ("HangsAtThree", Reason.STEP_TIMEOUT, "no answer within 1 s", 3),
        ("DiesAtFour", Reason.DIED, "exit status 9", 4),
        ("NotACommand", Reason.NOT_A_COMMAND, "tuple in place of a Command", 0),
        ("TextInCommand", Reason.NOT_A_COMMAND, "Expected `float`, got `str` - at `$.command.v_mps`", 0),
        ("RaisesInStart", Reason.START_RAISED, "RuntimeError: no map today", None),
        ("HangsInStart", Reason.START_TIMEOUT, "no answer within 1 s", None),
        ("ExitsInStart", Reason.DIED, "exit status 3", None),
    ],
)
def test_how_an_agent_fails(
    submission_of: MakeSubmission,
    hurried: Rules,
    tmp_path: Path,
    factory: str,
    reason: Reason,
    detail: str,
    step: int | None,
) -> None:
    answered = 0
    begun = time.monotonic()
    with AgentProcess(submission_of(factory).load, tmp_path / "log", hurried) as agent:
        agent.wait_loaded()
        with pytest.raises(AgentFailedError) as caught:
            agent.start(MISSION)
            for k in range(10):
                agent.ask(made_sense(k))
                agent.answer()
                answered += 1
    assert caught.value.ending.reason is reason
    assert caught.value.ending.detail.endswith(detail)
    assert answered == (step or 0)
    assert time.monotonic() - begun < 15


def test_a_traceback_shows_the_submissions_own_lines(
    submission_of: MakeSubmission, hurried: Rules, tmp_path: Path
) -> None:
    with pytest.raises(AgentFailedError) as caught:
        talk(submission_of("RaisesAtSeven"), hurried, tmp_path / "log")
    lines = caught.value.ending.detail.splitlines()
    assert "agents.py" in lines[1] and "in step" in lines[1]
    assert "child.py" not in caught.value.ending.detail


@pytest.mark.parametrize(
    ("module", "factory", "found", "todo"),
    [
        ("agents", "Missing", "no function Missing in module agents", "mend the submission's code or its entry"),
        ("agents", "not_callable", "no function not_callable", "mend the submission's code or its entry"),
        ("agents", "NoStep", "NoStep without step", "mend the submission's code or its entry"),
        ("agents", "NoMethods", "NoMethods without start and step", "mend the submission's code or its entry"),
        ("agents", "raises_when_made", "OSError: no weights", "mend the submission's code"),
        ("broken", "make", "No module named 'nothing_of_this_name'", "mend the submission's code"),
        ("garbled", "make", "SyntaxError", "mend the submission's code"),
        ("absent", "make", "No module named 'absent'", "mend the submission's code"),
        ("agents", "dies_when_made", "its process ended while loading (exit status 5)", "holds what it printed"),
    ],
)
def test_a_submission_that_cannot_be_loaded_is_bad_input(
    submission_of: MakeSubmission, hurried: Rules, tmp_path: Path, module: str, factory: str, found: str, todo: str
) -> None:
    submission = submission_of(factory, module=module)
    with pytest.raises(InputError) as caught:
        talk(submission, hurried, tmp_path / "log")
    assert found in caught.value.found
    assert todo in caught.value.todo
    assert caught.value.exit_code == 3


def test_loading_has_a_budget(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    impatient = msgspec.structs.replace(hurried, load_budget_s=0.5)
    with pytest.raises(InputError) as caught:
        talk(submission_of("hangs_when_made"), impatient, tmp_path / "log")
    assert caught.value.found == "still loading after 0.5 s"


def test_the_environment_is_not_inherited(
    submission_of: MakeSubmission, hurried: Rules, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SECRET_SEED", "7")
    talk(submission_of("environment"), hurried, tmp_path / "log", steps=1)
    told = (tmp_path / "log").read_text()
    assert "SECRET_SEED" not in told
    assert "OMP_NUM_THREADS" in told
    assert "submission-environment" in told, "it runs in its own folder"


def test_nothing_outlives_the_run(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    talk(submission_of("LeavesAChild"), hurried, tmp_path / "log", steps=1)
    pid = int((tmp_path / "log").read_text())
    for _ in range(50):
        if not running(pid):
            return
        time.sleep(0.05)
    raise AssertionError("its child lives on")


def running(pid: int) -> bool:
    """Whether the process is there and no zombie."""
    status = Path(f"/proc/{pid}/status")
    return status.is_file() and "State:\tZ" not in status.read_text()


def test_a_submission_does_not_see_the_organiser_s_salt(
    submission_of: MakeSubmission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "salt of the organiser, private")
    (answer,) = talk(submission_of("TellsSecrets"), Rules(), tmp_path / "log", steps=1)
    assert answer.command.pose_world_robot.x_m == 0.0
