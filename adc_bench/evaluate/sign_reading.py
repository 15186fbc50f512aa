"""Which vertical signs a submission read: its reports against the signs that it drove past."""

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import msgspec

from adc_bench.evaluate.course_progress import LEAD_M, Route
from adc_bench.evaluate.faults import Fault, FaultKind
from adc_bench.evaluate.log import Row
from adc_bench.evaluate.referee_watch import Watch
from adc_bench.evaluate.rules import Rules
from adc_bench.world.categories import SignCategory
from adc_bench.world.signs import VerticalSign

BESIDE_M = 1.2  # from the lane's middle to a sign that is meant for it
FACING_COS = -0.7  # of the angle between the driving direction and the way a board faces


class SignReading(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Signs passed, those of them read right, and the faults: signs missed, signs reported that were not there."""

    passed: int
    right: int
    faults: tuple[Fault, ...]


def read_signs(
    watches: Sequence[Watch], rows: Sequence[Row], signs: tuple[VerticalSign, ...], rules: Rules
) -> SignReading:
    """Return what a run's reports are worth. Each half lap counts for itself.

    A report is right from `sign_ahead_m` before its sign to `sign_beyond_m` behind it. A sign counts as passed from
    there on. A wrong report of one category counts once a half lap.
    """
    passed: set[tuple[int, SignCategory]] = set()  # half lap and sign
    right: set[tuple[int, SignCategory]] = set()
    wrong: set[tuple[int, SignCategory]] = set()
    faults = []
    for watch, row in zip(watches, rows, strict=True):
        half, s_m = watch.half, watch.progress.s_m
        due_m = sign_stations_m(watch.progress.route, signs)
        report = row.answer.sign if row.answer else None
        if report:
            ahead_m = due_m.get(report, math.inf) - s_m
            if -rules.sign_beyond_m <= ahead_m <= rules.sign_ahead_m:
                right.add((half, report))
            elif (half, report) not in right | wrong:
                wrong.add((half, report))
                faults.append(Fault(kind=FaultKind.FALSE_REPORT, time_s=row.time_s, what=report))
        for sign, station_m in due_m.items():
            if watch.best_m > station_m + rules.sign_beyond_m and (half, sign) not in passed:
                passed.add((half, sign))
                if (half, sign) not in right:
                    faults.append(Fault(kind=FaultKind.SIGN_MISSED, time_s=row.time_s, what=sign))
    return SignReading(passed=len(passed), right=len(right), faults=tuple(faults))


@lru_cache(maxsize=32)
def sign_stations_m(route: Route, signs: tuple[VerticalSign, ...]) -> Mapping[SignCategory, float]:
    """Return how far along a half lap each sign stands that is meant for who drives it."""
    stations = {}
    for sign in signs:
        s, offset = route.path.project([(sign.x_m, sign.y_m)])
        heading_rad = route.path.pose(float(s[0])).yaw_rad
        faces = math.cos(sign.yaw_rad - heading_rad) < FACING_COS
        if faces and abs(offset[0]) <= BESIDE_M and s[0] > LEAD_M:
            stations[sign.sign] = float(s[0]) - LEAD_M
    return stations
