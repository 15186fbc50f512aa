"""A drive as a shard: simulated first, since its driver looks at no picture, then rendered at the cameras' moments."""

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import h5py
import msgspec

from adc_bench.dataset.drive_log import put_log
from adc_bench.dataset.drive_script import DriveScript, Ending
from adc_bench.dataset.driving.driver import CONTROL_PERIOD_S, begin, drive, is_done, shown_sign
from adc_bench.dataset.driving.plan import DrivePlan, draw_drive
from adc_bench.dataset.shard import put_frames
from adc_bench.generate.drive_columns import Delivered, Row, log_of
from adc_bench.generate.frames import one_thread
from adc_bench.generate.plan import ShardTask, plan_renderer
from adc_bench.render import ArenaRenderer
from adc_bench.render.renderer import Shot
from adc_bench.sim import Simulation
from adc_bench.world.categories import PanelSign
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import CameraMount, SensorRig

REST_STEPS = 30  # after the last leg, and after a contact
SAME_S = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Simulated:
    """A drive without pictures, a row for each control step."""

    script: DriveScript
    rows: Sequence[Row]


def render_drive(task: ShardTask) -> tuple[bytes, int]:
    """Make the shard of one drive; return its file and how many frames it has.

    Raises:
        InputError: see `draw_drive`.
    """
    rig = SensorRig(cameras=task.plan.cameras)
    scenario, plan = draw_drive(task.plan.split, task.number, rig, task.salt)
    simulated = simulate(scenario, plan)
    with one_thread():
        shots = list(take_pictures(plan_renderer(task.plan), scenario, simulated.rows))
    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        put_frames(file, [shot.frame for shot in shots], [mount.name for mount in rig.cameras], [scenario])
        put_log(file, log_of(simulated.script, rig, simulated.rows, shots))
    return buffer.getvalue(), len(shots)


def simulate(scenario: Scenario, plan: DrivePlan) -> Simulated:
    """Drive a plan to its end; the last row's command is to stand."""
    simulation = Simulation(scenario, plan.script.start_pose, CONTROL_PERIOD_S)
    state, sign = begin(plan.legs, plan.hand), scenario.panel_sign
    last_step = plan.steps_max - 1
    ending: Ending = "time"
    rows: list[Row] = []
    while True:
        sign = shown_sign(state, plan.legs, sign)
        row = _observe(simulation, sign)
        found = _ending(row, is_done(state, plan.legs))
        if found and ending == "time":
            ending, last_step = found, min(last_step, row.step + REST_STEPS)
        if row.step == last_step:
            return Simulated(script=msgspec.structs.replace(plan.script, ending=ending), rows=(*rows, row))
        state, command = drive(state, plan.legs, plan.hand, simulation.state().pose_world_robot, row.step)
        rows.append(replace(row, command=command))
        simulation.advance(command.v_mps, command.omega_radps)


def take_pictures(renderer: ArenaRenderer, scenario: Scenario, rows: Sequence[Row]) -> Iterator[Delivered]:
    """Yield the pictures that arrive before the drive is over, in the order in which they are taken; each is finished
    while the next one is drawn.
    """
    renderer.load(scenario)
    before: tuple[float, float, Shot] | None = None
    for taken, (row, mount) in enumerate(_due(renderer.rig, rows)):
        renderer.set_panel(row.sign)
        renderer.place(row.bodies, row.torn)
        shot = renderer.shoot_next(taken, mount.name, row.pose_world_robot, time_s=row.time_s, motion=row.motion)
        if before:
            yield _delivered(renderer, *before)
        shot.read()
        before = row.time_s, mount.latency_s, shot
    if before:
        yield _delivered(renderer, *before)


def _due(rig: SensorRig, rows: Sequence[Row]) -> Iterator[tuple[Row, CameraMount]]:
    """Yield the steps at which cameras take pictures that arrive in time, camera by camera."""
    for row in rows:
        for mount in rig.cameras:
            is_turn = row.step % mount.period_steps == 0
            if is_turn and row.time_s + mount.latency_s <= rows[-1].time_s + SAME_S:
                yield row, mount


def _delivered(renderer: ArenaRenderer, time_s: float, latency_s: float, shot: Shot) -> Delivered:
    return Delivered(time_s=time_s, arrival_time_s=time_s + latency_s, frame=renderer.finish(shot))


def _observe(simulation: Simulation, sign: PanelSign) -> Row:
    state = simulation.state()
    return Row(
        step=simulation.step_index,
        time_s=simulation.time_s,
        pose_world_robot=simulation.pose3_world_robot(),
        motion=Motion(v_mps=state.v_mps, omega_radps=state.omega_radps),
        sign=sign,
        bodies=simulation.body_poses(),
        torn=simulation.torn_tapes(),
        readings=simulation.read_sensors(),
        contacts=tuple(simulation.take_contacts()),
        command=Motion(),
    )


def _ending(row: Row, done: bool) -> Ending | None:
    """Return what brings the drive to an end, if anything does: a tape gives way and is no reason to stop."""
    if any(not hit.with_name.startswith("tape") for hit in row.contacts):
        return "contact"
    return "finished" if done else None
