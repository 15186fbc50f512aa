"""A scenario cut into parts: floor, walls, ceiling, lamps, solids, boards, bodies, tapes, the robot."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from adc_bench.render.artwork import panel_picture, poster_picture, sign_picture
from adc_bench.render.atlas import Atlas, Covering, covering_of
from adc_bench.render.floor_light import EMPTY, FloorLight, Placed
from adc_bench.render.light import LAMP_GRID, LAMP_SIZE_M, UNIT_LUX, Lighting
from adc_bench.render.meshes import Patch, board_patches, flat_patch, patches, rectangles_mesh
from adc_bench.render.other_ids import ID_OF_KIND, OtherId
from adc_bench.render.parts import Painted, Part, Plain, TwoTone
from adc_bench.render.surfaces import Rectangle, floor_rectangle, grid_cells, screen_rectangle
from adc_bench.render.targets import label_ids
from adc_bench.render.textures import (
    FLOOR_KINDS,
    WALL_KINDS,
    course_bounds,
    floor_texture,
    hall_texture,
    wall_texture,
)
from adc_bench.world.categories import PanelSign
from adc_bench.world.scenario import Scenario
from adc_bench.world.signs import BOARD_M, board_outline
from adc_bench.world.solids import Solid

COURSE_TEXEL_M, HALL_TEXEL_M, WALL_TEXEL_M, SOLID_TEXEL_M = 0.025, 0.05, 0.25, 0.10
SCREEN_WHITE = 2.6  # radiance of a 250 cd/m2 screen's white in our unit: white paper under 300 lux is 95 cd/m2
CEILING_ALBEDO, LAMP_RADIANCE, LAMP_DROP_M = 0.6, 12.0, 0.01
BOARD_GREY = (0.42, 0.42, 0.43)
Bounds = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class ArenaParts:
    """The parts of a scenario that stand for good, and the floor's light, which follows the bodies.

    Attributes:
        floors: the light of the course and of the bare floor around it.
    """

    scenario: Scenario
    lighting: Lighting
    floors: tuple[FloorLight, FloorLight]

    @classmethod
    def of(cls, scenario: Scenario) -> "ArenaParts":
        """Compute the floor's light; the rest is computed when it is asked for."""
        lighting = Lighting(scenario=scenario)
        course, hall = floor_lights(lighting)
        return cls(scenario=scenario, lighting=lighting, floors=(course, hall))

    def standing(self) -> Iterator[Part]:
        """Yield the parts that stand for good."""
        yield from self._floor()
        yield from self._walls()
        yield from self._ceiling()
        yield self._solids()
        yield from self._boards()
        yield from self._posters()
        yield from (screen_part(self.scenario, solid) for solid in self.scenario.solids if solid.kind == "panel")

    def _floor(self) -> Iterator[Part]:
        """The painted floor, the crosswalk a part of its own cut out of it so that it has its own label id."""
        look, spec, ids = self.scenario.look, self.scenario.course_spec, label_ids(self.scenario)
        colour, line = FLOOR_KINDS[look.floor].albedo, (look.line_albedo,) * 3
        paint = TwoTone(
            draw=partial(floor_texture, FLOOR_KINDS[look.floor], look.texture_seed, spec),
            first=colour,
            second=line,
            key=("floor", look.floor, look.texture_seed, spec),
            wear=look.line_wear,
            dirt=look.dirt,
        )
        bounds, hall = course_bounds(spec), hall_bounds(self.scenario)
        (cx0, cy0), _, (cx1, cy1), _ = self.scenario.course.crosswalk_corners
        cells = list(grid_cells((bounds[0], cx0, cx1, bounds[2]), (bounds[1], cy0, cy1, bounds[3])))
        for name, inside in (("course", False), ("crosswalk", True)):
            boxes = [box for column, row, box in cells if ((column, row) == (1, 1)) == inside]
            yield self._floor_part(name, boxes, bounds, paint, ids.get(name, 0))
        rings = grid_cells((hall[0], bounds[0], bounds[2], hall[2]), (hall[1], bounds[1], bounds[3], hall[3]))
        around = [box for column, row, box in rings if (column, row) != (1, 1)]
        size = hall[2] - hall[0], hall[3] - hall[1]
        bare = TwoTone(
            draw=partial(hall_texture, FLOOR_KINDS[look.floor], look.texture_seed, *size),
            first=colour,
            second=colour,
            key=("hall", look.floor, look.texture_seed, size),
            dirt=look.dirt,
        )
        yield self._floor_part("hall_floor", around, hall, bare, 0)

    def _floor_part(self, name: str, boxes: list[Bounds], bounds: Bounds, albedo: TwoTone, label_id: int) -> Part:
        return Part(
            name=name,
            mesh=rectangles_mesh([floor_rectangle(box) for box in boxes], [_uv_of(box, bounds) for box in boxes]),
            albedo=albedo,
            label_id=label_id,
            gloss=self.scenario.look.floor_gloss,
            floor=True,
        )

    def _walls(self) -> Iterator[Part]:
        look, spec = self.scenario.look, self.scenario.arena_spec
        kind, height = WALL_KINDS[look.wall], spec.hall_height_m
        for name, wall in hall_walls(self.scenario).items():
            length, patch = float(np.linalg.norm(wall.right)), flat_patch(wall)
            yield Part(
                name=name,
                mesh=patch.mesh,
                albedo=TwoTone(
                    draw=partial(wall_texture, kind, look.texture_seed, length, height),
                    first=kind.albedo,
                    second=kind.second,
                    key=("wall", look.wall, look.texture_seed, length, height),
                ),
                samples=patch.samples(WALL_TEXEL_M),
                label_id=OtherId.WALL,
            )

    def _ceiling(self) -> Iterator[Part]:
        ceiling, look = flat_patch(hall_ceiling(self.scenario)), self.scenario.look
        yield Part(
            name="ceiling",
            mesh=ceiling.mesh,
            albedo=Plain(albedo=(CEILING_ALBEDO,) * 3),
            samples=ceiling.samples(max(ceiling.size_m)),  # the same light everywhere
            label_id=OtherId.WALL,
        )
        half, z = LAMP_SIZE_M / 2, self.scenario.arena_spec.hall_height_m - LAMP_DROP_M
        lamps = [
            Rectangle(
                corner=np.array([x - half, y - half, z]),
                right=np.array([2 * half, 0.0, 0.0]),
                down=np.array([0.0, 2 * half, 0.0]),
            )
            for x, y in LAMP_GRID
        ]
        warm = self.lighting.warm / self.lighting.warm.max()
        yield Part(
            name="lamps",
            mesh=rectangles_mesh(lamps, [(0, 0, 1, 1)] * len(lamps)),
            albedo=Plain(albedo=(float(warm[0]), float(warm[1]), float(warm[2]))),
            glow=LAMP_RADIANCE * self.lighting.lamp_share * look.illuminance_lux / UNIT_LUX,
            label_id=OtherId.WALL,
        )

    def _solids(self) -> Part:
        """Everything else that stands, in one mesh."""
        boards = {sign.name for sign in self.scenario.signs}
        solids = [
            solid for solid in self.scenario.solids if solid.kind not in ("wall", "poster") and solid.name not in boards
        ]
        backs = [Covering.of([back], SOLID_TEXEL_M) for _, back in self._board_sides.values()]
        coverings = [*(covering_of(solid, SOLID_TEXEL_M) for solid in solids), *backs]
        atlas = Atlas.of_coverings(coverings, [*(solid.albedo for solid in solids), *(BOARD_GREY for _ in backs)])
        ids = [*(ID_OF_KIND[solid.kind] for solid in solids), *(OtherId.SIGN_POST for _ in backs)]
        id_of_patch = np.repeat(np.array(ids, np.uint8), [len(covering.shapes) for covering in coverings])
        return Part(
            name="solids",
            mesh=atlas.mesh,
            albedo=Painted(picture=lambda: atlas.albedo),
            samples=atlas.samples,
            texel_ids=id_of_patch[atlas.of_patch],
        )

    @cached_property
    def _board_sides(self) -> Mapping[str, tuple[Patch, Patch]]:
        solids = {solid.name: solid for solid in self.scenario.solids}
        return {sign.name: board_patches(solids[sign.name], board_outline(sign)) for sign in self.scenario.signs}

    def _boards(self) -> Iterator[Part]:
        """The fronts of the vertical signs."""
        ids, sides, artwork = label_ids(self.scenario), self._board_sides, self.scenario.look.artwork
        for sign in self.scenario.signs:
            front, _ = sides[sign.name]
            yield Part(
                name=sign.name,
                mesh=front.mesh,
                albedo=Painted.of_print(partial(sign_picture, sign.sign, artwork), key=("sign", sign.sign, artwork)),
                samples=front.samples(BOARD_M / 4),
                label_id=ids[sign.name],
            )

    def _posters(self) -> Iterator[Part]:
        solids = {solid.name: solid for solid in self.scenario.solids if solid.kind == "poster"}
        for piece in self.scenario.furniture:
            if piece.kind == "poster":
                front = next(patches(solids[piece.name]))
                yield Part(
                    name=piece.name,
                    mesh=front.mesh,
                    albedo=Painted.of_print(partial(poster_picture, piece.variant), key=("poster", piece.variant)),
                    samples=front.samples(WALL_TEXEL_M),
                    label_id=OtherId.FURNITURE,
                )


def floor_lights(lighting: Lighting, bodies: Placed = EMPTY) -> Iterator[FloorLight]:
    """Yield the light of the course and of the bare floor around it, bodies on them."""
    course = course_bounds(lighting.scenario.course_spec)
    yield FloorLight(lighting, course, COURSE_TEXEL_M, bodies=bodies)
    yield FloorLight(lighting, hall_bounds(lighting.scenario), HALL_TEXEL_M, unseen=course, bodies=bodies)


def screen_part(scenario: Scenario, panel: Solid, sign: PanelSign | None = None) -> Part:
    """Return a panel's lit screen, showing the sign (by default the scenario's)."""
    sign, artwork = sign or scenario.panel_sign, scenario.look.artwork
    return Part(
        name=panel.name,
        mesh=rectangles_mesh([screen_rectangle(panel)], [(0, 0, 1, 1)]),
        albedo=Painted(picture=partial(panel_picture, sign, artwork), key=("panel", sign, artwork)),
        glow=SCREEN_WHITE * scenario.look.panel_luminance,
        label_id=label_ids(scenario)[panel.name],
    )


def hall_bounds(scenario: Scenario) -> Bounds:
    """Return x0, y0, x1, y1 of the hall."""
    x, y = scenario.arena_spec.hall_half_length_m, scenario.arena_spec.hall_half_width_m
    return -x, -y, x, y


def hall_walls(scenario: Scenario) -> Mapping[str, Rectangle]:
    """Return the four walls seen from inside, by the names of their solids."""
    _, _, x, y = hall_bounds(scenario)
    height = scenario.arena_spec.hall_height_m
    down = np.array([0.0, 0.0, -height])
    return {
        "wall_north": Rectangle(corner=np.array([-x, y, height]), right=np.array([2.0 * x, 0.0, 0.0]), down=down),
        "wall_east": Rectangle(corner=np.array([x, y, height]), right=np.array([0.0, -2.0 * y, 0.0]), down=down),
        "wall_south": Rectangle(corner=np.array([x, -y, height]), right=np.array([-2.0 * x, 0.0, 0.0]), down=down),
        "wall_west": Rectangle(corner=np.array([-x, -y, height]), right=np.array([0.0, 2.0 * y, 0.0]), down=down),
    }


def hall_ceiling(scenario: Scenario) -> Rectangle:
    """Return the ceiling seen from below."""
    x0, y0, x1, y1 = hall_bounds(scenario)
    corner = np.array([x0, y0, scenario.arena_spec.hall_height_m])
    return Rectangle(corner=corner, right=np.array([x1 - x0, 0.0, 0.0]), down=np.array([0.0, y1 - y0, 0.0]))


def _uv_of(box: Bounds, bounds: Bounds) -> Bounds:
    """Return the texture coordinates (left, top, right, bottom) of a floor box inside the texture's bounds."""
    x0, y0, x1, y1 = bounds
    return (box[0] - x0) / (x1 - x0), (y1 - box[3]) / (y1 - y0), (box[2] - x0) / (x1 - x0), (y1 - box[1]) / (y1 - y0)
