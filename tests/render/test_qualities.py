"""The three qualities of the same arenas: equal labels and shapes, equal brightness within the stated tolerance."""

from collections.abc import Callable, Iterator, Mapping

import msgspec
import numpy as np
import pytest
import sapien
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose2, Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.render.light import Lighting
from adc_bench.render.pack_camera import PackCamera, Stage
from adc_bench.render.pack_scene import PackScene, without_floods
from adc_bench.render.packs import PACKS
from adc_bench.render.scene import FastScene, sapien_pose
from adc_bench.render.view import FAR_M, NEAR_M
from adc_bench.world.arena import Tunnel
from adc_bench.world.layout import BoxPlace, Layout
from adc_bench.world.quality import QUALITIES, Quality
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import draw_signs
from adc_bench.world.streams import stream

SIZE_PX = 64, 48
# Relative difference of the mean linear brightness from that of `fast`. A traced glossy floor mirrors the even sky. In
# the tunnel `fast` and `standard` have the light of a formula, `raytraced` follows it from the openings.
TOLERANCE: Mapping[str, Mapping[Quality, float]] = {
    "glossy": {"standard": 0.10, "raytraced": 0.20},
    "dark": {"standard": 0.10, "raytraced": 0.10},
    "tunnel": {"standard": 0.10, "raytraced": 0.40},
}
ARENAS = tuple(TOLERANCE)
OTHERS = ("standard", "raytraced")
TUNNEL_S_M, TUNNEL_LENGTH_M = 6.0, 3.0
Taken = tuple[NDArray[np.uint8], NDArray[np.uint8]]


def _rig() -> SensorRig:
    rig = SensorRig()
    return msgspec.structs.replace(rig, cameras=(rig.camera("road").resized(*SIZE_PX),))


@pytest.fixture(scope="module")
def arenas(scenario_of: Callable[..., Scenario]) -> Mapping[str, tuple[Scenario, Pose3]]:
    """Arenas with the robot's pose in each."""

    def furnished(scenario: Scenario, layout: Layout) -> Scenario:
        signs = draw_signs(scenario.course_spec, stream(scenario.seed, "signs"))
        return msgspec.structs.replace(scenario, layout=layout, signs=signs)

    boxes = (BoxPlace(x_m=0.6, y_m=-0.4), BoxPlace(x_m=0.9, y_m=0.5, yaw_rad=0.4))
    tunnel = Tunnel(start_s_m=TUNNEL_S_M, length_m=TUNNEL_LENGTH_M)
    matt = furnished(scenario_of("normal", seed=1), Layout(boxes=boxes))
    glossy = msgspec.structs.replace(matt, look=msgspec.structs.replace(matt.look, floor_gloss=0.6))
    dark = furnished(scenario_of("dark", seed=2), Layout(boxes=boxes, tunnel=tunnel))
    outside = Pose2(x_m=-1.0, y_m=0.0, yaw_rad=0.0).to_pose3()
    inside = dark.course.lap.pose(TUNNEL_S_M + TUNNEL_LENGTH_M / 2).to_pose3()
    return {"glossy": (glossy, outside), "dark": (dark, outside), "tunnel": (dark, inside)}


@pytest.fixture(scope="module")
def renderers() -> Mapping[Quality, ArenaRenderer]:
    return {quality: ArenaRenderer(_rig(), quality) for quality in QUALITIES}


@pytest.fixture(scope="module")
def taken(
    arenas: Mapping[str, tuple[Scenario, Pose3]], renderers: Mapping[Quality, ArenaRenderer]
) -> Mapping[tuple[str, Quality], Taken]:
    def take() -> Iterator[tuple[tuple[str, Quality], Taken]]:
        for quality, renderer in renderers.items():
            loaded = None
            for name, (scenario, pose) in arenas.items():
                if scenario is not loaded:  # a path tracer's scene takes seconds to change
                    renderer.load(loaded := scenario)
                yield (name, quality), renderer.raw("road", pose)

    return dict(take())


def _brightness(rgba: NDArray[np.uint8]) -> float:
    return float(np.mean((rgba[..., :3] / 255.0) ** 2.2))


@pytest.mark.parametrize("arena", ARENAS)
@pytest.mark.parametrize("quality", OTHERS)
def test_labels_are_identical(taken: Mapping[tuple[str, Quality], Taken], arena: str, quality: Quality) -> None:
    ids = taken[arena, "fast"][1]
    assert np.array_equal(taken[arena, quality][1], ids)
    assert arena == "tunnel" or len(np.unique(ids)) >= 3


@pytest.mark.parametrize("arena", ARENAS)
@pytest.mark.parametrize("quality", OTHERS)
def test_brightness_agrees(taken: Mapping[tuple[str, Quality], Taken], arena: str, quality: Quality) -> None:
    tolerance = TOLERANCE[arena][quality]
    ours, other = taken[arena, "fast"][0], taken[arena, quality][0]
    assert _brightness(other) == pytest.approx(_brightness(ours), rel=tolerance)
    floor = np.s_[2 * SIZE_PX[1] // 3 :]
    assert _brightness(other[floor]) == pytest.approx(_brightness(ours[floor]), rel=tolerance)
    assert not np.array_equal(other, ours)


def test_a_pushed_box_is_where_a_fresh_arena_has_it(
    arenas: Mapping[str, tuple[Scenario, Pose3]], renderers: Mapping[Quality, ArenaRenderer]
) -> None:
    scenario, pose = arenas["glossy"]
    boxes = (BoxPlace(x_m=0.4, y_m=0.2, yaw_rad=0.3), scenario.layout.boxes[1])
    there = msgspec.structs.replace(scenario, layout=msgspec.structs.replace(scenario.layout, boxes=boxes))
    renderer = renderers["standard"]
    renderer.load(there)
    fresh, fresh_ids = renderer.raw("road", pose)
    renderer.load(scenario)
    before, _ = renderer.raw("road", pose)
    renderer.place({"box_0": Pose2(x_m=0.4, y_m=0.2, yaw_rad=0.3).to_pose3()})
    pushed, pushed_ids = renderer.raw("road", pose)
    assert np.array_equal(pushed, fresh)
    assert np.array_equal(pushed_ids, fresh_ids)
    assert not np.array_equal(pushed, before)


def _depth_of_ours(
    scenario: Scenario, pinhole: Camera, pose_world_camera: Pose3, down_px: float
) -> NDArray[np.float64]:
    """Return our pack's depth in metres, the picture's points moved down by a part of a pixel."""
    scene = sapien.Scene([sapien.render.RenderSystem()])
    FastScene(scene, scenario).place_robot(Pose3(rotation=np.eye(3), translation_m=np.full(3, 1e4)))
    p, component, entity = pinhole, sapien.render.RenderCameraComponent(*SIZE_PX), sapien.Entity()
    component.set_perspective_parameters(NEAR_M, FAR_M, p.fx_px, p.fy_px, p.cx_px, p.cy_px + down_px, 0.0)
    entity.add_component(component)
    scene.add_entity(entity)
    entity.set_pose(sapien_pose(pose_world_camera))
    scene.update_render()
    component.take_picture()
    return np.asarray(component.get_picture("GbufferDepth"), np.float64)


def test_shapes_are_identical(arenas: Mapping[str, tuple[Scenario, Pose3]], renderers: object) -> None:
    scenario, pose = arenas["glossy"]
    pinhole = Camera.from_hfov(width_px=SIZE_PX[0], height_px=SIZE_PX[1], hfov_rad=1.3)
    pose_world_camera = pose @ _rig().camera("road").pose_robot_camera()
    rasterised = Stage(pack=PACKS["standard"])
    PackScene(rasterised, scenario)
    lit, shell = (
        PackCamera(scene, rasterised.pack, pinhole, depth=0).take(pose_world_camera, "GbufferDepth")
        for scene in (rasterised.lit, rasterised.shell)
    )
    ours = _depth_of_ours(scenario, pinhole, pose_world_camera, 0.0)
    assert np.minimum(lit, shell) == pytest.approx(ours, abs=2e-7)  # the last bits of a float32
    # The second path through a pixel passes at (1/2, 1/3) of it (Halton), and leaves its position behind.
    traced = Stage(pack=msgspec.structs.replace(PACKS["raytraced"], samples=2))
    PackScene(traced, scenario)
    cover, walls = (PackCamera(scene, traced.pack, pinhole, depth=0) for scene in (traced.cover, traced.shell))
    near_z, far_z = (camera.take(pose_world_camera, "Position")[..., 2] for camera in (cover, walls))
    metres = -np.where(cover.take(pose_world_camera, "Segmentation")[..., 1] > 0, near_z, far_z)
    ours = _depth_of_ours(scenario, pinhole, pose_world_camera, 1 / 6)
    ours_m = NEAR_M * FAR_M / (FAR_M - ours * (FAR_M - NEAR_M))
    assert np.mean(np.abs(metres / ours_m - 1) < 1e-3) > 0.998


def test_traced_pictures_forget_the_one_before(
    arenas: Mapping[str, tuple[Scenario, Pose3]],
    renderers: Mapping[Quality, ArenaRenderer],
    taken: Mapping[tuple[str, Quality], Taken],
) -> None:
    again, _ = renderers["raytraced"].raw("road", arenas["dark"][1])  # after the one in the tunnel
    assert np.array_equal(again, taken["dark", "raytraced"][0])


@pytest.mark.parametrize("quality", OTHERS)
def test_nothing_is_left_behind(arenas: Mapping[str, tuple[Scenario, Pose3]], quality: Quality) -> None:
    stage = Stage(pack=PACKS[quality])
    scene = PackScene(stage, arenas["glossy"][0])
    assert stage.lit.entities
    scene.remove()
    assert not any(scene.entities for scene in (stage.lit, stage.shell, stage.cover))


def test_without_floods_the_rest_stays(arenas: Mapping[str, tuple[Scenario, Pose3]]) -> None:
    scenario, _ = arenas["glossy"]
    points, up = np.array([[2.0, 0.0, 0.0], [-6.0, 1.0, 0.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    whole = Lighting(scenario=scenario)
    floods = whole.level * scenario.look.flood_share * whole.cold
    rest = Lighting(scenario=without_floods(scenario)).irradiance(points, up)
    assert whole.irradiance(points, up) == pytest.approx(rest + floods, rel=1e-5)
