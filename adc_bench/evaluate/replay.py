"""One run over a recording: each observation goes to the submission, which answers before the next one comes.

Nothing waits for an answer here, so a declared latency changes nothing; it is checked all the same.
"""

from dataclasses import dataclass
from typing import Any, get_args

import msgspec

from adc_bench.api import Command, Element, Mission
from adc_bench.evaluate.agent_side import AgentSide, Answer, Load
from adc_bench.evaluate.ending import Ending, Reason
from adc_bench.evaluate.recorded_log import DetectionHeader, DetectionRow, LocalizationHeader, LocalizationRow, Located
from adc_bench.evaluate.recording import Shown, Source, drive_in, pictures_in
from adc_bench.evaluate.rules import Rules
from adc_bench.evaluate.trace import Driven, Trace, to_its_end, wait_loaded
from adc_bench.geometry import Pose2


@dataclass(frozen=True, kw_only=True)
class ReplayPlan:
    """All that fixes one run over a recording."""

    header: LocalizationHeader | DetectionHeader
    source: Source
    mission: Mission
    load: Load
    rules: Rules


def replay(plan: ReplayPlan, agent: AgentSide) -> Driven[Any]:
    """Return the run; whatever goes wrong in it ends it and nothing else. Rows that were not answered stand at its end.

    Raises:
        AdcBenchError: this machine cannot render, or the recording is damaged.
    """
    trace: Trace[Any] = Trace()
    return to_its_end(trace, lambda: _ending(plan, agent, trace))


def mission_over(
    name: str, start_pose: Pose2, lasts_s: float, *, latency_s: float, options: dict[str, str], rules: Rules
) -> Mission:
    """Return what a submission is told before a recording: it may hold anything, and nothing is to be driven."""
    return Mission(
        name=name,
        laps=0,
        elements=get_args(Element),
        time_limit_s=lasts_s,
        control_period_s=rules.control_period_s,
        latency_s=latency_s,
        start_pose=start_pose,
        course=rules.course,
        robot=rules.robot,
        rig=rules.rig,
        options=options,
    )


def _ending(plan: ReplayPlan, agent: AgentSide, trace: Trace[Any]) -> Ending:
    shown = _shown(plan)
    rows = tuple(each.row for each in shown)
    trace.unanswered = rows
    wait_loaded(trace, agent)
    agent.start(plan.mission)
    for count, each in enumerate(shown, start=1):
        trace.asked = each.sensed
        agent.ask(each.sensed)
        answered = agent.answer()
        trace.compute_s.append(answered.compute_s)
        trace.rows.append(_with_answer(each.row, answered.answer))
        trace.unanswered = rows[count:]
    return Ending(reason=Reason.FINISHED)


def _shown(plan: ReplayPlan) -> list[Shown]:
    if isinstance(plan.header, LocalizationHeader):
        return drive_in(plan.source)
    return pictures_in(plan.source, plan.rules.control_period_s)


def _with_answer(row: LocalizationRow | DetectionRow, answer: Answer) -> LocalizationRow | DetectionRow:
    if isinstance(answer, Command):
        located = Located(estimate=answer.pose_world_robot, covariance=answer.covariance)
        return msgspec.structs.replace(row, answer=located)
    return msgspec.structs.replace(row, answer=answer)
