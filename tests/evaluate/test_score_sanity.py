"""What every score obeys: faults never pay, estimates do not drive, and the rules' digest covers each figure."""

from collections.abc import Callable, Iterator
from functools import cache

import msgspec
import numpy as np
import pytest
from made_runs import PERIOD_S, PoseAt, along, header_of, log_of

from adc_bench.evaluate.faults import FaultKind, Price
from adc_bench.evaluate.log import EpisodeLog, Header, Hit
from adc_bench.evaluate.rules import RULES, Rules
from adc_bench.evaluate.score import score
from adc_bench.evaluate.suite import load_suite, rules_id
from adc_bench.geometry import Pose2
from adc_bench.world.layout import Layout, Works

SPEED_MPS = 2.0


def to_and_fro(header: Header) -> PoseAt:
    """Return the lap's poses, with two metres back on the way."""
    there, turn_s = along(header, SPEED_MPS), header.start_step * PERIOD_S + 12.0

    def pose(time_s: float) -> Pose2:
        if time_s >= turn_s + 1.0:
            return there(time_s - 2.0)
        return there(min(time_s, 2 * turn_s - time_s))

    return pose


def aside(left_m: Callable[[float], float]) -> Callable[[Header], PoseAt]:
    return lambda header: along(header, SPEED_MPS, left_m=left_m)


def straight(header: Header) -> PoseAt:
    return along(header, SPEED_MPS)


# By fault: the suite, and how it is driven there. Those of vertical signs, turns and stops are in test_rules_page.py.
FAULTY: dict[FaultKind, tuple[str, Callable[[Header], PoseAt]]] = {
    FaultKind.LINE_TOUCH: ("dev", aside(lambda s_m: -0.2 if 8.0 < s_m < 9.0 else 0.0)),
    FaultKind.OFF_ROAD: ("dev", aside(lambda s_m: -max(0.0, s_m - 30.0) / 2)),
    FaultKind.FALSE_START: ("dev", lambda header: along(header, SPEED_MPS, wait_s=-0.2)),
    FaultKind.STOP_PASSED: ("dev-d2", straight),
    FaultKind.STOP_OUTSIDE_ZONE: ("dev-d2", lambda header: along(header, SPEED_MPS, halts={19.0: 3.0})),
    FaultKind.WRONG_WAY: ("dev", to_and_fro),
    FaultKind.WRONG_LANE: ("dev", aside(lambda s_m: 0.775 if 7.0 < s_m < 15.0 else 0.0)),
    FaultKind.WORKS_MISSED: ("dev", straight),
    FaultKind.COLLISION: ("dev", straight),
}
BESIDE = Works(left=((2.0, -3.2), (4.0, -3.2)), right=((2.0, -4.2), (4.0, -4.2)))  # a way beside the +x loop's leg
HITS = (Hit(time_s=9.0, with_name="box_0", impulse_ns=1.0),)


@cache
def faulty(kind: FaultKind) -> EpisodeLog:
    suite, drive = FAULTY[kind]
    header = header_of(load_suite(suite))
    if kind is FaultKind.WORKS_MISSED:
        header = msgspec.structs.replace(header, layout=Layout(works=BESIDE))
    return log_of(header, drive(header), hits=HITS if kind is FaultKind.COLLISION else ())


@pytest.mark.parametrize("kind", FAULTY)
def test_each_fault_costs_and_costs_more_when_it_is_dearer(kind: FaultKind) -> None:
    log = faulty(kind)
    before = score(log)
    times = sum(fault.kind is kind for fault in before.faults)
    assert times, [fault.kind for fault in before.faults]
    for points, factor in ((0.0, 1.0), (0.5, 0.9), (1.0, 0.5)):
        prices = msgspec.structs.replace(RULES.prices, **{kind.value: Price(points=points, factor=factor)})
        found = score(log, msgspec.structs.replace(RULES, prices=prices))
        if points == 0.0:
            free = found
        assert found.points == pytest.approx(max(free.points - times * points, 0.0))
        assert found.driving_score == pytest.approx(free.driving_score * factor**times)
    assert before.points <= free.points and before.driving_score < free.driving_score


def with_estimates(log: EpisodeLog, estimate: Callable[[int, Pose2], Pose2]) -> EpisodeLog:
    rows = [
        msgspec.structs.replace(
            row, answer=row.answer and msgspec.structs.replace(row.answer, estimate=estimate(row.step, row.truth))
        )
        for row in log.rows
    ]
    return msgspec.structs.replace(log, rows=tuple(rows))


def test_estimates_that_leap_change_nothing_but_their_own_errors() -> None:
    """A submission that says it has finished, or is everywhere at once, earns what it drove."""
    log, rng = faulty(FaultKind.LINE_TOUCH), np.random.default_rng(1)
    everywhere = rng.uniform((-9.0, -4.0, -3.0), (9.0, 4.0, 3.0), size=(len(log.rows), 3)).tolist()
    finish = Pose2(x_m=1.0, y_m=-2.6125, yaw_rad=0.0)
    told: dict[str, Callable[[int, Pose2], Pose2]] = {
        "true": lambda step, truth: truth,
        "everywhere": lambda step, truth: Pose2(**dict(zip(("x_m", "y_m", "yaw_rad"), everywhere[step], strict=True))),
        "at the finish": lambda step, truth: finish,
        "ahead": lambda step, truth: truth @ Pose2(x_m=3.0, y_m=0.0, yaw_rad=0.0),
    }
    episodes = {name: score(with_estimates(log, estimate)) for name, estimate in told.items()}
    assert len({msgspec.json.encode(msgspec.structs.replace(e, localization=None)) for e in episodes.values()}) == 1
    errors = {name: episode.localization.position_rmse_m for name, episode in episodes.items() if episode.localization}
    assert errors.pop("true") == 0.0 and min(errors.values()) > 1.0


def changed(record: msgspec.Struct) -> Iterator[tuple[str, msgspec.Struct]]:
    """Yield a record with one of its figures changed, each in turn; those of suites (course, robot) aside."""
    for name in record.__struct_fields__:
        value = getattr(record, name)
        if name in ("course", "robot"):
            continue
        if isinstance(value, msgspec.Struct):
            for inner, other in changed(value):
                yield f"{name}.{inner}", msgspec.structs.replace(record, **{name: other})
        elif isinstance(value, (bool, int, float)):
            yield name, msgspec.structs.replace(record, **{name: value + 1})
        elif isinstance(value, str):
            yield name, msgspec.structs.replace(record, **{name: value + "x"})


def test_each_figure_of_the_rules_changes_their_digest() -> None:
    suite = load_suite("d1")
    names, digests = ["as they are"], [rules_id(suite).sha256]
    for name, rules in changed(RULES):
        assert isinstance(rules, Rules)
        names.append(name)
        digests.append(rules_id(suite, rules).sha256)
    assert {"touch_gap_s", "stop_zone_m", "prices.line_touch.points", "earnings.parked", "limits.step_s"} < set(names)
    assert len(set(digests)) == len(names) > 60
