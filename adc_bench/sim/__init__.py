"""Dynamics: the scenario as PhysX bodies, the robot on its wheels, its encoders and inertial sensors, and contacts."""

from adc_bench.sim.chassis import ChassisSpec
from adc_bench.sim.contacts import Contact
from adc_bench.sim.simulation import DYNAMICS, DynamicsSpec, RobotState, Simulation

__all__ = ["DYNAMICS", "ChassisSpec", "Contact", "DynamicsSpec", "RobotState", "Simulation"]
