"""What is red among the points of a scan lies in the boxes of the plan, and nothing else does."""

import zlib
from dataclasses import replace

import numpy as np
import pytest

from workbench.gui.scene.cloud import GRID, avoided_red, height_colours, in_short, painted_cloud
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.colours import AVOIDED, part_colour, rgb_of
from workbench.gui.shared.look import Look
from workbench.gui.shared.viser_server import close_viser, open_viser
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Obstacle, Scan

RED = np.array(rgb_of(AVOIDED))


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    yield server
    close_viser(server)


@pytest.fixture
def box(cell) -> Obstacle:
    T = cell.bin.T_world_bin * pose_from_rpy((0.03, -0.02, 0.03), (0, 0, 0.4))
    return Obstacle(T, np.array([0.05, 0.03, 0.06]))


@pytest.fixture
def points(cell, box) -> np.ndarray:
    """In the box, on its faces, and all around."""
    draw = np.random.default_rng(0)
    inside = draw.uniform(-0.5, 0.5, (200, 3)) * box.size
    faces = np.array([[x, 0, 0] for x in (-0.5, 0.5)]) * box.size
    there = np.vstack([inside, faces]) @ box.T_world_box.rotation.T + box.T_world_box.translation
    around = cell.bin.T_world_bin.translation + draw.uniform(-0.2, 0.2, (2000, 3))
    return np.vstack([there, around])


def is_red(colours) -> np.ndarray:
    return np.all(colours == RED, axis=1)


def test_points_are_red_exactly_where_the_plan_keeps_clear(cell, box, points):
    cloud = painted_cloud(cell, points, ())
    T = box.T_world_box.inverse()
    away = np.abs(points @ T.rotation.T + T.translation) - box.size / 2
    expected = np.all(away <= 1e-6, axis=1)
    assert 202 <= np.count_nonzero(expected) < len(points)
    np.testing.assert_array_equal(is_red(avoided_red(cloud, (box,))), expected)


def test_what_nothing_explains_is_not_red_while_nothing_avoids_it(cell, detections, points):
    cloud = painted_cloud(cell, points, detections)
    assert not is_red(avoided_red(cloud, ())).any()


def test_points_of_a_part_keep_its_colour_in_a_box(cell, detections):
    T = detections[0].T_world_part
    on_part = cell.part(detections[0].part).mesh.points @ T.rotation.T + T.translation
    cloud = painted_cloud(cell, on_part, detections)
    colours = avoided_red(cloud, (Obstacle(T, np.array([0.2, 0.2, 0.2])),))
    assert np.mean(np.all(colours == rgb_of(part_colour(0)), axis=1)) > 0.9


def test_points_beside_the_bin_are_grey_and_high_ones_differ_from_low_ones(cell):
    T = cell.bin.T_world_bin
    low, high, beside = (
        T.act(np.array(p)) for p in ((0, 0, 0), (0, 0, cell.bin.size[2]), (1, 0, 0))
    )
    colours = height_colours(cell, np.array([low, high, beside]))
    assert colours.shape == (3, 3)
    assert not np.array_equal(colours[0], colours[1])
    assert len(set(colours[2].tolist())) <= 3 and np.ptp(colours[2].astype(int)) < 20


def test_the_picture_turns_red_with_the_plan_and_back_without_it(
    server, cell, states, view_of, box, points
):
    T = cell.scanner.T_world_scanner.inverse()
    scan = Scan(points @ T.rotation.T + T.translation, cell.scanner.T_world_scanner, "drawn")
    found = view_of(replace(states.localized, scan=scan))
    planned = view_of(replace(states.planned, scan=scan, obstacles=(box,)))
    scene = ScenePicture(server, cell, most_points=10_000)

    def red() -> np.ndarray:
        cloud = server.scene.get_handle_by_name("/scan")
        drawn = np.asarray(cloud.points, float) + np.asarray(cloud.position)
        return drawn[is_red(np.asarray(cloud.colors))]

    scene.draw(None, found)
    assert len(red()) == 0
    scene.draw(found, planned)
    back = box.T_world_box.inverse()
    away = np.abs(red() @ back.rotation.T + back.translation) - box.size / 2
    assert len(red()) >= 100
    assert away.max() < GRID
    scene.draw(planned, found)
    assert len(red()) == 0


def test_a_scan_is_drawn_in_its_own_colours_where_somebody_wants_that(
    server, cell, states, view_of, box, points
):
    T = cell.scanner.T_world_scanner.inverse()
    # As the scanner saw it what lies in the box is green, and all else has a colour of its own.
    own = np.column_stack([np.arange(len(points)) % 200, np.full(len(points), 7), points[:, 0] > 0])
    own[:202] = (0, 180, 0)
    scan = Scan(
        points @ T.rotation.T + T.translation, cell.scanner.T_world_scanner, "drawn", colours=own
    )
    bare = replace(states.planned, scan=replace(scan, colours=None), obstacles=(box,))
    seen = replace(bare, scan=scan)
    # Fewer are drawn than there are, each with the colour that it has.
    scene = ScenePicture(server, cell, most_points=1500)

    def drawn() -> np.ndarray:
        names = ["/scan", *(f"/parts/part-{k + 1}/points" for k in range(len(seen.detections)))]
        clouds = [server.scene.get_handle_by_name(name) for name in names]
        colours = np.vstack([np.asarray(one.colors) for one in clouds])
        assert len(colours) == 1500
        return colours

    ours, as_scanned = Look(), Look(scan_colours=True)
    scene.draw(None, view_of(seen, ours))
    by_height = drawn()
    assert is_red(by_height).any()
    scene.draw(view_of(seen, ours), view_of(seen, as_scanned))
    chosen = np.random.default_rng(0).choice(len(points), 1500, replace=False, shuffle=False)
    owners = painted_cloud(cell, scan.points_world[chosen], seen.detections).owners
    order = np.argsort(np.where(owners < 0, -1, owners), kind="stable")
    np.testing.assert_array_equal(drawn(), own[chosen][order])
    scene.draw(view_of(seen, as_scanned), view_of(seen, ours))
    np.testing.assert_array_equal(drawn(), by_height)
    scene.draw(view_of(seen, ours), view_of(bare, as_scanned))
    np.testing.assert_array_equal(drawn(), by_height, "a scan without colours")


def test_points_go_out_short_and_are_drawn_where_they_are():
    """Of 0.9 MB a scan that took 9 s on a line of 1 Mbit/s; nobody sees a tenth of a millimetre."""
    across = np.linspace(-0.4, 0.4, 200)
    x, y = np.meshgrid(across + 1.3, across - 0.2)
    points = np.column_stack([x.ravel(), y.ravel(), 0.02 * np.sin(9 * x.ravel())])
    middle, near = in_short(points)
    assert near.dtype == np.float16
    assert np.abs(near.astype(float) + middle - points).max() <= GRID / 2 + 1e-9
    assert len(zlib.compress(near.tobytes())) < 5 * len(points)
    assert in_short(np.zeros((0, 3)))[1].shape == (0, 3)
