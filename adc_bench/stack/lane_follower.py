"""The driver without a map: it keeps to the lane whose lines its road camera shows, and knows no more of the road."""

from dataclasses import dataclass, field, replace

from adc_bench.api import Command, Mission, Observation
from adc_bench.geometry import Pose2, wrap_rad
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.driver import covariance_figures
from adc_bench.stack.lane_arc import LaneArc, LaneArcParams, abreast, correct
from adc_bench.stack.lane_lines import LaneLines, find_lane_lines
from adc_bench.stack.localizer import Detect, Localizer, LocalizerParams, LocalizerState
from adc_bench.stack.paint import find_paint
from adc_bench.stack.panel import PanelReading, read_panel
from adc_bench.stack.prediction import UnderWay, at_rest, send, when_acting
from adc_bench.stack.tracker import TrackerParams, gains
from adc_bench.world.robot import Motion


@dataclass(frozen=True, kw_only=True, eq=False)
class FollowerState:
    """Everything that one control step hands to the next; poses are those of the encoders alone."""

    place: LocalizerState
    arc: LaneArc
    under_way: UnderWay
    lines: LaneLines = field(default_factory=LaneLines)
    reading: PanelReading = field(default_factory=PanelReading)


class LaneFollower:
    """Waits for the green arrow, then follows the right-hand lane at one speed, straight on where the road branches.

    It looks at the panels until the arrow; the referee ends its run, for it counts no laps.
    """

    def __init__(self, detect: Detect, speed_mps: float) -> None:
        self._detect, self._speed_mps = detect, speed_mps
        self._arc_params, self._tracker_params = LaneArcParams(), TrackerParams()

    def start(self, mission: Mission) -> None:
        """Take the mission's robot, road camera and start pose, and how wide a lane is."""
        self._mission = mission
        self._odometry = Localizer(mission=mission, detect=self._detect, params=LocalizerParams(corrections=False))
        self._birds_eye = BirdsEye(mount=mission.rig.camera("road"))
        self._half_lane_m = (mission.course.radius_outer_m - mission.course.radius_centre_m) / 2
        self._state = FollowerState(
            place=self._odometry.start(),
            arc=LaneArc(pose=mission.start_pose),
            under_way=at_rest(mission.control_period_s, mission.latency_s),
        )

    def step(self, observation: Observation) -> Command:
        """Answer with the command, and the encoders' pose at the observation's time."""
        state = self._read(self._follow(self._state, observation), observation)
        state = replace(state, place=self._odometry.move(state.place, observation.encoders, observation.time_s))
        self._state, command = self._steer(state)
        belief = state.place.belief
        return Command(
            v_mps=command.v_mps,
            omega_radps=command.omega_radps,
            pose_world_robot=belief.pose,
            covariance=covariance_figures(belief),
        )

    def _follow(self, state: FollowerState, observation: Observation) -> FollowerState:
        """Return the state after a picture of the road, if there is one."""
        road = observation.pictures.get("road")
        if road is None:
            return state
        place = self._odometry.move(state.place, observation.encoders, road.time_s)
        lines = find_lane_lines(state.lines, find_paint(self._birds_eye, road.rgb), self._half_lane_m)
        arc = correct(state.arc, place.belief.pose, lines, self._half_lane_m, self._arc_params)
        return replace(state, place=place, lines=lines, arc=arc)

    def _read(self, state: FollowerState, observation: Observation) -> FollowerState:
        """Return the state after a picture of the panel, if there is one and the arrow is still awaited."""
        picture = observation.pictures.get("panel")
        if picture is None or state.reading.sign == "up":
            return state
        return replace(state, reading=read_panel(state.reading, self._detect(picture.rgb)))

    def _steer(self, state: FollowerState) -> tuple[FollowerState, Motion]:
        """Return the state after sending the next command, and that."""
        robot, period_s = self._mission.robot, self._mission.control_period_s
        pose, motion = when_acting(state.under_way, robot, state.place.belief.pose, period_s)
        command = self._along(state.arc, pose, motion) if state.reading.sign == "up" else Motion()
        return replace(state, under_way=send(state.under_way, robot, command, period_s)), command

    def _along(self, arc: LaneArc, pose: Pose2, motion: Motion) -> Motion:
        """Return the command that keeps to the arc, from pose and motion when it begins to act."""
        seen = abreast(arc, pose).pose.inverse() @ pose
        bound_m = self._tracker_params.offset_max_m
        by_offset, by_heading = gains(self._speed_mps, self._mission.control_period_s, self._tracker_params)
        back_radps = by_offset * min(max(seen.y_m, -bound_m), bound_m) + by_heading * wrap_rad(seen.yaw_rad)
        return Motion(v_mps=self._speed_mps, omega_radps=arc.curvature_pm * self._speed_mps - back_radps)
