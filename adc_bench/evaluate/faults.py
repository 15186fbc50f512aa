"""The faults of a run, and what each costs."""

from enum import StrEnum

import msgspec


class FaultKind(StrEnum):
    """Every fault that the referee knows; the names are those of `Prices`."""

    LINE_TOUCH = "line_touch"
    OFF_ROAD = "off_road"
    FALSE_START = "false_start"
    STOP_PASSED = "stop_passed"
    STOP_OUTSIDE_ZONE = "stop_outside_zone"
    ORDER_DISOBEYED = "order_disobeyed"
    WRONG_WAY = "wrong_way"
    WRONG_LANE = "wrong_lane"
    WORKS_MISSED = "works_missed"
    COLLISION = "collision"
    SIGN_MISSED = "sign_missed"
    FALSE_REPORT = "false_report"


class Fault(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One fault: when, and with what (a thing's or a sign's name) where it is with something."""

    kind: FaultKind
    time_s: float
    what: str = ""


class Price(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one fault costs: points off, and the factor on the driving score."""

    points: float
    factor: float


class Prices(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What each fault costs. The points of line touch, off road, stop passed and order disobeyed are published (adc.md
    4); a false start is a stop passed, the wrong way an order disobeyed. All others, and all factors, are our own.
    """

    line_touch: Price = Price(points=10.0, factor=0.95)
    off_road: Price = Price(points=20.0, factor=0.80)
    false_start: Price = Price(points=60.0, factor=0.70)
    stop_passed: Price = Price(points=60.0, factor=0.70)
    stop_outside_zone: Price = Price(points=10.0, factor=0.90)
    order_disobeyed: Price = Price(points=25.0, factor=0.80)
    wrong_way: Price = Price(points=25.0, factor=0.80)
    wrong_lane: Price = Price(points=10.0, factor=0.90)
    works_missed: Price = Price(points=50.0, factor=0.60)
    collision: Price = Price(points=20.0, factor=0.70)
    sign_missed: Price = Price(points=0.0, factor=0.90)  # it already earns nothing
    false_report: Price = Price(points=5.0, factor=0.90)

    def of(self, kind: FaultKind) -> Price:
        """Return the price of a fault."""
        price: Price = getattr(self, kind.value)
        return price
