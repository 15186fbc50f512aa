"""A localiser's score over a recorded drive: a pure function of its log."""

from collections.abc import Sequence
from itertools import pairwise

import msgspec
import numpy as np

from adc_bench.dataset.drive_recipe import Behaviour, MissionName
from adc_bench.evaluate.ending import FAILED, Reason, Status
from adc_bench.evaluate.log import LocalizationLog
from adc_bench.evaluate.metrics import Localization, localization, pose_array, replayed
from adc_bench.evaluate.recorded_log import LocalizationRow, Located
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.suite import rules_for


class LocalizationEpisode(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="localizer"
):
    """The score of one recorded drive. One that `failed` has the errors of who never left the start pose."""

    scenario: str
    seed: int
    light_level: str
    mission: MissionName
    behaviour: Behaviour
    status: Status
    reason: Reason
    sim_time_s: float
    distance_m: float
    localization: Localization | None  # none if this machine failed before the first answer

    @property
    def failed(self) -> bool:
        """Whether the submission broke as a program."""
        return self.status in FAILED


def score_localization(log: LocalizationLog, rules: Rules = RULES) -> LocalizationEpisode:
    """Return the score of a run."""
    header, rows = log.header, log.rows
    return LocalizationEpisode(
        scenario=header.scenario,
        seed=header.seed,
        light_level=header.look.light_level,
        mission=header.mission,
        behaviour=header.behaviour,
        status=log.ending.status,
        reason=log.ending.reason,
        sim_time_s=rows[-1].time_s if rows else 0.0,
        distance_m=_way_m(rows),
        localization=_localization(log, rules),
    )


def _way_m(rows: Sequence[LocalizationRow]) -> float:
    """Return how far the robot came, there and back added up."""
    return sum(float(np.hypot(b.truth.x_m - a.truth.x_m, b.truth.y_m - a.truth.y_m)) for a, b in pairwise(rows))


def _localization(log: LocalizationLog, rules: Rules) -> Localization | None:
    robot, start = rules_for(log.header.run.suite, rules).robot, log.header.start_pose
    answers = [Located(estimate=start) if log.ending.status in FAILED else row.answer for row in log.rows]
    given = [answer for answer in answers if answer is not None]
    if not given:
        return None
    covariances = [answer.covariance for answer in given]
    complete = all(covariance is not None for covariance in covariances)
    answered = [row for row, answer in zip(log.rows, answers, strict=True) if answer is not None]
    return localization(
        truth=pose_array([row.truth for row in answered]),
        estimate=pose_array([answer.estimate for answer in given]),
        covariance=np.array(covariances, dtype=np.float64).reshape(-1, 3, 3) if complete else None,
        reckoned=replayed(start, robot, [row.encoders for row in log.rows], [row.time_s for row in answered]),
    )
