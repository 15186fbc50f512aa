"""Collision shapes with what they touch and how they rub: the only page that knows PhysX' groups and materials."""

import math
from dataclasses import dataclass

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien import physx

from adc_bench.geometry import Pose3
from adc_bench.world.footprints import structure
from adc_bench.world.solids import Solid

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.81
SIDES = 24  # of a round solid's collision shape, which lies within the solid by at most 0.9 % of its radius

# A plane's normal is its own x: this quaternion turns it to the world's z.
_UPWARDS = (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0)


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A family of shapes: its bit, and the bits of the families that it meets (either side's word is enough)."""

    bit: int
    meets: int = 0

    def finish(self, shape: physx.PhysxCollisionShape, pose_body_shape: sapien.Pose) -> physx.PhysxCollisionShape:
        """Place the shape on its body and give it its family."""
        shape.local_pose = pose_body_shape
        shape.set_collision_groups([self.bit, self.meets, 0, 0])
        return shape

    def ball(self, radius_m: float, z_m: float, x_m: float, friction: float) -> physx.PhysxCollisionShape:
        """Return a sphere centred at (x, 0, z) of its body."""
        return self.finish(physx.PhysxCollisionShapeSphere(radius_m, rough(friction)), sapien.Pose([x_m, 0.0, z_m]))

    def box(
        self, size_m: tuple[float, float, float], centre_m: tuple[float, float, float], friction: float
    ) -> physx.PhysxCollisionShape:
        """Return a box along its body's axes, centred at a point of its body."""
        half = [side / 2 for side in size_m]
        return self.finish(physx.PhysxCollisionShapeBox(half, rough(friction)), sapien.Pose(list(centre_m)))

    def part(self, solid: Solid, friction: float) -> physx.PhysxCollisionShape:
        """Return a solid's shape where the solid is in its body; a round one is the hull of 24 points on each rim."""
        if solid.shape == "box":
            shape = physx.PhysxCollisionShapeBox([side / 2 for side in solid.size_m], rough(friction))
        else:
            shape = physx.PhysxCollisionShapeConvexMesh(round_corners(solid), np.ones(3, np.float32), rough(friction))
        return self.finish(shape, to_sapien(solid.pose_world_solid()))


# Wheels and castor roll on the floor alone: a wheel's ball is wider than the wheel, so the hull meets the obstacles.
# A body has each of its shapes twice, to rub on the floor by one figure and on everything else by another.
FLOOR = Surface(bit=1)
SOLID = Surface(bit=2)
ROLLING = Surface(bit=4, meets=FLOOR.bit)
HULL = Surface(bit=8, meets=FLOOR.bit | SOLID.bit)
SOLE = Surface(bit=16, meets=FLOOR.bit)
SKIN = Surface(bit=32, meets=SOLID.bit | HULL.bit | 32)


def physics(rate_hz: int) -> physx.PhysxCpuSystem:
    """Return an empty PhysX system whose behaviour rests on nothing that others in this process may have set."""
    physx.set_scene_config(gravity=[0.0, 0.0, -GRAVITY_MPS2], enable_enhanced_determinism=True)
    physx.set_shape_config(contact_offset=0.01, rest_offset=0.0)
    physx.set_body_config(solver_position_iterations=10, solver_velocity_iterations=1, sleep_threshold=0.005)
    system = physx.PhysxCpuSystem()
    system.timestep = 1 / rate_hz
    return system


def rough(friction: float) -> physx.PhysxMaterial:
    """Return a material that does not bounce. Two materials rub with the mean of their frictions.

    So the floor has none, a wheel or a body's sole twice its own, and the castor slides freely.
    """
    return physx.PhysxMaterial(friction, friction, 0.0)


def add_floor(scene: sapien.Scene) -> physx.PhysxRigidStaticComponent:
    """Lay the floor z = 0."""
    body = physx.PhysxRigidStaticComponent()
    plane = physx.PhysxCollisionShapePlane(rough(0.0))
    body.attach(FLOOR.finish(plane, sapien.Pose([0.0, 0.0, 0.0], _UPWARDS)))
    add_named(scene, "floor", body, sapien.Pose())
    return body


def add_solid(scene: sapien.Scene, solid: Solid, friction: float) -> None:
    """Stand an immovable solid, under the name of the thing that it is a part of."""
    body = physx.PhysxRigidStaticComponent()
    body.attach(SOLID.part(solid, friction))
    add_named(scene, structure(solid), body, sapien.Pose())


def round_corners(solid: Solid) -> Array:
    """Return points (n, 3) of a cylinder's or cone's hull in the solid's own frame, all on its surface."""
    half = np.array(solid.size_m) / 2
    angles = np.arange(SIDES) * (2 * math.pi / SIDES)
    rim = np.stack([np.cos(angles), np.sin(angles), np.ones(SIDES)], axis=1)
    top = rim if solid.shape == "cylinder" else np.array([[0.0, 0.0, 1.0]])
    corners: Array = np.concatenate([rim * [1.0, 1.0, -1.0], top]) * half
    return corners


def volume_m3(solid: Solid) -> float:
    """Return the volume of a solid's collision shape."""
    box_m3 = math.prod(solid.size_m)
    if solid.shape == "box":
        return box_m3
    prism_m3 = box_m3 * SIDES / 8 * math.sin(2 * math.pi / SIDES)
    return prism_m3 if solid.shape == "cylinder" else prism_m3 / 3


def to_sapien(pose: Pose3) -> sapien.Pose:
    """Return the pose in SAPIEN's type."""
    return sapien.Pose(pose.matrix())


def from_sapien(pose: sapien.Pose) -> Pose3:
    """Return the pose in our type."""
    matrix = pose.to_transformation_matrix().astype(np.float64)
    return Pose3(rotation=matrix[:3, :3].copy(), translation_m=matrix[:3, 3].copy())


def add_named(scene: sapien.Scene, name: str, body: physx.PhysxRigidBaseComponent, pose: sapien.Pose) -> None:
    """Put a body into the scene under a name."""
    entity = sapien.Entity()
    entity.name = name
    entity.add_component(body)
    entity.pose = pose
    scene.add_entity(entity)
