"""The reference's way of driving where panels order: leg by leg, each at the limits of the robot.

A leg ends at rest in the stop zone before the next crosswalk. When the sign there is believed in time, the next leg
takes the robot over at the speed that it has; until then it brakes as late as it can, and then it waits.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

from adc_bench.api import LaserScan, Mission
from adc_bench.geometry import Pose2
from adc_bench.stack.legs import Leg, half_lap_leg, last_leg, stop_before_m, way_of
from adc_bench.stack.orders import OrdersState, look, loop_behind, take_order
from adc_bench.stack.parking import ParkingPilot, ParkingState
from adc_bench.stack.pilots import BEYOND_FINISH_M
from adc_bench.stack.sign_reading import SignParams, SignsState, read_signs
from adc_bench.stack.timetable import SpeedLimits, Timetable, fastest
from adc_bench.stack.tracker import Tracker, TrackerParams
from adc_bench.world.categories import PanelSign, SignCategory
from adc_bench.world.frame import Detections
from adc_bench.world.robot import Motion
from adc_bench.world.route import Way
from adc_bench.world.sensors import CameraMount

LOOK_FROM_M = 4.0  # before a leg's end: the order has been changed by then, and the sign can be read


@dataclass(frozen=True, kw_only=True, eq=False)
class OrdersProgress:
    """The orders, the leg under way (None before the first), where on it the robot was, and how it goes round its loop.

    The start is as the end of a leg by the long straight, which `turn` leads over. `parking` is None until its turn.
    """

    orders: OrdersState = field(default_factory=OrdersState)
    leg: Timetable | None = None
    s_m: float = 0.0
    way: Way = "turn"
    parking: ParkingState | None = None
    signs: SignsState = field(default_factory=SignsState)


@dataclass(frozen=True, kw_only=True)
class OrdersPilot:
    """Waits for an order before each crosswalk, and carries it out."""

    mission: Mission
    speed_mps: float
    params: TrackerParams = field(default_factory=TrackerParams)

    @cached_property
    def _limits(self) -> SpeedLimits:
        return SpeedLimits.of(self.mission.robot, speed_mps=self.speed_mps)

    @cached_property
    def _parking(self) -> ParkingPilot:
        assert self.mission.parking  # without it no sign leads here
        return ParkingPilot(mission=self.mission, kind=self.mission.parking)

    def start(self) -> OrdersProgress:
        """Return the state before the first order."""
        return OrdersProgress()

    def looks(self, state: OrdersProgress) -> bool:
        """Return whether the next picture by the panels' camera matters."""
        return self._comes_to_panel(state) or (self._reads_signs and state.leg is not None)

    def look(self, state: OrdersProgress, pose: Pose2, detections: Detections) -> OrdersProgress:
        """Return the state after a picture by the panels' camera, taken at this pose."""
        if self._comes_to_panel(state):
            state = replace(state, orders=look(state.orders, detections))
        if not self._reads_signs or state.leg is None:
            return state
        line, mount = state.leg.line, self._mount
        return replace(state, signs=read_signs(state.signs, detections, mount, pose, line, state.s_m, SignParams()))

    def report(self, state: OrdersProgress) -> SignCategory | None:
        """Return the vertical sign that the last picture made sure of."""
        return state.signs.report

    def _comes_to_panel(self, state: OrdersProgress) -> bool:
        if state.orders.over:
            return False
        return state.leg is None or state.leg.line.length_m - state.s_m < LOOK_FROM_M

    @property
    def _reads_signs(self) -> bool:
        return "vertical_signs" in self.mission.elements

    @cached_property
    def _mount(self) -> CameraMount:
        return next(mount for mount in self.mission.rig.cameras if mount.name == "panel")

    def see(self, state: OrdersProgress, pose: Pose2, scan: LaserScan) -> OrdersProgress:
        """Return the state after a scan; only parking needs one."""
        if state.parking is None:
            return state
        return replace(state, parking=self._parking.see(state.parking, pose, scan))

    def steer(self, state: OrdersProgress, pose: Pose2, motion: Motion) -> tuple[OrdersProgress, Motion]:
        """Return the next state and the command. At rest it gives way to no noise in the pose."""
        state = self._take_order(state, pose, motion)
        if state.parking is not None:
            parking, command = self._parking.steer(state.parking, pose, motion)
            return replace(state, parking=parking), command
        if state.leg is None:
            return state, Motion()
        tracker = Tracker(
            robot=self.mission.robot,
            period_s=self.mission.control_period_s,
            timetable=state.leg,
            params=self.params,
        )
        s_m, command = tracker.track(state.s_m, pose, motion)
        return replace(state, s_m=s_m), command if command.v_mps > 0 else Motion()

    def _take_order(self, state: OrdersProgress, pose: Pose2, motion: Motion) -> OrdersProgress:
        """Return the state on the next leg, from where the robot is, if it has been ordered; one parks from a stand."""
        orders, sign = take_order(self.mission, state.orders)
        if sign is None or (sign == "park" and motion != Motion()):
            return state
        if sign == "park":
            return OrdersProgress(orders=orders, parking=self._parking.start())
        ahead = self._leg(state, sign).ahead(pose)
        leg = fastest(ahead, self._limits, start_mps=motion.v_mps)
        return OrdersProgress(orders=orders, leg=leg, way=way_of(sign))

    def _leg(self, state: OrdersProgress, sign: PanelSign) -> Leg:
        course, loop = self.mission.course, loop_behind(state.orders.crosswalk)
        if sign == "end":
            braking_m = self._limits.speed_mps**2 / (2 * self._limits.acceleration_mps2)
            return last_leg(course, loop, state.way, braking_m + BEYOND_FINISH_M)
        stop_m = stop_before_m(course, self.mission.robot)
        return half_lap_leg(course, loop, state.way, way_of(sign), stop_m)
