"""One drive: a scenario's arena and robot in PhysX, advanced by commands one control step at a time."""

import math
from dataclasses import dataclass

import msgspec
import sapien

from adc_bench.api import EncoderSamples, ImuSamples, LaserScan
from adc_bench.geometry import Pose2, Pose3
from adc_bench.sim.bodies import Bodies
from adc_bench.sim.chassis import ChassisSpec, add_chassis
from adc_bench.sim.contacts import Contact, ContactLog
from adc_bench.sim.laser import Laser
from adc_bench.sim.rays import Obstacles
from adc_bench.sim.sensors import Encoders, Imu
from adc_bench.sim.surfaces import add_floor, add_solid, physics
from adc_bench.sim.tapes import Tapes
from adc_bench.world.drive import limit, ramp, wheel_speeds_radps
from adc_bench.world.robot import Motion
from adc_bench.world.scenario import Scenario


class DynamicsSpec(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the world moves and is felt, beyond the robot's public figures; part of the rules."""

    physics_rate_hz: int = 200
    settling_s: float = 0.5  # before time 0
    solid_friction: float = 0.8
    tape_stretch_max: float = 0.15  # of its length between the standing cones; a tape pulled longer tears
    chassis: ChassisSpec = ChassisSpec()


DYNAMICS = DynamicsSpec()


class RobotState(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot's true pose on the floor, forward speed of its origin, and turn rate."""

    pose_world_robot: Pose2
    v_mps: float
    omega_radps: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Readings:
    """What arrived from the sensors since they were last read; of the laser the newest scan, None without a new one."""

    encoders: EncoderSamples
    imu: ImuSamples
    laser: LaserScan | None


class Simulation:
    """The truth of one drive. At time 0 the robot stands at `start_pose`; equal arguments and commands give equal bits.

    Needs no renderer. The sensors take their first samples at time 0 and deliver each when its latency has passed.
    """

    def __init__(
        self,
        scenario: Scenario,
        start_pose: Pose2,
        control_period_s: float = 0.05,
        *,
        dynamics: DynamicsSpec = DYNAMICS,
    ) -> None:
        self._robot, self._rate_hz = scenario.robot, dynamics.physics_rate_hz
        self._substeps = _whole(control_period_s * self._rate_hz)
        self._system = physics(self._rate_hz)
        self._scene = sapien.Scene([self._system])
        self._floor = add_floor(self._scene)
        for solid in scenario.solids:
            add_solid(self._scene, solid, dynamics.solid_friction)
        self._bodies = Bodies(self._scene, scenario.bodies)
        self._tapes = Tapes(scenario.tapes, self._robot, dynamics.tape_stretch_max)
        truth, cameras = scenario.robot_truth, scenario.rig.cameras
        self._chassis = add_chassis(self._scene, dynamics.chassis, self._robot, truth, cameras, start_pose)
        for _ in range(_whole(dynamics.settling_s * self._rate_hz)):
            self._system.step()
        self._start_instruments(scenario)

    def _start_instruments(self, scenario: Scenario) -> None:
        chassis, seed, rig = self._chassis, scenario.seed, scenario.rig
        self._physics_step, self._motion, self._contacts = 0, Motion(), ContactLog(chassis.root, self._floor)
        self._encoder_every = _whole(self._rate_hz / rig.encoders.rate_hz)
        self._encoders = Encoders(seed, rig.encoders, self._robot.encoder_ticks_per_turn, chassis.wheel_angles_rad())
        self._imu_every = _whole(self._rate_hz / rig.imu.rate_hz)
        bias_radps = scenario.robot_truth.gyro_bias_radps
        pose = chassis.pose_world_robot()
        self._imu = Imu(seed, rig.imu, bias_radps, pose.rotation, chassis.velocity_mps(pose))
        self._laser = Laser(seed, rig.laser) if rig.laser else None
        self._laser_every = _whole(self._rate_hz / rig.laser.rate_hz) if rig.laser else 0
        self._obstacles = Obstacles(scenario.solids, scenario.bodies)
        self._sample_sensors()

    @property
    def step_index(self) -> int:
        """How many control steps have passed."""
        return self._physics_step // self._substeps

    @property
    def time_s(self) -> float:
        """The time since the start."""
        return self._physics_step / self._rate_hz

    def advance(self, v_mps: float, omega_radps: float) -> None:
        """Let one control step pass under this command, held within the robot's limits; it must be finite."""
        assert math.isfinite(v_mps) and math.isfinite(omega_radps), "the caller checks commands"
        target = limit(self._robot, Motion(v_mps=v_mps, omega_radps=omega_radps))
        for _ in range(self._substeps):
            self._motion = ramp(self._robot, self._motion, target, 1 / self._rate_hz)
            self._chassis.set_wheel_speeds(wheel_speeds_radps(self._robot, self._motion))
            self._system.step()
            self._physics_step += 1
            self._encoders.follow(self._chassis.wheel_angles_rad())
            self._contacts.record(self.time_s, self._system.get_contacts())
            self._sample_sensors()
        self._bodies.follow()
        for name in self._tapes.step(self._bodies.poses(), self.pose3_world_robot()):
            self._contacts.touch(self.time_s, name)
        self._contacts.close_step()

    def _sample_sensors(self) -> None:
        if self._physics_step % self._encoder_every == 0:
            self._encoders.sample(self.time_s)
        if self._physics_step % self._imu_every == 0:
            pose = self._chassis.pose_world_robot()
            self._imu.sample(self.time_s, pose.rotation, self._chassis.velocity_mps(pose))
        if self._laser and self._physics_step % self._laser_every == 0:
            self._bodies.follow()
            self._obstacles.follow(self._bodies.poses())
            self._laser.sample(self.time_s, self._chassis.pose_world_robot(), self._obstacles)

    def state(self) -> RobotState:
        """Return the truth now."""
        pose = self.pose3_world_robot()
        velocity_mps = self._chassis.velocity_mps(pose)
        forward = pose.rotation[:, 0]
        return RobotState(
            pose_world_robot=Pose2(
                x_m=float(pose.translation_m[0]),
                y_m=float(pose.translation_m[1]),
                yaw_rad=math.atan2(forward[1], forward[0]),
            ),
            v_mps=float(forward @ velocity_mps),
            omega_radps=float(self._chassis.angular_velocity_radps()[2]),
        )

    def pose3_world_robot(self) -> Pose3:
        """Return the pose in space of the point midway between the wheels' feet, with the body's pitch and roll."""
        return self._chassis.pose_world_robot()

    def body_poses(self) -> dict[str, Pose3]:
        """Return where the bodies are in the world, by name; one at rest keeps its very record from call to call."""
        return self._bodies.poses()

    def torn_tapes(self) -> frozenset[str]:
        """Return the names of the tapes that are torn by now."""
        return self._tapes.torn

    def read_sensors(self) -> Readings:
        """Return what has arrived since the last call, this instant's samples included where nothing holds them up."""
        now_s = self.time_s
        return Readings(
            encoders=self._encoders.read(now_s),
            imu=self._imu.read(now_s),
            laser=self._laser.read(now_s) if self._laser else None,
        )

    def take_contacts(self) -> list[Contact]:
        """Return the contacts since the last call; the floor does not count."""
        return self._contacts.take()


def _whole(steps: float) -> int:
    """Return a count of steps that must come out whole."""
    assert abs(steps - round(steps)) < 1e-9 and round(steps) > 0, "rates must divide the physics rate"
    return round(steps)
