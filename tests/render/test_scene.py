"""The arena in SAPIEN: what moves, what is labelled, what the shader makes of light and albedo."""

import msgspec
import numpy as np
import pytest
import sapien
from halls import EAST_FLOOD, TUNNEL, hall
from numpy.typing import NDArray

from adc_bench.geometry import ROTATION_BODY_OPTICAL, Pose2, Pose3, rotation_zyx
from adc_bench.render import ArenaRenderer
from adc_bench.render.arena_parts import ArenaParts
from adc_bench.render.other_ids import OtherId
from adc_bench.render.parts import TwoTone
from adc_bench.render.scene import FastScene, sapien_pose
from adc_bench.render.targets import label_ids
from adc_bench.world.layout import BoxPlace
from adc_bench.world.scenario import Scenario

BOXES = (BoxPlace(x_m=-1.5, y_m=-1.9), BoxPlace(x_m=1.6, y_m=-2.6, yaw_rad=0.3))
Picture = NDArray[np.uint8]


class Eye:
    """A pinhole camera over the arena's pictures."""

    def __init__(self, renderer: ArenaRenderer) -> None:
        assert renderer.device_name
        self.scene = sapien.Scene([sapien.render.RenderSystem()])
        self._camera = sapien.render.RenderCameraComponent(160, 120)
        self._camera.set_perspective_parameters(0.05, 40, 120, 120, 80, 60, 0)
        self._entity = sapien.Entity()
        self._entity.add_component(self._camera)
        self.scene.add_entity(self._entity)

    def look(
        self, x: float, y: float, z: float, yaw: float, down: float, exposure: float = 0.6
    ) -> tuple[Picture, Picture]:
        rotation = rotation_zyx(yaw, down, 0.0) @ ROTATION_BODY_OPTICAL
        self._entity.set_pose(sapien_pose(Pose3(rotation=rotation, translation_m=np.array([x, y, z]))))
        self.scene.set_ambient_light([exposure] * 3)
        self.scene.update_render()
        self._camera.take_picture()
        colour, label = self._camera.get_picture("Color"), self._camera.get_picture("Label")
        return np.array(colour[..., :3]), np.array(label[..., 0])


@pytest.fixture(scope="module")
def eye(renderer: ArenaRenderer) -> Eye:
    return Eye(renderer)


def shot(eye: Eye, scenario: Scenario, view: tuple[float, ...]) -> tuple[Picture, Picture]:
    arena = FastScene(eye.scene, scenario)
    pictures = eye.look(*view)
    arena.remove()
    return pictures


OVER_START = (-2.6, -3.6, 1.2, 0.6, 0.5)
OVER_WORKS = (3.2, 5.6, 1.0, -0.7, 0.35)


def test_the_shader_multiplies_light_and_albedo(eye: Eye) -> None:
    """Dull floor straight below, against numpy: gamma(exposure x irradiance x albedo)."""
    scenario = hall(floods=(EAST_FLOOD,), floor_gloss=0.0, line_wear=0.6, dirt=0.8)
    colour, _ = shot(eye, scenario, (-3.0, -2.0, 3.0, np.pi / 2, np.pi / 2))
    parts = ArenaParts.of(scenario)
    course = next(part for part in parts.standing() if part.name == "course")
    x0, y0, x1, y1 = parts.floors[0].bounds
    u, v = np.meshgrid(np.arange(160) + 0.5, np.arange(120) + 0.5)
    places = np.stack([-3.0 + (u - 80) / 40, -2.0 - (v - 60) / 40], axis=2)  # 3 m above, 120 px focal length
    albedo = course.albedo.picture()[..., :3] / 255
    h, w = albedo.shape[:2]
    column, row = (places[..., 0] - x0) / (x1 - x0) * w, (y1 - places[..., 1]) / (y1 - y0) * h
    near = np.mean(
        [albedo[(row + dr).astype(int), (column + dc).astype(int)] for dr in (-2, 0, 2) for dc in (-2, 0, 2)], 0
    )
    light = parts.floors[0].at(places.reshape(-1, 2)).reshape(120, 160, 3)
    expected = 255 * np.clip(0.6 * near * light, 0, 1) ** (1 / 2.2)
    difference = np.abs(colour.astype(float) - expected)
    assert np.median(difference) < 2.5 and abs((colour - expected).mean()) < 1.0


def test_labels_are_what_stands_there_whatever_the_light(eye: Eye) -> None:
    scenario = hall(full=True, boxes=BOXES, floods=(EAST_FLOOD,))
    dark = msgspec.structs.replace(
        scenario, look=msgspec.structs.replace(scenario.look, floods=(), illuminance_lux=10.0, floor_gloss=0.9)
    )
    for view in (OVER_START, OVER_WORKS):
        (bright_colour, first), (dark_colour, second) = (shot(eye, s, view) for s in (scenario, dark))
        assert (first == second).all() and (bright_colour != dark_colour).any()
    ids = label_ids(scenario)
    seen = set(np.unique(shot(eye, scenario, OVER_WORKS)[1]).tolist())
    assert ids["cone_left_1"] in seen and ids["cone_right_1"] in seen


def test_a_moved_box_looks_as_if_it_had_always_been_there(eye: Eye) -> None:
    scenario = hall(boxes=BOXES, floods=(EAST_FLOOD,))
    there = Pose2(x_m=-1.1, y_m=-2.2, yaw_rad=0.5)
    elsewhere = hall(boxes=(BoxPlace(x_m=-1.1, y_m=-2.2, yaw_rad=0.5), BOXES[1]), floods=(EAST_FLOOD,))
    fresh = shot(eye, elsewhere, OVER_START)[0]
    arena = FastScene(eye.scene, scenario)
    at_first = eye.look(*OVER_START)[0]
    arena.place({"box_0": there.to_pose3()})
    moved = eye.look(*OVER_START)[0]
    arena.place({"box_0": scenario.bodies[0].pose.to_pose3()})
    back = eye.look(*OVER_START)[0]
    arena.remove()
    assert moved.tobytes() == fresh.tobytes() != at_first.tobytes()
    assert back.tobytes() == at_first.tobytes()


def test_a_fallen_cone_takes_its_tapes_down_with_it(eye: Eye) -> None:
    scenario = hall(full=True)
    arena = FastScene(eye.scene, scenario)
    standing, labels = eye.look(*OVER_WORKS)
    fallen = Pose3(rotation=rotation_zyx(0.0, np.pi / 2, 0.0), translation_m=np.array([6.6, 4.2, 0.08]))
    arena.place({"cone_right_1": fallen})
    lying, lying_labels = eye.look(*OVER_WORKS)
    arena.remove()
    assert (standing != lying).any() and (labels != lying_labels).any()


def test_a_torn_tape_is_gone_and_comes_back(eye: Eye) -> None:
    scenario = hall(full=True)
    arena = FastScene(eye.scene, scenario)
    whole, labels = eye.look(*OVER_WORKS)
    arena.place({}, torn=["tape_left_0"])
    torn, torn_labels = eye.look(*OVER_WORKS)
    arena.place({})
    again, _ = eye.look(*OVER_WORKS)
    arena.remove()
    assert (whole != torn).any() and whole.tobytes() == again.tobytes()
    assert (labels == OtherId.TAPE).any() and (labels == torn_labels)[labels != OtherId.TAPE].all()


def test_the_robot_s_shadow_falls_on_the_floor_and_moves_along(eye: Eye) -> None:
    scenario = hall(floods=(EAST_FLOOD,), floor_gloss=0.0)
    arena = FastScene(eye.scene, scenario)
    above = (-3.0, -2.6, 2.0, 0.0, np.pi / 2)
    empty = eye.look(*above)[0].astype(int)
    arena.place_robot(Pose2(x_m=-3.0, y_m=-2.6, yaw_rad=0.7).to_pose3())
    darker = empty - eye.look(*above)[0]
    arena.place_robot(Pose2(x_m=9.0, y_m=5.6, yaw_rad=0.7).to_pose3())
    gone = eye.look(*above)[0]
    arena.remove()
    assert (darker >= 0).all() and darker.max() > 5
    rows = darker.sum(axis=(1, 2))  # the picture's top is +x, where the floodlight stands
    assert rows[60:].sum() > 1.5 * rows[:60].sum()
    assert (gone == empty).all()


def test_the_robot_itself_is_seen_from_outside_only_when_asked(eye: Eye) -> None:
    arena = FastScene(eye.scene, hall())
    pose = Pose2(x_m=-1.5, y_m=-2.6, yaw_rad=0.0).to_pose3()
    arena.place_robot(pose)
    shadow_only = eye.look(*OVER_START)[0]
    arena.place_robot(pose, visible=True)
    with_robot = eye.look(*OVER_START)[0]
    arena.remove()
    assert (shadow_only != with_robot).any(axis=2).mean() > 0.02


def test_the_rig_does_not_see_its_own_robot(renderer: ArenaRenderer) -> None:
    scenario = hall(floods=(EAST_FLOOD,))
    renderer.load(scenario)
    pose = scenario.course.lap.pose(3.0).to_pose3()
    for camera in ("road", "panel"):
        view = renderer._cameras[camera].view
        pose_camera, pictures = renderer.pose_world_camera(camera, pose), []
        for visible in (False, True):
            renderer._arena.place_robot(pose, visible=visible)
            view.take(pose_camera, np.full(3, 0.6))
            view.read()
            pictures.append(np.array(view.colour()))
        assert (pictures[0] == pictures[1]).all()


def test_a_glossy_floor_shows_more_light_a_dull_one_none(eye: Eye) -> None:
    dull, glossy = (shot(eye, hall(floor_gloss=gloss), OVER_START)[0].astype(int) for gloss in (0.0, 0.6))
    assert (glossy >= dull).all() and (glossy - dull).mean() > 2


def test_wear_takes_paint_and_dirt_lightens_black_floor(eye: Eye) -> None:
    above = (-3.0, -2.2, 2.5, 0.0, np.pi / 2)
    fresh, worn, dirty = (
        shot(eye, hall(line_wear=wear, dirt=dirt, floor_gloss=0.0), above)[0].astype(int)
        for wear, dirt in ((0.0, 0.0), (0.6, 0.0), (0.0, 1.0))
    )
    lines = fresh[..., 1] > 120
    assert lines.any() and worn[lines].mean() < 0.93 * fresh[lines].mean()
    assert dirty[~lines].mean() > fresh[~lines].mean() + 1


def test_inside_the_tunnel_it_is_dark(eye: Eye) -> None:
    course = hall().course
    x, y, yaw = course.lap.poses(np.array([TUNNEL.start_s_m + 1.5]))[0]
    with_tunnel, without = (
        shot(eye, hall(tunnel=t, floor_gloss=0.6), (x, y, 0.7, yaw, 0.9))[0].mean() for t in (TUNNEL, None)
    )
    assert with_tunnel < 0.45 * without


def test_switching_scenarios_leaves_nothing_behind(eye: Eye) -> None:
    before, counts = len(eye.scene.entities), []
    for k in range(4):
        arena = FastScene(eye.scene, hall(full=k % 2 == 0, boxes=BOXES if k % 2 == 0 else ()))
        arena.place({} if k % 2 else {"box_0": Pose2(x_m=0.0, y_m=3.0, yaw_rad=0.0).to_pose3()}, torn=["tape_left_0"])
        counts.append(len(eye.scene.entities))
        arena.remove()
        assert len(eye.scene.entities) == before
    assert counts[0] == counts[2] > counts[1] == counts[3]


def test_every_solid_and_body_is_in_some_part() -> None:
    scenario = hall(full=True, boxes=BOXES)
    names = {part.name for part in ArenaParts.of(scenario).standing()}
    assert {sign.name for sign in scenario.signs} <= names
    assert {"course", "crosswalk", "hall_floor", "ceiling", "lamps", "solids", "poster_0"} <= names
    assert {solid.name for solid in scenario.solids if solid.kind in ("wall", "panel")} <= names


def test_two_tone_is_mixed_as_it_says() -> None:
    tones = np.array([[[128, 0, 0, 0], [128, 255, 0, 0], [128, 255, 255, 0], [128, 0, 0, 255]]], np.uint8)
    albedo = TwoTone(
        draw=lambda: tones, first=(0.1, 0.1, 0.1), second=(0.8, 0.8, 0.8), key="test", wear=0.5, dirt=1.0
    ).picture()[0, :, 0]
    np.testing.assert_allclose(albedo / 255, [0.1, 0.8, 0.45, 0.21], atol=0.005)
