"""The protocol as others read it: its published schema, and a program that is not Python."""

import json
import shutil
import subprocess
from pathlib import Path

import jsonschema
import msgspec
import pytest
from test_agent_process import MISSION, SCAN, SEEN, made_sensed, talk

from adc_bench.api import Command, Detection
from adc_bench.errors import InputError
from adc_bench.evaluate.agent_side import AgentFailedError
from adc_bench.evaluate.ending import Reason
from adc_bench.evaluate.protocol import (
    Fault,
    Hello,
    Message,
    MissionMessage,
    Ready,
    answer_message,
    command_message,
    schema,
)
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.sensed import message_of
from adc_bench.evaluate.shelf import WrittenShelf
from adc_bench.evaluate.submission import Submission, load_submission
from adc_bench.evaluate.wire import encoded
from adc_bench.geometry import Pose2

ROOT = Path(__file__).parents[2]
POSE = Pose2(x_m=1.0, y_m=2.0, yaw_rad=0.5)


def test_the_published_schema_is_the_protocol_s() -> None:
    wanted = "python -c 'from adc_bench.evaluate.protocol import schema; print(schema().decode(), end=\"\")'"
    path = ROOT / "docs" / "protocol.schema.json"
    assert path.read_bytes() == schema(), f"write it again: {wanted} >docs/protocol.schema.json"


def test_messages_on_the_wire_are_what_the_schema_says(tmp_path: Path) -> None:
    shelf = WrittenShelf(tmp_path / "pictures", RULES.rig)
    command = Command(v_mps=1.0, omega_radps=0.0, pose_world_robot=POSE, covariance=(1.0,) * 9)
    corners = ((1.0, 2.0), (3.0, 2.0), (3.0, 4.0), (1.0, 4.0))
    detection = Detection(category="panel_up", score=0.5, box_px=(1.0, 2.0, 3.0, 4.0), corners_px=corners)
    without = msgspec.structs.replace(detection, corners_px=None)
    messages: list[tuple[str, Message]] = [
        ("to_submission", MissionMessage(mission=MISSION)),
        ("to_submission", message_of(made_sensed(3, SCAN, (SEEN,)), shelf)),
        ("from_submission", Hello(protocol=1)),
        ("from_submission", Ready()),
        ("from_submission", command_message(3, command)),
        (
            "from_submission",
            answer_message("detector", 3, [detection, without]),
        ),
        ("from_submission", Fault(found="no map")),
    ]
    shelf.close()
    whole = json.loads(schema())
    for direction, message in messages:
        plain = msgspec.msgpack.decode(encoded(message))
        one_way = {"$defs": whole["$defs"], "$ref": f"#/$defs/{direction}"}
        jsonschema.validate(json.loads(json.dumps(plain).replace("Infinity", "3.0")), one_way)
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**plain, "type": "other"}, one_way)


@pytest.fixture(scope="session")
def cpp_driver(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not (shutil.which("g++") and shutil.which("make")):
        pytest.skip("no g++ and make")
    folder = tmp_path_factory.mktemp("cpp") / "cpp_driver"
    shutil.copytree(ROOT / "examples" / "cpp_driver", folder, ignore=shutil.ignore_patterns("driver"))
    subprocess.run(["make", "-s", "-C", str(folder)], check=True)
    return folder


def test_a_program_in_cpp_drives(cpp_driver: Path, tmp_path: Path) -> None:
    answers = talk(load_submission(str(cpp_driver), {}), RULES, tmp_path / "log", steps=5)
    turn = 2 * 3.141592653589793 * RULES.robot.wheel_radius_m / RULES.robot.encoder_ticks_per_turn
    for step, answer in enumerate(answers):
        moved_m = step * turn  # each step one tick more on both wheels
        assert answer.answer.pose_world_robot.x_m == pytest.approx(MISSION.start_pose.x_m + moved_m)
        assert answer.answer.v_mps == 0.0, "no panel was seen yet"


def command_submission(folder: Path, script: str) -> Submission:
    (folder / "drive.sh").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "drive.sh").chmod(0o755)
    text = 'name = "shell"\nauthors = ["someone"]\nkind = "driver"\ncommand = ["./drive.sh", "word"]\n'
    (folder / "submission.toml").write_text(text)
    return load_submission(str(folder), {})


SAY = """exec /usr/bin/env python3 -c '
import os, socket, struct, sys, time
end = socket.socket(socket.AF_UNIX)
end.connect(os.environ["ADC_BENCH_SOCKET"])
def say(body): end.sendall(struct.pack("!I", len(body)) + body)
{}
time.sleep(60)
'"""
HELLO = 'say(b"\\x82\\xa4type\\xa5hello\\xa8protocol\\x01")'


@pytest.mark.parametrize(
    ("script", "found"),
    [
        ("echo no way >&2; exit 7", "its process ended while loading (exit status 7)\n    | no way"),
        ("exec ./nothing-here", "its process ended while loading (exit status 127)"),
        (SAY.format('say(b"\\x82\\xa4type\\xa5hello\\xa8protocol\\x02")'), "protocol 2, where hello with protocol 1"),
        (SAY.format('say(b"\\x81\\xa4type\\xa5ready")'), "a ready at first, where hello with protocol 1"),
        (SAY.format('say(b"\\xc1")'), "a message that is none: MessagePack data is malformed"),
        (SAY.format('say(b"\\x82\\xa4type\\xa5fault\\xa5found\\xa6no map")'), "no map"),
        ("sleep 60", "still loading after 3 s"),
    ],
)
def test_a_command_that_does_not_speak_it_is_bad_input(tmp_path: Path, hurried: Rules, script: str, found: str) -> None:
    limits = msgspec.structs.replace(hurried.limits, load_s=3.0)
    rules = msgspec.structs.replace(hurried, limits=limits)
    with pytest.raises(InputError) as caught:
        talk(command_submission(tmp_path, script), rules, tmp_path / "log")
    assert found in caught.value.found
    assert caught.value.where == "submission entry ./drive.sh word"


def test_a_command_that_answers_the_mission_with_something_else(tmp_path: Path, hurried: Rules) -> None:
    script = SAY.format(f"{HELLO}\n{HELLO}")
    with pytest.raises(AgentFailedError) as caught:
        talk(command_submission(tmp_path, script), hurried, tmp_path / "log")
    assert caught.value.ending.reason is Reason.OUT_OF_TURN
    assert caught.value.ending.detail == "a hello where ready was due"
