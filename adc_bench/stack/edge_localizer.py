"""The reference's localiser: encoders and gyro carry the pose, the edges of the map's paint in the picture hold it.

One step: new samples go onto the tape; the estimate is moved to the picture's time and corrected by it; the pose is
moved on from there to now. A picture that arrives late finds the estimate where it was taken, for the tape holds what
came since. Pictures running that show edges, but not where they should be, add to the doubt, and after a few of them
the robot is looked for round about.
"""

import math
from dataclasses import dataclass, field, replace
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import Mission, Observation, Picture
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.edge_fit import EdgeFit, EdgeFitParams, fit_edges, offset_jacobian
from adc_bench.stack.edge_search import EdgeSearchParams, expect_edges, find_edges
from adc_bench.stack.ekf import Belief
from adc_bench.stack.lost import LostParams, guessed, next_guesses
from adc_bench.stack.paint_edges import paint_edges
from adc_bench.stack.pose_filter import Estimate, MotionNoise, StartSpread, predict, start_estimate, widened
from adc_bench.stack.travel import Reached, Tape, forget, record, travel
from adc_bench.world.course import Course

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class EdgeLocalizerParams:
    """How a picture is used.

    Attributes:
        horizon_s: how late a picture may come and still be of use.
        least_edges: fewer tell nothing.
        least_share: of the expected edges that must agree before a picture is believed.
        surprise: squared distance per degree of freedom from which on the way before cannot have been what it seemed;
            pictures running share their errors, so it is commonly a sixth.
        astray_m: where a picture does not fit or surprises, it is looked at again with this much doubt more ...
        astray_rad: ... and this much in its yaw.
        place_m: after so much way a picture's errors are others; a turn counts as the way of a point ...
        lever_m: ... so far from the axle.
        stuck_m: after so much way the very same picture cannot be a new one.
        least_news: share of the errors that are others even where the robot stands.
    """

    horizon_s: float = 0.5
    least_edges: int = 12
    least_share: float = 0.5
    surprise: float = 1.5
    astray_m: float = 0.05
    astray_rad: float = math.radians(2.0)
    place_m: float = 0.05
    lever_m: float = 0.5
    stuck_m: float = 0.02
    least_news: float = 0.1
    start: StartSpread = field(default_factory=StartSpread)
    noise: MotionNoise = field(default_factory=MotionNoise)
    search: EdgeSearchParams = field(default_factory=EdgeSearchParams)
    fit: EdgeFitParams = field(default_factory=EdgeFitParams)
    lost: LostParams = field(default_factory=LostParams)


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeState:
    """The estimate at the last picture, what encoders and gyro said since then, and the estimate now.

    `used` is the last picture that was believed, `way_m` how far the robot has come since, and `contradicted` how many
    came since that showed edges elsewhere. `fit` is what the picture of this step said; None where none came or it was
    not believed.
    """

    settled: Estimate
    reached: Reached
    now: Estimate
    way_m: float
    tape: Tape = field(default_factory=Tape)
    used: NDArray[np.uint8] | None = None
    contradicted: int = 0
    fit: EdgeFit | None = None

    @property
    def belief(self) -> Belief:
        """The pose at the last observation's time."""
        return self.now.belief


class EdgeLocalizer:
    """Pure steps from state to state, for one mission; its map is drawn once."""

    def __init__(self, mission: Mission, params: EdgeLocalizerParams | None = None) -> None:
        self._mission, self._params = mission, params or EdgeLocalizerParams()
        self._edges_world = paint_edges(Course(spec=mission.course))

    def start(self) -> EdgeState:
        """Return the state at the mission's start pose."""
        estimate = start_estimate(self._mission.start_pose, self._params.start)
        return EdgeState(settled=estimate, reached=Reached(), now=estimate, way_m=self._params.place_m)

    def step(self, state: EdgeState, observation: Observation) -> EdgeState:
        """Return the state at the observation's time."""
        tape = record(state.tape, observation.encoders, observation.imu, self._mission.robot)
        state = replace(state, tape=tape, fit=None)
        road = observation.pictures.get("road")
        if road is not None and road.time_s >= state.reached.time_s:
            state = self._look(self._settle(state, road.time_s), road)
        state = self._settle(state, observation.time_s - self._params.horizon_s)
        return replace(state, now=self._settle(state, observation.time_s).settled)

    def _settle(self, state: EdgeState, time_s: float) -> EdgeState:
        """Return the state with its settled estimate moved to a time, if that is later, and the tape before it cut."""
        if time_s <= state.reached.time_s:
            return state
        p = self._params
        way, reached = travel(state.tape, state.reached, time_s, self._mission.robot)
        return replace(
            state,
            settled=predict(state.settled, way, p.noise),
            reached=reached,
            way_m=state.way_m + float(np.abs(way.forward_m).sum() + p.lever_m * np.abs(way.turn_rad).sum()),
            tape=forget(state.tape, time_s),
        )

    def _look(self, state: EdgeState, road: Picture) -> EdgeState:
        """Return the state after a picture taken where its settled estimate is."""
        p = self._params
        if state.used is not None and state.way_m > p.stuck_m and np.array_equal(road.rgb, state.used):
            return state
        news = min(max(state.way_m / p.place_m, p.least_news), 1.0)
        sight = self._compare(state.settled, road.rgb, news)
        if not self._is_believed(sight) or sight.fit.squared_distance > p.surprise * sight.fit.freedoms:
            sight = self._compare(widened(state.settled, p.astray_m, p.astray_rad), road.rgb, news)
        if sight is None:
            return state
        return _corrected(state, road, sight) if self._is_believed(sight) else self._search(state, road, news)

    def _search(self, state: EdgeState, road: Picture, news: float) -> EdgeState:
        """Return the state after a picture that contradicts it: in more doubt, or where a guess agrees."""
        lost = self._params.lost
        settled = widened(state.settled, lost.doubt_m, lost.doubt_rad)
        state = replace(state, settled=settled, contradicted=state.contradicted + 1)
        guesses = next_guesses(state.contradicted, lost)
        sights = [self._compare(guessed(settled, guess), road.rgb, news) for guess in guesses]
        agreeing = [sight for sight in sights if sight is not None and sight.agrees_with(lost)]
        best = max(agreeing, key=lambda sight: sight.fit.agreeing / sight.expected, default=None)
        return state if best is None else _corrected(state, road, best)

    def _is_believed(self, sight: "_Sight | None") -> TypeGuard["_Sight"]:
        p = self._params
        return sight is not None and sight.fit.agreeing >= max(p.least_edges, p.least_share * sight.expected)

    def _compare(self, estimate: Estimate, rgb: NDArray[np.uint8], news: float) -> "_Sight | None":
        """Return what a picture (height, width, 3) says; None where too few of the expected edges are found."""
        p = self._params
        eye = BirdsEye(mount=self._mission.rig.camera("road"), tilt_rad=estimate.tilt_rad)
        pose = estimate.belief.pose
        expected = expect_edges(eye, self._edges_world.seen_from(pose), p.search)
        jacobian = offset_jacobian(expected, eye, pose.yaw_rad)
        spread_m = np.sqrt(np.einsum("ni,ij,nj->n", jacobian, estimate.covariance, jacobian))
        found, offsets_m = find_edges(rgb, expected, spread_m, p.search)
        if len(offsets_m) < p.least_edges:
            return None
        fit = fit_edges(estimate, expected.of(found), offsets_m, jacobian[found], news, p.fit)
        return _Sight(fit=fit, expected=len(found))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Sight:
    """What a picture says: the fit to the edges found in it, and how many were expected."""

    fit: EdgeFit
    expected: int

    def agrees_with(self, lost: LostParams) -> bool:
        """Return whether so much agrees that a guess is believed."""
        return self.fit.agreeing >= max(lost.least_edges, lost.least_share * self.expected)


def _corrected(state: EdgeState, road: Picture, sight: _Sight) -> EdgeState:
    return replace(state, settled=sight.fit.estimate, way_m=0.0, used=road.rgb, contradicted=0, fit=sight.fit)
