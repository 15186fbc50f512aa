"""Halls for the tests of light and scene: one of everything, its look under control."""

import msgspec

from adc_bench.world.arena import Tunnel
from adc_bench.world.course import CourseSpec
from adc_bench.world.furniture import Furniture
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.look import Flood, LookFamily, draw_look
from adc_bench.world.robot import RobotParams, draw_robot_truth
from adc_bench.world.scenario import Scenario
from adc_bench.world.signs import draw_signs
from adc_bench.world.streams import stream

FAMILY = LookFamily(floors=("grey_carpet",), walls=("plaster",), light_sets=("neutral_hall",))
EAST_FLOOD = Flood(azimuth_rad=0.0, elevation_rad=0.6, share=0.6)
TUNNEL = Tunnel(start_s_m=8.0, length_m=5.0)
WORKS = Works(left=((5.9, 3.6), (4.7, 3.9)), right=((7.2, 3.0), (6.6, 4.2), (5.4, 4.9)))
FURNITURE = (
    Furniture(name="chair_0", kind="chair", x_m=-2.0, y_m=5.0, yaw_rad=0.3),
    Furniture(name="person_0", kind="person", x_m=0.0, y_m=5.0, yaw_rad=-1.5),
    Furniture(name="person_1", kind="person", x_m=1.0, y_m=5.2, yaw_rad=-1.5, variant=1),
    Furniture(name="cabinet_0", kind="cabinet", x_m=3.0, y_m=6.5, yaw_rad=-1.57),
    Furniture(name="poster_0", kind="poster", x_m=-4.0, y_m=6.98, yaw_rad=-1.5708),
)


def hall(
    *, boxes: tuple[BoxPlace, ...] = (), tunnel: Tunnel | None = None, full: bool = False, **look: object
) -> Scenario:
    """A hall with boxes and a tunnel if wanted, or full of everything; `look` replaces fields of a normal look."""
    drawn = msgspec.structs.replace(draw_look(FAMILY, stream(3, "look"), "normal"), exposure_bias_ev=0.0)
    return Scenario(
        name="hall",
        seed=3,
        look=msgspec.structs.replace(drawn, **look),
        robot_truth=draw_robot_truth(RobotParams(), stream(3, "robot")),
        panel_sign="up",
        layout=Layout(boxes=boxes, tunnel=tunnel, works=WORKS if full else None, signs=full),
        signs=draw_signs(CourseSpec(), stream(3, "signs")) if full else (),
        furniture=FURNITURE if full else (),
    )
