"""A submission's process without a simulator: observations made by hand."""

import contextlib
import time
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from made_runs import MakeSubmission

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan, SeenObject
from adc_bench.errors import InputError
from adc_bench.evaluate.agent_side import AgentFailedError, Answered
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.isolation import AgentProcess
from adc_bench.evaluate.limits import Limits
from adc_bench.evaluate.protocol import Order
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.sensed import Sensed, message_of, observation_in, observation_of
from adc_bench.evaluate.shelf import ReadShelf, WrittenShelf
from adc_bench.evaluate.submission import Submission
from adc_bench.evaluate.suite import load_suite, mission_for
from adc_bench.evaluate.wire import decoded, encoded
from adc_bench.geometry import Pose2
from adc_bench.world.salt import VARIABLE

MISSION = mission_for(load_suite("dev"), latency_s=0.0, options={})


def made_sensed(step: int, laser: LaserScan | None = None, objects: tuple[SeenObject, ...] = ()) -> Sensed:
    bgr = np.full((24, 32, 3), (200, 100, 10), dtype=np.uint8)
    jpeg = cv2.imencode(".jpg", bgr)[1].tobytes()
    time_s = np.array([step * 0.05])
    return Sensed(
        step=step,
        time_s=step * 0.05,
        pictures={"road": (step * 0.05, jpeg)},
        encoders=EncoderSamples(time_s=time_s, left_ticks=np.array([step]), right_ticks=np.array([step])),
        imu=ImuSamples(time_s=time_s, yaw_rate_radps=np.zeros(1), acceleration_x_mps2=np.zeros(1)),
        laser=laser,
        objects=objects,
    )


SCAN = LaserScan(time_s=0.1, ranges_m=np.append(np.random.default_rng(1).uniform(0.06, 3.0, size=337), np.inf))
SEEN = SeenObject(category="crosswalk", instance="crosswalk", pose_robot_object=Pose2(x_m=0.65, y_m=0.4, yaw_rad=0.0))


def test_observations_pass_the_wire_to_the_last_bit(tmp_path: Path) -> None:
    sent = made_sensed(2, SCAN, (SEEN,))
    written = WrittenShelf(tmp_path / "pictures", RULES.rig)
    back = observation_in(decoded(encoded(message_of(sent, written)), Order), ReadShelf(tmp_path / "pictures"))
    direct = observation_of(sent)
    assert back.laser is not None and back.laser.ranges_m.tobytes() == SCAN.ranges_m.tobytes()
    assert (back.laser.time_s, back.objects) == (0.1, (SEEN,))
    assert np.array_equal(back.pictures["road"].rgb, direct.pictures["road"].rgb)
    for name in ("encoders", "imu"):
        pairs = zip(vars(getattr(back, name)).values(), vars(getattr(direct, name)).values(), strict=True)
        assert all(np.array_equal(a, b) and a.dtype == b.dtype for a, b in pairs)
    written.put("road", np.zeros((24, 32, 3), np.uint8))
    assert back.pictures["road"].rgb.mean() > 50, "a picture taken is the agent's own"
    written.close()


def talk(submission: Submission, rules: Rules, log: Path, steps: int = 10) -> list[Answered]:
    """Talk with a submission for some steps; `log` receives what it printed."""
    process = AgentProcess(submission.load, rules.rig, rules.limits)
    try:
        with process as agent:
            agent.wait_loaded()
            agent.start(MISSION)
            answers = []
            for step in range(steps):
                agent.ask(made_sensed(step))
                answers.append(agent.answer())
            return answers
    finally:
        log.write_bytes(process.printed)


def test_an_agent_sees_the_observation_and_one_thread(
    submission_of: MakeSubmission, hurried: Rules, tmp_path: Path
) -> None:
    answers = talk(submission_of("Tells"), hurried, tmp_path / "log", steps=3)
    last = answers[-1].answer
    assert last.pose_world_robot.x_m == pytest.approx(10, abs=3), "red"
    assert last.pose_world_robot.y_m == pytest.approx(200, abs=3), "blue"
    assert last.pose_world_robot.yaw_rad == 0.1
    assert (last.v_mps, last.omega_radps) == (2.0, 1.0)
    assert all(0 <= answer.compute_s < 1 for answer in answers)


def test_numpy_numbers_make_a_command(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    (answer,) = talk(submission_of("Straight"), hurried, tmp_path / "log", steps=1)
    assert answer.answer.v_mps == 1.5
    assert answer.answer.covariance == (1, 0, 0, 0, 1, 0, 0, 0, 1)


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
    with AgentProcess(submission_of(factory).load, hurried.rig, hurried.limits) as agent:
        agent.wait_loaded()
        with pytest.raises(AgentFailedError) as caught:
            agent.start(MISSION)
            for k in range(10):
                agent.ask(made_sensed(k))
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
    assert 'File "agents.py", line' in lines[1] and "in step" in lines[1], "no path of this machine"
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
        ("agents", "dies_when_made", "its process ended while loading (exit status 5)\n    | dying", "validate"),
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
    impatient = msgspec.structs.replace(hurried, limits=Limits(load_s=0.5))
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
    assert "submission" in told, "it runs in its own folder"


def test_nothing_outlives_the_run(submission_of: MakeSubmission, hurried: Rules, tmp_path: Path) -> None:
    talk(submission_of("LeavesAChild"), hurried, tmp_path / "log", steps=1)
    mark = (tmp_path / "log").read_text().strip()
    for _ in range(50):
        if mark not in command_lines():
            return
        time.sleep(0.05)
    raise AssertionError("its child lives on")


def command_lines() -> str:
    """Return the command lines of all processes."""
    lines = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            lines.append(path.read_text())
    return "\n".join(lines)


def test_a_submission_does_not_see_the_organiser_s_salt(
    submission_of: MakeSubmission, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "salt of the organiser, private")
    (answer,) = talk(submission_of("TellsSecrets"), Rules(), tmp_path / "log", steps=1)
    assert answer.answer.pose_world_robot.x_m == 0.0
