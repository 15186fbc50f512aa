"""Each arena that cannot be is refused, with the culprits' names; what only touches is not."""

import math
from collections.abc import Callable
from itertools import product
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely
from shapely import affinity

from adc_bench.errors import InputError
from adc_bench.world.arena import Tunnel
from adc_bench.world.checks import check_layout, check_scenario
from adc_bench.world.footprints import extents
from adc_bench.world.furniture import Furniture
from adc_bench.world.layout import BoxPlace, Layout, Works
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import ImuSpec, LaserSpec, SemanticCameraSpec, SensorRig
from adc_bench.world.setup import load_layout
from adc_bench.world.solids import Solid
from adc_bench.world.works import blocked_by, layout_bodies

SetUp = Callable[..., Scenario]
STRAIGHT = Works(left=((3.0, 5.5), (4.2, 5.5), (5.4, 5.5)), right=((3.0, 4.5), (4.2, 4.5), (5.4, 4.5)))


def refusal(layout: Layout) -> InputError:
    with pytest.raises(InputError) as caught:
        check_layout(layout, "my.toml")
    assert caught.value.where == "my.toml" and caught.value.exit_code == 3
    return caught.value


def moved(row: tuple[tuple[float, float], ...], dy: float) -> tuple[tuple[float, float], ...]:
    return tuple((x, y + dy) for x, y in row)


def test_two_boxes_in_one_place_are_refused_by_name() -> None:
    error = refusal(Layout(boxes=(BoxPlace(x_m=2.0, y_m=5.0), BoxPlace(x_m=2.5, y_m=5.1), BoxPlace(x_m=4.0, y_m=5.0))))
    assert error.found == "overlapping: box_0 and box_1"
    assert error.wanted == "things that keep clear of each other"


@pytest.mark.parametrize(
    ("box", "culprit"),
    [
        (BoxPlace(x_m=0.0, y_m=-1.2), "gantry and box_0"),
        (BoxPlace(x_m=5.35, y_m=3.0), "tunnel and box_0"),
    ],
)
def test_a_box_in_what_stands_is_refused_by_name(box: BoxPlace, culprit: str) -> None:
    layout = Layout(boxes=(box,), tunnel=Tunnel(start_s_m=11.0, length_m=3.0))
    assert refusal(layout).found == f"overlapping: {culprit}"


def test_many_overlaps_name_the_first_and_count_the_rest() -> None:
    pile = tuple(BoxPlace(x_m=2.0 + 0.01 * k, y_m=5.0) for k in range(4))
    assert refusal(Layout(boxes=pile)).found.endswith("box_1 and box_2 and 2 more")


def test_touching_is_not_overlapping() -> None:
    check_layout(Layout(boxes=(BoxPlace(x_m=2.0, y_m=5.0), BoxPlace(x_m=2.6, y_m=5.0))), "touching")
    check_layout(Layout(tunnel=Tunnel(start_s_m=8.0, length_m=4.0)), "a tunnel's parts")
    check_layout(Layout(tunnel=Tunnel(start_s_m=38.5, length_m=4.0)), "a tunnel under the gantry")


def test_what_hangs_above_does_not_overlap_what_stands_below() -> None:
    check_layout(Layout(boxes=(BoxPlace(x_m=0.0, y_m=-2.6),)), "a box under a panel")


@pytest.mark.parametrize("x_m", [10.8, -11.5, 400.0, math.nan, math.inf])
def test_a_box_outside_the_hall_is_refused_by_name(x_m: float) -> None:
    error = refusal(Layout(boxes=(BoxPlace(x_m=0.0, y_m=5.0), BoxPlace(x_m=x_m, y_m=0.0))))
    assert error.found == "outside the hall: box_1"
    assert error.wanted == "everything inside the hall of 22 x 14 x 4 m"


def test_a_cone_outside_the_hall_is_refused_by_name() -> None:
    works = Works(left=moved(STRAIGHT.left, 2.0), right=STRAIGHT.right)
    assert refusal(Layout(works=works)).found == "outside the hall: cone_left_0, cone_left_1, cone_left_2"


def test_rows_too_close_are_refused_by_the_cones() -> None:
    check_layout(Layout(works=STRAIGHT), "1.00 m apart")
    near = Works(left=((3.0, 5.5), (4.2, 5.15), (5.4, 5.5)), right=STRAIGHT.right)
    error = refusal(Layout(works=near))
    assert error.found == "the corridor of the road-works is blocked by cone_left_1, cone_right_1"
    assert error.wanted == "a way of 0.60 m between the rows, from the first cones to the last"


def test_the_corridor_needs_60_cm_between_feet() -> None:
    for clear_m, passable in ((0.61, True), (0.59, False)):
        works = Works(left=STRAIGHT.left, right=moved(STRAIGHT.right, 1.0 - clear_m - 0.15))
        assert bool(blocked_by(works, extents([], layout_bodies(Layout(works=works))))) is not passable


def test_a_tape_across_the_corridor_blocks_it() -> None:
    zigzag = Works(left=((3.0, 5.5), (4.2, 4.6), (5.4, 5.5)), right=((3.0, 4.5), (4.15, 3.3), (5.4, 4.5)))
    assert not blocked_by(zigzag, extents([], layout_bodies(Layout(works=zigzag))))
    crossed = Works(left=zigzag.left, right=((3.0, 4.5), (4.2, 5.2), (5.4, 4.5)))
    assert "blocked by" in refusal(Layout(works=crossed)).found


def test_swapped_rows_are_refused() -> None:
    swapped = Works(left=STRAIGHT.right, right=STRAIGHT.left)
    assert refusal(Layout(works=swapped)).found == "works.left lies to the right of works.right in driving order"


def test_a_box_in_the_corridor_is_refused_by_name() -> None:
    layout = Layout(works=STRAIGHT, boxes=(BoxPlace(x_m=0.0, y_m=5.0), BoxPlace(x_m=4.2, y_m=5.0)))
    assert refusal(layout).found == "the corridor of the road-works is blocked by box_1"


def test_a_row_of_one_cone_is_refused() -> None:
    error = refusal(Layout(works=Works(left=STRAIGHT.left, right=((3.0, 4.5),))))
    assert (error.found, error.wanted) == ("1 in works.right", "at least 2 cones in each row")


@pytest.mark.parametrize(
    ("tunnel", "found"),
    [
        (Tunnel(start_s_m=-1.0, length_m=2.0), "tunnel.start_s_m = -1"),
        (Tunnel(start_s_m=1.0, length_m=0.0), "tunnel.length_m = 0"),
        (Tunnel(start_s_m=1.0, length_m=math.inf), "tunnel.length_m = inf"),
        (Tunnel(start_s_m=math.nan, length_m=2.0), "tunnel.start_s_m = nan"),
    ],
)
def test_an_absurd_tunnel_is_refused(tunnel: Tunnel, found: str) -> None:
    assert refusal(Layout(tunnel=tunnel)).found == found


@pytest.mark.parametrize(
    ("changed", "found"),
    [
        ({"z_m": -0.1}, "camera 'road' is below the floor: z_m = -0.1"),
        ({"z_m": math.nan}, "camera 'road' is below the floor: z_m = nan"),
        ({"z_m": 3.0}, "camera 'road' is too high: z_m = 3"),
        ({"x_m": math.inf}, "camera 'road' is off the robot: x_m = inf"),
        ({"pitch_down_rad": 2.0}, "camera 'road' has a pitch of 114.592 degrees"),
        ({"hfov_rad": 0.0}, "camera 'road' has a field of view of 0 degrees"),
        ({"width_px": 0}, "camera 'road' has pictures of 0 x 240"),
    ],
)
def test_a_camera_that_cannot_be_is_refused_by_name(changed: dict[str, float], found: str, arena: SetUp) -> None:
    rig = SensorRig()
    mount = msgspec.structs.replace(rig.cameras[0], **changed)
    with pytest.raises(InputError) as caught:
        arena(rig=msgspec.structs.replace(rig, cameras=(mount, rig.cameras[1])))
    assert caught.value.found == found and caught.value.where == "the arena test"


@pytest.mark.parametrize(
    ("rig", "found"),
    [
        (SensorRig(semantic=SemanticCameraSpec(camera="rear")), "a semantic camera on 'rear'"),
        (SensorRig(laser=LaserSpec(latency_s=-0.1)), "a sensor's negative latency_s"),
        (SensorRig(imu=ImuSpec(latency_s=math.nan)), "a sensor's negative latency_s"),
    ],
)
def test_a_rig_that_cannot_be_is_refused(rig: SensorRig, found: str, arena: SetUp) -> None:
    with pytest.raises(InputError) as caught:
        arena(rig=rig)
    assert caught.value.found == found


def test_furniture_in_the_way_is_refused_by_name(arena: SetUp) -> None:
    scenario = arena(layout=load_layout("d4_v1"), furniture=False)
    x_m, y_m = np.mean([scenario.layout.works.left[1], scenario.layout.works.right[2]], axis=0)
    person = Furniture(name="person_7", kind="person", x_m=float(x_m), y_m=float(y_m), yaw_rad=0.0)
    with pytest.raises(InputError) as caught:
        check_scenario(msgspec.structs.replace(scenario, furniture=(person,)), "here")
    assert caught.value.found == "the corridor of the road-works is blocked by person_7"
    chair = Furniture(name="chair_0", kind="chair", x_m=5.246, y_m=-3.203, yaw_rad=0.0)
    signs = arena(layout=load_layout("v1"), furniture=False)
    with pytest.raises(InputError) as caught:
        check_scenario(msgspec.structs.replace(signs, furniture=(chair,)), "here")
    assert caught.value.found == "overlapping: sign_0 and chair_0"


def test_a_layout_file_is_checked_when_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('name = "mine"\n[[boxes]]\nx_m = 20\ny_m = 0\n')
    with pytest.raises(InputError) as caught:
        load_layout(str(path))
    assert (caught.value.where, caught.value.found) == (str(path), "outside the hall: box_0")


def test_an_unknown_layout_lists_the_known() -> None:
    with pytest.raises(InputError) as caught:
        load_layout("d9")
    assert (caught.value.where, caught.value.found) == ("layout 'd9'", "an unknown name")
    for name in ("b2_v1", "d3_v1", "d4_v2", "open", "p2", "v1", "random_works", "random_all"):
        assert name in caught.value.wanted


def test_overlaps_agree_with_brute_force() -> None:
    """Random pairs of turned boxes against shapely's own polygons and height intervals."""
    rng = np.random.default_rng(5)
    found = expected = 0
    for _ in range(400):
        pair = [_random_solid(rng, f"sign_{k}") for k in range(2)]
        bodies = extents(pair)
        assert bodies.owner == ("sign_0", "sign_1")
        polygons = [_polygon(solid) for solid in pair]
        for k in range(2):
            assert bodies.footprint(k).symmetric_difference(polygons[k]).area < 1e-9
            x0, y0, x1, y1 = polygons[k].bounds
            z, half = pair[k].centre_m[2], pair[k].size_m[2] / 2
            assert bodies.low[k] == pytest.approx([x0, y0, z - half])
            assert bodies.high[k] == pytest.approx([x1, y1, z + half])
        overlap = polygons[0].intersection(polygons[1])
        deep = (bodies.low.max(axis=0) < bodies.high.min(axis=0)).all() and overlap.area > 1e-2
        clear = polygons[0].distance(polygons[1]) > 0
        if deep != clear:  # the rest only graze
            expected += deep
            found += _refused(pair)
    assert found == expected > 50


def _random_solid(rng: np.random.Generator, name: str) -> Solid:
    return Solid(
        name=name,
        kind="sign",
        centre_m=(float(rng.uniform(3, 4)), float(rng.uniform(4, 5)), 1.0),
        size_m=tuple(rng.uniform(0.2, 0.8, 3)),
        yaw_rad=float(rng.uniform(-4, 4)),
    )


def _polygon(solid: Solid) -> shapely.Polygon:
    x, y = solid.size_m[0] / 2, solid.size_m[1] / 2
    turned = affinity.rotate(shapely.box(-x, -y, x, y), solid.yaw_rad, origin=(0, 0), use_radians=True)
    return affinity.translate(turned, *solid.centre_m[:2])


def _refused(solids: list[Solid]) -> bool:
    from adc_bench.world.checks import _overlaps

    return bool(_overlaps(extents(solids)))


def test_a_pitched_solid_reaches_as_far_as_its_corners() -> None:
    solid = Solid(
        name="panel", kind="panel", centre_m=(1.0, 2.0, 3.0), size_m=(0.2, 0.5, 0.4), yaw_rad=0.7, pitch_rad=0.4
    )
    corners = [np.array(signs) * np.array(solid.size_m) / 2 for signs in product((-1, 1), repeat=3)]
    points = solid.pose_world_solid().transform(np.array(corners))
    bounds = extents([solid])
    assert bounds.low[0] == pytest.approx(points.min(axis=0)) and bounds.high[0] == pytest.approx(points.max(axis=0))
