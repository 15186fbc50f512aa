"""A scenario's arena on the stage of one of SAPIEN's shader packs: the meshes of `FastScene` with their albedo apart
from their light.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence

import msgspec
import sapien

from adc_bench.geometry import Pose3
from adc_bench.render.arena_parts import ArenaParts, screen_part
from adc_bench.render.moving import Moving, lit_pose, moving_bodies, moving_robot, same_pose, tape_part
from adc_bench.render.pack_camera import Stage
from adc_bench.render.pack_lights import glowing_floods, glowing_lamps, shadowing_floods, sky_radiance
from adc_bench.render.pack_surfaces import albedo_texture, give_back, glowing, light_at, reflecting
from adc_bench.render.parts import Part
from adc_bench.render.scene import FAR_AWAY, body_pose, entity_of
from adc_bench.world.categories import PanelSign
from adc_bench.world.scenario import Scenario

SHELL = ("wall", "ceiling", "lamps", "poster")  # how the names of the hall's parts begin


class Thing:
    """A part on the stage, in the scenes in which it stands."""

    def __init__(self, placed: Sequence[tuple[sapien.Scene, sapien.Entity]]) -> None:
        self._placed = placed
        for scene, entity in placed:
            scene.add_entity(entity)

    def move(self, pose: sapien.Pose) -> None:
        """Put it at a pose."""
        for _, entity in self._placed:
            entity.set_pose(pose)

    def remove(self) -> None:
        """Take it out of the scenes."""
        for scene, entity in self._placed:
            scene.remove_entity(entity)


class PackScene:
    """One scenario's arena on a stage."""

    def __init__(self, stage: Stage, scenario: Scenario) -> None:
        self._stage, self._scenario, self._bakes = stage, scenario, stage.pack.bakes_diffuse
        self._black = sapien.render.RenderMaterial(base_color=[0.0, 0.0, 0.0, 1.0])
        self._things: list[Thing] = []
        self._screens: list[sapien.render.RenderMaterial] = []
        self._floors: list[tuple[Part, sapien.render.RenderMaterial]] = []
        self._bodies: dict[str, tuple[Moving, Thing, sapien.render.RenderMaterial]] = {}
        self._tapes: dict[str, Thing] = {}
        whole = ArenaParts.of(scenario)
        self._arena = ArenaParts.of(without_floods(scenario)) if self._bakes else whole
        self._add_bodies()
        self._add_standing(part for part in self._arena.standing() if not part.name.startswith(SHELL))
        self._add_shell(whole)
        self._hang_tapes(frozenset(), ())
        self._add_lights(whole)
        self.show(scenario.panel_sign)

    def remove(self) -> None:
        """Take everything out of the scenes."""
        for thing in (*self._things, *self._tapes.values()):
            thing.remove()
        self._things.clear()
        self._tapes.clear()

    def show(self, sign: PanelSign) -> None:
        """Let both panels show the sign."""
        panel = next(solid for solid in self._scenario.solids if solid.kind == "panel")
        texture = albedo_texture(screen_part(self._scenario, panel, sign).albedo)
        for material in self._screens:
            material.set_emission_texture(texture)

    def place(self, bodies: Mapping[str, Pose3], torn: Collection[str] = ()) -> None:
        """Move bodies to these poses and hide torn tapes; baked light follows those that have really moved."""
        moved = {name: pose for name, pose in bodies.items() if not same_pose(pose, self._poses[name])}
        self._poses |= moved
        for name, pose in moved.items():
            body, thing, material = self._bodies[name]
            thing.move(body_pose(pose))
            self._bake(material, body.part, lit_pose(pose))
        if moved:
            self._shade_floors(moved)
            for part, material in self._floors:
                self._bake(material, part)
        self._hang_tapes(frozenset(torn), moved)

    def place_robot(self, pose_world_robot: Pose3, *, visible: bool = False) -> None:
        """Put the robot where it is. Whether it is visible or not, it is there: its own cameras do not see it."""
        self._robot.move(body_pose(pose_world_robot))

    def _thing(self, part: Part, material: sapien.render.RenderMaterial) -> Thing:
        """Put a part under the lights."""
        placed = [(self._stage.lit, entity_of(part.mesh, material))]
        if self._stage.pack.is_traced:
            placed.append((self._stage.cover, entity_of(part.mesh, self._black)))
        return Thing(placed)

    def _add_standing(self, parts: Iterable[Part]) -> None:
        for part in parts:
            material = glowing(part, None) if part.glow else reflecting(part)
            self._bake(material, part)
            self._things.append(self._thing(part, material))
            if part.floor:
                self._floors.append((part, material))
            if part.glow:
                self._screens.append(material)

    def _add_shell(self, whole: ArenaParts) -> None:
        for part in whole.standing():
            if not part.name.startswith(SHELL):
                continue
            light = light_at(whole.lighting, part.samples) if part.samples else None
            self._things.append(Thing([(self._stage.shell, entity_of(part.mesh, glowing(part, light)))]))

    def _add_bodies(self) -> None:
        for body in moving_bodies(self._scenario):
            material = reflecting(body.part)
            self._bake(material, body.part, lit_pose(body.start))
            thing = self._thing(body.part, material)
            thing.move(body_pose(body.start))
            self._things.append(thing)
            self._bodies[body.name] = body, thing, material
        self._poses = {name: body.start for name, (body, _, _) in self._bodies.items()}
        self._shade_floors(self._poses)
        robot = moving_robot(self._scenario)
        material = reflecting(robot.part)
        self._bake(material, robot.part)
        self._robot = self._thing(robot.part, material)
        self._robot.move(FAR_AWAY)
        self._things.append(self._robot)

    def _add_lights(self, whole: ArenaParts) -> None:
        lighting, lit = whole.lighting, self._stage.lit
        if self._bakes:
            lights = [*shadowing_floods(lighting)]
        else:
            lights = [*glowing_floods(lighting), *glowing_lamps(lighting)]
            lit.set_ambient_light(sky_radiance(lighting).tolist())
        self._things += [Thing([(lit, light)]) for light in lights]

    def _bake(self, material: sapien.render.RenderMaterial, part: Part, pose: Pose3 | None = None) -> None:
        """Put the diffuse light on a part, its frame at a pose, into its material."""
        if self._bakes and part.floor:
            give_back(material, part, self._arena.floors[part.name == "hall_floor"].picture)
        elif self._bakes and part.samples:
            samples = part.samples.moved(pose) if pose else part.samples
            give_back(material, part, light_at(self._arena.lighting, samples))

    def _shade_floors(self, moved: Mapping[str, Pose3]) -> None:
        """Put bodies' shadows from the lamps into the floor's baked light."""
        if self._bakes:
            shading = {name: (self._bodies[name][0].solids, lit_pose(pose)) for name, pose in moved.items()}
            for floor in self._arena.floors:
                floor.place(shading)

    def _hang_tapes(self, torn: frozenset[str], moved: Collection[str]) -> None:
        """Hang the tapes whose cones have moved, and take down the torn ones."""
        poses = {name: lit_pose(pose) for name, pose in self._poses.items()}
        for tape in self._scenario.tapes:
            stale = tape.first in moved or tape.second in moved or tape.name in torn
            if stale and tape.name in self._tapes:
                self._tapes.pop(tape.name).remove()
            if tape.name not in self._tapes and tape.name not in torn:
                part = tape_part(tape, poses)
                material = reflecting(part)
                self._bake(material, part)
                self._tapes[tape.name] = self._thing(part, material)


def without_floods(scenario: Scenario) -> Scenario:
    """Return the scenario lit by sky and lamps alone, as strongly as they light it beside the floodlights."""
    look = scenario.look
    left = look.illuminance_lux * (1 - look.flood_share)
    return msgspec.structs.replace(scenario, look=msgspec.structs.replace(look, floods=(), illuminance_lux=left))
