"""Where the robot is: encoders predict, what the road camera sees corrects."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from adc_bench.api import EncoderSamples, Mission, Observation
from adc_bench.geometry import wrap_rad
from adc_bench.stack.birds_eye import BirdsEye
from adc_bench.stack.circle import see_circle
from adc_bench.stack.circuits import Circuits, Place, Ways
from adc_bench.stack.crosswalk import CrosswalkFinder
from adc_bench.stack.ekf import (
    Belief,
    Innovation,
    SeenLine,
    WheelModel,
    compare_line,
    compare_point,
    correct,
    nearest,
    start_belief,
)
from adc_bench.stack.lane_lines import LaneLines, find_lane_lines
from adc_bench.stack.lane_map import LaneMap, Stretch
from adc_bench.stack.odometry import WheelTrack, advance
from adc_bench.stack.paint import Paint, find_paint
from adc_bench.stack.path_following import wrap_to
from adc_bench.stack.straight import see_straight
from adc_bench.world.categories import CATEGORY_ID
from adc_bench.world.course import Course
from adc_bench.world.frame import Detections

Detect = Callable[[NDArray[np.uint8]], Detections]
MOVED_M = 1e-3


@dataclass(frozen=True, kw_only=True)
class LocalizerParams:
    """How what is seen is weighed.

    Attributes:
        corrections: whether it is weighed at all; without, the pose is dead reckoning.
        repeats: how many pictures running share one error (camera tilt, uneven paint), see `ekf.correct`.
    """

    corrections: bool = True
    repeats: float = 8.0
    least_score: float = 0.4
    crosswalk_ahead_m: tuple[float, float] = (0.5, 3.5)


@dataclass(frozen=True, kw_only=True, eq=False)
class Sighting:
    """A landmark seen, whether it is inside its gate or not, against the belief that it met."""

    kind: Literal["line", "circle", "corner"]
    innovation: Innovation


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalizerState:
    """The belief with all that carries it from picture to picture; `sightings` are those of the last observation."""

    belief: Belief
    place: Place
    track: WheelTrack | None = None
    lines: LaneLines = field(default_factory=LaneLines)
    sightings: tuple[Sighting, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Localizer:
    """Pure steps from state to state, for one mission."""

    mission: Mission
    detect: Detect
    params: LocalizerParams = field(default_factory=LocalizerParams)

    @cached_property
    def _circuits(self) -> Circuits:
        return Circuits(course=Course(spec=self.mission.course))

    @cached_property
    def _lane_maps(self) -> Mapping[Ways, LaneMap]:
        course = self._circuits.course
        return {ways: LaneMap(course=course, lap=each.path) for ways, each in self._circuits.by_ways.items()}

    @cached_property
    def birds_eye(self) -> BirdsEye:
        """The road camera's view of the floor."""
        return BirdsEye(mount=self.mission.rig.camera("road"))

    @cached_property
    def _crosswalk(self) -> CrosswalkFinder:
        return CrosswalkFinder(spec=self.mission.course, birds_eye=self.birds_eye)

    @cached_property
    def _wheels(self) -> WheelModel:
        robot = self.mission.robot
        return WheelModel(radius_m=robot.wheel_radius_m, separation_m=robot.wheel_separation_m)

    def start(self) -> LocalizerState:
        """Return the state at the mission's start pose."""
        pose = self.mission.start_pose
        return LocalizerState(belief=start_belief(pose), place=self._circuits.start(pose))

    def step(self, state: LocalizerState, observation: Observation) -> LocalizerState:
        """Return the state at the observation's time; until the robot moves, the start pose stands."""
        road, state = observation.pictures.get("road"), replace(state, sightings=())
        if road is not None and self.params.corrections and self._has_moved(state):
            state = self.look(self.move(state, observation.encoders, road.time_s), road.rgb)
        return self.move(state, observation.encoders, observation.time_s)

    def _has_moved(self, state: LocalizerState) -> bool:
        pose, start = state.belief.pose, self.mission.start_pose
        return math.hypot(pose.x_m - start.x_m, pose.y_m - start.y_m) > MOVED_M

    def move(self, state: LocalizerState, encoders: EncoderSamples, until_s: float) -> LocalizerState:
        """Return the state at `until_s` by the encoders."""
        ticks = self.mission.robot.encoder_ticks_per_turn
        belief, track = advance(state.belief, state.track, encoders, until_s, self._wheels, ticks)
        return replace(state, belief=belief, track=track, place=self._circuits.follow(state.place, belief.pose))

    def look(self, state: LocalizerState, rgb: NDArray[np.uint8]) -> LocalizerState:
        """Return the state corrected by a road picture (height, width, 3) taken where the state is."""
        paint, lane_map = find_paint(self.birds_eye, rgb), self._lane_maps[state.place.ways]
        lines = find_lane_lines(state.lines, paint, lane_map.half_lane_m)
        belief, seen = state.belief, []
        for stretch in lane_map.stretches(lines, belief, state.place.s_m):
            sighting = self._compare_stretch(lane_map, belief, stretch)
            if sighting is not None:
                seen.append(sighting)
                belief = self._believe(belief, sighting)
        corners = self._compare_crosswalk(replace(state, belief=belief), rgb, paint)
        for corner in corners:
            belief = self._believe(belief, corner)
        return replace(state, belief=belief, lines=lines, sightings=(*seen, *corners))

    def _believe(self, belief: Belief, sighting: Sighting) -> Belief:
        """Return the belief after a sighting, which counts if it is inside its gate."""
        innovation = sighting.innovation
        return correct(belief, innovation, self.params.repeats) if innovation.inside_gate else belief

    def _compare_stretch(self, lane_map: LaneMap, belief: Belief, stretch: Stretch) -> Sighting | None:
        """Return what a stretch of lane says, against the nearest landmark of its kind; None where it says nothing."""
        if stretch.curvature_pm == 0:
            seen_line = see_straight(stretch.points_robot, self.birds_eye)
            if seen_line is None:
                return None
            line = SeenLine(normal_rad=float(seen_line.parameters[0]), distance_m=float(seen_line.parameters[1]))
            known = lane_map.straights()
            return _sighting("line", (compare_line(belief, line, seen_line.covariance, each) for each in known))
        circle = see_circle(stretch.by_radius(), stretch.curvature_pm, self.birds_eye)
        if circle is None:
            return None
        centres = lane_map.centres(stretch.curvature_pm)
        seen, noise = circle.parameters, circle.covariance
        return _sighting("circle", (compare_point(belief, seen, noise, centre) for centre in centres))

    def _compare_crosswalk(self, state: LocalizerState, rgb: NDArray[np.uint8], paint: Paint) -> list[Sighting]:
        """Return what the near corners of the crosswalk say, each against the nearest corner of the map."""
        road_yaw_rad = self._crosswalk_ahead(state)
        if road_yaw_rad is None:
            return []
        box = self._best_crosswalk(self.detect(rgb))
        seen = box and self._crosswalk.find(box, wrap_rad(road_yaw_rad - state.belief.pose.yaw_rad), paint)
        if not seen:
            return []
        belief, found = state.belief, []
        for corner, covariance in zip(seen.corners_robot, seen.covariances, strict=True):
            candidates = self._circuits.course.crosswalk_corners
            sighting = _sighting("corner", (compare_point(belief, corner, covariance, each) for each in candidates))
            if sighting is not None:
                found.append(sighting)
        return found

    def _crosswalk_ahead(self, state: LocalizerState) -> float | None:
        """Return the road's direction at the next crosswalk passage, or None while that is far: no need to look."""
        circuit, (low, high) = self._circuits.by_ways[state.place.ways], self.params.crosswalk_ahead_m
        for s_m in (0.0, circuit.crosswalk_back_m):
            if low < wrap_to(s_m - state.place.s_m, circuit.path.length_m) < high:
                return circuit.path.pose(s_m).yaw_rad
        return None

    def _best_crosswalk(self, detections: Detections) -> tuple[float, float, float, float] | None:
        wanted = CATEGORY_ID["crosswalk"]
        for box, score, category in zip(detections.boxes_px, detections.scores, detections.category_ids, strict=True):
            if int(category) == wanted and score >= self.params.least_score:
                x0, y0, x1, y1 = (float(v) for v in box)
                return x0, y0, x1, y1
        return None


def _sighting(kind: Literal["line", "circle", "corner"], candidates: Iterable[Innovation]) -> Sighting | None:
    """Return a sighting of the nearest landmark of its kind; None where the map has none."""
    innovation = nearest(candidates)
    return None if innovation is None else Sighting(kind=kind, innovation=innovation)
