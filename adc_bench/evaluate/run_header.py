"""Which run a log is of."""

from typing import Literal

import msgspec

from adc_bench.evaluate.submission import SubmissionId
from adc_bench.evaluate.suite import AnySuite, RulesId


class RunId(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the runs of one result folder share."""

    schema: Literal["adc-bench-episode-3"] = "adc-bench-episode-3"
    suite: AnySuite
    rules: RulesId
    submission: SubmissionId
    software: dict[str, str]


class RunHeader(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    """What the first line of every log says."""

    run: RunId
    scenario: str
    seed: int
