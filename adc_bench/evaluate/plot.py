"""The driven paths over the course, with the estimates."""

import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adc_bench.dataset.layout import write_file
from adc_bench.evaluate.log import AnyLog, DetectionLog, EpisodeLog, LocalizationLog, Row
from adc_bench.evaluate.metrics import replayed
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.suite import rules_for
from adc_bench.geometry import Pose2
from adc_bench.world.course import Course

COLUMNS = 2


def plot_paths(all_logs: Sequence[AnyLog], path: Path, rules: Rules = RULES) -> None:
    """Write a PNG with one map a run: the true path, the submission's estimate, dead reckoning from the encoders.

    Sets of pictures have no paths: of them nothing is drawn.
    """
    from matplotlib.figure import Figure

    logs = [log for log in all_logs if not isinstance(log, DetectionLog)]
    if not logs:
        return
    columns = min(len(logs), COLUMNS)
    rows = math.ceil(len(logs) / columns)
    figure = Figure(figsize=(8.5 * columns, 4.2 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for axis, log in zip(axes, logs, strict=False):
        _draw_course(axis, Course(spec=rules_for(log.header.run.suite, rules).course))
        _draw_run(axis, log, rules)
    for axis in axes[len(logs) :]:
        axis.set_axis_off()
    picture = io.BytesIO()
    figure.savefig(picture, format="png", metadata={"Software": None})
    write_file(path, picture.getvalue())


def _draw_course(axis: Any, course: Course) -> None:
    for mark in course.paint:
        axis.fill(*np.asarray(mark.exterior.coords).T, facecolor="0.78", edgecolor="none")
        for hole in mark.interiors:  # an island's line is a ring
            axis.fill(*np.asarray(hole.coords).T, facecolor="white", edgecolor="none")
    axis.set_aspect("equal")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")


def _draw_run(axis: Any, log: EpisodeLog | LocalizationLog, rules: Rules) -> None:
    truth = _points([row.truth for row in log.rows])
    estimate = _points([row.answer.estimate for row in log.rows if row.answer])
    robot = rules_for(log.header.run.suite, rules).robot
    encoders, times_s = [row.encoders for row in log.rows], [row.time_s for row in log.rows]
    reckoned = replayed(log.header.start_pose, robot, encoders, times_s)
    axis.plot(*reckoned.T, color="tab:orange", linewidth=0.8, label="dead reckoning")
    axis.plot(*truth.T, color="tab:blue", linewidth=1.4, label="driven")
    axis.plot(*estimate.T, color="tab:red", linewidth=0.8, linestyle="--", label="estimate")
    hits = [row.truth for row in log.rows if isinstance(row, Row) and row.hits]
    axis.plot(*_points(hits).T, "kx", label="contact" if hits else None)
    axis.set_title(f"{log.header.run.submission.name} on {log.header.scenario}: {log.ending.reason}")
    axis.legend(loc="upper center", fontsize="small")


def _points(poses: Sequence[Pose2]) -> NDArray[np.float64]:
    return np.array([(pose.x_m, pose.y_m) for pose in poses], dtype=np.float64).reshape(-1, 2)
