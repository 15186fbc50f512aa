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
from adc_bench.world.furniture import Furniture, chair_body, furniture_solids
from adc_bench.world.layout import Layout
from adc_bench.world.look import Look
from adc_bench.world.robot import RobotParams, RobotTruth
from adc_bench.world.sensors import SensorRig
from adc_bench.world.signs import VerticalSign, sign_solids
from adc_bench.world.solids import Body, Solid
from adc_bench.world.works import Tape, layout_bodies, layout_tapes


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
        chairs = [chair_body(piece) for piece in self.furniture if piece.kind == "chair"]
        return (*layout_bodies(self.layout), *chairs)

    @cached_property
    def tapes(self) -> tuple[Tape, ...]:
        """The tapes between the cones of the road-works."""
        return layout_tapes(self.layout)

    @cached_property
    def solids(self) -> tuple[Solid, ...]:
        """Everything that stands: walls, gantry, panels, the tunnel if there is one, signs, furniture."""
        return (
            *arena_solids(self.arena_spec, self.course, self.layout),
            *(solid for sign in self.signs for solid in sign_solids(sign)),
            *(solid for piece in self.furniture for solid in furniture_solids(piece)),
        )


def arena_solids(spec: ArenaSpec, course: Course, layout: Layout) -> tuple[Solid, ...]:
    """Return walls, gantry, panels and, if the layout has one, the tunnel."""
    tunnel = tunnel_solids(spec, course, layout.tunnel) if layout.tunnel else ()
    return (*wall_solids(spec), *gantry_solids(spec, course), *panel_solids(spec, course), *tunnel)
