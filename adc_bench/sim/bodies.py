"""What can be pushed and knocked over: boxes, cones and chairs as rigid bodies with mass and friction."""

import sapien
from sapien import physx

from adc_bench.geometry import Pose3
from adc_bench.sim.surfaces import SKIN, SOLE, add_named, from_sapien, to_sapien, volume_m3
from adc_bench.world.solids import Body


class Bodies:
    """The movable bodies of a scene, asleep where they were put until something touches them."""

    def __init__(self, scene: sapien.Scene, bodies: tuple[Body, ...]) -> None:
        self._poses = {body.name: body.pose.to_pose3() for body in bodies}
        self._components = {body.name: _add_body(scene, body) for body in bodies}
        self._at_rest = dict.fromkeys(self._components, True)

    def follow(self) -> None:
        """Take note of where the bodies that move are now; a body needs some 0.4 s of rest to fall asleep."""
        for name, component in self._components.items():
            asleep = component.is_sleeping
            if not (asleep and self._at_rest[name]):
                self._poses[name] = from_sapien(component.entity_pose)
            self._at_rest[name] = asleep

    def poses(self) -> dict[str, Pose3]:
        """Return each body's pose in the world when last followed; one that rests keeps its very record."""
        return dict(self._poses)


def _add_body(scene: sapien.Scene, body: Body) -> physx.PhysxRigidDynamicComponent:
    """Lay a body of even density to sleep where it stands.

    PhysX reckons mass, its centre and its inertia from the shapes, of which there are two for each part.
    """
    component = physx.PhysxRigidDynamicComponent()
    density_kgpm3 = body.mass_kg / (2 * sum(volume_m3(part) for part in body.parts))
    for part in body.parts:
        for shape in (SOLE.part(part, 2 * body.friction), SKIN.part(part, body.friction)):
            shape.density = density_kgpm3
            component.attach(shape)
    add_named(scene, body.name, component, to_sapien(body.pose.to_pose3()))
    component.put_to_sleep()
    return component
