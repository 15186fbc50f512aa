import math
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
import sapien
import shapely
from made_arenas import ahead, through_cones
from sapien import physx

from adc_bench.geometry import Pose2
from adc_bench.sim import DYNAMICS, Contact, Simulation
from adc_bench.sim.bodies import Bodies
from adc_bench.sim.surfaces import GRAVITY_MPS2, add_floor, physics
from adc_bench.sim.tapes import Tapes
from adc_bench.world.furniture import Furniture, chair_body
from adc_bench.world.layout import BoxPlace, Layout, Place, Works
from adc_bench.world.scenario import Scenario
from adc_bench.world.solids import Body, Solid
from adc_bench.world.works import Tape, box_body, cone_body

CHAIR = Furniture(name="chair_0", kind="chair", x_m=4.0, y_m=0.0, yaw_rad=0.4)
BODIES = (box_body(0, BoxPlace(x_m=2.0, y_m=0.0, yaw_rad=0.3)), cone_body("cone_left_0", (3.0, 0.0)), chair_body(CHAIR))


def with_boxes(scenario: Scenario, *places: Place) -> Scenario:
    layout = Layout(boxes=tuple(BoxPlace(x_m=x_m, y_m=y_m) for x_m, y_m in places))
    return msgspec.structs.replace(scenario, layout=layout)


def with_cones(scenario: Scenario, left: tuple[Place, ...], right: tuple[Place, ...]) -> Scenario:
    return msgspec.structs.replace(scenario, layout=Layout(works=Works(left=left, right=right)))


def drive(sim: Simulation, steps: int, v_mps: float) -> list[Contact]:
    for _ in range(steps):
        sim.advance(v_mps, 0.0)
    return sim.take_contacts()


def up(sim: Simulation, name: str) -> float:
    """How upright a body stands: 1 upright, 0 on its side."""
    return float(sim.body_poses()[name].rotation[2, 2])


@pytest.fixture
def scene() -> sapien.Scene:
    scene = sapien.Scene([physics(200)])
    add_floor(scene)
    return scene


def components(scene: sapien.Scene) -> dict[str, physx.PhysxRigidDynamicComponent]:
    return {part.entity.name: part for part in scene.physx_system.rigid_dynamic_components}


def test_bodies_have_their_mass_and_the_inertia_of_their_shape(scene: sapien.Scene) -> None:
    Bodies(scene, BODIES)
    parts = components(scene)
    for body in BODIES:
        assert parts[body.name].mass == pytest.approx(body.mass_kg, rel=1e-4)
    box = parts["box_0"]
    a, b, c = BODIES[0].parts[0].size_m
    expected = BODIES[0].mass_kg / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.asarray(box.inertia) == pytest.approx(expected, rel=1e-3)
    assert box.cmass_local_pose.p[2] == pytest.approx(c / 2, abs=1e-4)
    foot, cone = BODIES[1].parts
    foot_m3 = math.prod(foot.size_m)
    cone_m3 = math.pi / 12 * math.prod(cone.size_m)
    low, high = cone.centre_m[2] - cone.size_m[2] / 4, foot.centre_m[2]  # a cone's middle of mass: a quarter up
    middle_m = (cone_m3 * low + foot_m3 * high) / (cone_m3 + foot_m3)
    assert parts["cone_left_0"].cmass_local_pose.p[2] == pytest.approx(middle_m, abs=1e-3)


def test_bodies_stand_where_they_are_put_and_stay_when_woken(scene: sapien.Scene) -> None:
    bodies = Bodies(scene, BODIES)
    before = bodies.poses()
    for body in BODIES:
        assert before[body.name].matrix() == pytest.approx(body.pose.to_pose3().matrix())
    for _ in range(100):
        scene.step()
    bodies.follow()
    assert all(pose is before[name] for name, pose in bodies.poses().items()), "they sleep"
    for part in components(scene).values():
        part.wake_up()
    for _ in range(400):
        scene.step()
        bodies.follow()
    for name, pose in bodies.poses().items():
        assert np.abs(pose.matrix() - before[name].matrix()).max() < 1e-4, name
    assert all(part.is_sleeping for part in components(scene).values())


def test_a_body_slides_by_its_friction(scene: sapien.Scene) -> None:
    bodies = Bodies(scene, BODIES)
    box = components(scene)["box_0"]
    box.set_linear_velocity([1.0, 0.0, 0.0])
    x_m = bodies.poses()["box_0"].translation_m[0]
    for _ in range(200):
        scene.step()
        bodies.follow()
    slid_m = bodies.poses()["box_0"].translation_m[0] - x_m
    assert slid_m == pytest.approx(1.0**2 / (2 * BODIES[0].friction * GRAVITY_MPS2), rel=0.05)


@pytest.mark.parametrize("v_mps", [0.8, 1.5])
def test_a_box_is_moved_by_momentum(nominal: Scenario, start: Pose2, v_mps: float) -> None:
    """Physics step by step: what the robot's contacts give less the floor's friction is what the box gains."""
    arena = with_boxes(nominal, ahead(start, 1.4))
    body, robot = arena.bodies[0], nominal.robot
    sim = Simulation(arena, start, 0.005)
    places, impulses_ns, speeds = [sim.body_poses()["box_0"].translation_m[0]], [], [0.0]
    while sum(1 for impulse in impulses_ns if impulse) < 4:
        sim.advance(v_mps, 0.0)
        contacts = sim.take_contacts()
        assert {contact.with_name for contact in contacts} <= {"box_0"}
        impulses_ns.append(sum(contact.impulse_ns for contact in contacts))
        places.append(sim.body_poses()["box_0"].translation_m[0])
        speeds.append(sim.state().v_mps)
        assert sim.step_index < 800
    hit = next(k for k, impulse in enumerate(impulses_ns) if impulse)
    box_mps = np.diff(places) / 0.005
    moved_s = 0.005 * np.count_nonzero(box_mps[hit:] > 0.01)
    gained_ns = body.mass_kg * box_mps[-1]
    rubbed_ns = body.friction * body.mass_kg * GRAVITY_MPS2 * moved_s
    assert sum(impulses_ns) == pytest.approx(gained_ns + rubbed_ns, rel=0.04)
    # The blow itself: both go on together. The wheels' rotors and the floor's grip take a small part in it.
    together_mps = robot.mass_kg / (robot.mass_kg + body.mass_kg) * v_mps
    assert box_mps[hit + 3] == pytest.approx(together_mps, rel=0.12)
    assert speeds[hit + 3] == pytest.approx(box_mps[hit + 3], rel=0.05)
    lost_ns = robot.mass_kg * (v_mps - speeds[hit + 1])
    assert impulses_ns[hit] == pytest.approx(lost_ns, rel=0.08)


def test_a_box_pushed_against_another_is_the_only_contact(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(with_boxes(nominal, ahead(start, 1.2), ahead(start, 1.81)), start)
    contacts = drive(sim, 60, 1.5)
    assert {contact.with_name for contact in contacts} == {"box_0"}
    moved = sim.body_poses()["box_1"].translation_m[0] - ahead(start, 1.81)[0]
    assert moved > 0.03, "the first box moved the second"


def test_a_cone_is_pushed_aside(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(with_cones(nominal, (ahead(start, 1.2, 0.15),), (ahead(start, 1.2, 3.0),)), start)
    contacts = drive(sim, 60, 1.8)
    assert contacts and contacts[0].with_name == "cone_left_0" and contacts[0].impulse_ns > 1.0
    assert sim.body_poses()["cone_left_0"].translation_m[0] > ahead(start, 1.4)[0]
    assert sim.body_poses()["cone_right_0"].translation_m[:2] == pytest.approx(ahead(start, 1.2, 3.0))


def test_a_tall_thing_hit_low_falls_over(nominal: Scenario, start: Pose2) -> None:
    arena, (x_m, y_m) = msgspec.structs.replace(nominal), ahead(start, 1.2)
    pole = Solid(name="pole_it", kind="chair", centre_m=(0.0, 0.0, 0.5), size_m=(0.1, 0.1, 1.0), shape="cylinder")
    pose = Pose2(x_m=x_m, y_m=y_m, yaw_rad=0.0)
    vars(arena)["bodies"] = (Body(name="pole", kind="chair", pose=pose, mass_kg=2.0, friction=0.8, parts=(pole,)),)
    sim = Simulation(arena, start)
    assert {contact.with_name for contact in drive(sim, 80, 1.5)} == {"pole"}
    assert up(sim, "pole") < 0.8


def test_a_chair_gives_way_and_a_gantry_post_does_not(nominal: Scenario) -> None:
    chair = msgspec.structs.replace(CHAIR, x_m=1.5, yaw_rad=0.0)
    arena = msgspec.structs.replace(nominal, furniture=(chair,))
    sim = Simulation(arena, Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0))
    before = sim.state().v_mps
    contacts = drive(sim, 50, 1.5)
    assert {contact.with_name for contact in contacts} == {"chair_0"}
    assert sim.body_poses()["chair_0"].translation_m[0] > 1.6
    assert sim.state().v_mps > before + 0.3, "it is light"


def test_the_mast_meets_what_hangs_over_the_hull(nominal: Scenario, start: Pose2) -> None:
    x_m, y_m = ahead(start, 1.5)
    top_m = max(mount.z_m for mount in nominal.rig.cameras) + DYNAMICS.chassis.mast_margin_m
    for z_m, touches in ((top_m - 0.05, True), (0.5, True), (top_m + 0.06, False)):
        arena = msgspec.structs.replace(nominal)
        bar = Solid(name="bar", kind="gantry", centre_m=(x_m, y_m, z_m), size_m=(0.05, 1.0, 0.1))
        vars(arena)["solids"] = (bar,)
        sim = Simulation(arena, start)
        assert bool(drive(sim, 50, 1.0)) is touches, z_m
        if touches:
            mast_m = max(mount.x_m for mount in nominal.rig.cameras) + DYNAMICS.chassis.mast_margin_m
            assert sim.state().pose_world_robot.x_m == pytest.approx(x_m - 0.025 - mast_m, abs=0.05)  # it leans


def test_a_tape_tears_where_the_robot_crosses_it(nominal: Scenario, start: Pose2) -> None:
    left = tuple(ahead(start, 1.5, y_m) for y_m in (-0.6, 0.6, 1.8))
    right = tuple(ahead(start, 3.0, y_m) for y_m in (-3.0, -2.0))
    sim = Simulation(with_cones(nominal, left, right), start)
    before = sim.body_poses()
    assert sim.torn_tapes() == frozenset()
    contacts = drive(sim, 50, 1.5)
    (contact,) = contacts
    assert (contact.with_name, contact.impulse_ns) == ("tape_left_0", 0.0)
    assert sim.torn_tapes() == {"tape_left_0"}
    reached_s = (1.5 - nominal.robot.length_m / 2) / 1.5 + 0.375  # the ramp loses 0.375 s
    assert contact.time_s == pytest.approx(reached_s, abs=0.06)
    assert all(pose is before[name] for name, pose in sim.body_poses().items()), "it pulls at no cone"


def test_a_tape_tears_when_a_cone_is_pushed_away(nominal: Scenario, start: Pose2) -> None:
    """The middle one of three cones across the way is hit; the tapes' other ends stay behind, beside the robot."""
    left = (ahead(start, 1.5, 1.2), ahead(start, 1.5, 0.0), ahead(start, 2.3, -0.9))
    arena = with_cones(nominal, left, (ahead(start, 1.0, 3.0),))
    sim = Simulation(arena, start)
    torn_at = {}
    for _ in range(50):
        sim.advance(1.5, 0.0)
        for name in sim.torn_tapes() - torn_at.keys():
            poses = sim.body_poses()
            tape = next(tape for tape in arena.tapes if tape.name == name)
            apart = poses[tape.first].translation_m - poses[tape.second].translation_m
            torn_at[name] = float(np.linalg.norm(apart)) / tape.rest_length_m
    assert {contact.with_name for contact in sim.take_contacts()} >= {"cone_left_1", "tape_left_0"}
    assert set(torn_at) == {"tape_left_0", "tape_left_1"}


@pytest.mark.parametrize(("stretch", "torn"), [(1.14, set()), (1.16, {"tape"})])
def test_a_stretched_tape_tears_without_a_contact(nominal: Scenario, stretch: float, torn: set[str]) -> None:
    tape = Tape(name="tape", first="a", second="b", rest_length_m=2.0)
    tapes = Tapes([tape], nominal.robot, DYNAMICS.tape_stretch_max)
    upright = Pose2(x_m=0.0, y_m=0.0, yaw_rad=0.0).to_pose3()
    away = Pose2(x_m=0.0, y_m=2.0 * stretch, yaw_rad=0.0).to_pose3()
    for _ in range(2):
        assert tapes.step({"a": upright, "b": away}, Pose2(x_m=2.0, y_m=0.0, yaw_rad=0.0).to_pose3()) == []
        assert tapes.torn == torn


def test_an_outline_crosses_a_tape_as_plane_geometry_says(nominal: Scenario) -> None:
    rng, robot = np.random.default_rng(5), nominal.robot
    tape = Tape(name="tape", first="a", second="b", rest_length_m=9.0)
    hits = 0
    for _ in range(1500):
        ax, ay, bx, by, x_m, y_m = rng.uniform(-0.8, 0.8, size=6)
        pose = Pose2(x_m=x_m, y_m=y_m, yaw_rad=rng.uniform(-3.0, 3.0))
        half = np.array([robot.length_m, robot.width_m]) / 2
        outline = shapely.Polygon(pose.transform(half * [[1, 1], [-1, 1], [-1, -1], [1, -1]]))
        crosses = outline.intersects(shapely.LineString([(ax, ay), (bx, by)]))
        ends = {name: Pose2(x_m=x, y_m=y, yaw_rad=0.0).to_pose3() for name, x, y in (("a", ax, ay), ("b", bx, by))}
        assert Tapes([tape], robot, 0.15).step(ends, pose.to_pose3()) == (["tape"] if crosses else [])
        hits += crosses
    assert 200 < hits < 1300


SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
from made_arenas import through_cones
print(through_cones())
"""


def test_a_drive_through_cones_has_the_same_bits_in_every_process() -> None:
    script = SCRIPT.format(tests=str(Path(__file__).parent))
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert through_cones() == through_cones() == other.stdout.strip()
