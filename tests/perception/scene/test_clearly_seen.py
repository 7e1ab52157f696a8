"""The rule of what is clearly seen (docs/scanners.md), judged by counting points anew.

Within `max(4 mm, 2 pixels)` of a point at least five points, which together stand for 6 mm2, are
more than 6 mm from all that is known, and see what their neighbours see: then all of them are in a
box.  The judge knows the truth and counts with trees of SciPy; it shares no code with what it
judges.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from workbench.formats.cells.reading import read_cell
from workbench.gui.scene.cloud import avoided_red, painted_cloud
from workbench.gui.shared.colours import AVOIDED, rgb_of
from workbench.model.cell import Cell, Fixture
from workbench.model.geometry import Box, Cylinder, Floats, Solid, pose_from_rpy
from workbench.model.scan import Obstacle, Scan
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

CELL = read_cell("tx2_90")
FIELDS = (20, 30, 45, 60, 75)
RESOLUTIONS = [(320, 240), (640, 480), (1280, 960), (2048, 1536)]

NEAR, PIXELS, FEWEST, AREA, KNOWN = 0.004, 2.0, 5, 6e-6, 0.006
"""The rule: [m], in pixels, points, [m2], [m]."""

COUNTED = 1.25
"""How much wider pixels are told from points than they are, at most."""

DRAWN = 50_000
"""Points that a page paints, about."""

AT = pose_from_rpy((0, 0, 0))

THINGS = {
    "post": (Box(np.array([0.02, 0.02, 0.1])), (-0.1, -0.15, 0.05), (0, 0, 0.3)),
    "wall": (Box(np.array([0.004, 0.12, 0.08])), (0.1, -0.12, 0.04), (0, 0, 0.2)),
    "wire": (Cylinder(0.002, 0.2), (0.0, 0.12, 0.06), (0, np.pi / 2, 0.4)),
    "plate": (Box(np.array([0.08, 0.06, 0.003])), (-0.08, 0.02, 0.06), (0.5, 0.4, 0)),
    "steep plate": (Box(np.array([0.06, 0.05, 0.003])), (0.09, 0.1, 0.05), (0, 1.25, 0.8)),
}
"""Shape, place and turn in the bin's frame."""


def viewed(degrees: float, resolution: tuple[int, int]) -> Cell:
    mount = replace(CELL.scanner, field_of_view=np.deg2rad(degrees), resolution=resolution)
    return replace(CELL, scanner=mount)


def with_things(cell: Cell) -> Cell:
    made = [
        Fixture(name, cell.bin.T_world_bin * pose_from_rpy(p, rpy), (Solid(name, shape, AT),))
        for name, (shape, p, rpy) in THINGS.items()
    ]
    return replace(cell, fixtures=(*cell.fixtures, *made))


def box_distances(points: Floats, T, size: Floats) -> Floats:
    """How far points (n, 3) [m] are from the surface of a box."""
    away = np.abs((points - T.translation) @ T.rotation) - np.asarray(size) / 2
    outside = np.linalg.norm(np.maximum(away, 0.0), axis=1)
    return np.where(away.max(axis=1) > 0, outside, -away.max(axis=1))


def within(points: Floats, low: Floats, high: Floats) -> np.ndarray:
    """Which points (n, 3) [m] lie between two corners; by columns, of which there are millions."""
    x, y, z = ((points[:, k] >= low[k]) & (points[:, k] <= high[k]) for k in range(3))
    return x & y & z


def held(points: Floats, boxes: Sequence[Obstacle]) -> np.ndarray:
    """Which points (n, 3) [m] lie in a box."""
    is_held = np.zeros(len(points), bool)
    for one in boxes:
        half = one.size / 2 + 1e-6
        away = (points - one.T_world_box.translation) @ one.T_world_box.rotation
        is_held |= within(away, -half, half)
    return is_held


def surface_tree(shape, T) -> cKDTree:
    """Points all over a surface, in the world."""
    if isinstance(shape, Box):
        mesh = trimesh.creation.box(shape.size)
    elif isinstance(shape, Cylinder):
        mesh = trimesh.creation.cylinder(shape.radius, shape.length)
    else:
        mesh = trimesh.Trimesh(shape.points, shape.triangles, process=False)
    points = trimesh.sample.sample_surface(mesh, 30_000, seed=1)[0]
    return cKDTree(points @ T.rotation.T + T.translation)


def of_the_cell(cell: Cell, points: Floats) -> Floats:
    """How far points are from bin and fixtures [m], which are boxes here."""
    owners = [(cell.bin.T_world_bin, cell.bin.solids)]
    owners += [(one.T_world_fixture, one.solids) for one in cell.fixtures]
    return np.min(
        [
            box_distances(points, T * solid.T_owner_shape, solid.shape.size)
            for T, solids in owners
            for solid in solids
        ],
        axis=0,
    )


def surrounded(scan: Scan, is_of: np.ndarray) -> np.ndarray:
    """Which points see a thing as all pixels do that are up to two beside them."""
    width, height = scan.resolution
    picture = np.zeros(width * height, bool)
    picture[scan.pixels[is_of]] = True
    picture = picture.reshape(height, width)
    all_around = np.zeros_like(picture)
    inner = np.ones((height - 4, width - 4), bool)
    for row in range(5):
        for column in range(5):
            inner &= picture[row : row + height - 4, column : column + width - 4]
    all_around[2:-2, 2:-2] = inner
    return all_around.reshape(-1)[scan.pixels] & is_of


def clearly_seen(scan: Scan, is_of: np.ndarray, pitch: float) -> np.ndarray:
    """Which points of a thing the rule calls clearly seen."""
    sure = np.flatnonzero(surrounded(scan, is_of))
    clear = np.zeros(len(scan.points), bool)
    if not len(sure):
        return clear
    tree = cKDTree(scan.points_world[sure])
    near = tree.query_ball_point(
        scan.points_world[sure], max(NEAR, PIXELS * pitch), return_length=True
    )
    clear[sure[near >= max(FEWEST, COUNTED * AREA / pitch**2)]] = True
    return clear


@pytest.mark.parametrize("resolution", RESOLUTIONS, ids=str)
@pytest.mark.parametrize("degrees", FIELDS)
def test_nothing_clearly_seen_is_lost_and_what_is_red_is_avoided(degrees, resolution):
    cell = viewed(degrees, resolution)
    pile = drop_parts(CELL.parts[:1] * 3, CELL.bin, seed=11)
    scan = synthesize(with_things(cell), pile, seed=3)
    found = pile[:-1]
    boxes = unexplained(cell, scan, found)
    points = scan.points_world
    some = points[:: max(1, len(points) // DRAWN)]
    cloud = painted_cloud(cell, some, found)
    is_red = np.all(avoided_red(cloud, boxes) == rgb_of(AVOIDED), axis=1)
    assert np.array_equal(is_red, held(some, boxes) & (cloud.owners < 0)), "red is what is avoided"

    T_bin = cell.bin.T_world_bin
    trees = {
        name: surface_tree(shape, T_bin * pose_from_rpy(p, rpy))
        for name, (shape, p, rpy) in THINGS.items()
    }
    trees["part without a model"] = surface_tree(
        CELL.part(pile[-1].part).mesh, pile[-1].T_world_part
    )
    known = [surface_tree(CELL.part(one.part).mesh, one.T_world_part) for one in found]
    far = np.linalg.norm(scan.T_world_scanner.translation - T_bin.translation)
    pitch = 2 * np.tan(np.deg2rad(degrees) / 2) / resolution[0] * far
    seen = {}
    for name, tree in trees.items():
        on = np.flatnonzero(within(points, tree.mins - 0.003, tree.maxes + 0.003))
        on = on[tree.query(points[on], distance_upper_bound=0.003)[0] < 0.0025]
        on = on[of_the_cell(cell, points[on]) > KNOWN + 5e-4]
        for other in known:
            on = on[other.query(points[on], distance_upper_bound=0.02)[0] > KNOWN + 1e-3]
        is_of = np.zeros(len(points), bool)
        is_of[on] = True
        is_clear = clearly_seen(scan, is_of, pitch)
        seen[name] = np.count_nonzero(is_clear)
        lost = np.count_nonzero(~held(points[is_clear], boxes))
        assert lost == 0, f"{name}: {lost} of {seen[name]} points"
    if resolution[0] >= 1280 and degrees <= 60:
        assert seen["post"] and seen["plate"] and seen["part without a model"]
