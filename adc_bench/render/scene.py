"""A scenario's static surfaces as SAPIEN render bodies, lit by pictures computed once.

The only file that knows how our shader pack reads a material's slots (shaders/arena/gbuffer.frag), and SAPIEN's axes.
"""

from functools import lru_cache

import numpy as np
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Pose3
from adc_bench.render.artwork import panel_picture
from adc_bench.render.light import LAMP_GRID, UNIT_LUX, Lighting
from adc_bench.render.surfaces import (
    Mesh,
    Rectangle,
    floor_rectangle,
    grid_cells,
    light_picture,
    rectangles_mesh,
    screen_rectangle,
    solids_atlas,
)
from adc_bench.render.targets import Target, targets_of
from adc_bench.render.textures import (
    FLOOR_KINDS,
    WALL_KINDS,
    TwoTone,
    course_bounds,
    floor_texture,
    hall_texture,
    wall_texture,
)
from adc_bench.world.arena import PANEL_NAMES
from adc_bench.world.categories import PANEL_SIGNS, PanelSign
from adc_bench.world.course import CourseSpec
from adc_bench.world.scenario import Scenario

FLOOR_TEXEL_M, HALL_TEXEL_M, SOLID_TEXEL_M = 0.05, 0.20, 0.10
CROSSWALK_ID = 1
PANEL_IDS = dict(zip(PANEL_NAMES, (2, 3), strict=True))
SCREEN_WHITE = 2.6  # radiance of a 250 cd/m2 screen's white in our unit: white paper under 300 lux is 95 cd/m2
CEILING_ALBEDO, LAMP_RADIANCE, LAMP_SIZE_M = 0.6, 12.0, 0.7
Uv = tuple[float, float, float, float]


def sapien_pose(pose_world_camera: Pose3) -> sapien.Pose:
    """Return SAPIEN's pose (x forward, y left, z up) of a camera given with optical axes."""
    pose = pose_world_camera @ Pose3(rotation=ROTATION_BODY_OPTICAL.T.copy(), translation_m=np.zeros(3))
    return sapien.Pose(pose.matrix().astype(np.float32))


class StaticScene:
    """The render bodies of one scenario inside a SAPIEN scene."""

    def __init__(self, scene: sapien.Scene, scenario: Scenario) -> None:
        self._scene, self._scenario = scene, scenario
        self._entities: list[sapien.Entity] = []
        self._screens: dict[str, sapien.render.RenderMaterial] = {}
        lighting = Lighting(scenario=scenario)
        self._add_course(lighting)
        self._add_hall(lighting)
        self._add_solids(lighting)
        self._add_screens()
        self.show(scenario.panel_sign)

    def remove(self) -> None:
        """Take the bodies out of the scene."""
        for entity in self._entities:
            self._scene.remove_entity(entity)
        self._entities.clear()

    def show(self, sign: PanelSign) -> None:
        """Let both panels show the sign."""
        self.sign = sign
        for material in self._screens.values():
            material.set_base_color_texture(_screen_texture(sign))

    @property
    def targets(self) -> tuple[Target, ...]:
        """What is labelled in this scene, with the sign shown now."""
        return targets_of(self._scenario, self.sign)

    def floor_irradiance(self, points_world: NDArray[np.float64]) -> float:
        """Return the mean irradiance of the floor at points (n, 2), by the green channel."""
        x0, y0, x1, y1 = course_bounds(self._scenario.course_spec)
        height, width = self._floor_light.shape[:2]
        column = np.clip((points_world[:, 0] - x0) / (x1 - x0) * width, 0, width - 1).astype(int)
        row = np.clip((y1 - points_world[:, 1]) / (y1 - y0) * height, 0, height - 1).astype(int)
        return float(self._floor_light[row, column, 1].mean())

    def _add_course(self, lighting: Lighting) -> None:
        """The painted floor, the crosswalk a body of its own cut out of it so that it has its own label id."""
        look, spec = self._scenario.look, self._scenario.course_spec
        bounds = course_bounds(spec)
        self._floor_light = light_picture(lighting, floor_rectangle(bounds), FLOOR_TEXEL_M)
        texture = _floor_texture(look.floor, look.texture_seed, spec)
        light = _texture(self._floor_light)
        (cx0, cy0), _, (cx1, cy1), _ = self._scenario.course.crosswalk_corners
        cells = list(grid_cells((bounds[0], cx0, cx1, bounds[2]), (bounds[1], cy0, cy1, bounds[3])))
        for label_id in (0, CROSSWALK_ID):
            part = [box for column, row, box in cells if ((column, row) == (1, 1)) == (label_id == CROSSWALK_ID)]
            mesh = rectangles_mesh([floor_rectangle(box) for box in part], [_uv_of(box, bounds) for box in part])
            self._add(
                mesh, _two_tone(FLOOR_KINDS[look.floor].albedo, (look.line_albedo,) * 3, texture, light, label_id)
            )

    def _add_hall(self, lighting: Lighting) -> None:
        """The bare floor around the course, the walls and the ceiling."""
        look, spec = self._scenario.look, self._scenario.arena_spec
        x, y = spec.hall_half_length_m, spec.hall_half_width_m
        hall, course = (-x, -y, x, y), course_bounds(self._scenario.course_spec)
        around = [
            box
            for column, row, box in grid_cells(
                (hall[0], course[0], course[2], hall[2]), (hall[1], course[1], course[3], hall[3])
            )
            if (column, row) != (1, 1)
        ]
        floor = rectangles_mesh([floor_rectangle(box) for box in around], [_uv_of(box, hall) for box in around])
        light = _texture(light_picture(lighting, floor_rectangle(hall), HALL_TEXEL_M))
        colour = FLOOR_KINDS[look.floor].albedo
        self._add(
            floor, _two_tone(colour, colour, _hall_texture(look.floor, look.texture_seed, 2 * x, 2 * y), light, 0)
        )
        for wall in _walls(x, y, spec.hall_height_m):
            length = float(np.linalg.norm(wall.right))
            kind = WALL_KINDS[look.wall]
            texture = _wall_texture(look.wall, look.texture_seed, length, spec.hall_height_m)
            light = _texture(light_picture(lighting, wall, HALL_TEXEL_M))
            self._add(rectangles_mesh([wall], [(0, 0, 1, 1)]), _two_tone(kind.albedo, kind.second, texture, light, 0))
        self._add_ceiling(
            lighting,
            Rectangle(
                corner=np.array([-x, -y, spec.hall_height_m]),
                right=np.array([2.0 * x, 0, 0]),
                down=np.array([0, 2.0 * y, 0]),
            ),
        )

    def _add_ceiling(self, lighting: Lighting, ceiling: Rectangle) -> None:
        look = self._scenario.look
        radiance = light_picture(lighting, ceiling, HALL_TEXEL_M)
        radiance[..., :3] *= CEILING_ALBEDO
        height, width = radiance.shape[:2]
        glow = LAMP_RADIANCE * look.lamp_share * (1 - look.flood_share) * look.illuminance_lux / UNIT_LUX
        half = LAMP_SIZE_M / 2
        for x, y in LAMP_GRID:
            u0, u1 = ((x + d - ceiling.corner[0]) / ceiling.right[0] * width for d in (-half, half))
            v0, v1 = ((y + d - ceiling.corner[1]) / ceiling.down[1] * height for d in (-half, half))
            radiance[round(v0) : round(v1), round(u0) : round(u1), :3] += glow
        self._add(rectangles_mesh([ceiling], [(0, 0, 1, 1)]), _lit(_texture(radiance)))

    def _add_solids(self, lighting: Lighting) -> None:
        solids = [solid for solid in self._scenario.solids if solid.kind != "wall"]
        mesh, atlas = solids_atlas(lighting, solids, SOLID_TEXEL_M)
        self._add(mesh, _lit(_texture(atlas)))

    def _add_screens(self) -> None:
        level = SCREEN_WHITE * self._scenario.look.panel_luminance
        for solid in self._scenario.solids:
            if solid.kind == "panel":
                material = sapien.render.RenderMaterial(
                    base_color=[level, level, level, 1.0], roughness=PANEL_IDS[solid.name] / 255, metallic=0.0
                )
                self._screens[solid.name] = material
                material.set_base_color_texture(_screen_texture(self._scenario.panel_sign))
                self._add(rectangles_mesh([screen_rectangle(solid)], [(0, 0, 1, 1)]), material)

    def _add(self, mesh: Mesh, material: sapien.render.RenderMaterial) -> None:
        body = sapien.render.RenderBodyComponent()
        body.attach(
            sapien.render.RenderShapeTriangleMesh(mesh.vertices, mesh.triangles, mesh.normals, mesh.uvs, material)
        )
        entity = sapien.Entity()
        entity.add_component(body)
        self._scene.add_entity(entity)
        self._entities.append(entity)


def _uv_of(box: Uv, bounds: Uv) -> Uv:
    """Return the texture coordinates (left, top, right, bottom) of a floor box inside the texture's bounds."""
    x0, y0, x1, y1 = bounds
    return (box[0] - x0) / (x1 - x0), (y1 - box[3]) / (y1 - y0), (box[2] - x0) / (x1 - x0), (y1 - box[1]) / (y1 - y0)


def _walls(x: float, y: float, height: float) -> tuple[Rectangle, ...]:
    """Return the four walls seen from inside."""
    down = np.array([0.0, 0.0, -height])
    return (
        Rectangle(corner=np.array([-x, y, height]), right=np.array([2.0 * x, 0.0, 0.0]), down=down),
        Rectangle(corner=np.array([x, y, height]), right=np.array([0.0, -2.0 * y, 0.0]), down=down),
        Rectangle(corner=np.array([x, -y, height]), right=np.array([-2.0 * x, 0.0, 0.0]), down=down),
        Rectangle(corner=np.array([-x, -y, height]), right=np.array([0.0, 2.0 * y, 0.0]), down=down),
    )


def _texture(picture: NDArray[np.float32]) -> sapien.render.RenderTexture2D:
    return sapien.render.RenderTexture2D(picture, "R32G32B32A32Sfloat", address_mode="edge")


def _lit(radiance: sapien.render.RenderTexture2D) -> sapien.render.RenderMaterial:
    material = sapien.render.RenderMaterial(base_color=[1.0, 1.0, 1.0, 1.0], roughness=0.0, metallic=0.0)
    material.set_emission_texture(radiance)
    return material


def _two_tone(
    albedo: tuple[float, ...],
    second: tuple[float, ...],
    texture: sapien.render.RenderTexture2D,
    light: sapien.render.RenderTexture2D,
    label_id: int,
) -> sapien.render.RenderMaterial:
    material = sapien.render.RenderMaterial(
        base_color=[2 * albedo[0], 2 * albedo[1], 2 * albedo[2], 1.0],
        emission=[*second, 1.0],
        roughness=label_id / 255,
        metallic=1.0,
    )
    material.set_base_color_texture(texture)
    material.set_emission_texture(light)
    return material


def _mipmapped(picture: TwoTone) -> sapien.render.RenderTexture2D:
    levels = int(np.log2(min(picture.shape[:2]))) - 1
    return sapien.render.RenderTexture2D(
        np.ascontiguousarray(picture), "R8G8Unorm", mipmap_levels=levels, address_mode="edge"
    )


# Surfaces come back from scenario to scenario: a look has one of a few kinds of floor and wall, and one of two seeds.
@lru_cache(maxsize=8)
def _floor_texture(kind: str, seed: int, spec: CourseSpec) -> sapien.render.RenderTexture2D:
    return _mipmapped(floor_texture(FLOOR_KINDS[kind], seed, spec))


@lru_cache(maxsize=8)
def _hall_texture(kind: str, seed: int, length_m: float, width_m: float) -> sapien.render.RenderTexture2D:
    return _mipmapped(hall_texture(FLOOR_KINDS[kind], seed, length_m, width_m))


@lru_cache(maxsize=32)
def _wall_texture(kind: str, seed: int, length_m: float, height_m: float) -> sapien.render.RenderTexture2D:
    return _mipmapped(wall_texture(WALL_KINDS[kind], seed, length_m, height_m))


@lru_cache(maxsize=len(PANEL_SIGNS))
def _screen_texture(sign: PanelSign) -> sapien.render.RenderTexture2D:
    return sapien.render.RenderTexture2D(panel_picture(sign), "R8G8B8A8Unorm", mipmap_levels=6, address_mode="edge")
