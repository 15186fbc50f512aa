"""The worked examples of docs/rules.md, each driven; and the prices beside what the referee charges."""

import re
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest
from made_runs import COURSE, PERIOD_S, START_X_M, along, crosswalks_m, header_of, log_of

from adc_bench.evaluate.course_progress import route_of
from adc_bench.evaluate.faults import FaultKind, Price
from adc_bench.evaluate.log import EpisodeLog, Header, Hit
from adc_bench.evaluate.programme import Programme, Trial
from adc_bench.evaluate.rules import RULES
from adc_bench.evaluate.score import Episode, score
from adc_bench.evaluate.sign_reading import sign_stations_m
from adc_bench.evaluate.suite import load_suite
from adc_bench.geometry import Pose2
from adc_bench.world.categories import PanelSign

PAGE = (Path(__file__).parents[2] / "docs" / "rules.md").read_text(encoding="utf-8")
D1 = header_of(load_suite("d1"))
BOX = Hit(time_s=12.0, with_name="box_0", impulse_ns=2.0)


def d2(*orders: PanelSign) -> Header:
    return header_of(msgspec.structs.replace(load_suite("d2"), trials=(Trial(orders=orders),)))


def onto_the_line(s_m: float) -> float:
    return -0.21 if 10.0 < s_m < 10.5 else 0.0


def straight_on(time_s: float) -> Pose2:
    driven_m = max(time_s - D1.start_step * PERIOD_S, 0.0)
    return D1.start_pose @ Pose2(x_m=driven_m, y_m=0.0, yaw_rad=0.0)


def stops_short() -> EpisodeLog:
    header = d2("up", "stop", "up", "left", "right", "end")
    nose_m = RULES.robot.length_m / 2 + RULES.course.crosswalk_depth_m / 2
    return log_of(header, along(header, 1.0, halts={crosswalks_m(header.orders)[0] - nose_m - 1.0: 3.0}))


def passes_the_stop() -> EpisodeLog:
    header = d2("up", "stop", "up", "left", "right", "end")
    return log_of(header, along(header, 1.0))


def straight_on_at_every_crosswalk() -> EpisodeLog:
    header = d2("up", "right", "left", "up", "end")
    return log_of(header, along(header, 1.0, orders=("up", "up", "up", "up", "end")))


def parks(rest_s: float, *, over_the_line: bool) -> EpisodeLog:
    """A robot beside the parallel place 4 s after the start, that moves in sideways, rests, and moves out again."""
    header = header_of(load_suite("p1"))
    place, start = COURSE.parking_places[0].pose, header.start_pose
    begun_s = header.start_step * PERIOD_S

    def pose(time_s: float) -> Pose2:
        along_lane, driven_s = min(max((time_s - begun_s) / 4.0, 0.0), 1.0), time_s - begun_s - 4.0
        inwards = min(max(driven_s, 0.0), 1.0) if driven_s < 1.0 + rest_s else 0.0
        too_far_m = 0.30 if over_the_line and 0.9 < driven_s < 1.0 else 0.0
        y_m = start.y_m + inwards * (place.y_m - start.y_m) - too_far_m
        return Pose2(x_m=start.x_m + along_lane * (place.x_m - start.x_m), y_m=y_m, yaw_rad=0.0)

    return log_of(header, pose)


def ten_of_twelve_signs() -> EpisodeLog:
    header = header_of(load_suite("v1"))
    start_s, begun_m, reports = header.start_step * PERIOD_S, -START_X_M, {}
    for half_lap in Programme(orders=header.orders).half_laps:
        route = route_of(COURSE, half_lap)
        for sign, station_m in sign_stations_m(route, header.signs).items():
            reports[start_s + begun_m + station_m - 1.0] = sign
        begun_m += route.length_m
    left_out = list(reports)[:2]
    lie = {start_s + 1.0: reports[left_out[0]]}  # long before the sign
    told = {time_s: sign for time_s, sign in reports.items() if time_s not in left_out}
    return log_of(header, along(header, 1.0), reports=lie | told)


EXAMPLES: dict[str, Callable[[], EpisodeLog]] = {
    "`d1`, two clean laps": lambda: log_of(D1, along(D1, 1.0)),
    "the same, one line touched and one box hit": lambda: log_of(D1, along(D1, 1.0, left_m=onto_the_line), hits=[BOX]),
    "the same, 0.2 s before the start": lambda: log_of(D1, along(D1, 1.0, wait_s=-0.2)),
    "`d1`, straight on into the first bend": lambda: log_of(D1, straight_on),
    "`d2`, orders up right left up end": straight_on_at_every_crosswalk,
    "`d2`, orders up stop up left right end": passes_the_stop,
    "the same, stood for 3 s one metre before": stops_short,
    "`p1`, parked, one line touched": lambda: parks(30.0, over_the_line=True),
    "`p1`, stood for 4.9 s and left": lambda: parks(4.9, over_the_line=False),
    "`v1`, ten of twelve signs read": ten_of_twelve_signs,
}


@cache
def example_log(example: str) -> EpisodeLog:
    return EXAMPLES[example]()


def row_of(example: str) -> tuple[float, float]:
    """Return the points and the driving score in the page's row that begins with these words."""
    rows = [line for line in PAGE.splitlines() if line.startswith(f"| {example}")]
    assert len(rows) == 1, example
    points, driving_score = (re.findall(r"\*\*([\d.]+)\*\*", cell) for cell in rows[0].split("|")[2:4])
    return float(points[-1]), float(driving_score[-1])


@pytest.mark.parametrize("example", EXAMPLES)
def test_the_page_tells_what_the_score_says(example: str) -> None:
    episode = score(example_log(example))
    assert (round(episode.points, 2), round(episode.driving_score, 2)) == pytest.approx(row_of(example))


def test_every_example_of_the_page_is_driven() -> None:
    table = PAGE.split("### Worked examples")[1]
    assert table.count("\n| ") - 1 == len(EXAMPLES)


@pytest.mark.parametrize("kind", FaultKind)
def test_the_page_has_every_fault_and_its_price(kind: FaultKind) -> None:
    rows = [line for line in PAGE.splitlines() if line.startswith(f"| `{kind.value}` |")]
    assert len(rows) == 1
    points, factor = rows[0].split("|")[3:5]
    price = RULES.prices.of(kind)
    assert float(points.split()[0]) == price.points and float(factor) == price.factor


def test_the_page_has_every_suite_with_its_runs_and_limit() -> None:
    for name in ("d1", "d2", "d3", "d4", "p1", "p2", "b1", "b2", "v1"):
        suite = load_suite(name)
        row = next(line for line in PAGE.splitlines() if re.match(rf"\| .*`{name}`", line))
        assert row.split("|")[3:5] == [f" {len(suite.seeds)} ", f" {suite.time_limit_s:.0f} s "]


def dearer(log: EpisodeLog, kind: FaultKind) -> Episode:
    price = RULES.prices.of(kind)
    raised = Price(points=price.points + 1.0, factor=price.factor / 2)
    prices = msgspec.structs.replace(RULES.prices, **{kind.value: raised})
    return score(log, msgspec.structs.replace(RULES, prices=prices))


def test_no_fault_pays() -> None:
    for kind in FaultKind:
        price = RULES.prices.of(kind)
        assert price.points >= 0 and 0 < price.factor < 1


@pytest.mark.parametrize(
    ("example", "kind"),
    [
        ("the same, one line touched and one box hit", FaultKind.LINE_TOUCH),
        ("the same, one line touched and one box hit", FaultKind.COLLISION),
        ("`d2`, orders up stop up left right end", FaultKind.STOP_PASSED),
        ("`d2`, orders up right left up end", FaultKind.ORDER_DISOBEYED),
        ("`v1`, ten of twelve signs read", FaultKind.FALSE_REPORT),
        ("`v1`, ten of twelve signs read", FaultKind.SIGN_MISSED),
    ],
)
def test_dearer_faults_cost_more(example: str, kind: FaultKind) -> None:
    before, after = score(example_log(example)), dearer(example_log(example), kind)
    times = sum(fault.kind is kind for fault in before.faults)
    assert times and after.points == pytest.approx(before.points - times)
    assert after.driving_score == pytest.approx(before.driving_score / 2**times)


def test_one_more_hit_never_pays() -> None:
    header = header_of(load_suite("dev"))
    hits = [msgspec.structs.replace(BOX, time_s=3.0 + 2 * count) for count in range(4)]
    found = [score(log_of(header, along(header, 3.0), hits=hits[:count])) for count in range(5)]
    for before, after in pairwise(found):
        assert after.points == pytest.approx(before.points - 20.0)
        assert after.driving_score == pytest.approx(before.driving_score * 0.7)
