"""The reference's way of driving where panels order: leg by leg, each at the limits of the robot.

A leg ends at rest in the stop zone before the next crosswalk. When the sign there is believed in time, the next leg
takes the robot over at the speed that it has; until then it brakes as late as it can, and then it waits. Where boxes
or road-works may stand, the way ahead is planned anew with every scan of the laser.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from adc_bench.api import LaserScan, Mission
from adc_bench.geometry import Pose2
from adc_bench.stack.detour import Detour, DetourParams
from adc_bench.stack.laser_clusters import scan_points
from adc_bench.stack.legs import Leg, half_lap_leg, last_leg, stop_before_m, way_of
from adc_bench.stack.obstacle_map import ObstacleMap, see
from adc_bench.stack.orders import OrdersState, look, loop_behind, take_order
from adc_bench.stack.panel import uncut
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

LOOK_FROM_M = 3.0  # before a leg's end: from farther off and aslant an arrow may be taken for another


@dataclass(frozen=True, kw_only=True, eq=False)
class OrdersProgress:
    """The orders, the leg under way (None before the first), where on its lane the robot was, the speeds that it keeps
    (None until they are planned), how it goes round its loop, and what is known to stand.

    The start is as the end of a leg by the long straight, which `turn` leads over. `parking` is None until its turn.
    """

    orders: OrdersState = field(default_factory=OrdersState)
    leg: Leg | None = None
    s_m: float = 0.0
    timetable: Timetable | None = None
    way: Way = "turn"
    known: ObstacleMap = field(default_factory=ObstacleMap)
    parking: ParkingState | None = None
    signs: SignsState = field(default_factory=SignsState)


@dataclass(frozen=True, kw_only=True)
class OrdersPilot:
    """Waits for an order before each crosswalk, and carries it out."""

    mission: Mission
    speed_mps: float
    params: TrackerParams = field(default_factory=TrackerParams)
    detour: DetourParams = field(default_factory=DetourParams)

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
            state = replace(state, orders=look(state.orders, uncut(detections, self._mount)))
        if not self._reads_signs or state.leg is None or state.timetable is None:
            return state
        line, mount = state.timetable.line, self._mount
        on_line_m = float(np.interp(state.s_m, line.path_s_m, line.s_m))
        return replace(state, signs=read_signs(state.signs, detections, mount, pose, line, on_line_m, SignParams()))

    def report(self, state: OrdersProgress) -> SignCategory | None:
        """Return the vertical sign that the last picture made sure of."""
        return state.signs.report

    def _comes_to_panel(self, state: OrdersProgress) -> bool:
        if state.orders.over:
            return False
        return state.leg is None or state.leg.end_m - state.s_m < LOOK_FROM_M

    @property
    def _reads_signs(self) -> bool:
        return "vertical_signs" in self.mission.elements

    @cached_property
    def _mount(self) -> CameraMount:
        return next(mount for mount in self.mission.rig.cameras if mount.name == "panel")

    def see(self, state: OrdersProgress, pose: Pose2, scan: LaserScan) -> OrdersProgress:
        """Return the state after a scan: to be planned anew where something may stand in the way."""
        if state.parking is not None:
            return replace(state, parking=self._parking.see(state.parking, pose, scan))
        laser = self.mission.rig.laser
        if laser is None or not self._goes_round:
            return state
        known = see(state.known, scan_points(scan, laser), pose, scan.time_s, self.detour.map)
        return replace(state, known=known, timetable=None)

    @property
    def _goes_round(self) -> bool:
        return bool({"boxes", "works"} & set(self.mission.elements))

    def steer(self, state: OrdersProgress, pose: Pose2, motion: Motion) -> tuple[OrdersProgress, Motion]:
        """Return the next state and the command. At rest it gives way to no noise in the pose."""
        state = self._take_order(state, pose, motion)
        if state.parking is not None:
            parking, command = self._parking.steer(state.parking, pose, motion)
            return replace(state, parking=parking), command
        if state.leg is None:
            return state, Motion()
        timetable = state.timetable or self._plan(state.leg, state, pose, motion)
        tracker = Tracker(
            robot=self.mission.robot,
            period_s=self.mission.control_period_s,
            timetable=timetable,
            params=self.params,
        )
        line = timetable.line
        on_line_m, command = tracker.track(float(np.interp(state.s_m, line.path_s_m, line.s_m)), pose, motion)
        s_m = float(np.interp(on_line_m, line.s_m, line.path_s_m))
        return replace(state, s_m=s_m, timetable=timetable), command if command.v_mps > 0 else Motion()

    def _take_order(self, state: OrdersProgress, pose: Pose2, motion: Motion) -> OrdersProgress:
        """Return the state on the next leg, from where the robot is, if it has been ordered; one parks from a stand."""
        orders, sign = take_order(self.mission, state.orders)
        if sign is None or (sign == "park" and motion != Motion()):
            return state
        if sign == "park":
            return OrdersProgress(orders=orders, parking=self._parking.start())
        leg = self._leg(state, sign)
        return OrdersProgress(orders=orders, leg=leg, s_m=leg.place_m(pose), way=way_of(sign), known=state.known)

    def _plan(self, leg: Leg, state: OrdersProgress, pose: Pose2, motion: Motion) -> Timetable:
        """Return the speeds from where the robot is on its leg, and as fast as it is."""
        if not self._goes_round:
            return fastest(leg.ahead(state.s_m), self._limits, start_mps=motion.v_mps)
        detour = Detour(mission=self.mission, route=leg.lane, end_m=leg.end_m, params=self._careful)
        return detour.timetable(state.known, state.s_m, pose, motion.v_mps)

    @cached_property
    def _careful(self) -> DetourParams:
        """Where something may stand: no faster than the whole drive."""
        p = self.detour
        return replace(
            p,
            speed_mps=min(self.speed_mps, p.speed_mps),
            works_speed_mps=min(self.speed_mps, p.works_speed_mps),
        )

    def _leg(self, state: OrdersProgress, sign: PanelSign) -> Leg:
        course, loop = self.mission.course, loop_behind(state.orders.crosswalk)
        if sign == "end":
            braking_m = self._limits.speed_mps**2 / (2 * self._limits.acceleration_mps2)
            return last_leg(course, loop, state.way, braking_m + BEYOND_FINISH_M)
        stop_m = stop_before_m(course, self.mission.robot)
        return half_lap_leg(course, loop, state.way, way_of(sign), stop_m)
