"""Collision shapes with what they touch and how they rub: the only page that knows PhysX' groups and materials."""

import math
from dataclasses import dataclass

import sapien
from sapien import physx

from adc_bench.geometry import Pose3
from adc_bench.world.solids import Solid

GRAVITY_MPS2 = 9.81

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

    def box(self, size_m: tuple[float, float, float], z_m: float, friction: float) -> physx.PhysxCollisionShape:
        """Return a box centred at (0, 0, z) of its body."""
        half = [side / 2 for side in size_m]
        return self.finish(physx.PhysxCollisionShapeBox(half, rough(friction)), sapien.Pose([0.0, 0.0, z_m]))


# Wheels and castor roll on the floor alone: a wheel's ball is wider than the wheel, so the hull meets the obstacles.
FLOOR = Surface(bit=1)
SOLID = Surface(bit=2)
ROLLING = Surface(bit=4, meets=FLOOR.bit)
HULL = Surface(bit=8, meets=FLOOR.bit | SOLID.bit)


def physics(rate_hz: int) -> physx.PhysxCpuSystem:
    """Return an empty PhysX system whose behaviour rests on nothing that others in this process may have set."""
    physx.set_scene_config(gravity=[0.0, 0.0, -GRAVITY_MPS2], enable_enhanced_determinism=True)
    physx.set_shape_config(contact_offset=0.01, rest_offset=0.0)
    system = physx.PhysxCpuSystem()
    system.timestep = 1 / rate_hz
    return system


def rough(friction: float) -> physx.PhysxMaterial:
    """Return a material that does not bounce. Two materials rub with the mean of their frictions.

    So the floor has none, a wheel twice its own, and the castor slides freely.
    """
    return physx.PhysxMaterial(friction, friction, 0.0)


def add_floor(scene: sapien.Scene) -> None:
    """Lay the floor z = 0."""
    body = physx.PhysxRigidStaticComponent()
    plane = physx.PhysxCollisionShapePlane(rough(0.0))
    body.attach(FLOOR.finish(plane, sapien.Pose([0.0, 0.0, 0.0], _UPWARDS)))
    _add(scene, "floor", body, sapien.Pose())


def add_solid(scene: sapien.Scene, solid: Solid, friction: float) -> None:
    """Stand an immovable box under its own name."""
    body = physx.PhysxRigidStaticComponent()
    body.attach(SOLID.box(solid.size_m, 0.0, friction))
    _add(scene, solid.name, body, to_sapien(solid.pose_world_solid()))


def to_sapien(pose: Pose3) -> sapien.Pose:
    """Return the pose in SAPIEN's type."""
    return sapien.Pose(pose.matrix())


def _add(scene: sapien.Scene, name: str, body: physx.PhysxRigidStaticComponent, pose: sapien.Pose) -> None:
    entity = sapien.Entity()
    entity.name = name
    entity.add_component(body)
    entity.pose = pose
    scene.add_entity(entity)
