"""Dynamics: the scenario as PhysX bodies, the robot on its wheels, its sensors but the cameras, and contacts."""

from adc_bench.sim.chassis import ChassisSpec
from adc_bench.sim.contacts import Contact
from adc_bench.sim.delivery import Delivery
from adc_bench.sim.simulation import DYNAMICS, DynamicsSpec, Readings, RobotState, Simulation

__all__ = ["DYNAMICS", "ChassisSpec", "Contact", "Delivery", "DynamicsSpec", "Readings", "RobotState", "Simulation"]
