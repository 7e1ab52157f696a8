"""Edits of grasp libraries, patterns and symmetries."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.formats.parts.reading import read_part
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, GraspPair, GraspPattern, is_same_grip
from workbench.model.part_edits import edit_library, free_name, mirror_entry, names_in
from workbench.model.symmetry import Symmetry

ANGLES = st.floats(-3.0, 3.0, allow_nan=False)
LENGTHS = st.floats(-0.1, 0.1, allow_nan=False)


def grasp(name="g", T=None, **fields) -> Grasp:
    return Grasp(name, T or pin.SE3.Identity(), opening=0.03, grip=0.02, **fields)


def names(library: GraspLibrary) -> list[str]:
    return [entry.name for entry in library.entries]


def test_entries_are_replaced_in_place_and_added_at_the_end():
    a, b, c, d = (grasp(name) for name in "abcd")
    library = GraspLibrary((a, b, c))
    assert names(edit_library(library, (), (d,))) == ["a", "b", "c", "d"]
    assert names(edit_library(library, (b,), (d,))) == ["a", "d", "c"]
    assert names(edit_library(library, (b, c), (d,))) == ["a", "d"]
    assert names(edit_library(library, (c, a), (d,))) == ["b", "d"]
    assert names(edit_library(library, (a, b, c), ())) == []
    with pytest.raises(InputError, match="somebody has removed it"):
        edit_library(library, (d,), ())
    with pytest.raises(InputError, match="changed by somebody else"):
        edit_library(library, (replace(a, opening=0.05),), ())
    with pytest.raises(InputError, match="'c' would be used twice"):
        edit_library(library, (a,), (c,))


def test_a_pattern_may_not_stand_for_a_name_that_is_taken():
    single = grasp("p-1-2")
    pattern = GraspPattern(grasp("p"), np.array([0.0, 0, 1]), (0.0, 1.0))
    with pytest.raises(InputError, match="'p-1-2' would be used twice"):
        edit_library(GraspLibrary((single,)), (), (pattern,))
    assert names_in((pattern,)) == ["p", "p-1-1", "p-1-2"]


@pytest.mark.parametrize(
    ("taken", "name", "free"),
    [((), "a", "a"), (("a",), "a", "a-2"), (("a", "a-2"), "a-2", "a-3"), (("7",), "7", "7-2")],
)
def test_names_that_are_free(taken, name, free):
    assert free_name(taken, name) == free


@given(position=st.tuples(LENGTHS, LENGTHS, LENGTHS), angles=st.tuples(ANGLES, ANGLES, ANGLES))
def test_mirrored_twice_is_as_before_and_always_a_pose(position, angles):
    one = grasp(T=pose_from_rpy(position, angles), approach=np.array([0.6, 0.0, 0.8]))
    normal = np.array([0.0, 0.6, 0.8])
    image = mirror_entry(one, normal)
    assert np.linalg.det(image.T_part_tcp.rotation) == pytest.approx(1.0)
    M = np.eye(3) - 2 * np.outer(normal, normal)
    world = image.T_part_tcp.rotation @ image.approach
    assert np.allclose(world, M @ one.T_part_tcp.rotation @ one.approach)
    back = mirror_entry(image, normal)
    assert np.allclose(back.T_part_tcp.homogeneous, one.T_part_tcp.homogeneous, atol=1e-12)
    assert np.allclose(back.approach, one.approach)


def test_a_mirrored_pattern_stands_for_the_mirrored_grasps():
    T = pose_from_rpy((0.01, 0.02, 0.03), (0.1, 0.2, 0.3))
    pattern = GraspPattern(
        grasp(T=T),
        axis=np.array([0.0, 0.6, 0.8]),
        angles=(0.0, 0.7),
        offsets=(0.0, 0.01),
        through=np.array([0.01, 0.0, 0.0]),
        across=np.array([1.0, 0.0, 0.0]),
        across_offsets=(0.0, 0.02),
    )
    normal = np.array([1.0, 0.0, 0.0])
    image = mirror_entry(pattern, normal)
    assert isinstance(image, GraspPattern)
    assert len(image.grasps) == pattern.count == 8
    for one, other in zip(pattern.grasps, image.grasps, strict=True):
        single = mirror_entry(one, normal)
        assert np.allclose(single.T_part_tcp.homogeneous, other.T_part_tcp.homogeneous)


def test_a_pattern_turns_last_so_that_a_grid_goes_around_with_its_face():
    T = pin.SE3(np.eye(3), np.array([0.02, 0.0, 0.0]))
    pattern = GraspPattern(
        grasp(T=T),
        axis=np.array([0.0, 0.0, 1.0]),
        angles=(0.0, np.pi / 2),
        across=np.array([0.0, 1.0, 0.0]),
        across_offsets=(-0.01, 0.01),
    )
    places = {g.name: np.round(g.T_part_tcp.translation, 6).tolist() for g in pattern.grasps}
    assert places == {
        "g-1-1-1": [0.02, -0.01, 0.0],
        "g-1-1-2": [0.02, 0.01, 0.0],
        "g-1-2-1": [0.01, 0.02, 0.0],
        "g-1-2-2": [-0.01, 0.02, 0.0],
    }


def test_a_symmetry_multiplies_grasps_and_leaves_out_grips_that_are_there():
    part = read_part("keyed_cylinder")
    side = part.library.entries[0]
    hexagon = replace(part, library=GraspLibrary((side.grasp,)), symmetry=Symmetry(fold=6))
    assert [g.name for g in hexagon.grasps] == [
        "side",
        "side@60",
        "side@120",
        "side@180",
        "side@240",
        "side@300",
    ]
    fives = replace(part, symmetry=Symmetry(fold=5))
    assert len(fives.grasps) == 15, "the pattern has them all already"
    top = grasp("top", pose_from_rpy((0, 0, 0.04), (np.pi, 0, 0)), free_rotation=np.pi)
    anyhow = replace(part, library=GraspLibrary((top,)), symmetry=Symmetry(fold=0))
    assert len(anyhow.grasps) == 1, "a turn about the tool's own axis is no other grip"


def test_fingers_that_change_places_are_the_same_grip_and_a_cup_has_none():
    flipped = pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    assert is_same_grip(grasp(), grasp(T=flipped))
    cup = Grasp("c", pin.SE3.Identity(), 0.0, 0.0)
    assert not is_same_grip(cup, replace(cup, T_part_tcp=flipped))
    assert not is_same_grip(grasp(), grasp(arms=("left",)))
    assert not is_same_grip(grasp(), grasp(T=pose_from_rpy((0.001, 0, 0))))


def test_pairs_allow_what_they_name_in_their_order():
    pattern = GraspPattern(grasp("p"), np.array([0.0, 0, 1]), (0.0, 1.0))
    entries = (pattern, grasp("a"), grasp("b"))
    free = GraspLibrary(entries)
    assert free.allows("p-1-1", "a") and free.allows("b", "b")
    pairs = (GraspPair("p", "a", is_ordered=True), GraspPair("a", "b"))
    library = GraspLibrary(entries, pairs)
    assert library.allows("p-1-2", "a")
    assert library.allows("p-1-2@180", "a"), "what a symmetry makes of it counts too"
    assert not library.allows("a", "p-1-2")
    assert library.allows("a", "b") and library.allows("b", "a")
    assert not library.allows("p-1-1", "b")


@pytest.mark.parametrize("fold", [0, 7, 10])
def test_no_grip_of_a_symmetry_is_left_out_or_there_twice(fold):
    part = read_part("keyed_cylinder")
    top = grasp("top", pose_from_rpy((0, 0, 0.04), (np.pi, 0, 0)))
    symmetric = replace(part, library=replace(part.library, entries=(*part.library.entries, top)))
    symmetric = replace(symmetric, symmetry=Symmetry(fold=fold))
    found = list(symmetric.library.grasps)
    for one in symmetric.library.grasps:
        for _, motion in symmetric.symmetry.turns:
            copy = replace(one, T_part_tcp=motion * one.T_part_tcp)
            if not any(is_same_grip(known, copy) for known in found):
                found.append(copy)
    assert len(symmetric.grasps) == len(found)
    for one, other in zip(symmetric.grasps, found, strict=True):
        assert np.allclose(one.T_part_tcp.homogeneous, other.T_part_tcp.homogeneous)
