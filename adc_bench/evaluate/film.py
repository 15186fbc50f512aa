"""A run as a film: what the road camera saw, the robot on the course from above, its speed, and what happened.

VP9 in MP4, ten pictures a second: browsers play it, and the encoder comes with OpenCV.
"""

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Mission
from adc_bench.errors import MachineError
from adc_bench.evaluate.agent_side import AgentSide, Answered
from adc_bench.evaluate.events import Event, events_of
from adc_bench.evaluate.film_map import DRIVEN, ESTIMATE, FilmMap
from adc_bench.evaluate.log import EpisodeLog, Row
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.score import score
from adc_bench.evaluate.sensed import Sensed
from adc_bench.world.scenario import Scenario

Picture = NDArray[np.uint8]

CODEC = "vp09"
SIZE_PX = (640, 360)
EVERY_STEPS = 2
LAST_S = 1.0  # the last picture stands so long
ROAD_PX = (8, 8, 256, 192)  # left, top, width, height
MAP_PX = (272, 8, 360, 192)
CHART_PX = (8, 236, 376, 116)
TEXT_PX = (396, 222)
LINE_PX, LINES = 17, 8
GROUND, INK, FAINT, SPEED, FAULT = (24, 24, 28), (235, 235, 235), (120, 120, 126), (255, 190, 90), (70, 80, 250)
COLOURS = {"panel": (120, 220, 140), "lap": SPEED, "fault": FAULT, "end": INK}


class Camera:
    """A submission's side that keeps the road camera's pictures on their way to it."""

    def __init__(self, agent: AgentSide) -> None:
        self._agent = agent
        self.pictures: list[bytes | None] = []  # JPEG, the newest at each step; None before the first

    def wait_loaded(self) -> None:
        """Wait as the submission's side does."""
        self._agent.wait_loaded()

    def start(self, mission: Mission) -> None:
        """Tell the mission."""
        self._agent.start(mission)

    def ask(self, sensed: Sensed) -> None:
        """Keep the picture, and hand the observation over."""
        last = self.pictures[-1] if self.pictures else None
        self.pictures.append(sensed.pictures["road"][1] if "road" in sensed.pictures else last)
        self._agent.ask(sensed)

    def answer(self) -> Answered:
        """Return the submission's answer."""
        return self._agent.answer()


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """A run that is over, with the road camera's newest picture at each of its steps (JPEG; None before the first)."""

    log: EpisodeLog
    pictures: Sequence[bytes | None]
    scenario: Scenario
    rules: Rules = RULES

    def mp4(self) -> bytes:
        """Return the film; the same run gives the same bytes under the same version of OpenCV.

        Raises:
            MachineError: this OpenCV has no encoder for it.
        """
        rate_hz = 1 / (EVERY_STEPS * self.rules.control_period_s)
        with tempfile.TemporaryDirectory(prefix="adc-bench-") as folder:
            path = Path(folder, "run.mp4")
            writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*CODEC), rate_hz, SIZE_PX)
            if not writer.isOpened():
                raise MachineError(
                    where=f"OpenCV {cv2.__version__}",
                    found="no encoder for VP9 in MP4",
                    wanted="OpenCV with FFmpeg and libvpx, as its wheels have it",
                    todo="install opencv-python-headless, or leave --record out",
                )
            for picture in self.frames():
                writer.write(picture)
            for _ in range(round(LAST_S * rate_hz)):
                writer.write(picture)
            writer.release()
            return path.read_bytes()

    def frames(self) -> Iterator[Picture]:
        """Yield the film's pictures (360, 640, 3), blue first; the run's last step is the last."""
        last = len(self.log.rows) - 1
        for step in [*range(0, last, EVERY_STEPS), last]:
            yield self.frame(step)

    def frame(self, step: int) -> Picture:
        """Return the picture of a step."""
        row, canvas = self.log.rows[step], self._ground.copy()
        self._draw_road(canvas, step)
        left, top, width, height = MAP_PX
        canvas[top : top + height, left : left + width] = self._map.drawn(self.log.rows[: step + 1])
        for text, colour, line in (("driven", DRIVEN, 2), ("estimate", ESTIMATE, 1)):
            _write(canvas, text, (left, top + height - line * LINE_PX), colour)
        self._draw_chart(canvas, step)
        self._draw_text(canvas, row, over=step == len(self.log.rows) - 1)
        return canvas

    @cached_property
    def _ground(self) -> Picture:
        canvas = np.full((SIZE_PX[1], SIZE_PX[0], 3), GROUND, dtype=np.uint8)
        left, top, width, height = CHART_PX
        cv2.rectangle(canvas, (left, top), (left + width, top + height), FAINT, 1)
        for event in self._events:
            x = self._chart_x(event.time_s)
            cv2.line(canvas, (x, top + 1), (x, top + height - 1), tuple(c // 2 for c in COLOURS[event.kind]), 1)
        return canvas

    @cached_property
    def _map(self) -> FilmMap:
        return FilmMap(scenario=self.scenario, size_px=MAP_PX[2:])

    @cached_property
    def _events(self) -> tuple[Event, ...]:
        return events_of(self.log, score(self.log, self.rules))

    @cached_property
    def _curve(self) -> NDArray[np.int32]:
        """The chart's points (steps, 2): speed over time."""
        _, top, _, height = CHART_PX
        share = np.array([abs(row.v_mps) for row in self.log.rows]) / self.rules.robot.speed_max_mps
        y = top + height - 2 - np.clip(share, 0.0, 1.0) * (height - 4)
        return np.column_stack([[self._chart_x(row.time_s) for row in self.log.rows], np.round(y)]).astype(np.int32)

    def _chart_x(self, time_s: float) -> int:
        left, _, width, _ = CHART_PX
        return round(left + 1 + (width - 2) * time_s / max(self.log.rows[-1].time_s, 1e-9))

    def _draw_road(self, canvas: Picture, step: int) -> None:
        left, top, width, height = ROAD_PX
        jpeg = self.pictures[min(step, len(self.pictures) - 1)] if self.pictures else None
        if jpeg is None:  # the submission failed before the first observation
            return
        seen = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        assert seen is not None, "the renderer's pictures are whole"
        canvas[top : top + height, left : left + width] = cv2.resize(
            seen, (width, height), interpolation=cv2.INTER_AREA
        )

    def _draw_chart(self, canvas: Picture, step: int) -> None:
        left, top, _, _ = CHART_PX
        cv2.polylines(canvas, [self._curve[: step + 1]], False, SPEED, 1, cv2.LINE_AA)
        cv2.circle(canvas, self._curve[step].tolist(), 3, SPEED, -1, cv2.LINE_AA)
        speed = f"speed {self.log.rows[step].v_mps:.2f} m/s of {self.rules.robot.speed_max_mps:g}"
        _write(canvas, speed, (left, top - 8), SPEED)

    def _draw_text(self, canvas: Picture, row: Row, *, over: bool) -> None:
        header, (left, top) = self.log.header, TEXT_PX
        past = [event for event in self._events if event.time_s <= row.time_s + 1e-9]
        told = past if over else [event for event in past if event.kind != "end"]
        _write(canvas, f"{header.run.submission.name}  {header.scenario}  {row.time_s:6.2f} s", (left, top), INK)
        for line, event in enumerate(told[-LINES + 1 :], start=1):
            where = (left, top + line * LINE_PX)
            _write(canvas, f"{event.time_s:6.2f} {event.text}", where, COLOURS[event.kind])


def _write(canvas: Picture, text: str, at: tuple[int, int], colour: tuple[int, ...]) -> None:
    cv2.putText(canvas, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.40, colour, 1, cv2.LINE_AA)
