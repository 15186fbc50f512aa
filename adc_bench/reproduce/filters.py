"""Where a lap's robot believed itself to be: by its encoders alone, and by the EKF with simulated landmarks."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples
from adc_bench.evaluate.rules import RULES
from adc_bench.geometry import Pose2
from adc_bench.reproduce.laps import COURSE, START, Lap
from adc_bench.reproduce.settings import SimulatedLandmarks
from adc_bench.stack.ekf import Belief, Innovation, WheelModel, compare_point, correct, nearest, start_belief
from adc_bench.stack.odometry import WheelTrack, advance
from adc_bench.world.streams import stream

Array = NDArray[np.float64]
Kind = Literal["circle", "corner", "line"]
WHEELS = WheelModel(radius_m=RULES.robot.wheel_radius_m, separation_m=RULES.robot.wheel_separation_m)
CORNER_ASIDE_M = 1.0
LOOP_CENTRES = ((RULES.course.loop_centre_x_m, 0.0), (-RULES.course.loop_centre_x_m, 0.0))


class Seen(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An innovation: of points the x and y in the robot frame in metres, of lines angle and distance; with the filter's
    own standard deviations of both. `believed` if it was inside the gate.
    """

    time_s: float
    kind: Kind
    residual: tuple[float, float]
    sd: tuple[float, float]
    place_world: tuple[float, float] | None  # of a point, as the estimate has it
    believed: bool


class Estimate(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """True and believed poses by control step, the belief's standard deviations, and what was seen."""

    time_s: tuple[float, ...]
    truth: tuple[Pose2, ...]
    believed: tuple[Pose2, ...]
    sd_x_m: tuple[float, ...]
    sd_y_m: tuple[float, ...]
    seen: tuple[Seen, ...]

    @property
    def error_m(self) -> Array:
        """Believed less true x and y, (n, 2)."""
        pairs = zip(self.believed, self.truth, strict=True)
        return np.array([(b.x_m - t.x_m, b.y_m - t.y_m) for b, t in pairs])


def seen_of(time_s: float, kind: Kind, innovation: Innovation, belief: Belief) -> Seen:
    """Return the record of an innovation that met this belief."""
    return Seen(
        time_s=time_s,
        kind=kind,
        residual=_pair(innovation.residual),
        sd=_pair(np.sqrt(np.diag(innovation.covariance))),
        place_world=None if kind == "line" else _pair(_place(innovation, belief)),
        believed=innovation.inside_gate,
    )


def _place(innovation: Innovation, belief: Belief) -> Array:
    """Return the seen point in the world: H holds what is expected, (seen_y, -seen_x), in its last column."""
    expected = np.array([-innovation.jacobian[1, 2], innovation.jacobian[0, 2]])
    return np.asarray(belief.pose.transform(expected + innovation.residual))


def estimate_of(
    times_s: Sequence[float], truth: Sequence[Pose2], beliefs: Sequence[Belief], seen: Sequence[Seen]
) -> Estimate:
    """Return the record of beliefs, one a control step."""
    sds = [np.sqrt(np.diag(belief.covariance)) for belief in beliefs]
    return Estimate(
        time_s=tuple(times_s),
        truth=tuple(truth),
        believed=tuple(belief.pose for belief in beliefs),
        sd_x_m=tuple(float(sd[0]) for sd in sds),
        sd_y_m=tuple(float(sd[1]) for sd in sds),
        seen=tuple(seen),
    )


def dead_reckoned(lap: Lap) -> Estimate:
    """Return the estimate from the encoders alone."""
    return estimate_of(lap.time_s, poses_of(lap), _beliefs(lap, lambda belief, step: belief), ())


def filtered(lap: Lap, seed: int, landmarks: SimulatedLandmarks) -> Estimate:
    """Return the EKF's estimate, told where near landmarks are from the robot, with noise, at every control step."""
    rng, truth = stream(seed, "reproduce", "landmarks"), poses_of(lap)
    seen: list[Seen] = []

    def look(belief: Belief, step: int) -> Belief:
        for kind, point_robot in near(truth[step], landmarks):
            noisy = point_robot + landmarks.sd_m * rng.standard_normal(2)
            known = LOOP_CENTRES if kind == "circle" else COURSE.crosswalk_corners
            noise = np.eye(2) * landmarks.sd_m**2
            innovation = nearest(compare_point(belief, noisy, noise, each) for each in known)
            assert innovation is not None
            seen.append(seen_of(lap.time_s[step], kind, innovation, belief))
            belief = correct(belief, innovation) if innovation.inside_gate else belief
        return belief

    return estimate_of(lap.time_s, truth, _beliefs(lap, look), seen)


def near(pose: Pose2, landmarks: SimulatedLandmarks) -> Iterator[tuple[Kind, Array]]:
    """Yield the landmarks told at a true pose, in the robot frame: loop centre, near right corner of the crosswalk."""
    for centre in pose.inverse().transform(LOOP_CENTRES):
        if math.hypot(*centre) < landmarks.circle_range_m:
            yield "circle", np.asarray(centre)
    low, high = landmarks.corner_ahead_m
    corners = pose.inverse().transform(COURSE.crosswalk_corners)
    ahead = [corner for corner in corners if low < corner[0] < high and -CORNER_ASIDE_M < corner[1] < 0]
    if ahead:
        yield "corner", np.asarray(min(ahead, key=lambda corner: float(corner[0])))


def poses_of(lap: Lap) -> tuple[Pose2, ...]:
    """Return the true poses."""
    rows = zip(lap.x_m, lap.y_m, lap.yaw_rad, strict=True)
    return tuple(Pose2(x_m=x_m, y_m=y_m, yaw_rad=yaw_rad) for x_m, y_m, yaw_rad in rows)


def _beliefs(lap: Lap, look: Callable[[Belief, int], Belief]) -> list[Belief]:
    """Return the belief at every control step, from the known start on."""
    times = np.array(lap.encoder_time_s)
    ticks = np.array([lap.left_ticks, lap.right_ticks], dtype=np.int64)
    belief, done, beliefs = start_belief(START), 0, []
    track: WheelTrack | None = None
    for step, time_s in enumerate(lap.time_s):
        upto = int(np.searchsorted(times, time_s, side="right"))
        samples = EncoderSamples(
            time_s=times[done:upto], left_ticks=ticks[0, done:upto], right_ticks=ticks[1, done:upto]
        )
        per_turn = RULES.robot.encoder_ticks_per_turn
        belief, track = advance(belief, track, samples, time_s, WHEELS, per_turn)
        belief, done = look(belief, step), upto
        beliefs.append(belief)
    return beliefs


def _pair(values: Array) -> tuple[float, float]:
    return float(values[0]), float(values[1])
