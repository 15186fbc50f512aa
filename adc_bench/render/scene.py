"""The arena of the `fast` quality inside a SAPIEN scene: parts with their light multiplied in once.

The one file, with `view.py`, that knows SAPIEN's axes.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Pose3
from adc_bench.render.arena_parts import ArenaParts, floor_lights, screen_part
from adc_bench.render.floor_light import Placed
from adc_bench.render.light import Lighting
from adc_bench.render.materials import (
    baked_material,
    floor_material,
    light_texture,
    lit,
    material_of,
    texture_of,
)
from adc_bench.render.meshes import Mesh, Samples
from adc_bench.render.mirror import hall_mirror
from adc_bench.render.moving import Moving, lit_pose, moving_bodies, moving_robot, same_pose, tape_part
from adc_bench.render.parts import Light, Painted, Part
from adc_bench.render.scene_numbers import SceneNumbers
from adc_bench.render.targets import Target, targets_of
from adc_bench.world.categories import PanelSign
from adc_bench.world.scenario import Scenario

FAR_AWAY = sapien.Pose([0.0, 0.0, -1000.0])


def sapien_pose(pose_world_camera: Pose3) -> sapien.Pose:
    """Return SAPIEN's pose (x forward, y left, z up) of a camera given with optical axes."""
    return body_pose(pose_world_camera @ Pose3(rotation=ROTATION_BODY_OPTICAL.T.copy(), translation_m=np.zeros(3)))


def body_pose(pose: Pose3) -> sapien.Pose:
    """Return SAPIEN's pose of a body."""
    return sapien.Pose(pose.matrix().astype(np.float32))


def entity_of(mesh: Mesh, material: sapien.render.RenderMaterial) -> sapien.Entity:
    """Return an entity of one mesh with one material."""
    body = sapien.render.RenderBodyComponent()
    body.attach(sapien.render.RenderShapeTriangleMesh(mesh.vertices, mesh.triangles, mesh.normals, mesh.uvs, material))
    entity = sapien.Entity()
    entity.add_component(body)
    return entity


class FastScene:
    """One scenario's arena in a SAPIEN scene."""

    def __init__(self, scene: sapien.Scene, scenario: Scenario, *, at_once: bool = True) -> None:
        """Build the arena and put it into the scene; if not at once, it waits for `build` and `enter`."""
        self._scene, self.scenario = scene, scenario
        self._entities: list[sapien.Entity] = []
        self._screens: list[sapien.render.RenderMaterial] = []
        self._bodies = {body.name: body for body in moving_bodies(scenario)}
        self._poses = {name: body.start for name, body in self._bodies.items()}
        self._lit: dict[str, Pose3] = {}
        self._body_light: dict[str, sapien.render.RenderTexture2D] = {}
        self._body_entities: dict[str, sapien.Entity] = {}
        self._tape_entities: dict[str, sapien.Entity] = {}
        self._pieces = self._built()
        if at_once:
            self.enter()

    def build(self) -> None:
        """Build one more piece, in some 10 ms, beside the scene; nothing if there is none left."""
        next(self._pieces, None)

    def enter(self) -> None:
        """Build what is left, and put everything into the scene."""
        for _ in self._pieces:
            pass
        for entity in self._entities:
            self._scene.add_entity(entity)
        self._numbers = SceneNumbers(self._scene, self._arena.lighting)
        self._hang_tapes(frozenset(), self._bodies)
        self.show(self.scenario.panel_sign)

    def _built(self) -> Iterator[None]:
        lighting, floors = Lighting(scenario=self.scenario), []
        bodies = self._newly_lit(self._bodies)
        for floor in floor_lights(lighting, bodies):
            floors.append(floor)
            yield
        self._arena = ArenaParts(scenario=self.scenario, lighting=lighting, floors=(floors[0], floors[1]))
        self._floor_light = [light_texture(floor.picture) for floor in floors]
        parts = list(self._arena.standing())
        yield
        light = self._light_of([part.samples for part in parts])
        yield
        mirror = light_texture(hall_mirror(lighting))
        yield
        for part, picture in zip(parts, light, strict=True):
            self._add_standing(part, picture, mirror)
        yield
        for body in self._bodies.values():
            self._add_body(body)
        self._add_robot(moving_robot(self.scenario))
        yield
        self._light_bodies(bodies)

    def remove(self) -> None:
        """Take everything out of the scene."""
        for entity in (*self._entities, *self._tape_entities.values()):
            self._scene.remove_entity(entity)
        self._numbers.remove()
        self._entities.clear()
        self._tape_entities.clear()

    def show(self, sign: PanelSign) -> None:
        """Let both panels show the sign."""
        self.sign = sign
        panel = next(solid for solid in self.scenario.solids if solid.kind == "panel")
        picture = screen_part(self.scenario, panel, sign).albedo
        assert isinstance(picture, Painted)
        for material in self._screens:
            material.set_base_color_texture(texture_of(picture))

    def place(self, bodies: Mapping[str, Pose3], torn: Collection[str] = ()) -> None:
        """Move bodies to these poses and hide torn tapes; light is baked anew where one has really moved."""
        moved = {name: pose for name, pose in bodies.items() if not same_pose(pose, self._poses[name])}
        for name, pose in moved.items():
            self._poses[name] = pose
            self._body_entities[name].set_pose(body_pose(pose))
        self._hang_tapes(frozenset(torn), self._relight(moved))

    def place_robot(self, pose_world_robot: Pose3, *, visible: bool = False) -> None:
        """Put the robot where it is: its shadow, and the robot itself where a camera may see it."""
        self._numbers.place_robot(pose_world_robot)
        self._robot.set_pose(body_pose(pose_world_robot) if visible else FAR_AWAY)

    @property
    def body_poses(self) -> Mapping[str, Pose3]:
        """Where the bodies are now."""
        return self._poses

    @property
    def targets(self) -> tuple[Target, ...]:
        """What is labelled in this scene, with the sign shown now, where the bodies are now."""
        return targets_of(self.scenario, self.sign, self._poses)

    def floor_irradiance(self, points_world: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the irradiance (n,) of the floor at points (n, 2), by the green channel."""
        return self._arena.floors[0].at(points_world)[:, 1]

    def _add(self, mesh: Mesh, material: sapien.render.RenderMaterial) -> sapien.Entity:
        entity = entity_of(mesh, material)
        self._entities.append(entity)
        return entity

    def _add_standing(self, part: Part, light: Light | None, mirror: sapien.render.RenderTexture2D) -> None:
        if part.floor:
            material = floor_material(part, self._floor_light[part.name == "hall_floor"], mirror)
        elif light is not None and isinstance(part.albedo, Painted) and part.albedo.key is None:
            baked = lit(part.albedo.picture(), light, part.texel_ids)
            material = baked_material(light_texture(baked), part.label_id)
        else:
            material = material_of(part, None if light is None else light_texture(light))
        self._add(part.mesh, material)
        if part.glow and isinstance(part.albedo, Painted):  # the lamps are plain
            self._screens.append(material)

    def _light_of(self, samples: Sequence[Samples | None]) -> list[Light | None]:
        """Return the light pictures at samples in the world, all computed in one go."""
        some = [s for s in samples if s is not None]
        if not some:
            return [None] * len(samples)
        points, normals = np.concatenate([s.points for s in some]), np.concatenate([s.normals for s in some])
        rgb = self._arena.lighting.irradiance(points, normals)
        pieces = iter(np.split(rgb, np.cumsum([len(s.points) for s in some])[:-1]))
        return [None if s is None else s.picture(next(pieces)) for s in samples]

    def _add_body(self, body: Moving) -> None:
        light = self._body_light[body.name] = light_texture(np.ones((*body.atlas.albedo.shape[:2], 4), np.float32))
        entity = self._add(body.part.mesh, baked_material(light, body.label_id))
        entity.set_pose(body_pose(body.start))
        self._body_entities[body.name] = entity

    def _add_robot(self, robot: Moving) -> None:
        (picture,) = self._light_of([robot.atlas.samples])
        assert picture is not None
        self._robot = self._add(
            robot.part.mesh, baked_material(light_texture(lit(robot.atlas.albedo, picture)), robot.label_id)
        )
        self._robot.set_pose(FAR_AWAY)

    def _relight(self, names: Collection[str]) -> Collection[str]:
        """Bake the light of bodies whose pose on the light's grid has changed, and of the floor around them.

        Returns their names.
        """
        changed = self._newly_lit(names)
        self._light_bodies(changed)
        if changed:
            for floor, texture in zip(self._arena.floors, self._floor_light, strict=True):
                if floor.place(changed):
                    texture.upload(floor.picture)
        return changed

    def _newly_lit(self, names: Collection[str]) -> Placed:
        """Return those of the bodies whose pose on the light's grid has changed, and take note of it."""
        poses = {name: lit_pose(self._poses[name]) for name in names}
        changed = {
            name: (self._bodies[name].solids, pose)
            for name, pose in poses.items()
            if name not in self._lit or not same_pose(pose, self._lit[name])
        }
        self._lit.update({name: pose for name, (_, pose) in changed.items()})
        return changed

    def _light_bodies(self, names: Collection[str]) -> None:
        bodies = [(name, self._bodies[name].atlas) for name in names]
        light = self._light_of([atlas.samples.moved(self._lit[name]) for name, atlas in bodies])
        for (name, atlas), picture in zip(bodies, light, strict=True):
            assert picture is not None
            self._body_light[name].upload(lit(atlas.albedo, picture))

    def _hang_tapes(self, torn: frozenset[str], moved: Collection[str]) -> None:
        """Hang the tapes whose cones have moved, and take down the torn ones."""
        wanted = [tape for tape in self.scenario.tapes if tape.name not in torn]
        stale = {tape.name for tape in wanted if tape.first in moved or tape.second in moved}
        for name in list(self._tape_entities):
            if name in torn or name in stale:
                self._scene.remove_entity(self._tape_entities.pop(name))
        parts = [tape_part(tape, self._lit) for tape in wanted if tape.name not in self._tape_entities]
        for part, picture in zip(parts, self._light_of([part.samples for part in parts]), strict=True):
            assert picture is not None
            entity = entity_of(part.mesh, material_of(part, light_texture(picture)))
            self._scene.add_entity(entity)
            self._tape_entities[part.name] = entity
