"""The thesis' way of driving where panels order: PID along the lane at one speed, stops, and its rule round obstacles.

Before a crosswalk without an order the speed goes to zero at once, where braking ends in the stop zone. Where a mission
may hold boxes or road-works, the rule of section 6.4 steers while it is active. The thesis lets the lane choose the
side: here what stands right of the road's middle is passed on the left, all else on the right. What stands beside the
road is left out: in a bend the wall of a tunnel ahead would be gone round too.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

from adc_bench.api import LaserScan, Mission
from adc_bench.geometry import Path, Pose2, wrap_rad
from adc_bench.stack.avoidance import AvoidanceParams, Avoiding, Side, ahead, avoid
from adc_bench.stack.laser_clusters import Array, Cluster, clustered, scan_points
from adc_bench.stack.legs import Leg, half_lap_leg, last_leg, stop_before_m, way_of
from adc_bench.stack.orders import OrdersState, look, loop_behind, take_order
from adc_bench.stack.orders_pilot import LOOK_FROM_M
from adc_bench.stack.parking import ParkingPilot, ParkingState
from adc_bench.stack.path_following import Follower, FollowParams, follow, progress
from adc_bench.stack.pilots import BEYOND_FINISH_M
from adc_bench.world.categories import PanelSign, SignCategory
from adc_bench.world.frame import Detections
from adc_bench.world.robot import Motion
from adc_bench.world.route import Way

AHEAD_M = 1.0  # of the robot on the lane: the direction that must be free for the avoidance to end
ROAD_M = 4.0  # of the lane, before and behind, to which what the laser meets may belong
BLIND_S = 0.3  # without a scan for so long it goes round nothing any farther, but stands


@dataclass(frozen=True, kw_only=True, eq=False)
class ThesisProgress:
    """The orders, the leg under way (None before the first), how far on its lane the robot is, how it goes round its
    loop, the avoidance with its last command (None while it does not steer), and for how many control steps there was
    no scan. `parking` is None until its turn.
    """

    orders: OrdersState = field(default_factory=OrdersState)
    leg: Leg | None = None
    follower: Follower = field(default_factory=lambda: Follower(s_m=0.0))
    way: Way = "turn"
    avoiding: Avoiding = field(default_factory=lambda: Avoiding(side="left"))
    around: Motion | None = None
    blind_steps: int = 0
    parking: ParkingState | None = None


@dataclass(frozen=True, kw_only=True)
class ThesisPilot:
    """Waits for an order before each crosswalk, and carries it out."""

    mission: Mission
    speed_mps: float
    following: FollowParams = field(default_factory=FollowParams)
    avoidance: AvoidanceParams = field(default_factory=AvoidanceParams)

    @cached_property
    def _parking(self) -> ParkingPilot:
        assert self.mission.parking  # without it no sign leads here
        return ParkingPilot(mission=self.mission, kind=self.mission.parking)

    @property
    def _goes_round(self) -> bool:
        return bool({"boxes", "works"} & set(self.mission.elements))

    @property
    def _braking_m(self) -> float:
        return self.speed_mps**2 / (2 * self.mission.robot.acceleration_max_mps2)

    def start(self) -> ThesisProgress:
        """Return the state before the first order."""
        return ThesisProgress()

    def looks(self, state: ThesisProgress) -> bool:
        """Return whether the next picture by the panels' camera matters."""
        if state.orders.over:
            return False
        return state.leg is None or state.leg.end_m - state.follower.s_m < LOOK_FROM_M

    def look(self, state: ThesisProgress, pose: Pose2, detections: Detections) -> ThesisProgress:
        """Return the state after a picture by the panels' camera."""
        return replace(state, orders=look(state.orders, detections)) if self.looks(state) else state

    def report(self, state: ThesisProgress) -> SignCategory | None:
        """Return None: no vertical signs are read."""
        return None

    def see(self, state: ThesisProgress, pose: Pose2, scan: LaserScan) -> ThesisProgress:
        """Return the state after a scan taken at this pose."""
        laser = self.mission.rig.laser
        if state.parking is not None:
            return replace(state, parking=self._parking.see(state.parking, pose, scan))
        if laser is None or state.leg is None or not self._goes_round:
            return state
        lane, s_m = state.leg.lane, progress(state.follower.s_m, pose, state.leg.lane)
        found = clustered(self._on_road(scan_points(scan, laser), pose, lane, s_m), laser)
        avoiding = state.avoiding if state.avoiding.active else Avoiding(side=self._side(found, pose, lane, s_m))
        goal = lane.pose(s_m + AHEAD_M)
        path_rad = wrap_rad(math.atan2(goal.y_m - pose.y_m, goal.x_m - pose.x_m) - pose.yaw_rad)
        avoiding, command = avoid(avoiding, found, path_rad, scan.time_s, self.avoidance)
        return replace(state, avoiding=avoiding, around=command, blind_steps=0)

    def _on_road(self, points: Array, pose: Pose2, lane: Path, s_m: float) -> Array:
        """Return those of the points (n, 2), seen from the robot, that stand on one of the road's two lanes."""
        _, offset_m = lane.project(pose.transform(points), around_s_m=s_m, window_m=ROAD_M)
        return points[(-self._lane_m / 2 < offset_m) & (offset_m < 1.5 * self._lane_m)]

    def _side(self, found: tuple[Cluster, ...], pose: Pose2, lane: Path, s_m: float) -> Side:
        """Return on which hand to pass what is nearest ahead."""
        point = ahead(found, self.avoidance)
        if point is None:
            return "left"
        _, offset_m = lane.project(pose.transform([point]), around_s_m=s_m, window_m=ROAD_M)
        return "left" if offset_m[0] < self._lane_m / 2 else "right"

    @property
    def _lane_m(self) -> float:
        return self.mission.course.radius_outer_m - self.mission.course.radius_centre_m

    def steer(self, state: ThesisProgress, pose: Pose2, motion: Motion) -> tuple[ThesisProgress, Motion]:
        """Return the next state and the command."""
        state = self._take_order(state, pose, motion)
        if state.parking is not None:
            parking, command = self._parking.steer(state.parking, pose, motion)
            return replace(state, parking=parking), command
        if state.leg is None or state.follower.s_m > state.leg.end_m - self._braking_m:
            return state, Motion()
        lane, period_s = state.leg.lane, self.mission.control_period_s
        if state.around is not None:
            follower = Follower(s_m=progress(state.follower.s_m, pose, lane))
            command = Motion() if state.blind_steps * period_s > BLIND_S else state.around
            return replace(state, follower=follower, blind_steps=state.blind_steps + 1), command
        follower, omega_radps = follow(state.follower, pose, lane, self.speed_mps, period_s, self.following)
        return replace(state, follower=follower), Motion(v_mps=self.speed_mps, omega_radps=omega_radps)

    def _take_order(self, state: ThesisProgress, pose: Pose2, motion: Motion) -> ThesisProgress:
        """Return the state on the next leg, if it has been ordered; one parks from a stand."""
        orders, sign = take_order(self.mission, state.orders)
        if sign is None or (sign == "park" and motion != Motion()):
            return state
        if sign == "park":
            return ThesisProgress(orders=orders, parking=self._parking.start())
        leg = self._leg(state, sign)
        follower = replace(state.follower, s_m=leg.place_m(pose))
        return replace(state, orders=orders, leg=leg, follower=follower, way=way_of(sign))

    def _leg(self, state: ThesisProgress, sign: PanelSign) -> Leg:
        course, loop = self.mission.course, loop_behind(state.orders.crosswalk)
        if sign == "end":
            return last_leg(course, loop, state.way, self._braking_m + BEYOND_FINISH_M)
        return half_lap_leg(course, loop, state.way, way_of(sign), stop_before_m(course, self.mission.robot))
