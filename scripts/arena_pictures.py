"""Draw the pictures of docs/arena.md: every element, the drawings of signs in all styles, the top view against the
geometry, eight looks, a tunnel passage.

Usage: python scripts/arena_pictures.py [--out docs/pictures/arena]

Takes about a minute on two cores. Prints the figures that the page quotes.
"""

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

import cv2
import matplotlib
import msgspec
import numpy as np
import shapely
from numpy.typing import NDArray

from adc_bench.dataset import load_split
from adc_bench.geometry import Camera, Pose2, Pose3
from adc_bench.render import ArenaRenderer
from adc_bench.render.artwork import panel_picture, sign_picture
from adc_bench.render.exposure import follow
from adc_bench.world.arena import ArenaSpec, Tunnel
from adc_bench.world.categories import PANEL_SIGNS, SIGNS
from adc_bench.world.course import COURSE_SETS, Course
from adc_bench.world.look import ARTWORKS, LIGHT_LEVELS, Look, LookFamily, draw_look
from adc_bench.world.picture import decode_picture
from adc_bench.world.robot import ROBOTS, Motion
from adc_bench.world.scenario import Scenario
from adc_bench.world.sensors import SensorRig
from adc_bench.world.setup import draw_layout, set_up
from adc_bench.world.signs import draw_signs
from adc_bench.world.streams import stream

matplotlib.use("Agg")
Picture = NDArray[np.uint8]
Point = tuple[float, float, float]
FAMILY = LookFamily(
    floors=("charcoal_vinyl", "grey_carpet", "worn_vinyl"),
    walls=("plaster", "brick", "concrete"),
    light_sets=("warm_hall", "window_left", "neutral_hall", "floodlight_east"),
)
CAMERA = Camera.from_hfov(width_px=480, height_px=360, hfov_rad=math.radians(65))
START = Pose2(x_m=-0.65, y_m=-2.6125, yaw_rad=0.0)
TILE_M, PIXEL_M, HEIGHT_M = 3.0, 0.005, 2.6
SPLITS, GREY = ("train", "val", "test"), 96

# Name of the picture: layout, where the camera is and where it looks (x, y, z in the world).
VIEWS: dict[str, tuple[str, Point | None, Point | None]] = {
    "course": ("open", (-3.0, -6.6, 3.4), (1.5, 0.0, 0.0)),
    "gantry": ("open", (-2.2, -2.6, 0.9), (0.0, -2.3, 0.75)),
    "tunnel": ("random_tunnel", None, None),
    "boxes": ("d3_v1", (-9.6, -2.2, 2.6), (-5.0, -0.3, 0.0)),
    "works_d4_v1": ("d4_v1", (5.2, -4.6, 1.9), (8.2, -1.0, 0.0)),
    "works_d4_v2": ("d4_v2", (-3.0, 4.8, 2.0), (-6.6, 2.4, 0.0)),
    "works_random": ("random_works", None, None),
    "parallel_bay": ("p2", (0.6, -5.6, 1.6), (3.0, -3.2, 0.0)),
    "two_place_bay": ("b2_v1", (-0.6, -5.6, 1.5), (-2.2, -3.8, 0.0)),
    "signs": ("v1", (3.2, -3.0, 1.2), (5.6, -0.2, 0.4)),
    "hall": ("open", (0.0, 0.6, 1.5), (-9.0, 5.5, 0.9)),
    "robot": ("open", (-1.9, -1.6, 0.9), (-0.55, -2.6, 0.3)),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("docs/pictures/arena"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    renderer = ArenaRenderer(SensorRig())
    for name, view in VIEWS.items():
        write(out / f"{name}.jpg", element(renderer, *view))
    write(out / "looks.jpg", eight_looks(renderer))
    write(out / "signs_all.jpg", sign_sheet(renderer))
    write(out / "artworks.jpg", artwork_sheet())
    for name in COURSE_SETS:
        top_view(renderer, name, out / f"top_{name}.jpg")
    exposure_line(renderer, out)


def write(path: Path, rgb: Picture) -> None:
    cv2.imwrite(str(path), cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), (cv2.IMWRITE_JPEG_QUALITY, 85))


def scenario(layout: str = "open", *, seed: int = 3, look: Look | None = None, course: str = "a") -> Scenario:
    spec = COURSE_SETS[course]
    return set_up(
        name=f"{layout}-{seed}",
        seed=seed,
        layout=draw_layout(layout, Course(spec=spec), stream(seed, "layout")),
        look=look or draw_look(FAMILY, stream(seed, "look"), "normal"),
        panel_sign="up",
        course=spec,
        arena=ArenaSpec(),
        robot=ROBOTS["pioneer"],
        rig=SensorRig(),
    )


def looking(eye: Point, at: Point) -> Pose3:
    """Return the pose (optical axes) of a camera at `eye` that looks at a point."""
    forward = np.array(at) - np.array(eye)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    return Pose3(
        rotation=np.stack([right, np.cross(forward, right), forward], axis=1), translation_m=np.array(eye, dtype=float)
    )


def element(renderer: ArenaRenderer, layout: str, eye: Point | None, at: Point | None) -> Picture:
    arena = scenario(layout)
    renderer.load(arena)
    pose = looking(eye, at) if eye and at else looking(*auto_view(arena))
    return renderer.look_from(CAMERA, pose, START.to_pose3())


def auto_view(arena: Scenario) -> tuple[Point, Point]:
    """Return a view of what was drawn: the mouth of the tunnel, or the road-works from the hall's middle."""
    if arena.tunnel:
        before = arena.course.lap.pose(arena.tunnel.start_s_m - 1.7).transform([(0.0, 0.4)])[0]
        mouth = arena.course.lap.pose(arena.tunnel.start_s_m + 0.6).transform([(0.0, 0.4)])[0]
        return (*before, 1.5), (*mouth, 0.6)
    works = arena.layout.works
    assert works
    middle = np.mean([*works.left, *works.right], axis=0)
    eye = middle + 3.2 * (-middle + (0.0, 0.0)) / np.linalg.norm(middle)
    return (float(eye[0]), float(eye[1]), 2.4), (float(middle[0]), float(middle[1]), 0.0)


def eight_looks(renderer: ArenaRenderer) -> Picture:
    """Return the same view at two looks of each light level, from dark to glaring."""
    rows = []
    for seed in (11, 12):
        cells = []
        for level in LIGHT_LEVELS:
            look = draw_look(FAMILY, stream(seed, "look", level), level)
            arena = scenario("d3_v1", look=look)
            renderer.load(arena)
            picture = renderer.picture("road", Pose2(x_m=-3.2, y_m=-2.0, yaw_rad=3.1).to_pose3(), time_s=0.0)
            rgb = decode_picture(picture)
            cells.append(captioned(rgb, f"{level}, {look.illuminance_lux:.0f} lux, {look.colour_temperature_k:.0f} K"))
        rows.append(np.concatenate(cells, axis=1))
    return np.concatenate(rows, axis=0)


def captioned(rgb: Picture, text: str) -> Picture:
    rgb = np.ascontiguousarray(rgb)
    for shade, thickness in (((0, 0, 0), 3), ((255, 255, 255), 1)):
        cv2.putText(rgb, text, (5, rgb.shape[0] - 7), cv2.FONT_HERSHEY_SIMPLEX, 0.42, shade, thickness, cv2.LINE_AA)
    return rgb


def sign_sheet(renderer: ArenaRenderer) -> Picture:
    arena = scenario("v1")
    renderer.load(arena)
    camera = Camera.from_hfov(width_px=160, height_px=160, hfov_rad=math.radians(40))
    cells = {}
    for sign in draw_signs(arena.course_spec, stream(arena.seed, "signs")):
        foot = Pose2(x_m=sign.x_m, y_m=sign.y_m, yaw_rad=sign.yaw_rad)
        x, y = foot.transform([(0.9, 0.12)])[0]
        cells[sign.sign] = captioned(
            renderer.look_from(camera, looking((x, y, 0.8), (sign.x_m, sign.y_m, 0.72))), sign.sign[5:]
        )
    ordered = [cells[name] for name in sorted(cells)]
    return np.concatenate([np.concatenate(ordered[k : k + 6], axis=1) for k in (0, 6)], axis=0)


def artwork_sheet() -> Picture:
    """Return a row for each style of drawing: its name and the split that shows it, six panels, twelve signs."""
    shown_in = {name: split for split in SPLITS for name in load_split(split).looks.artworks}
    rows = []
    for artwork in ARTWORKS:
        panels = [panel_picture(sign, artwork) for sign in PANEL_SIGNS]
        small = [cv2.resize(picture[..., :3], (112, 63), interpolation=cv2.INTER_AREA) for picture in panels]
        left = np.concatenate([np.concatenate(small[k : k + 3], axis=1) for k in (0, 3)], axis=0)
        signs = [on_grey(sign_picture(sign, artwork)) for sign in SIGNS]
        right = np.concatenate([np.concatenate(signs[k : k + 6], axis=1) for k in (0, 6)], axis=0)
        title = np.full((18, left.shape[1] + right.shape[1], 3), GREY, np.uint8)
        label = f"{artwork} ({shown_in[artwork]})"
        cv2.putText(title, label, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1, cv2.LINE_AA)
        rows += [title, np.concatenate([left, right], axis=1)]
    return np.concatenate(rows, axis=0)


def on_grey(picture: Picture) -> Picture:
    """Return a sign (h, w, 4) as 63 x 63 pixels on grey."""
    share = picture[..., 3:] / 255.0
    whole = np.round(picture[..., :3] * share + GREY * (1 - share)).astype(np.uint8)
    return np.asarray(cv2.resize(whole, (63, 63), interpolation=cv2.INTER_AREA), np.uint8)


def tiles(course: Course) -> Iterator[tuple[float, float]]:
    x0, y0, x1, y1 = shapely.union_all(course.paint).bounds
    for x in np.arange(x0 - 0.3 + TILE_M / 2, x1 + 0.3 + TILE_M / 2, TILE_M):
        for y in np.arange(y0 - 0.3 + TILE_M / 2, y1 + 0.3 + TILE_M / 2, TILE_M):
            yield float(x), float(y)


def top_view(renderer: ArenaRenderer, course_set: str, path: Path) -> None:
    """Draw the floor from straight above, tile by tile, over the outlines of the geometric description, and measure
    how far the painted edges lie from them.
    """
    look = msgspec.structs.replace(
        draw_look(FAMILY, stream(3, "look"), "normal"),
        floods=(),
        lamp_share=0.0,
        line_wear=0.0,
        dirt=0.0,
        floor_gloss=0.0,
    )
    arena = msgspec.structs.replace(scenario(look=look, course=course_set), furniture=())
    renderer.load(arena)
    size = round(TILE_M / PIXEL_M)
    f_px = HEIGHT_M / PIXEL_M
    camera = Camera(width_px=size, height_px=size, fx_px=f_px, fy_px=f_px, cx_px=size / 2, cy_px=size / 2)
    down = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    edges = shapely.union_all(arena.course.paint).boundary
    shapely.prepare(edges)
    hidden = hidden_by_gantry(arena)
    placed = [(x, y) for x, y in tiles(arena.course)]
    x0, y1 = min(x for x, _ in placed) - TILE_M / 2, max(y for _, y in placed) + TILE_M / 2
    width = round((max(x for x, _ in placed) + TILE_M / 2 - x0) / PIXEL_M)
    height = round((y1 - min(y for _, y in placed) + TILE_M / 2) / PIXEL_M)
    whole, offsets = np.zeros((height, width, 3), np.uint8), []
    for x, y in placed:
        rgb = renderer.look_from(camera, Pose3(rotation=down, translation_m=np.array([x, y, HEIGHT_M])))
        column, row = round((x - TILE_M / 2 - x0) / PIXEL_M), round((y1 - y - TILE_M / 2) / PIXEL_M)
        whole[row : row + size, column : column + size] = rgb
        offsets.append(edge_offsets_px(rgb, x - TILE_M / 2, y + TILE_M / 2, edges, hidden))
    offset = np.concatenate(offsets)
    print(
        f"top view, set {course_set}: {len(offset)} edge points, distance to the description median "
        f"{np.median(offset):.2f} px, 99th percentile {np.percentile(offset, 99):.2f} px, largest {offset.max():.2f} px"
    )
    draw_outlines(whole, arena.course, x0, y1)
    write(path, np.asarray(cv2.resize(whole, None, fx=0.4, fy=0.4, interpolation=cv2.INTER_AREA)))


def edge_offsets_px(
    rgb: Picture, x0: float, y1: float, edges: shapely.Geometry, hidden: shapely.Geometry
) -> NDArray[np.float64]:
    """Return how far (n,) the half-way points between floor and paint along rows and columns lie from the description.

    Points in `hidden`, where the gantry stands before the floor, are left out.
    """
    grey = (cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY) / 255.0) ** 2.2  # linear light, in which half covered is half way
    level = (np.median(grey) + grey.max()) / 2
    found = []
    for picture, swap in ((grey, False), (grey.T, True)):
        before, after = picture[:, :-1], picture[:, 1:]
        steep = (before < level) != (after < level)
        row, column = np.nonzero(steep & (np.abs(after - before) > 0.1))
        share = (level - before[row, column]) / (after - before)[row, column]
        along, across = column + share + 0.5, row + 0.5
        u, v = (across, along) if swap else (along, across)
        found.append(np.stack([x0 + u * PIXEL_M, y1 - v * PIXEL_M], axis=1))
    points = np.concatenate(found)
    points = points[~shapely.contains_xy(hidden, points)]
    offset: NDArray[np.float64] = shapely.distance(edges, shapely.points(points)) / PIXEL_M
    return offset


def hidden_by_gantry(arena: Scenario) -> shapely.Geometry:
    """Return the floor that gantry and panels may hide from a camera above the tile that they stand in."""
    parts = [solid for solid in arena.solids if solid.kind in ("gantry", "panel")]
    spans = [(*solid.centre_m, *solid.size_m) for solid in parts]
    ends = [(x + a * dx / 2, y + b * dy / 2) for x, y, _, dx, dy, _ in spans for a in (-1, 1) for b in (-1, 1)]
    return shapely.MultiPoint(ends).convex_hull.buffer(0.5)


def draw_outlines(whole: Picture, course: Course, x0: float, y1: float) -> None:
    for polygon in course.paint:
        for ring in (polygon.exterior, *polygon.interiors):
            points = (shapely.get_coordinates(ring) - (x0, y1)) / (PIXEL_M, -PIXEL_M)
            cv2.polylines(whole, [np.round(points * 16).astype(np.int32)], True, (255, 60, 60), 1, cv2.LINE_AA, 4)


def exposure_line(renderer: ArenaRenderer, out: Path) -> None:
    """Drive through a tunnel at 1 m/s: exposure, the picture's mean and its darkest and brightest moments."""
    import matplotlib.pyplot as plt

    course = Course()
    tunnel = Tunnel(start_s_m=10.0, length_m=3.5)
    base = scenario(seed=5)
    arena = msgspec.structs.replace(base, layout=msgspec.structs.replace(base.layout, tunnel=tunnel), furniture=())
    renderer.load(arena)
    times = np.arange(0.0, tunnel.length_m + 4.0, 0.05)
    means, settled, followed, strip = [], [], [], []
    lag_s, now = renderer.rig.camera("road").imaging.exposure_lag_s, None
    for time_s in times:
        pose = course.lap.pose(tunnel.start_s_m - 2.5 + time_s).to_pose3()
        jpeg = renderer.picture("road", pose, time_s=float(time_s), motion=Motion(v_mps=1.0))
        rgb = decode_picture(jpeg)
        means.append(rgb.mean())
        settled.append(renderer.exposure(pose))
        now = follow(now, settled[-1], float(time_s), lag_s)
        followed.append(now.exposure)
        if round(time_s / 0.05) % 8 == 0:
            strip.append(captioned(rgb, f"{time_s:.1f} s"))
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(9, 5), sharex=True)
    top.plot(times, np.log2(settled), "--", label="metered")
    top.plot(times, np.log2(followed), label="camera")
    top.set_ylabel("exposure, stops")
    top.legend()
    bottom.plot(times, means)
    bottom.set_ylabel("mean of the picture, of 255")
    bottom.set_xlabel("time, s (1 m/s)")
    for axis in (top, bottom):
        axis.axvspan(2.5, 2.5 + tunnel.length_m, color="0.9", label="robot in the tunnel")
    figure.tight_layout()
    figure.savefig(out / "exposure.png", dpi=90)
    plt.close(figure)
    rows = [np.concatenate(strip[k : k + 6], axis=1) for k in range(0, len(strip) - 5, 6)]
    sheet = np.concatenate(rows[:3], axis=0)
    write(out / "tunnel_passage.jpg", np.asarray(cv2.resize(sheet, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)))


if __name__ == "__main__":
    main()
