import math
from collections.abc import Iterator

import msgspec
import numpy as np
import pytest
import sapien
import shapely
from numpy.typing import NDArray

from adc_bench.geometry import Pose2, Pose3, rotation_zyx
from adc_bench.sim import Simulation
from adc_bench.sim.laser import Laser, beam_angles_rad
from adc_bench.sim.rays import Obstacles
from adc_bench.sim.surfaces import add_floor, add_solid, physics
from adc_bench.world.layout import BoxPlace, Layout
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import LaserSpec
from adc_bench.world.solids import Body, Shape, Solid

Array = NDArray[np.float64]
SPEC = LaserSpec()
EXACT = LaserSpec(noise_near_m=0.0, noise_share=0.0)
HERE = Pose2(x_m=0.3, y_m=-0.2, yaw_rad=0.7)


def solid(shape: Shape, x_m: float, y_m: float, z_m: float, size_m: tuple[float, float, float], **more: float) -> Solid:
    return Solid(name="it", kind="cabinet", centre_m=(x_m, y_m, z_m), size_m=size_m, shape=shape, **more)


def ranges(solids: list[Solid], pose: Pose3, bodies: tuple[Body, ...] = ()) -> Array:
    return Laser(1, EXACT).true_ranges_m(pose, Obstacles(solids, bodies))


def flat_oracle(outlines: list[shapely.Geometry], pose: Pose2) -> Array:
    """What a level laser reads, by 2-D geometry: the distance to where each beam first meets an outline."""
    origin = pose @ Pose2(x_m=SPEC.x_m, y_m=0.0, yaw_rad=0.0)
    start, everything = shapely.Point(origin.x_m, origin.y_m), shapely.union_all(outlines)
    read = []
    for angle in beam_angles_rad(SPEC) + pose.yaw_rad:
        end = (origin.x_m + SPEC.range_max_m * math.cos(angle), origin.y_m + SPEC.range_max_m * math.sin(angle))
        met = shapely.LineString([start, end]).intersection(everything)
        read.append(math.inf if met.is_empty else start.distance(met))
    return np.array(read)


def test_has_the_beams_of_its_spec() -> None:
    angles = beam_angles_rad(SPEC)
    assert angles.size == SPEC.beams == 338
    assert angles[0] == pytest.approx(-math.radians(135))
    assert np.diff(angles) == pytest.approx(math.radians(0.8))
    assert angles[-1] <= math.radians(135) + 1e-9


def test_upright_boxes_rods_and_cones_are_where_plane_geometry_has_them() -> None:
    rng = np.random.default_rng(4)
    solids, outlines = [], []
    for shape in ("box", "cylinder", "cone") * 12:
        far, angle, yaw = rng.uniform(0.8, 3.2), rng.uniform(-math.pi, math.pi), rng.uniform(-3, 3)
        x_m, y_m = HERE.x_m + far * math.cos(angle), HERE.y_m + far * math.sin(angle)
        length, width, height = rng.uniform((0.1, 0.1, 0.3), (0.5, 0.5, 0.7))
        if shape == "box":
            solids.append(solid(shape, x_m, y_m, height / 2, (length, width, height), yaw_rad=yaw))
            outline = shapely.affinity.rotate(
                shapely.box(-length / 2, -width / 2, length / 2, width / 2), yaw, (0, 0), True
            )
            outlines.append(shapely.affinity.translate(outline, x_m, y_m))
        else:
            solids.append(solid(shape, x_m, y_m, height / 2, (length, length, height)))
            narrow = 1.0 if shape == "cylinder" else 1 - SPEC.z_m / height
            outlines.append(shapely.Point(x_m, y_m).buffer(length / 2 * narrow, quad_segs=512))
    read, expected = ranges(solids, HERE.to_pose3()), flat_oracle(outlines, HERE)
    assert (np.isfinite(read) == np.isfinite(expected)).mean() > 0.995  # a beam may graze the oracle's polygon
    both = np.isfinite(read) & np.isfinite(expected)
    assert both.sum() > 150
    assert np.quantile(np.abs(read[both] - expected[both]), 0.99) < 1e-4
    assert np.median(np.abs(read[both] - expected[both])) < 1e-6


@pytest.fixture
def tilted() -> list[Solid]:
    rng = np.random.default_rng(8)
    return [
        solid(
            shape,
            *rng.uniform(-2.5, 2.5, size=2),
            rng.uniform(0.0, 0.4),
            tuple(rng.uniform(0.1, 0.6, size=3)),
            yaw_rad=rng.uniform(-3, 3),
            pitch_rad=rng.uniform(-1.6, 1.6),
        )
        for shape in ("box", "cylinder", "cone") * 10
    ]


@pytest.mark.parametrize("pitch_rad", [0.0, 0.1, -0.1])
def test_leaning_things_are_where_physx_meets_them(tilted: list[Solid], pitch_rad: float) -> None:
    """PhysX has hulls of 24 sides for the round ones, which lie up to 0.9 % of the radius inside."""
    system = physics(200)
    scene = sapien.Scene([system])
    add_floor(scene)
    away = [it for it in tilted if math.hypot(it.centre_m[0] - HERE.x_m, it.centre_m[1] - HERE.y_m) > 0.8]
    for it in away:
        add_solid(scene, it, 0.5)
    pose = Pose3(rotation=rotation_zyx(0.7, pitch_rad, 0.03), translation_m=np.array([HERE.x_m, HERE.y_m, 0.0]))
    read = ranges(away, pose)
    origin = pose.transform([[SPEC.x_m, 0.0, SPEC.z_m]])[0]
    angles = beam_angles_rad(SPEC)
    beams = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1) @ pose.rotation.T
    hits = [system.raycast(origin, beam, SPEC.range_max_m) for beam in beams]
    expected = np.array([math.inf if hit is None else hit.distance for hit in hits])
    assert np.isfinite(expected).sum() > 100
    assert (np.isfinite(read) == np.isfinite(expected)).mean() > 0.985
    both = np.isfinite(read) & np.isfinite(expected)
    error = np.abs(read[both] - expected[both])
    assert np.median(error) < 2e-5
    assert np.quantile(error, 0.9) < 3e-3
    assert np.quantile(error, 0.97) < 2e-2  # beams that graze a rod


def test_a_leaning_robot_sees_the_floor() -> None:
    pose = Pose3(rotation=rotation_zyx(0.0, 0.1, 0.0), translation_m=np.zeros(3))  # nose down
    ahead = ranges([], pose)[SPEC.beams // 2]
    height_m = SPEC.z_m * math.cos(0.1) - SPEC.x_m * math.sin(0.1)
    assert ahead == pytest.approx(height_m / math.sin(0.1), rel=1e-4)
    assert not np.isfinite(ranges([], HERE.to_pose3())).any(), "a level one does not"


def with_laser(scenario: Scenario, laser: LaserSpec | None) -> Scenario:
    return msgspec.structs.replace(scenario, rig=msgspec.structs.replace(scenario.rig, laser=laser))


def scans(sim: Simulation, steps: int) -> Iterator[tuple[float, float, Array]]:
    """Yield when a scan was read, when it was taken, and its ranges."""
    for k in range(steps):
        if scan := sim.read_sensors().laser:
            yield sim.time_s, scan.time_s, scan.ranges_m
        sim.advance(0.5, 0.2 * math.sin(k))


def test_scans_stand_on_an_exact_grid(nominal: Scenario, start: Pose2) -> None:
    read = list(scans(Simulation(nominal, start), 21))
    assert [taken_s for _, taken_s, _ in read] == [k / 10 for k in range(11)]
    assert all(ranges_m.shape == (SPEC.beams,) and ranges_m.dtype == np.float64 for _, _, ranges_m in read)
    assert all(SPEC.range_min_m <= r.min() and r.max() <= SPEC.range_max_m for _, _, r in read)


def test_without_a_laser_there_is_no_scan(nominal: Scenario, start: Pose2) -> None:
    assert list(scans(Simulation(with_laser(nominal, None), start), 5)) == []


def test_the_noise_has_the_stated_size(nominal: Scenario) -> None:
    wall = solid("box", 5.0, 0.0, 0.5, (8.0, 20.0, 1.0))  # its near face at x = 1
    stand = Pose3(rotation=np.eye(3), translation_m=np.zeros(3))
    laser, obstacles = Laser(3, SPEC), Obstacles([wall], ())
    true_m = laser.true_ranges_m(stand, obstacles)
    read = []
    for k in range(400):
        laser.sample(k / 10, stand, obstacles)
        scan = laser.read(k / 10)
        assert scan is not None
        read.append(scan.ranges_m)
    error = np.array(read) - true_m
    ahead = SPEC.beams // 2
    assert error[:, ahead].std() == pytest.approx(0.010, rel=0.15)
    far = int(np.argmin(np.abs(true_m - 2.5)))
    assert error[:, far].std() == pytest.approx(0.025, rel=0.15)
    assert error[:, true_m < 2.5].mean() == pytest.approx(0.0, abs=1e-3)
    assert (np.array(read)[:, np.isinf(true_m)] == SPEC.range_max_m).all()
    assert np.isinf(true_m).sum() > 100


def test_the_noise_has_its_own_stream(nominal: Scenario, start: Pose2) -> None:
    loud = with_laser(nominal, LaserSpec(noise_near_m=0.1))
    a, b = Simulation(nominal, start), Simulation(loud, start)
    for _ in range(20):
        a.advance(0.5, 0.3)
        b.advance(0.5, 0.3)
    one, other = a.read_sensors(), b.read_sensors()
    assert one.laser and other.laser and (one.laser.ranges_m != other.laser.ranges_m).any()
    assert one.imu.yaw_rate_radps.tobytes() == other.imu.yaw_rate_radps.tobytes()
    assert a.state() == b.state()


def test_the_robot_does_not_see_itself_but_sees_a_box_move(nominal: Scenario, start: Pose2) -> None:
    layout = Layout(boxes=(BoxPlace(x_m=start.x_m + 1.5, y_m=start.y_m),))
    arena = with_laser(msgspec.structs.replace(nominal, layout=layout), EXACT)
    sim = Simulation(arena, start)
    ahead = SPEC.beams // 2
    beam_rad = float(beam_angles_rad(SPEC)[ahead])
    scan = sim.read_sensors().laser
    assert scan and scan.ranges_m[ahead] == pytest.approx((1.5 - 0.3 - SPEC.x_m) / math.cos(beam_rad), abs=2e-3)
    for _ in range(60):
        sim.advance(2.0, 0.0)
    box = sim.body_poses()["box_0"]
    assert box.translation_m[0] > start.x_m + 1.52, "it was pushed"
    scan = sim.read_sensors().laser
    assert scan and scan.time_s == sim.time_s
    pose = sim.pose3_world_robot()
    front_m = float(pose.inverse().transform([box.translation_m])[0][0]) - 0.3
    assert scan.ranges_m[ahead] == pytest.approx(front_m - SPEC.x_m, abs=3e-3)
    assert scan.ranges_m.min() > nominal.robot.length_m / 2 - SPEC.x_m - 5e-3
