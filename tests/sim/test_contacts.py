import math

import pytest

from adc_bench.geometry import Pose2
from adc_bench.sim import Contact, Simulation
from adc_bench.world.scenario import Scenario


def drive_into(nominal: Scenario, start: Pose2, v_mps: float) -> tuple[Simulation, list[Contact], float]:
    """Drive until the first contact: the simulation, the contacts of that control step, the speed before."""
    sim = Simulation(nominal, start)
    for _ in range(200):
        before_mps = sim.state().v_mps
        sim.advance(v_mps, 0.0)
        if contacts := sim.take_contacts():
            return sim, contacts, before_mps
    raise AssertionError("nothing was hit")


def test_free_driving_touches_nothing(nominal: Scenario, start: Pose2) -> None:
    sim = Simulation(nominal, start)
    for _ in range(60):
        sim.advance(1.0, 0.0)
    assert sim.take_contacts() == []


@pytest.mark.parametrize("v_mps", [0.5, 1.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_gantry_post_stops_the_robot_with_its_momentum(nominal: Scenario, side: str, v_mps: float) -> None:
    post = next(solid for solid in nominal.solids if solid.name == f"gantry_post_{side}")
    sim, contacts, before_mps = drive_into(nominal, Pose2(x_m=-2.0, y_m=post.centre_m[1], yaw_rad=0.0), v_mps)
    (contact,) = contacts
    assert contact.with_name == "gantry"
    assert sim.time_s - 0.05 < contact.time_s <= sim.time_s
    lost_ns = nominal.robot.mass_kg * (before_mps - sim.state().v_mps)
    # The wheels' rotors give up their momentum as well, and the motors push on.
    assert lost_ns * 0.95 < contact.impulse_ns < lost_ns * 1.3 + 54 * 0.05
    front_m = nominal.robot.length_m / 2 + post.size_m[0] / 2
    assert sim.state().pose_world_robot.x_m == pytest.approx(-front_m, abs=2e-3)


def test_the_body_is_as_wide_as_the_robot_not_as_its_wheels_balls(nominal: Scenario) -> None:
    post = next(solid for solid in nominal.solids if solid.name == "gantry_post_left")
    for gap_m, touches in ((0.01, False), (-0.01, True)):
        y_m = post.centre_m[1] - post.size_m[1] / 2 - nominal.robot.width_m / 2 - gap_m
        sim = Simulation(nominal, Pose2(x_m=-1.0, y_m=y_m, yaw_rad=0.0))
        for _ in range(40):
            sim.advance(1.0, 0.0)
        assert bool(sim.take_contacts()) is touches


def test_a_lasting_touch_is_one_contact_each_control_step(nominal: Scenario) -> None:
    sim, _, _ = drive_into(nominal, Pose2(x_m=10.0, y_m=0.0, yaw_rad=0.0), 0.5)
    for _ in range(10):
        sim.advance(0.5, 0.0)
    contacts = sim.take_contacts()
    assert [contact.with_name for contact in contacts] == ["walls"] * 10
    assert len({math.floor(contact.time_s * 20 - 1e-6) for contact in contacts}) == 10
    assert sim.take_contacts() == []


def test_the_robot_drives_away_again(nominal: Scenario) -> None:
    sim, _, _ = drive_into(nominal, Pose2(x_m=10.0, y_m=0.0, yaw_rad=0.0), 1.0)
    for _ in range(40):
        sim.advance(-0.5, 0.0)
    sim.take_contacts()
    sim.advance(-0.5, 0.0)
    assert sim.take_contacts() == []
    assert sim.state().v_mps == pytest.approx(-0.5, rel=0.02)
