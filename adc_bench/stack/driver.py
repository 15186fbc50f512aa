"""The driver: waits for the green arrow, drives its laps in the right lane, stops behind the finish line."""

import math
from dataclasses import dataclass, field, replace
from typing import Literal

from adc_bench.api import Command, Mission, Observation
from adc_bench.geometry import Pose2
from adc_bench.stack.ekf import Belief
from adc_bench.stack.localizer import Detect, Localizer, LocalizerState
from adc_bench.stack.panel import PanelReading, read_panel
from adc_bench.stack.path_following import Follower, FollowParams, follow

Phase = Literal["wait", "drive", "stop"]


@dataclass(frozen=True, kw_only=True)
class DriverParams:
    """How it drives; without `corrections` the pose is dead reckoning."""

    speed_mps: float = 1.0
    corrections: bool = True
    beyond_finish_m: float = 0.3
    follow: FollowParams = field(default_factory=FollowParams)


@dataclass(frozen=True, kw_only=True, eq=False)
class DriverState:
    """Everything that one control step hands to the next."""

    phase: Phase
    localizer: LocalizerState
    follower: Follower
    panel: PanelReading = field(default_factory=PanelReading)
    v_mps: float = 0.0
    omega_radps: float = 0.0


class Driver:
    """The thesis' driver as an agent of the benchmark."""

    def __init__(self, detect: Detect, params: DriverParams | None = None) -> None:
        self._detect = detect
        self._params = params or DriverParams()

    def start(self, mission: Mission) -> None:
        """Take the mission's map, robot and rig."""
        self._mission = mission
        self._localizer = Localizer(mission=mission, detect=self._detect)
        at_start = self._localizer.start()
        self._state = DriverState(phase="wait", localizer=at_start, follower=Follower(s_m=at_start.s_m))

    def step(self, observation: Observation) -> Command:
        """Answer with the command, and the estimate at the observation's time."""
        state = replace(self._state, localizer=self._localize(observation))
        state = self._decide(state, observation)
        self._state = self._steer(state)
        belief = self._state.localizer.belief
        return Command(
            v_mps=self._state.v_mps,
            omega_radps=self._state.omega_radps,
            pose_world_robot=belief.pose,
            covariance=covariance_figures(belief),
        )

    def _localize(self, observation: Observation) -> LocalizerState:
        """Return the state at the observation's time; while it waits, the start pose stands."""
        localizer, state = self._localizer, self._state.localizer
        road = observation.pictures.get("road")
        if road is not None and self._params.corrections and self._state.phase != "wait":
            state = localizer.move(state, observation.encoders, road.time_s)
            state = localizer.look(state, road.rgb)
        return localizer.move(state, observation.encoders, observation.time_s)

    def _decide(self, state: DriverState, observation: Observation) -> DriverState:
        """Return the state with its phase brought up to date."""
        panel = observation.pictures.get("panel")
        if state.phase == "wait" and panel is not None:
            reading = read_panel(state.panel, self._detect(panel.rgb))
            return replace(state, panel=reading, phase="drive" if reading.sign == "up" else "wait")
        finish_m = self._mission.laps * self._localizer.lane_map.lap.length_m + self._params.beyond_finish_m
        return replace(state, phase="stop") if state.phase == "drive" and state.localizer.s_m > finish_m else state

    def _steer(self, state: DriverState) -> DriverState:
        """Return the state with the next command; it will act one control step from now, so it aims from there."""
        if state.phase != "drive":
            return replace(state, v_mps=0.0, omega_radps=0.0)
        period_s, speed_mps = self._mission.control_period_s, self._params.speed_mps
        delay_s = period_s + self._mission.latency_s
        pose = state.localizer.belief.pose @ arc_step(state.v_mps * delay_s, state.omega_radps * delay_s)
        lap = self._localizer.lane_map.lap
        follower, omega_radps = follow(state.follower, pose, lap, speed_mps, period_s, self._params.follow)
        return replace(state, follower=follower, v_mps=speed_mps, omega_radps=omega_radps)


def covariance_figures(belief: Belief) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return the covariance's nine figures by rows."""
    a, b, c, d, e, f, g, h, i = (float(v) for v in belief.covariance.ravel())
    return a, b, c, d, e, f, g, h, i


def arc_step(length_m: float, turn_rad: float) -> Pose2:
    """Return the pose at the end of an arc of this length and turn, seen from its start."""
    half = turn_rad / 2
    chord_m = length_m * (math.sin(half) / half if half else 1.0)
    return Pose2(x_m=chord_m * math.cos(half), y_m=chord_m * math.sin(half), yaw_rad=turn_rad)
