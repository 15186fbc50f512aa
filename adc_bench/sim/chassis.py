"""The robot as a PhysX articulation: a hull with its cameras' mast on two driven wheels and a frictionless castor.

The root's frame is the robot's: x forward, y left, its origin on the floor midway between the wheels.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
import sapien
from numpy.typing import NDArray
from sapien import physx

from adc_bench.geometry import Pose2, Pose3
from adc_bench.sim.surfaces import HULL, ROLLING, from_sapien, to_sapien
from adc_bench.world.robot import RobotParams, RobotTruth
from adc_bench.world.sensors import CameraMount

Array = NDArray[np.float64]

# A joint turns about its own x: this quaternion lays that axis along the robot's y, so that forward is positive.
_AXLE = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
# Fewer let the wheels creep at standstill and lean to one side on the straight.
_SOLVER_ITERATIONS = 32


class ChassisSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the public figures of a robot leave open; our own choice, part of the rules.

    Inertia, torque and drive are shares of the robot's mass seen at the wheel's rim, so that they fit any robot.
    """

    ground_clearance_m: float = 0.025  # above the foot of a cone
    hull_friction: float = 0.2  # of the smooth hull; its mean with what it meets counts
    mast_margin_m: float = 0.03  # the mast reaches this far beyond the cameras' centres; its mass is the hull's
    castor_x_m: float = -0.18
    castor_radius_m: float = 0.02
    centre_of_mass_x_m: float = -0.04  # behind the axle, so that braking does not lift the castor
    centre_of_mass_z_m: float = 0.08
    wheel_mass_share: float = 0.04  # each wheel
    rotor_mass_share: float = 0.2  # each motor's rotor behind its gear
    torque_margin: float = 1.5  # of each motor, over what accelerates the whole robot at its limit
    drive_rate_hz: float = 600.0  # how fast a motor's controller removes a speed error


@dataclass(frozen=True, kw_only=True, eq=False)
class Chassis:
    """The robot's parts in a scene; all it tells is true."""

    root: physx.PhysxArticulationLinkComponent
    wheels: tuple[physx.PhysxArticulationLinkComponent, physx.PhysxArticulationLinkComponent]

    def set_wheel_speeds(self, speeds_radps: tuple[float, float]) -> None:
        """Tell the wheels' drives (left, right) what to hold."""
        for wheel, speed_radps in zip(self.wheels, speeds_radps, strict=True):
            wheel.joint.set_drive_velocity_target(speed_radps)

    def wheel_angles_rad(self) -> Array:
        """Return the joint angles (left, right), (2,), up to whole turns."""
        return np.asarray(self.root.articulation.qpos, dtype=np.float64)

    def pose_world_robot(self) -> Pose3:
        """Return where the robot is, with pitch and roll."""
        return from_sapien(self.root.entity_pose)

    def angular_velocity_radps(self) -> Array:
        """Return the angular velocity in the world, (3,)."""
        return np.asarray(self.root.angular_velocity, dtype=np.float64)

    def velocity_mps(self, pose_world_robot: Pose3) -> Array:
        """Return the velocity of the robot's origin in the world, (3,), at the pose where it is now.

        PhysX gives that of the centre of mass.
        """
        x, y, z = pose_world_robot.rotation @ self.root.cmass_local_pose.p
        wx, wy, wz = self.root.angular_velocity.tolist()
        turning_mps = np.array([wy * z - wz * y, wz * x - wx * z, wx * y - wy * x])
        at_origin: Array = self.root.linear_velocity - turning_mps
        return at_origin


def add_chassis(
    scene: sapien.Scene,
    spec: ChassisSpec,
    robot: RobotParams,
    truth: RobotTruth,
    cameras: Sequence[CameraMount],
    start: Pose2,
) -> Chassis:
    """Stand the robot, at rest, on the floor at `start`."""
    root = _hull(spec, robot, cameras)
    half_m = truth.wheel_separation_m / 2
    wheels = (
        _wheel(root, "wheel_left", spec, robot, y_m=half_m, radius_m=truth.wheel_radius_left_m),
        _wheel(root, "wheel_right", spec, robot, y_m=-half_m, radius_m=truth.wheel_radius_right_m),
    )
    for link in (root, *wheels):
        entity = sapien.Entity()
        entity.name = link.name
        entity.add_component(link)
        scene.add_entity(entity)
    articulation = root.articulation
    articulation.root_pose = to_sapien(start.to_pose3())
    articulation.solver_position_iterations = _SOLVER_ITERATIONS
    articulation.solver_velocity_iterations = 1
    articulation.sleep_threshold = 0.0
    return Chassis(root=root, wheels=wheels)


def _hull(
    spec: ChassisSpec, robot: RobotParams, cameras: Sequence[CameraMount]
) -> physx.PhysxArticulationLinkComponent:
    """Return the root link: the robot's outline above its clearance as one box, the castor under it, the mast on it."""
    size = np.array([robot.length_m, robot.width_m, robot.height_m - spec.ground_clearance_m])
    root = physx.PhysxArticulationLinkComponent(None)
    root.name = "hull"
    root.attach(HULL.box(tuple(size), (0.0, 0.0, (robot.height_m + spec.ground_clearance_m) / 2), spec.hull_friction))
    for shape in _mast(spec, robot, cameras):
        root.attach(shape)
    root.attach(ROLLING.ball(spec.castor_radius_m, spec.castor_radius_m, spec.castor_x_m, friction=0.0))
    mass_kg = robot.mass_kg * (1 - 2 * spec.wheel_mass_share)
    root.mass = mass_kg
    root.cmass_local_pose = sapien.Pose([spec.centre_of_mass_x_m, 0.0, spec.centre_of_mass_z_m])
    root.inertia = mass_kg / 12 * (np.sum(size**2) - size**2)  # a uniform box
    return root


def _mast(spec: ChassisSpec, robot: RobotParams, cameras: Sequence[CameraMount]) -> list[physx.PhysxCollisionShape]:
    """Return one box from the hull's top to the highest camera, as long as the cameras stand apart."""
    above = [mount for mount in cameras if mount.z_m > robot.height_m]
    if not above:
        return []
    margin_m = spec.mast_margin_m
    back_m, front_m = min(mount.x_m for mount in above) - margin_m, max(mount.x_m for mount in above) + margin_m
    top_m = max(mount.z_m for mount in above) + margin_m
    size_m = (front_m - back_m, 2 * margin_m, top_m - robot.height_m)
    return [HULL.box(size_m, ((back_m + front_m) / 2, 0.0, (top_m + robot.height_m) / 2), spec.hull_friction)]


def _wheel(
    root: physx.PhysxArticulationLinkComponent,
    name: str,
    spec: ChassisSpec,
    robot: RobotParams,
    *,
    y_m: float,
    radius_m: float,
) -> physx.PhysxArticulationLinkComponent:
    """Return a driven wheel: a ball, which touches the floor at one point just below the middle of its axle."""
    wheel = physx.PhysxArticulationLinkComponent(root)
    wheel.name = name
    wheel.attach(ROLLING.ball(radius_m, 0.0, 0.0, friction=2 * robot.friction))
    wheel.mass = spec.wheel_mass_share * robot.mass_kg
    wheel.cmass_local_pose = sapien.Pose()
    wheel.inertia = wheel.mass * radius_m**2 * np.array([0.25, 0.5, 0.25])  # a disc about y
    _set_motor(wheel.joint, spec, robot)
    wheel.joint.pose_in_parent = sapien.Pose([0.0, y_m, radius_m], _AXLE)
    wheel.joint.pose_in_child = sapien.Pose([0.0, 0.0, 0.0], _AXLE)
    return wheel


def _set_motor(joint: physx.PhysxArticulationJoint, spec: ChassisSpec, robot: RobotParams) -> None:
    inertia_kgm2 = robot.mass_kg * robot.wheel_radius_m**2  # the whole robot, seen from one axle
    torque_nm = robot.mass_kg * robot.acceleration_max_mps2 * robot.wheel_radius_m
    joint.type = "revolute"
    joint.limit = np.array([-np.inf, np.inf])
    joint.set_armature(np.array([spec.rotor_mass_share * inertia_kgm2], dtype=np.float32))
    joint.set_drive_properties(0.0, spec.drive_rate_hz * inertia_kgm2, spec.torque_margin * torque_nm)
