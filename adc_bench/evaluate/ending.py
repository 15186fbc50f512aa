"""The ways a run can end."""

from collections.abc import Mapping
from enum import StrEnum
from typing import Literal

import msgspec

Status = Literal["success", "timeout", "agent-failed", "invalid", "simulator-error", "host-error", "aborted"]
FAILED: tuple[Status, ...] = ("agent-failed", "invalid")  # the submission broke as a program


class Reason(StrEnum):
    """Every way a run can end."""

    FINISHED = "finished"
    OFF_ROAD = "off-road"
    TIME_LIMIT = "time-limit"
    BLOCKED = "blocked"
    LOAD_FAILED = "load-failed"
    START_RAISED = "start-raised"
    START_TIMEOUT = "start-timeout"
    STEP_RAISED = "step-raised"
    STEP_TIMEOUT = "step-timeout"
    TOTAL_TIMEOUT = "total-timeout"
    MEMORY = "memory"
    DIED = "died"
    NOT_A_COMMAND = "not-a-command"
    NOT_DETECTIONS = "not-detections"
    NOT_FINITE = "not-finite"
    OUT_OF_RANGE = "out-of-range"
    BAD_MESSAGE = "bad-message"
    OUT_OF_TURN = "out-of-turn"
    PHYSICS = "physics"
    SIMULATOR = "simulator"
    HOST = "host"


# `success` says that the run came to an end that belongs to driving, leaving the road included; how far it got is
# the completion's to say. `agent-failed` and `invalid` are faults of the submission as a program.
STATUS_OF: Mapping[Reason, Status] = {
    Reason.FINISHED: "success",
    Reason.OFF_ROAD: "success",
    Reason.TIME_LIMIT: "timeout",
    Reason.BLOCKED: "timeout",
    Reason.LOAD_FAILED: "agent-failed",
    Reason.START_RAISED: "agent-failed",
    Reason.START_TIMEOUT: "agent-failed",
    Reason.STEP_RAISED: "agent-failed",
    Reason.STEP_TIMEOUT: "agent-failed",
    Reason.TOTAL_TIMEOUT: "agent-failed",
    Reason.MEMORY: "agent-failed",
    Reason.DIED: "agent-failed",
    Reason.NOT_A_COMMAND: "invalid",
    Reason.NOT_DETECTIONS: "invalid",
    Reason.NOT_FINITE: "invalid",
    Reason.OUT_OF_RANGE: "invalid",
    Reason.BAD_MESSAGE: "invalid",
    Reason.OUT_OF_TURN: "invalid",
    Reason.PHYSICS: "simulator-error",
    Reason.SIMULATOR: "simulator-error",
    Reason.HOST: "host-error",
}


class Ending(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a run ended; `detail` holds the last lines of a traceback where there is one."""

    reason: Reason
    detail: str = ""

    @property
    def status(self) -> Status:
        """The status that goes with the reason."""
        return STATUS_OF[self.reason]
