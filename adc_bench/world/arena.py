"""What stands on the floor, as data: gantry, panels, walls and tunnel, each a set of solid boxes."""

import math
from functools import lru_cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Path
from adc_bench.world.course import Course
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]


class ArenaSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Figures of the arena's furniture; part of the rules."""

    hall_half_length_m: float = 11.0
    hall_half_width_m: float = 7.0
    hall_height_m: float = 4.0
    gantry_width_m: float = 2.0
    gantry_height_m: float = 1.5
    gantry_bar_m: float = 0.05
    panel_width_m: float = 0.4758
    panel_height_m: float = 0.2673
    panel_depth_m: float = 0.04
    panel_centre_z_m: float = 1.0
    panel_tilt_rad: float = math.radians(25)
    tunnel_clear_half_width_m: float = 0.85
    tunnel_height_m: float = 1.3
    tunnel_wall_m: float = 0.03


class Tunnel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An opaque tunnel over both lanes, along the middle of the road of the lap from `start_s_m` on."""

    start_s_m: float
    length_m: float


PANEL_NAMES = ("panel_facing_west", "panel_facing_east")
TUNNEL_ALBEDO = (0.12, 0.12, 0.13)
JOINT_M = 0.01  # the tunnel's segments reach this far into each other


def panel_solids(spec: ArenaSpec, course: Course) -> tuple[Solid, Solid]:
    """Return the two panels over the crosswalk: seen by +x traffic, then by -x traffic. Their screen is the +x side
    of the box (its own frame), tilted down.
    """
    c = course.spec
    size = (spec.panel_depth_m, spec.panel_width_m, spec.panel_height_m)
    return tuple(  # type: ignore[return-value]
        Solid(
            name=name,
            kind="panel",
            centre_m=(0.0, y_m, spec.panel_centre_z_m),
            size_m=size,
            yaw_rad=yaw,
            pitch_rad=spec.panel_tilt_rad,
            albedo=(0.03, 0.03, 0.03),
        )
        for name, y_m, yaw in zip(
            PANEL_NAMES, (-c.lane_outer_radius_m, -c.lane_inner_radius_m), (math.pi, 0.0), strict=True
        )
    )


def gantry_solids(spec: ArenaSpec, course: Course) -> tuple[Solid, ...]:
    """Return the posts, the beam and the hangers of the panels."""
    y = -course.spec.radius_centre_m
    bar, height, half = spec.gantry_bar_m, spec.gantry_height_m, spec.gantry_width_m / 2
    posts = [
        Solid(
            name=f"gantry_post_{side}",
            kind="gantry",
            centre_m=(0.0, y + sign * half, height / 2),
            size_m=(bar, bar, height),
        )
        for side, sign in (("left", 1.0), ("right", -1.0))
    ]
    beam = Solid(
        name="gantry_beam",
        kind="gantry",
        centre_m=(0.0, y, height - bar / 2),
        size_m=(bar, 2 * half - bar, bar),
    )
    drop = height - bar - spec.panel_centre_z_m
    hangers = [
        Solid(
            name=f"gantry_hanger_{panel.name}",
            kind="gantry",
            centre_m=(0.0, panel.centre_m[1], height - bar - drop / 2),
            size_m=(0.02, 0.03, drop),
        )
        for panel in panel_solids(spec, course)
    ]
    return (*posts, beam, *hangers)


def wall_solids(spec: ArenaSpec) -> tuple[Solid, ...]:
    """Return the four walls of the hall."""
    length, width, height = spec.hall_half_length_m, spec.hall_half_width_m, spec.hall_height_m
    long, short = (2 * length, 0.1, height), (0.1, 2 * width, height)
    return (
        Solid(name="wall_north", kind="wall", centre_m=(0.0, width + 0.05, height / 2), size_m=long),
        Solid(name="wall_south", kind="wall", centre_m=(0.0, -width - 0.05, height / 2), size_m=long),
        Solid(name="wall_east", kind="wall", centre_m=(length + 0.05, 0.0, height / 2), size_m=short),
        Solid(name="wall_west", kind="wall", centre_m=(-length - 0.05, 0.0, height / 2), size_m=short),
    )


def road_centre(course: Course) -> Path:
    """Return the middle of the road along the lap: the right lane's centre moved left by half a lane pitch."""
    c = course.spec
    return course.lap.offset((c.radius_outer_m - c.radius_centre_m) / 2)


@lru_cache(maxsize=8)
def tunnel_s_on_centre(course: Course, tunnel: Tunnel) -> tuple[float, float]:
    """Return the stretch (from, to) of `road_centre` that the tunnel covers."""
    centre = road_centre(course)
    pose = course.lap.pose(tunnel.start_s_m)
    share = tunnel.start_s_m / course.lap.length_m * centre.length_m
    s, _ = centre.project([(pose.x_m, pose.y_m)], around_s_m=share, window_m=3.0)
    return float(s[0]), float(s[0]) + tunnel.length_m


def tunnel_solids(spec: ArenaSpec, course: Course, tunnel: Tunnel) -> tuple[Solid, ...]:
    """Return the tunnel's walls and roof, in straight segments of about 0.4 m that meet at their ends."""
    s0, s1 = tunnel_s_on_centre(course, tunnel)
    stations = road_centre(course).poses(np.linspace(s0, s1, max(1, math.ceil((s1 - s0) / 0.4)) + 1))
    normals = np.stack([-np.sin(stations[:, 2]), np.cos(stations[:, 2])], axis=1)
    reach = spec.tunnel_clear_half_width_m + spec.tunnel_wall_m / 2
    left, right = stations[:, :2] + reach * normals, stations[:, :2] - reach * normals
    solids = []
    for k in range(len(stations) - 1):
        solids += [
            _tunnel_wall(spec, f"tunnel_left_{k:02d}", left[k], left[k + 1]),
            _tunnel_wall(spec, f"tunnel_right_{k:02d}", right[k], right[k + 1]),
            _tunnel_roof(spec, f"tunnel_roof_{k:02d}", np.array([left[k], left[k + 1], right[k + 1], right[k]])),
        ]
    return tuple(solids)


def _tunnel_wall(spec: ArenaSpec, name: str, start: Array, end: Array) -> Solid:
    x_m, y_m = (start + end) / 2
    length, yaw = math.hypot(*(end - start)), math.atan2(*(end - start)[::-1])
    return Solid(
        name=name,
        kind="tunnel",
        centre_m=(float(x_m), float(y_m), spec.tunnel_height_m / 2),
        size_m=(length + 2 * JOINT_M, spec.tunnel_wall_m, spec.tunnel_height_m),
        yaw_rad=yaw,
        albedo=TUNNEL_ALBEDO,
    )


def _tunnel_roof(spec: ArenaSpec, name: str, corners: Array) -> Solid:
    """Return the slab over one segment: the smallest rectangle along the road over its corners (4, 2)."""
    along = (corners[1] - corners[0]) + (corners[2] - corners[3])
    yaw = math.atan2(along[1], along[0])
    axes = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    local = corners @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    x_m, y_m = (low + high) / 2 @ axes
    length, width = high - low
    return Solid(
        name=name,
        kind="tunnel",
        centre_m=(float(x_m), float(y_m), spec.tunnel_height_m + spec.tunnel_wall_m / 2),
        size_m=(float(length) + 2 * JOINT_M, float(width) + spec.tunnel_wall_m, spec.tunnel_wall_m),
        yaw_rad=yaw,
        albedo=TUNNEL_ALBEDO,
    )
