"""Where things that were not found may go on: below and behind those that were."""

from dataclasses import replace

import numpy as np
import open3d as o3d
import pytest
import trimesh
from shipped import shipped

from workbench.formats.parts.reading import read_part
from workbench.model.scan import Unexplained
from workbench.perception.scene.hidden import Room, hidden_columns
from workbench.perception.scene.unexplained import look_around
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.surfaces import add_surface

CELL = shipped("yumi")
PART = read_part("bracket")
CELL = replace(CELL, parts=(PART,))
EDGE = 0.002


def room(reach=0.03, eye=(0.0, 0.0, 0.8), **about):
    """A plate of 60 x 60 mm, 4 mm thick, 30 mm over the floor; all else is free."""
    parts = o3d.t.geometry.RaycastingScene(nthreads=1)
    plate = trimesh.creation.box((0.06, 0.06, 0.004))
    plate.apply_translation((0.0, 0.0, 0.03))
    add_surface(parts, plate)
    known = {"half": np.array([0.15, 0.1]), "top": 0.032} | about
    return Room(parts, np.array(eye), reach=reach, **known)


def columns(x, y, height, where):
    """Where a thing seen from above at (x, y) [m], up to a height [m], may go on."""
    cells = np.floor(np.stack([x, y], axis=1) / EDGE).astype(np.int64)
    more, heights = hidden_columns(cells, np.full(len(cells), height), EDGE, where)
    return (more + 0.5) * EDGE, heights


EDGE_OF_PLATE = np.full(5, 0.033), np.linspace(-0.01, 0.01, 5)


def test_a_thing_beside_a_plate_goes_on_below_it_as_far_as_it_is_long():
    places, heights = columns(*EDGE_OF_PLATE, 0.02, room())
    assert 0.0 < places[:, 0].min() < 0.008, "30 mm from where it was seen"
    assert places[:, 0].max() <= 0.034, "what lies open is no place for it"
    assert np.all(heights[np.abs(places).max(axis=1) < 0.026] <= 0.028), "the plate itself is known"
    assert np.all(heights > 0.02)


@pytest.mark.parametrize("far", [0.05, 0.09])
def test_what_is_apart_from_what_is_hidden_does_not_go_on(far):
    places, _ = columns(np.full(5, far), EDGE_OF_PLATE[1], 0.02, room(reach=0.08))
    assert len(places) == 0


def test_a_scanner_that_looks_below_the_plate_sees_that_nothing_is_there():
    aslant = room(eye=(0.6, 0.0, 0.02))
    places, _ = columns(*EDGE_OF_PLATE, 0.02, aslant)
    above, _ = columns(*EDGE_OF_PLATE, 0.02, room())
    assert len(places) < len(above) / 4


def test_nothing_goes_on_where_no_part_is_high_or_outside_the_bin():
    assert len(columns(*EDGE_OF_PLATE, 0.02, room(top=0.0))[0]) == 0
    assert len(columns(np.array([0.3]), np.array([0.0]), 0.02, room())[0]) == 0


def test_a_large_bin_is_divided_more_coarsely_and_not_refused():
    x = np.linspace(-2, 2, 400)
    wide = room(reach=1.0, half=np.array([3.0, 3.0]))
    places, _ = columns(np.append(x, 0.033), np.append(np.full(400, 1.0), 0.0), 0.5, wide)
    assert len(places) > 0


def held(boxes, points):
    """Which points (n, 3) in the world lie in a box."""
    inside = np.zeros(len(points), bool)
    for one in boxes:
        T = one.T_world_box.inverse()
        away = np.abs(points @ T.rotation.T + T.translation)
        inside |= np.all(away <= one.size / 2 + 1e-6, axis=1)
    return inside


def near_to(boxes, points, far):
    """Which points (n, 3) in the world are no further than this [m] from a box."""
    away = np.full(len(points), np.inf)
    for one in boxes:
        T = one.T_world_box.inverse()
        over = np.abs(points @ T.rotation.T + T.translation) - one.size / 2
        away = np.minimum(away, np.linalg.norm(np.maximum(over, 0.0), axis=1))
    return away <= far


@pytest.mark.extensive
def test_in_piles_the_hidden_side_of_what_was_not_found_is_held():
    """Of its surface outside the boxes around what was seen, near to these and off the floor."""
    hidden = kept = 0
    for seed in range(8):
        truth = drop_parts((PART,) * 8, CELL.bin, seed=seed)
        scan = synthesize(CELL, truth, seed=seed)
        for left_out in range(0, 8, 3):
            found = tuple(one for k, one in enumerate(truth) if k != left_out)
            around = look_around(CELL, scan, found)
            T = truth[left_out].T_world_part
            surface = trimesh.Trimesh(PART.mesh.points, PART.mesh.triangles, process=False)
            points = np.asarray(surface.sample(2000, seed=1)) @ T.rotation.T + T.translation
            outside = points[~held(around.seen, points)]
            is_low = outside[:, 2] < CELL.bin.T_world_bin.translation[2] + 0.002
            outside = outside[~is_low & near_to(around.seen, outside, 0.015)]
            hidden += len(outside)
            kept += int(held(around.unseen, outside).sum())
    assert hidden > 2000, "there is something to hold"
    assert kept > 0.6 * hidden, f"{kept} of {hidden}"


def test_where_all_is_known_nothing_goes_on():
    truth = drop_parts((PART,) * 5, CELL.bin, seed=3)
    around = look_around(CELL, synthesize(CELL, truth, seed=3), truth)
    assert around == Unexplained()
