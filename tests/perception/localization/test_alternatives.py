"""Turns of a part that look alike share the chance of the pose."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from trimesh.boolean import difference

from workbench.app.runtime.work import find_parts
from workbench.model.geometry import Box, Mesh, Solid, pose_from_rpy
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry
from workbench.perception.localization.alternatives import (
    FEWEST_TELLING,
    SHARPNESS,
    TELLING,
    is_better,
    margin,
    share_nearby,
    weights,
)
from workbench.perception.localization.certainty import covariance
from workbench.perception.matching.maps import make_map
from workbench.perception.matching.sightings import look
from workbench.perception.parts.part_surface import prepare
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent

SIZE = np.array([0.04, 0.04, 0.012])
PITCH = 0.0007


def plate(name, *notches):
    """A square plate with corners cut away: one for each place (3,) [m] of a cutting box."""
    mesh = trimesh.creation.box(SIZE)
    for place in notches:
        cut = trimesh.creation.box((0.016, 0.016, 0.008))
        cut.apply_translation(place)
        mesh = difference([mesh, cut])
    piece = Solid("box", Box(SIZE), pin.SE3.Identity())
    shape = Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    return Part(name, shape, (piece,), 0.05, Symmetry(), GraspLibrary())


BELOW, ABOVE = (0.02, 0.02, -0.006), (0.02, 0.02, 0.006)


def found(cell, part):
    there = replace(cell, parts=(part,))
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, SIZE[2] / 2), (0, 0, 0.4))
    seen = synthesize(there, (Detection(part.name, T),), seed=5)
    return find_parts(there, {"scan": seen, "seed": 0}, silent, never).detections


def test_four_turns_that_look_alike_share_the_chance(cell):
    (detection,) = found(cell, plate("below", BELOW))
    assert detection.probability == pytest.approx(0.25, abs=0.05)


def test_a_notch_that_is_seen_decides_the_turn(cell):
    (detection,) = found(cell, plate("above", ABOVE))
    assert detection.probability > 0.9


def test_a_pose_is_better_by_a_share_of_what_it_explains_and_by_some_pixels():
    few, many = np.array([0.0, 100, 0, 0]), np.array([0.0, 10_000, 0, 0])
    assert margin(few) == FEWEST_TELLING
    assert margin(many) == pytest.approx(TELLING * 10_000)
    behind = few - [0.0, FEWEST_TELLING, 0, 0]
    assert is_better(few, behind[None])
    assert not is_better(few, behind[None] + [0, 1.0, 0, 0])
    assert is_better(few, np.empty((0, 4)))


def test_the_weight_of_another_turn_falls_with_each_margin():
    own = np.array([0.0, 100, 0, 0])
    others = own - np.outer([-1.0, 0.0, 1.0, 2.0], [0, FEWEST_TELLING, 0, 0])
    assert weights(own, others) == pytest.approx(
        np.exp(-SHARPNESS * np.array([0.0, 0.0, 1.0, 2.0]))
    )


@pytest.mark.parametrize(("turn_is_free", "low", "high"), [(False, 0.3, 0.75), (True, 0.95, 1.0)])
def test_a_disc_shows_no_turn_unless_none_counts(cell, turn_is_free, low, high):
    disc = trimesh.creation.cylinder(0.02, 0.012, sections=64)
    mesh = Mesh(np.asarray(disc.vertices), np.asarray(disc.faces))
    part = replace(plate("disc"), mesh=mesh)
    there = replace(cell, parts=(part,))
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, SIZE[2] / 2), (0, 0, 0))
    scan = synthesize(there, (Detection("disc", T),), seed=6)
    surface = prepare(part)
    scene = scene_model(scan, there, smallest=surface.diameter)
    depth_map = make_map(scan, cell.bin, scene.bin, size=surface.diameter, pitch=PITCH)
    assert depth_map is not None
    pose, tolerance = (scan.T_world_scanner.inverse() * T).homogeneous, 0.0012
    sighting = look(depth_map, surface, pose, tolerance)
    known = covariance(depth_map, surface, pose, sighting, tolerance)
    share = share_nearby(depth_map, surface, pose, known, tolerance, is_roll_free=turn_is_free)
    assert low <= share <= high
