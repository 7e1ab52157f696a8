"""What is clearly seen is avoided, however the scanner looks at it; what is no thing is not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import open3d as o3d
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan
from workbench.model.cell import Cell, Fixture
from workbench.model.geometry import Box, Cylinder, Floats, Solid, pose_from_rpy
from workbench.model.scan import Detection, Obstacle, Scan
from workbench.perception.scene.reach import reach
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.noise_models import FINE_SCANNER, ROUGH
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

CUBE = 0.002
DEEP, FLAT = read_cell("tx2_90"), read_cell("yumi")
POSTS = ((0.02, (-0.1, -0.15)), (0.04, (0.08, 0.02)), (0.06, (-0.05, 0.18)))
"""Width and place in the bin [m]."""

HIGH = 0.1
RESOLUTIONS = [(320, 240), (640, 480), (1280, 960), (2048, 1536)]


def with_view(cell: Cell, degrees: float, resolution: tuple[int, int]) -> Cell:
    mount = replace(cell.scanner, field_of_view=np.deg2rad(degrees), resolution=resolution)
    return replace(cell, scanner=mount)


def with_thing(cell: Cell, shape: Box | Cylinder, p_bin) -> Cell:
    """The cell with something in the bin's frame that the planner is not told of."""
    T = cell.bin.T_world_bin * pose_from_rpy(p_bin)
    thing = Fixture("thing", T, (Solid("thing", shape, pose_from_rpy((0, 0, 0))),))
    return replace(cell, fixtures=(*cell.fixtures, thing))


def in_bin(cell: Cell, scan: Scan) -> Floats:
    T = cell.bin.T_world_bin.inverse()
    return scan.points_world @ T.rotation.T + T.translation


def in_world(cell: Cell, points: Floats) -> Floats:
    """Where points (n, 3) [m] of the bin's frame are in the world."""
    T = cell.bin.T_world_bin
    return points @ T.rotation.T + T.translation


def held(points: Floats, boxes: tuple[Obstacle, ...], grown: float = CUBE) -> np.ndarray:
    """Which world points (n, 3) lie in one of the boxes."""
    inside = np.zeros(len(points), bool)
    for one in boxes:
        T = one.T_world_box.inverse()
        away = np.abs(points @ T.rotation.T + T.translation) - one.size / 2
        inside |= np.all(away <= grown, axis=1)
    return inside


@pytest.mark.parametrize("noise", [FINE_SCANNER, ROUGH], ids=["fine", "rough"])
@pytest.mark.parametrize("resolution", RESOLUTIONS, ids=str)
@pytest.mark.parametrize("degrees", [30, 45, 60])
def test_posts_are_boxed_at_every_field_of_view_and_resolution(degrees, resolution, noise):
    cell = with_view(DEEP, degrees, resolution)
    truth = cell
    for width, (x, y) in POSTS:
        truth = with_thing(truth, Box(np.array([width, width, HIGH])), (x, y, HIGH / 2))
    scan = synthesize(truth, [], seed=0, noise=noise)
    boxes = unexplained(cell, scan, ())
    points = in_bin(cell, scan)
    # Of three million points few are of the posts' tops.
    points = points[np.abs(points[:, 2] - HIGH) < 0.005]
    for width, (x, y) in POSTS:
        top = points[np.abs(points[:, :2] - (x, y)).max(axis=1) < width / 2]
        assert np.mean(held(in_world(cell, top), boxes)) >= 0.95, width
    # And no more than the posts and the pixels beside them.
    pixel = 1.6 * 2 * np.tan(np.deg2rad(degrees) / 2) / resolution[0]
    volume = sum(float(np.prod(one.size)) for one in boxes)
    rim = 2 * max(0.006, 1.5 * pixel) + 2 * pixel
    assert volume < sum((width + rim) ** 2 for width, _ in POSTS) * (HIGH + 0.01)


@pytest.mark.parametrize(("degrees", "resolution"), [(30, (640, 480)), (60, (2048, 1536))])
def test_a_thin_pin_is_boxed(degrees, resolution):
    cell = with_view(DEEP, degrees, resolution)
    truth = with_thing(cell, Cylinder(0.003, 0.12), (0.05, -0.1, 0.06))
    boxes = unexplained(cell, synthesize(truth, [], seed=0), ())
    tip = cell.bin.T_world_bin.act(np.array([0.05, -0.1, 0.119]))
    assert held(tip[None], boxes).all()


@pytest.mark.parametrize("seed", range(3))
def test_what_touches_a_part_is_boxed(seed):
    pile = drop_parts(FLAT.parts[:1], FLAT.bin, seed=seed)
    (part,) = pile
    T = FLAT.bin.T_world_bin.inverse() * part.T_world_part
    points = FLAT.part(part.part).mesh.points @ T.rotation.T + T.translation
    side = -np.sign(T.translation[0]) or 1.0
    x = (points[:, 0] * side).max() * side + side * 0.0101
    post = Box(np.array([0.02, 0.02, 0.05]))
    y = points[np.argmax(points[:, 0] * side), 1]
    scan = synthesize(with_thing(FLAT, post, (x, y, 0.025)), pile, seed=seed)
    boxes = unexplained(FLAT, scan, pile)
    away = in_bin(FLAT, scan) - (x, y, 0.05)
    is_top = np.all(np.abs(away) < (0.01, 0.01, 0.003), axis=1)
    assert np.count_nonzero(is_top) > 50
    assert np.mean(held(scan.points_world, boxes)[is_top]) >= 0.95


def test_what_lies_on_the_rim_is_boxed():
    length, _, height = DEEP.bin.size
    at = (length / 2, 0.05, height + 0.02)
    scan = synthesize(with_thing(DEEP, Box(np.array([0.06, 0.04, 0.04])), at), [], seed=0)
    boxes = unexplained(DEEP, scan, ())
    away = in_bin(DEEP, scan) - (*at[:2], height + 0.04)
    is_top = np.all(np.abs(away) < (0.03, 0.02, 0.004), axis=1)
    assert np.count_nonzero(is_top) > 500
    assert np.mean(held(scan.points_world, boxes)[is_top]) >= 0.95


@pytest.mark.parametrize("resolution", [(320, 240), (640, 480), (1280, 960)], ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_single_points_in_the_air_are_no_obstacles(seed, resolution):
    cell = with_view(DEEP, 30, resolution)
    scan = synthesize(cell, [], seed=seed)
    draw = np.random.default_rng(seed)
    points = np.array(scan.points)
    wrong = draw.random(len(points)) < 0.004
    points[wrong] *= draw.uniform(0.8, 0.98, (np.count_nonzero(wrong), 1))
    assert unexplained(cell, Scan(points, scan.T_world_scanner, "speckled"), ()) == ()


@pytest.mark.parametrize("noise", [FINE_SCANNER, ROUGH], ids=["fine", "rough"])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_a_pile_that_is_known_leaves_no_obstacle(name, seed, noise):
    shipped = {"yumi": FLAT, "tx2_90": DEEP}[name]
    pile = drop_parts(shipped.parts[:1] * (2 + 3 * (seed % 3)), shipped.bin, seed=seed)
    own = np.rad2deg(shipped.scanner.field_of_view)
    for degrees, resolution in ((own, (640, 480)), (own, (320, 240)), (60, (1280, 960))):
        cell = with_view(shipped, degrees, resolution)
        assert unexplained(cell, synthesize(cell, pile, seed=seed, noise=noise), pile) == ()


def test_five_million_points_give_the_boxes_of_a_million():
    cell = with_view(DEEP, 30, (1280, 960))
    width, (x, y) = POSTS[0]
    truth = with_thing(cell, Box(np.array([width, width, HIGH])), (x, y, HIGH / 2))
    scan = synthesize(truth, [], seed=0)
    draw = np.random.default_rng(0)
    many = np.vstack([scan.points + draw.normal(0, 2e-4, scan.points.shape) for _ in range(6)])
    assert len(many) > 4_900_000
    (box,) = unexplained(cell, Scan(many, scan.T_world_scanner, "many"), ())
    at = cell.bin.T_world_bin.act(np.array([x, y, HIGH / 2]))
    np.testing.assert_allclose(box.T_world_box.translation, at, atol=0.004)
    np.testing.assert_allclose(box.size, [width, width, HIGH], atol=0.014)


def test_what_no_arm_reaches_is_left_alone():
    scan = synthesize(DEEP, [], seed=0)
    far = DEEP.T_world_robot.translation + (reach(DEEP) + 0.2, 0.0, 0.0)
    heap = far + np.random.default_rng(0).uniform(-0.05, 0.05, (3000, 3))
    T = scan.T_world_scanner.inverse()
    points = np.vstack([scan.points, heap @ T.rotation.T + T.translation])
    assert unexplained(DEEP, Scan(points, scan.T_world_scanner, "wall"), ()) == ()
    only = Scan(points[len(scan.points) :], scan.T_world_scanner, "wall")
    assert unexplained(DEEP, only, ()) == ()


@pytest.mark.parametrize("count", [1, 4])
def test_a_scan_of_next_to_nothing_has_no_obstacles(count):
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (count, 3)) + (0, 0, 1.4)
    assert unexplained(DEEP, Scan(points, DEEP.scanner.T_world_scanner, "few"), ()) == ()


def test_pixels_without_a_measurement_change_nothing(tmp_path: Path):
    width, (x, y) = POSTS[1]
    truth = with_thing(DEEP, Box(np.array([width, width, HIGH])), (x, y, HIGH / 2))
    scan = synthesize(truth, [], seed=0)
    full = np.full((scan.resolution[0] * scan.resolution[1], 3), np.nan)
    full[scan.pixels] = scan.points
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(full))
    assert o3d.io.write_point_cloud(str(tmp_path / "scan.ply"), cloud)
    found = read_scan(tmp_path / "scan.ply", DEEP.scanner)
    assert len(found.points) == len(scan.points)
    one, other = (unexplained(DEEP, each, ()) for each in (scan, found))
    assert [box.size.tolist() for box in one] == [box.size.tolist() for box in other]


def test_a_part_that_is_missing_is_in_the_way_at_a_wide_angle_too():
    cell = with_view(DEEP, 60, (640, 480))
    pile: tuple[Detection, ...] = drop_parts(DEEP.parts[:1] * 4, DEEP.bin, seed=2)
    scan = synthesize(cell, pile, seed=2)
    boxes = unexplained(cell, scan, pile[:-1])
    away = scan.points_world - pile[-1].T_world_part.translation
    own = np.linalg.norm(away, axis=1) < 0.03
    floor = in_bin(cell, scan)[:, 2] < 0.008
    assert np.mean(held(scan.points_world, boxes)[own & ~floor]) >= 0.95
