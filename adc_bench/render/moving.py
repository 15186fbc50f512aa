"""What moves: bodies, the tapes between cones, the robot, each a part in its own frame, lit where it is."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import msgspec
import numpy as np
from numpy.typing import NDArray

from adc_bench.geometry import Pose3
from adc_bench.render.atlas import Atlas
from adc_bench.render.meshes import Mesh, Samples
from adc_bench.render.other_ids import ID_OF_KIND, OtherId
from adc_bench.render.parts import Painted, Part
from adc_bench.render.targets import label_ids
from adc_bench.world.robot import RobotParams
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Body, Solid
from adc_bench.world.works import TAPE_HEIGHT_M, TAPE_WIDTH_M, Tape

Array = NDArray[np.float64]
BODY_TEXEL_M = 0.06
STEP_M, STEP_TURN = 0.005, 1 / 128  # light is computed for poses on this grid, so that it forgets how they came about
TAPE_SEGMENTS, TAPE_SAG = 4, 0.02  # sag of the middle, of the length
TAPE_PRINT_M, TAPE_STRIPE_M = 4.0, 0.1
TAPE_RED, TAPE_WHITE = (0.62, 0.03, 0.03), (0.75, 0.75, 0.75)
MAST_X_M, MAST_SIDE_M, MAST_TOP_M = 0.03, 0.06, 0.72
HULL_RED, RUBBER, DECK, METAL = (0.40, 0.03, 0.03), (0.03, 0.03, 0.03), (0.05, 0.05, 0.055), (0.45, 0.46, 0.47)


def lit_pose(pose: Pose3) -> Pose3:
    """Return the pose that the light is computed for: within 5 mm and half a degree or so."""
    rows = np.round(pose.rotation / STEP_TURN) * STEP_TURN
    x = rows[:, 0] / np.linalg.norm(rows[:, 0])
    z = np.cross(x, rows[:, 1])
    z /= np.linalg.norm(z)
    rotation = np.stack([x, np.cross(z, x), z], axis=1)
    return Pose3(rotation=rotation, translation_m=np.round(pose.translation_m / STEP_M) * STEP_M)


def same_pose(a: Pose3, b: Pose3) -> bool:
    """Return whether two poses are equal to the bit."""
    return bool((a.translation_m == b.translation_m).all() and (a.rotation == b.rotation).all())


@dataclass(frozen=True, kw_only=True, eq=False)
class Moving:
    """A thing in its own frame: its solids there, and its label id."""

    name: str
    solids: tuple[Solid, ...]
    start: Pose3
    label_id: int

    @cached_property
    def atlas(self) -> Atlas:
        """Its surface."""
        return _atlas_of(tuple(msgspec.structs.replace(solid, name="") for solid in self.solids))

    @cached_property
    def part(self) -> Part:
        """How it is drawn."""
        atlas = self.atlas
        return Part(
            name=self.name,
            mesh=atlas.mesh,
            albedo=Painted(picture=lambda: atlas.albedo),
            samples=atlas.samples,
            label_id=self.label_id,
            body=self.name,
        )


@lru_cache(maxsize=32)
def _atlas_of(solids: tuple[Solid, ...]) -> Atlas:
    """Return the atlas of nameless solids: cones are all alike."""
    return Atlas.of(solids, BODY_TEXEL_M)


def moving_bodies(scenario: Scenario) -> tuple[Moving, ...]:
    """Return the scenario's bodies."""
    ids = label_ids(scenario)

    def of(body: Body) -> Moving:
        return Moving(
            name=body.name,
            solids=body.parts,
            start=body.pose.to_pose3(),
            label_id=ids[body.name] if body.category else ID_OF_KIND[body.kind],
        )

    return tuple(of(body) for body in scenario.bodies)


def moving_robot(scenario: Scenario) -> Moving:
    """Return the robot's visible parts: hull, deck, wheels and the cameras' mast."""
    return Moving(
        name="robot",
        solids=robot_solids(scenario.robot),
        start=Pose3(rotation=np.eye(3), translation_m=np.zeros(3)),
        label_id=OtherId.ROBOT,
    )


def robot_solids(robot: RobotParams) -> tuple[Solid, ...]:
    """Return the robot's visible parts in its own frame."""
    radius, wheel = robot.wheel_radius_m, robot.wheel_width_m
    inner = robot.width_m - 2 * wheel - 0.02
    hull_low, hull_high = 0.06, robot.height_m - 0.015
    wheels = [
        Solid(
            name=f"robot_wheel_{side}",
            kind="box",
            shape="cylinder",
            centre_m=(0.0, sign * robot.wheel_separation_m / 2, radius),
            size_m=(2 * radius, 2 * radius, wheel),
            yaw_rad=math.pi / 2,
            pitch_rad=math.pi / 2,
            albedo=RUBBER,
        )
        for side, sign in (("left", 1.0), ("right", -1.0))
    ]
    boxes = (
        ("hull", (0.0, (hull_low + hull_high) / 2), (robot.length_m - 0.02, inner, hull_high - hull_low), HULL_RED),
        ("deck", (0.0, robot.height_m - 0.0075), (robot.length_m, robot.width_m, 0.015), DECK),
        (
            "mast",
            (MAST_X_M, (robot.height_m + MAST_TOP_M) / 2),
            (MAST_SIDE_M, MAST_SIDE_M, MAST_TOP_M - robot.height_m),
            METAL,
        ),
    )
    return (
        *wheels,
        *(
            Solid(name=f"robot_{name}", kind="box", centre_m=(x, 0.0, z), size_m=size, albedo=albedo)
            for name, (x, z), size, albedo in boxes
        ),
    )


def tape_part(tape: Tape, lit_poses: Mapping[str, Pose3]) -> Part:
    """Return a tape hanging between its cones (where the light has them), in the world, seen from both sides."""
    line = _tape_line([lit_poses[tape.first], lit_poses[tape.second]])

    side, count = _tape_normal(line), len(line)
    samples = Samples(
        points=np.concatenate([line, line]),
        normals=np.repeat([side, -side], count, axis=0),
        index=np.arange(2 * count, dtype=np.int32).reshape(2, count),
    )
    return Part(
        name=tape.name,
        mesh=_tape_mesh(line),
        albedo=Painted(picture=_tape_print, key="tape"),
        samples=samples,
        label_id=OtherId.TAPE,
        body=tape.name,
    )


def _tape_line(ends: Sequence[Pose3]) -> Array:
    """Return the tape's middle line (n, 3) from cone to cone."""
    start, end = (pose.transform(np.array([[0.0, 0.0, TAPE_HEIGHT_M]]))[0] for pose in ends)
    t = np.linspace(0.0, 1.0, TAPE_SEGMENTS + 1)[:, None]
    line: Array = start + t * (end - start)
    line[:, 2] -= 4 * TAPE_SAG * float(np.linalg.norm(end - start)) * (t * (1 - t))[:, 0]
    return line


def _tape_normal(line: Array) -> Array:
    along = line[-1] - line[0]
    normal = np.array([along[1], -along[0], 0.0])
    return normal / max(float(np.linalg.norm(normal)), 1e-9)


def _tape_mesh(line: Array) -> Mesh:
    """Return two layers of quads, back to back: the front's texture in the upper half, the back's in the lower."""
    n, half, normal = len(line), np.array([0.0, 0.0, TAPE_WIDTH_M / 2]), _tape_normal(line)
    share = np.linspace(0.0, min(1.0, float(np.linalg.norm(line[-1] - line[0])) / TAPE_PRINT_M), n)
    k = np.arange(n - 1)[:, None]
    front = np.concatenate([np.hstack([k, k + n, k + n + 1]), np.hstack([k, k + n + 1, k + 1])])
    uvs = [np.stack([share, np.full(n, v)], axis=1) for v in (0.05, 0.45, 0.55, 0.95)]
    return Mesh(
        vertices=np.concatenate([line + half, line - half] * 2).astype(np.float32),
        normals=np.repeat([normal, -normal], 2 * n, axis=0).astype(np.float32),
        uvs=np.concatenate(uvs).astype(np.float32),
        triangles=np.concatenate([front, front[:, ::-1] + 2 * n]).astype(np.uint32),
    )


@lru_cache(maxsize=1)
def _tape_print() -> NDArray[np.uint8]:
    """Return the tape's print over `TAPE_PRINT_M`, (h, w, 4) uint8, linear."""
    width = 512
    red = np.floor(np.arange(width) / width * TAPE_PRINT_M / TAPE_STRIPE_M) % 2 == 0
    row = np.where(red[:, None], TAPE_RED, TAPE_WHITE) * 255
    rgba = np.column_stack([np.round(row), np.full(width, 255)]).astype(np.uint8)
    return np.repeat(rgba[None], 8, axis=0)
