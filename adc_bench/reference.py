"""The built-in agents: the detector and the driving stack put together, by name."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Agent, Kind, Mission, PictureDetector
from adc_bench.errors import UsageError
from adc_bench.stack import Driver, StandStill
from adc_bench.stack.caution import carefully
from adc_bench.stack.conduct import AfterArrow, Conduct
from adc_bench.stack.driver import Localizing
from adc_bench.stack.edge_localizer import EdgeLocalizer
from adc_bench.stack.lane_follower import LaneFollower
from adc_bench.stack.localizer import Detect, Localizer, LocalizerParams
from adc_bench.stack.lone_localizer import LoneLocalizer
from adc_bench.stack.orders_pilot import OrdersPilot
from adc_bench.stack.pilots import HeadingPilot, LinePilot, Pilot, TrajectoryPilot
from adc_bench.stack.second_look import SecondLook
from adc_bench.stack.thesis_pilot import ThesisPilot
from adc_bench.world.frame import Detections

Options = Mapping[str, str]


@dataclass(frozen=True, kw_only=True)
class Layers:
    """Layers that a driver is lent in place of its own; None where it has its own."""

    detect: Detect | None = None
    localizer: Callable[[Mission], Localizing[Any]] | None = None


OWN_LAYERS = Layers()

REFERENCE_SPEED_MPS, THESIS_SPEED_MPS, LANE_SPEED_MPS = 2.2, 1.0, 1.0
PILOTS: Mapping[str, Callable[..., Pilot[Any]]] = {"pid": HeadingPilot, "linearisation": TrajectoryPilot}


def reference(options: Options, layers: Layers = OWN_LAYERS) -> Agent:
    """Return the best driver here: the map's paint edges for its place, a rounded line at the robot's limits,
    the panels' orders, boxes, road-works, parking; slower where it doubts its place.

    Options: `weights` (a file), `speed_mps` (the greatest speed).
    """
    _refuse_unknown(options, known=("weights", "speed_mps"))
    speed_mps = _number(options, "speed_mps", default=REFERENCE_SPEED_MPS)
    return Driver(
        layers.detect or SecondLook(detect=_detect(options)),
        layers.localizer or (lambda mission: EdgeLocalizer(mission=mission)),
        lambda mission: _reference_conduct(mission, speed_mps),
        carefully,
    )


def thesis(options: Options, layers: Layers = OWN_LAYERS) -> Agent:
    """Return the thesis' driver: detector, lane lines, EKF, and one of its two controllers; it obeys the panels, goes
    round boxes by the thesis' rule, and parks.

    Options: `weights` (a file), `speed_mps`, `controller` (`pid` or `linearisation`; that one drives laps of an empty
    road, all else is left to `pid`).
    """
    _refuse_unknown(options, known=("weights", "speed_mps", "controller"))
    pilot = PILOTS[_choice(options, "controller", tuple(PILOTS))]
    return _driver(options, layers, pilot, LocalizerParams())


def odometry_only(options: Options, layers: Layers = OWN_LAYERS) -> Agent:
    """Return the thesis' driver without corrections: it sees the panel, and then drives blind. Options: `weights`,
    `speed_mps`.
    """
    _refuse_unknown(options, known=("weights", "speed_mps"))
    return _driver(options, layers, HeadingPilot, LocalizerParams(corrections=False))


def lane_follower(options: Options, layers: Layers = OWN_LAYERS) -> Agent:
    """Return the driver that has no map and keeps to the lane that its road camera shows. Options: `weights`,
    `speed_mps`.
    """
    _refuse_unknown(options, known=("weights", "speed_mps"))
    if layers.localizer:
        raise _without_layer("lane-follower, which steers by no pose")
    return LaneFollower(layers.detect or _detect(options), _number(options, "speed_mps", default=LANE_SPEED_MPS))


def stand_still(options: Options, layers: Layers = OWN_LAYERS) -> Agent:
    """Return the agent that never moves; it has no options and no layers."""
    _refuse_unknown(options, known=())
    if layers != OWN_LAYERS:
        raise _without_layer("stand-still, which neither looks nor locates itself")
    return StandStill()


BUILT_IN: Mapping[str, Callable[..., Agent]] = {
    "reference": reference,
    "thesis": thesis,
    "odometry-only": odometry_only,
    "lane-follower": lane_follower,
    "stand-still": stand_still,
}


def reference_localizer(options: Options) -> Agent:
    """Return the reference driver's localiser; it has no options."""
    _refuse_unknown(options, known=())
    return LoneLocalizer(lambda mission: EdgeLocalizer(mission=mission))


def thesis_localizer(options: Options) -> Agent:
    """Return the thesis driver's localiser. Options: `weights` (a file)."""
    _refuse_unknown(options, known=("weights",))
    detect = _detect(options)
    return LoneLocalizer(lambda mission: Localizer(mission=mission, detect=detect))


def odometry_localizer(options: Options) -> Agent:
    """Return the thesis driver's localiser that only reckons with the encoders; it has no options."""
    _refuse_unknown(options, known=())
    blind = LocalizerParams(corrections=False)
    return LoneLocalizer(lambda mission: Localizer(mission=mission, detect=_blind, params=blind))


def reference_detector(options: Options) -> PictureDetector:
    """Return the detector that every built-in driver has. Options: `weights` (a file)."""
    from adc_bench.detector.lone import LoneDetector

    _refuse_unknown(options, known=("weights",))
    return LoneDetector(_weights(options))


LOCALIZERS: Mapping[str, Callable[[Options], Agent]] = {
    "reference": reference_localizer,
    "thesis": thesis_localizer,
    "odometry-only": odometry_localizer,
}
DETECTORS: Mapping[str, Callable[[Options], PictureDetector]] = {"reference": reference_detector}
OF_KIND: Mapping[Kind, Mapping[str, Callable[[Options], Agent | PictureDetector]]] = {
    "driver": BUILT_IN,
    "localizer": LOCALIZERS,
    "detector": DETECTORS,
}


def _reference_conduct(mission: Mission, speed_mps: float) -> Conduct[Any]:
    """Return who looks about and obeys; on an empty road whose panels only start and end a run, who drives it all from
    the arrow on.
    """
    if {"orders", "vertical_signs", "boxes", "works"} & set(mission.elements) or mission.parking:
        return OrdersPilot(mission=mission, speed_mps=speed_mps)
    return AfterArrow(pilot=LinePilot(mission=mission, speed_mps=speed_mps))


def _thesis_conduct(mission: Mission, pilot: Callable[..., Pilot[Any]], speed_mps: float) -> Conduct[Any]:
    """Return who obeys and goes round things; on an empty road whose panels only start and end a run, who drives it."""
    if {"orders", "boxes", "works"} & set(mission.elements) or mission.parking:
        return ThesisPilot(mission=mission, speed_mps=speed_mps)
    return AfterArrow(pilot=pilot(mission=mission, speed_mps=speed_mps))


def _driver(options: Options, layers: Layers, pilot: Callable[..., Pilot[Any]], params: LocalizerParams) -> Agent:
    detect, speed_mps = layers.detect or _detect(options), _number(options, "speed_mps", default=THESIS_SPEED_MPS)
    return Driver(
        detect,
        layers.localizer or (lambda mission: Localizer(mission=mission, detect=detect, params=params)),
        lambda mission: _thesis_conduct(mission, pilot, speed_mps),
    )


def _detect(options: Options) -> Detect:
    # torch takes seconds to import; agents without a detector do not pay for it.
    from adc_bench.detector import Detector

    return Detector.load(_weights(options))


def _weights(options: Options) -> Path:
    from adc_bench.detector import shipped_weights

    weights = options.get("weights")
    return Path(weights) if weights else shipped_weights()


def _blind(rgb: NDArray[np.uint8]) -> Detections:
    raise AssertionError("dead reckoning looks at no picture")


def _without_layer(found: str) -> UsageError:
    return UsageError(
        where="--privileged",
        found=found,
        wanted="a driver that has the layer",
        todo="name another built-in driver",
    )


def _refuse_unknown(options: Options, known: tuple[str, ...]) -> None:
    for key in options:
        if key not in known:
            raise UsageError(
                where=f"--set {key}={options[key]}",
                found=f"the unknown option {key!r}",
                wanted=f"one of {', '.join(known)}" if known else "no options: this agent has none",
                todo="correct the option's name or leave it out",
            )


def _choice(options: Options, key: str, choices: tuple[str, ...]) -> str:
    """Return the option's value, the first choice by default."""
    value = options.get(key, choices[0])
    if value not in choices:
        raise UsageError(
            where=f"--set {key}={value}",
            found=repr(value),
            wanted=f"one of {', '.join(choices)}",
            todo="correct the option's value",
        )
    return value


def _number(options: Options, key: str, default: float) -> float:
    text = options.get(key)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0):
        raise UsageError(
            where=f"--set {key}={text}",
            found=repr(text),
            wanted=f"a number above 0, such as {default}",
            todo="correct the option's value",
        )
    return value
