"""The built-in agents: the detector and the driving stack put together, by name."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path

from adc_bench.api import Agent
from adc_bench.errors import UsageError
from adc_bench.stack import Driver, DriverParams, StandStill
from adc_bench.stack.localizer import Detect

Options = Mapping[str, str]


def thesis(options: Options) -> Agent:
    """Return the thesis' driver: detector, lane lines, EKF, PID. Options: `weights` (a file), `speed_mps`."""
    return _driver(options, corrections=True)


def odometry_only(options: Options) -> Agent:
    """Return the same driver without corrections: it sees the panel, and then drives blind. Options as `thesis`."""
    return _driver(options, corrections=False)


def stand_still(options: Options) -> Agent:
    """Return the agent that never moves; it has no options."""
    _refuse_unknown(options, known=())
    return StandStill()


BUILT_IN: Mapping[str, Callable[[Options], Agent]] = {
    "thesis": thesis,
    "odometry-only": odometry_only,
    "stand-still": stand_still,
}


def _driver(options: Options, *, corrections: bool) -> Agent:
    _refuse_unknown(options, known=("weights", "speed_mps"))
    defaults = DriverParams()
    speed_mps = _number(options, "speed_mps", defaults.speed_mps)
    return Driver(_detect(options), DriverParams(speed_mps=speed_mps, corrections=corrections))


def _detect(options: Options) -> Detect:
    # torch takes seconds to import; agents without a detector do not pay for it.
    from adc_bench.detector import Detector, shipped_weights

    weights = options.get("weights")
    return Detector.load(Path(weights) if weights else shipped_weights())


def _refuse_unknown(options: Options, known: tuple[str, ...]) -> None:
    for key in options:
        if key not in known:
            raise UsageError(
                where=f"--set {key}={options[key]}",
                found=f"the unknown option {key!r}",
                wanted=f"one of {', '.join(known)}" if known else "no options: this agent has none",
                todo="correct the option's name or leave it out",
            )


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
