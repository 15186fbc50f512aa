"""A scenario: one complete arena, with its look, ready to be rendered or driven."""

from functools import cached_property

import msgspec

from adc_bench.world.arena import (
    ArenaSpec,
    Tunnel,
    gantry_solids,
    panel_solids,
    tunnel_solids,
    wall_solids,
)
from adc_bench.world.categories import PanelSign
from adc_bench.world.course import Course, CourseSpec
from adc_bench.world.furniture import Furniture
from adc_bench.world.layout import Layout
from adc_bench.world.look import Look
from adc_bench.world.robot import RobotParams, RobotTruth
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import VerticalSign
from adc_bench.world.solids import Body, Solid


class Scenario(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, dict=True):
    """Everything that stands, shines and drives in one arena."""

    name: str
    seed: int
    look: Look
    robot_truth: RobotTruth
    panel_sign: PanelSign
    layout: Layout = Layout()
    signs: tuple[VerticalSign, ...] = ()
    furniture: tuple[Furniture, ...] = ()
    course_spec: CourseSpec = CourseSpec()
    arena_spec: ArenaSpec = ArenaSpec()
    robot: RobotParams = RobotParams()
    rig: SensorRig = SensorRig()

    @cached_property
    def course(self) -> Course:
        """The road."""
        return Course(spec=self.course_spec)

    @property
    def tunnel(self) -> Tunnel | None:
        """The tunnel, if there is one."""
        return self.layout.tunnel

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """Everything that can be pushed: boxes, cones, chairs."""
        return ()

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """Everything that stands: walls, gantry, panels and, if there is one, the tunnel."""
        spec, course = self.arena_spec, self.course
        tunnel = tunnel_solids(spec, course, self.tunnel) if self.tunnel else ()
        return (*wall_solids(spec), *gantry_solids(spec, course), *panel_solids(spec, course), *tunnel)
