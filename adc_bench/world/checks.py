"""Refusing arenas that cannot be: things inside each other or outside the hall, blocked road-works, absurd cameras."""

import math
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import shapely

from adc_bench.errors import InputError
from adc_bench.geometry import Pose2
from adc_bench.world.arena import ArenaSpec, Tunnel
from adc_bench.world.course import Course
from adc_bench.world.footprints import Extents, extents
from adc_bench.world.layout import Layout
from adc_bench.world.scenario import Scenario, arena_solids
from adc_bench.world.sensors import CameraMount, SensorRig
from adc_bench.world.solids import Body, Solid
from adc_bench.world.works import CORRIDOR_WIDTH_M, blocked_by, is_swapped, layout_bodies

Value = TypeVar("Value")

TOUCH_M = 1e-3  # things may reach this far into each other
TOLD = 4  # culprits named in one message
CAMERA_REACH_M, CAMERA_HEIGHT_MAX_M = 1.0, 2.0
PICTURE_MAX_PX = 4096
CONES_MIN = 2  # of a row


def check_scenario(scenario: Scenario, where: str) -> None:
    """Check a whole scenario.

    Raises:
        InputError: two things overlap, one stands outside the hall, the road-works' corridor is blocked, a camera is
            below the floor or otherwise absurd. The culprits are named.
    """
    _check_rig(scenario.rig, where)
    _check_layout(scenario.layout, scenario.course, where)
    _check_things(scenario.layout, scenario.solids, scenario.bodies, scenario.arena_spec, where)


def check_layout(layout: Layout, where: str) -> None:
    """Check a layout alone on the default course and in the default hall.

    Raises:
        InputError: as `check_scenario`.
    """
    course, arena = Course(), ArenaSpec()
    _check_layout(layout, course, where)
    _check_things(layout, arena_solids(arena, course, layout), layout_bodies(layout), arena, where)


def check_start(scenario: Scenario, start: Pose2, where: str) -> None:
    """Check that the robot has room where it starts.

    Raises:
        InputError: something stands there; it is named.
    """
    things, robot = extents(scenario.solids, scenario.bodies), scenario.robot
    half = np.array([robot.length_m, robot.width_m]) / 2
    body = shapely.Polygon(start.transform(half * [(1, 1), (-1, 1), (-1, -1), (1, -1)]))
    low = np.flatnonzero(things.low[:, 2] < max(robot.height_m, *(mount.z_m for mount in scenario.rig.cameras)))
    met = _once([things.owner[k] for k in low if body.intersects(things.footprint(int(k)))])
    if met:
        raise InputError(
            where=where,
            found=f"overlapping: the robot at its start and {_listed(met)}",
            wanted=f"free floor at ({start.x_m:.2f}, {start.y_m:.2f})",
            todo="move it away",
        )


def _check_rig(rig: SensorRig, where: str) -> None:
    names = [mount.name for mount in rig.cameras]
    if rig.semantic and rig.semantic.camera not in names:
        raise InputError(
            where=where,
            found=f"a semantic camera on {rig.semantic.camera!r}",
            wanted=f"a camera of the rig: {_listed(names)}",
            todo="name one of them",
        )
    latencies_s = [rig.encoders.latency_s, rig.imu.latency_s, *(mount.latency_s for mount in rig.cameras)]
    latencies_s += [rig.laser.latency_s] if rig.laser else []
    if not all(0 <= latency_s < math.inf for latency_s in latencies_s):
        raise InputError(where=where, found="a sensor's negative latency_s", wanted="0 or more seconds", todo="mend it")
    for mount in rig.cameras:
        for good, found, wanted in _mount_faults(mount):
            if not good:
                raise InputError(
                    where=where, found=f"camera {mount.name!r} {found}", wanted=wanted, todo="mend that camera's mount"
                )


def _mount_faults(mount: CameraMount) -> tuple[tuple[bool, str, str], ...]:
    """Return (is it good, what was found, what was wanted) for each thing to know about a mount. NaN is never good."""
    reach, top, side = CAMERA_REACH_M, CAMERA_HEIGHT_MAX_M, PICTURE_MAX_PX
    pitch, hfov = math.degrees(mount.pitch_down_rad), math.degrees(mount.hfov_rad)
    width, height = mount.width_px, mount.height_px
    return (
        (mount.z_m > 0, f"is below the floor: z_m = {mount.z_m:g}", f"0 < z_m <= {top:g}"),
        (mount.z_m <= top, f"is too high: z_m = {mount.z_m:g}", f"0 < z_m <= {top:g}"),
        (abs(mount.x_m) <= reach, f"is off the robot: x_m = {mount.x_m:g}", f"-{reach:g} <= x_m <= {reach:g}"),
        (abs(pitch) <= 90, f"has a pitch of {pitch:g} degrees", "-90 to 90 degrees"),
        (0 < hfov < 180, f"has a field of view of {hfov:g} degrees", "between 0 and 180 degrees"),
        (
            min(width, height) >= 1 and max(width, height) <= side,
            f"has pictures of {width} x {height}",
            f"1 to {side} pixels a side",
        ),
    )


def _check_layout(layout: Layout, course: Course, where: str) -> None:
    """Check what must hold before there are any solids."""
    if layout.tunnel:
        _check_tunnel(layout.tunnel, course, where)
    rows = {"works.left": layout.works.left, "works.right": layout.works.right} if layout.works else {}
    for key, row in rows.items():
        if len(row) < CONES_MIN:
            raise InputError(
                where=where,
                found=f"{len(row)} in {key}",
                wanted=f"at least {CONES_MIN} cones in each row",
                todo="add cones, or remove the road-works",
            )


def _check_tunnel(tunnel: Tunnel, course: Course, where: str) -> None:
    lap_m = course.lap.length_m
    for key, value, low, high in (
        ("start_s_m", tunnel.start_s_m, 0.0, lap_m),
        ("length_m", tunnel.length_m, 0.1, lap_m / 4),
    ):
        if not low <= value <= high:
            raise InputError(
                where=where,
                found=f"tunnel.{key} = {value:g}",
                wanted=f"{low:g} to {high:.2f}",
                todo="mend that key",
            )


def _check_things(
    layout: Layout, solids: Sequence[Solid], bodies: Sequence[Body], arena: ArenaSpec, where: str
) -> None:
    things = extents(solids, bodies)
    outside = _outside(things, arena)
    if outside:
        size = f"{2 * arena.hall_half_length_m:g} x {2 * arena.hall_half_width_m:g} x {arena.hall_height_m:g} m"
        raise InputError(
            where=where,
            found=f"outside the hall: {_listed(outside)}",
            wanted=f"everything inside the hall of {size}",
            todo="move it inside",
        )
    overlaps = _overlaps(things)
    if overlaps:
        raise InputError(
            where=where,
            found=f"overlapping: {_listed([f'{a} and {b}' for a, b in overlaps])}",
            wanted="things that keep clear of each other",
            todo="move one of each pair",
        )
    if layout.works and is_swapped(layout.works):
        raise InputError(
            where=where,
            found="works.left lies to the right of works.right in driving order",
            wanted="both rows in driving order, left and right as the driver sees them",
            todo="swap the rows, or turn both round",
        )
    blocked = blocked_by(layout.works, things) if layout.works else ()
    if blocked:
        raise InputError(
            where=where,
            found=f"the corridor of the road-works is blocked by {_listed(blocked)}",
            wanted=f"a way of {CORRIDOR_WIDTH_M:.2f} m between the rows, from the first cones to the last",
            todo="move them apart",
        )


def _outside(things: Extents, arena: ArenaSpec) -> list[str]:
    """Return the things that are not inside the hall; the walls are its limits."""
    reach = np.array([arena.hall_half_length_m, arena.hall_half_width_m])
    within = np.all((things.low[:, :2] >= -reach - TOUCH_M) & (things.high[:, :2] <= reach + TOUCH_M), axis=1)
    within &= (things.low[:, 2] >= -TOUCH_M) & (things.high[:, 2] <= arena.hall_height_m + TOUCH_M)
    return _once([things.owner[k] for k in np.flatnonzero(~within) if things.owner[k] != "walls"])


def _overlaps(things: Extents) -> list[tuple[str, str]]:
    """Return the pairs of things that reach into each other by more than `TOUCH_M`.

    The panels' hangers may pass through the roof of a tunnel over the crosswalk.
    """
    low, high = things.low + TOUCH_M / 2, things.high - TOUCH_M / 2
    owner = np.unique(np.array(things.owner), return_inverse=True)[1]
    meet = np.triu(owner[:, None] != owner[None, :])
    for axis in range(3):
        meet &= (low[:, None, axis] < high[None, :, axis]) & (low[None, :, axis] < high[:, None, axis])
    pairs = []
    for first, second in np.argwhere(meet):
        names = things.owner[first], things.owner[second]
        shrunk = [things.footprint(k).buffer(-TOUCH_M / 2) for k in (first, second)]
        if set(names) != {"gantry", "tunnel"} and shapely.intersects(*shrunk):
            pairs.append(names)
    return _once(pairs)


def _once(values: list[Value]) -> list[Value]:
    return list(dict.fromkeys(values))


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - TOLD} more" if len(names) > TOLD else ""
    return ", ".join(names[:TOLD]) + more
