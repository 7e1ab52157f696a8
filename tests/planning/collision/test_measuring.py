"""Distances of groups of shapes: those of their pairs, measured one by one."""

import os

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Box, Cylinder, Mesh, pieces_of
from workbench.planning.collision.distances.measuring import (
    Group,
    distance,
    find_nearing,
    group_distance,
    moved_distance,
)


def poses(count):
    rng = np.random.default_rng(4)
    for _ in range(count):
        turn = pin.exp3(rng.normal(size=3))
        yield pin.SE3(turn, rng.uniform(-0.06, 0.06, size=3))


@pytest.mark.parametrize("name", ["keyed_cylinder", "bracket"])
def test_groups_are_as_far_apart_as_their_nearest_shapes(name):
    tool, part = read_cell("yumi").arms[0].tool, read_part(f"parts/{name}")
    solids = [*tool.body, *(finger.solid for finger in tool.fingers)]
    one = Group([(solid.shape, solid.T_owner_shape) for solid in solids])
    other = Group([(piece.shape, piece.T_owner_shape) for piece in part.pieces])
    shifts = np.random.default_rng(5).uniform(-0.01, 0.01, size=(len(solids), 3))
    for T in poses(25):
        each = [
            min(
                distance(
                    shape,
                    T * pin.SE3(np.eye(3), shift) * solid.T_owner_shape,
                    piece.shape,
                    piece.T_owner_shape,
                )
                for piece in part.pieces
                for shape in pieces_of(solid.shape)
            )
            for solid, shift in zip(solids, shifts, strict=True)
        ]
        far, at = group_distance(one, T, shifts, other)
        # How deep things are is found by iterations, whose last digits other instructions change.
        is_usual = os.environ["OPENBLAS_CORETYPE"] == "Nehalem"
        off = 1e-9 if far > 0 or is_usual else 1e-6
        assert far == pytest.approx(min(each), abs=off) and each[at] == pytest.approx(far, abs=off)


def hull_of(points, pieces=()):
    return Mesh(points, ConvexHull(points).simplices, is_convex=True, pieces=pieces)


def divided_shape():
    rng = np.random.default_rng(6)
    clouds = [rng.normal(size=(10, 3)) * 0.004 + rng.normal(size=3) * 0.015 for _ in range(12)]
    return hull_of(np.concatenate(clouds), tuple(map(hull_of, clouds)))


def test_a_shape_with_pieces_is_as_far_away_as_its_nearest_piece_also_deep_inside():
    shape = divided_shape()
    for T in poses(40):
        each = min(
            distance(one, T, other, pin.SE3.Identity())
            for one in pieces_of(shape)
            for other in pieces_of(shape)
        )
        assert distance(shape, T, shape, pin.SE3.Identity()) == each
        for within in (-0.004, 0.0, 0.003):
            assert distance(shape, T, shape, pin.SE3.Identity(), within) == min(each, within)


def test_what_comes_too_near_on_its_way_is_found_wherever_it_does():
    shape = divided_shape()
    bed = (shape, pin.SE3.Identity())
    found = set()
    for k, T in enumerate(poses(60)):
        way = np.random.default_rng(k).normal(size=3)
        steps = np.arange(0.001, 0.02, 0.001)[:, None] * way / np.linalg.norm(way)
        begins = moved_distance((shape, T), bed, np.zeros(3))
        keeps = min(0.004, begins - 0.0005)
        gaps = [moved_distance((shape, T), bed, step) for step in steps]
        nearing = find_nearing((shape, T), bed, steps, begins, keeps)
        found.add(nearing is None)
        assert nearing == next((gap for gap in gaps if gap < keeps), None)
    assert found == {True, False}


def test_nothing_is_named_beyond_what_is_asked_for():
    one = Group([(Box(np.full(3, 0.02)), pin.SE3.Identity())])
    other = Group([(Cylinder(0.01, 0.02), pin.SE3.Identity())])
    away, still = pin.SE3(np.eye(3), np.array([0.05, 0.0, 0.0])), np.zeros((1, 3))
    assert group_distance(one, away, still, other, within=0.01) == (0.01, -1)
    far, at = group_distance(one, away, still, other)
    assert far == pytest.approx(0.03, abs=1e-6) and at == 0


def test_a_group_of_nothing_meets_nothing():
    other = Group([(Cylinder(0.01, 0.02), pin.SE3.Identity())])
    nothing = group_distance(Group([]), pin.SE3.Identity(), np.zeros((0, 3)), other)
    assert nothing == (np.inf, -1)
