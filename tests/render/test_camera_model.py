"""The camera's stages: each off is the identity, each on does what its formula says."""

from collections.abc import Callable

import cv2
import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from adc_bench.geometry import Camera, Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.render.exposure import moved
from adc_bench.render.motion_blur import Flow, MotionBlur
from adc_bench.render.sensor import GAMMA, Sensor, noise_sd
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import IDEAL, PINHOLE, CameraMount, Imaging, Lens, SensorRig

Make = Callable[..., Scenario]
Picture = NDArray[np.uint8]
STRONG = Lens(k1=-0.276, k2=0.045)


def rig_with(imaging: Imaging, lens: Lens = PINHOLE) -> SensorRig:
    mounts = tuple(msgspec.structs.replace(mount, imaging=imaging, lens=lens) for mount in SensorRig().cameras)
    return SensorRig(cameras=mounts)


def ideal(**stages: object) -> Imaging:
    return msgspec.structs.replace(IDEAL, **stages)


def mount_with(imaging: Imaging) -> CameraMount:
    return rig_with(imaging).camera("road")


def decode(file: bytes) -> Picture:
    return np.asarray(cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR), np.uint8)


def before_crosswalk(scenario: Scenario, gap_m: float = 1.0) -> Pose3:
    return scenario.course.lap.pose(-gap_m).to_pose3()


@pytest.fixture(scope="module")
def ideal_renderer() -> ArenaRenderer:
    return ArenaRenderer(rig_with(IDEAL))


@pytest.fixture(scope="module")
def lens_renderer() -> ArenaRenderer:
    return ArenaRenderer(rig_with(IDEAL, STRONG))


def test_with_every_stage_off_the_picture_is_the_rendered_one(ideal_renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("dim")
    ideal_renderer.load(scenario)
    pose = before_crosswalk(scenario)
    rgba, _ = ideal_renderer.raw("road", pose)
    moving = Motion(v_mps=2.0, omega_radps=3.0)
    for file in (
        ideal_renderer.picture("road", pose, time_s=0.0, motion=moving),
        ideal_renderer.frame(3, "road", pose, motion=moving).jpeg,
    ):
        assert (decode(file)[..., ::-1] == rgba[..., :3]).all()
        assert file[1:4] == b"PNG"


# Lens


@pytest.mark.parametrize("name", ["road", "panel"])
def test_opencv_undoes_the_lens(
    name: str, ideal_renderer: ArenaRenderer, lens_renderer: ArenaRenderer, scenario_of: Make
) -> None:
    """What OpenCV's own undistortion makes of our distorted picture is the picture without the lens."""
    scenario = scenario_of("normal")
    pictures = []
    for renderer in (ideal_renderer, lens_renderer):
        renderer.load(scenario)
        pictures.append(renderer.raw(name, before_crosswalk(scenario))[0])
    camera = lens_renderer.rig.camera(name).camera()
    matrix = camera.matrix() - np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])  # OpenCV's pixel centres are whole
    undone = cv2.undistort(pictures[1], matrix, np.array([STRONG.k1, STRONG.k2, 0.0, 0.0]))
    sharp, undone = (cv2.GaussianBlur(picture[4:-4, 4:-4], (0, 0), 1.2) for picture in (pictures[0], undone))
    difference, as_is = (np.abs(sharp.astype(int) - other).mean() for other in (undone, pictures[1][4:-4, 4:-4]))
    assert difference < 1.0 < 6 * difference < as_is


def test_the_crosswalk_lies_where_the_camera_projects_its_corners(
    lens_renderer: ArenaRenderer, scenario_of: Make
) -> None:
    scenario = scenario_of("normal")
    lens_renderer.load(scenario)
    pose = before_crosswalk(scenario, 1.4)
    _, ids = lens_renderer.raw("road", pose)
    corners = np.column_stack([scenario.course.crosswalk_corners, np.zeros(4)])
    edge = np.concatenate([np.linspace(a, b, 60) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
    assert iou(ids == 1, outline(lens_renderer, "road", pose, edge)) > 0.97


def test_the_panel_lies_where_the_camera_projects_it(lens_renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal")
    lens_renderer.load(scenario)
    pose = before_crosswalk(scenario, 1.6)
    _, ids = lens_renderer.raw("panel", pose)
    solid = next(solid for solid in scenario.solids if solid.name == "panel_facing_west")
    depth, width, height = solid.size_m
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * (width, height)
    screen = np.column_stack([np.full(4, depth / 2), around])
    edge = np.concatenate([np.linspace(a, b, 20) for a, b in zip(screen, np.roll(screen, -1, axis=0), strict=True)])
    mask = ids == next(target.label_id for target in lens_renderer.targets if target.instance == solid.name)
    expected = outline(lens_renderer, "panel", pose, solid.pose_world_solid().transform(edge))
    assert mask.sum() > 500
    for axis in (0, 1):
        seen, wanted = (np.flatnonzero(picture.any(axis=axis))[[0, -1]] for picture in (mask, expected))
        assert np.abs(seen - wanted).max() <= 1


def outline(renderer: ArenaRenderer, name: str, pose: Pose3, points_world: NDArray[np.float64]) -> NDArray[np.bool_]:
    camera = renderer.rig.camera(name).camera()
    points = renderer.pose_world_camera(name, pose).inverse().transform(points_world)
    mask = np.zeros((camera.height_px, camera.width_px), np.uint8)
    cv2.fillPoly(mask, [np.round((camera.project(points) - 0.5) * 16).astype(np.int32)], 1, shift=4)
    return mask > 0


def iou(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> float:
    return float((one & other).sum() / (one | other).sum())


# Motion blur


def flow_of(camera: Camera, pose_camera: Pose3, motion: Motion, shutter_s: float) -> Flow | None:
    robot = Pose3(rotation=np.eye(3), translation_m=np.zeros(3))
    return MotionBlur(camera).flow(robot, pose_camera, motion, shutter_s)


@pytest.mark.parametrize("lens", [PINHOLE, STRONG], ids=["pinhole", "lens"])
@pytest.mark.parametrize(
    "motion", [Motion(v_mps=2.0), Motion(omega_radps=2.0), Motion(v_mps=1.0, omega_radps=-1.5)], ids=str
)
def test_floor_points_ahead_blur_by_speed_times_shutter(motion: Motion, lens: Lens) -> None:
    mount = msgspec.structs.replace(SensorRig().camera("road"), lens=lens)
    camera, pose, shutter_s = mount.camera(), mount.pose_robot_camera(), 1 / 60
    flow = flow_of(camera, pose, motion, shutter_s)
    assert flow
    for x_m, y_m in ((0.8, 0.0), (1.0, 0.2), (1.4, -0.3)):
        # in the robot's frame the floor moves the other way: by v along x, and turning by omega about the origin
        velocity = np.array([-motion.v_mps + motion.omega_radps * y_m, -motion.omega_radps * x_m, 0.0])
        middle = np.array([x_m, y_m, 0.0])
        ends = pose.inverse().transform([middle - velocity * shutter_s / 2, middle + velocity * shutter_s / 2])
        expected = np.diff(camera.project(ends), axis=0)[0]
        column, row = np.floor(camera.project(pose.inverse().transform([middle]))[0]).astype(int)
        assert np.allclose(flow.shift_px[:, row, column], expected, atol=0.1 + 0.03 * np.hypot(*expected))


def test_a_robot_that_stands_or_moves_slowly_takes_sharp_pictures() -> None:
    mount = SensorRig().camera("road")
    for motion, shutter_s in ((Motion(), 1 / 60), (Motion(v_mps=2.0), 0.0), (Motion(v_mps=0.05), 1 / 60)):
        assert flow_of(mount.camera(), mount.pose_robot_camera(), motion, shutter_s) is None


@pytest.mark.parametrize(
    "motion", [Motion(v_mps=1.5), Motion(omega_radps=2.0), Motion(v_mps=1.0, omega_radps=1.0)], ids=str
)
@pytest.mark.parametrize("lens", [PINHOLE, Lens()], ids=["pinhole", "lens"])
def test_blur_is_near_the_mean_of_pictures_taken_through_the_exposure(
    motion: Motion, lens: Lens, scenario_of: Make
) -> None:
    renderer = ArenaRenderer(rig_with(ideal(shutter_max_s=1 / 60), lens))
    scenario = scenario_of("dark")
    renderer.load(scenario)
    pose = before_crosswalk(scenario, 1.2)
    frame = renderer.frame(0, "road", pose, motion=motion)
    assert frame.conditions.shutter_s == 1 / 60 and frame.conditions.blur_px > 1.5
    times_s = (np.arange(24) + 0.5) / 24 / 60 - 1 / 120
    taken = [
        renderer.exposed("road", pose @ moved(motion, time_s).to_pose3(), frame.conditions.exposure)[..., 2::-1]
        for time_s in times_s
    ]
    mean = 255 * np.mean((np.array(taken) / 255) ** GAMMA, axis=0) ** (1 / GAMMA)
    sharp = renderer.raw("road", pose)[0][..., 2::-1]
    blurred, unblurred = (np.abs(picture - mean)[:, 12:-12].mean() for picture in (decode(frame.jpeg), sharp))
    assert blurred < 1.0 and blurred < 0.5 * unblurred


def test_labels_are_those_of_mid_exposure(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("dark")
    renderer.load(scenario)
    pose = before_crosswalk(scenario, 1.2)
    still, turning = (renderer.frame(0, "road", pose, motion=Motion(omega_radps=w)) for w in (0.0, 2.0))
    assert still.labels == turning.labels and still.jpeg != turning.jpeg


# Vignetting, white balance, noise, file


def grey(value: int) -> Picture:
    return np.full((240, 320, 4), value, np.uint8)


def test_light_falls_off_evenly_towards_the_corners() -> None:
    sensor = Sensor(mount_with(ideal(vignetting=0.3)))
    picture = sensor.develop(grey(200), 1.0, np.random.default_rng(0))[..., 0]
    assert (picture == picture[::-1]).all() and (picture == picture[:, ::-1]).all()
    u, v = np.meshgrid(np.arange(320) - 159.5, np.arange(240) - 119.5)
    ordered = picture.ravel()[np.argsort(np.hypot(u, v).ravel(), kind="stable")].astype(int)
    assert (np.diff(ordered) <= 0).all()
    assert picture[120, 160] == 200
    assert (picture[0, 0] / 200) ** GAMMA == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_noise_has_the_deviation_that_counting_electrons_gives(gain: float) -> None:
    """An independent count: Poisson electrons, normal read noise, gain, then gamma."""
    imaging, rng = Imaging(), np.random.default_rng(0)
    for value in (30, 80, 150, 220):
        electrons = (value / 255) ** GAMMA * imaging.full_well_electrons / gain
        read = rng.poisson(electrons, 200_000) + imaging.read_noise_electrons * rng.standard_normal(200_000)
        signal = np.clip(read * gain / imaging.full_well_electrons, 0, 1)
        assert noise_sd(gain, imaging)[value] == pytest.approx((255 * signal ** (1 / GAMMA)).std(), rel=0.1)


@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_delivered_noise_is_unbiased_and_has_the_deviation_of_the_signal(gain: float) -> None:
    imaging = ideal(full_well_electrons=9000.0, read_noise_electrons=6.0)
    sensor, expected = Sensor(mount_with(imaging)), noise_sd(gain, imaging)
    for value in (40, 100, 200):
        picture = sensor.develop(grey(value), gain, np.random.default_rng(0)).astype(float)
        rounding = 1 / 12
        assert picture.std() == pytest.approx(np.sqrt(expected[value] ** 2 + rounding), rel=0.05)
        assert picture.mean() == pytest.approx(value, abs=0.05)
        channels = np.corrcoef(picture.reshape(-1, 3).T)
        assert np.abs(channels - np.eye(3)).max() < 0.02


def test_shot_noise_alone_is_even_and_read_noise_grows_in_the_dark() -> None:
    shot, both = (noise_sd(4.0, ideal(full_well_electrons=9000.0, read_noise_electrons=r))[20:] for r in (0.0, 6.0))
    assert shot.max() < 1.35 * shot.min()
    assert (both > shot).all() and (np.diff(both - shot) < 0).all() and both[0] > 2 * shot[0]


def test_pictures_differ_in_their_noise_by_their_number_alone(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("dim")
    pose = before_crosswalk(scenario)
    renderer.load(scenario)
    drive = [renderer.picture("road", pose, time_s=0.05 * k) for k in range(3)]
    assert len(set(drive)) == 3
    assert renderer.frame(1, "road", pose).jpeg == drive[1]


def test_white_balance_makes_a_grey_floor_greyer(scenario_of: Make) -> None:
    casts = []
    for share in (0.0, 0.7, 1.0):
        renderer = ArenaRenderer(rig_with(ideal(white_balance=share)))
        scenario = scenario_of("normal", seed=4)
        warm = msgspec.structs.replace(scenario.look, colour_temperature_k=2800.0)
        renderer.load(msgspec.structs.replace(scenario, look=warm))
        rgba, ids = renderer.raw("road", before_crosswalk(scenario))
        red, _, blue = (rgba[ids == 1][:, :3].astype(float) ** GAMMA).mean(axis=0)  # paint, which has no colour
        casts.append(red / blue)
    assert casts[0] > 1.5 * casts[1] > 1.5 * casts[2]
    assert casts[2] == pytest.approx(1.0, abs=0.35)


@pytest.mark.parametrize(("quality", "magic"), [(92, b"\xff\xd8"), (None, b"\x89P")])
def test_the_file_is_a_jpeg_or_a_png(quality: int | None, magic: bytes) -> None:
    sensor = Sensor(mount_with(ideal(jpeg_quality=quality)))
    file = sensor.encode(sensor.develop(grey(77), 1.0, np.random.default_rng(0)))
    assert file[:2] == magic and (decode(file) == 77).all()


# A camera anywhere


def test_a_view_from_above_sees_the_floor_well_exposed(renderer: ArenaRenderer, scenario_of: Make) -> None:
    scenario = scenario_of("normal")
    renderer.load(scenario)
    down = Pose3(rotation=np.diag([1.0, -1.0, -1.0]), translation_m=np.array([0.0, -2.6, 3.5]))
    for hfov_rad in (1.0, 0.5):
        camera = Camera.from_hfov(width_px=300, height_px=200, hfov_rad=hfov_rad)
        rgb = renderer.look_from(camera, down)
        assert rgb.shape == (200, 300, 3) and rgb.dtype == np.uint8
        assert 30 < rgb.mean() < 200 and np.percentile(rgb, 99) > 150
