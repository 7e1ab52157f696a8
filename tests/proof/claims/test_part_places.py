"""A part has to lie where the cell wants it: asked again by the proof, with its own search."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_nests
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace
from workbench.model.symmetry import Symmetry, SymmetryAxis, make_turn
from workbench.proof.claims.places.placed_poses import place_offs

X, Y, Z = np.eye(3)


@pytest.fixture(scope="module")
def nests(cell):
    return with_nests(cell, part="keyed_cylinder")


@pytest.fixture(scope="module")
def plan(nests, detections):
    return plan_pick(nests, detections[:1], "scan", seed=0).plan


def refusals(cell: Cell, plan) -> list[str]:
    """What a proof of the plan says in a cell that differs in its places alone."""
    proof = prove(cell, replace(plan, cell_digest=cell.digest))
    return [str(violation) for violation in proof.violations]


def shifted(cell: Cell, way: pin.SE3, **changes) -> Cell:
    """The cell with what it wants moved in the frame of the part."""
    arms = tuple(
        replace(
            arm,
            part_places=tuple(
                replace(one, T_world_part=one.T_world_part * way, **changes)
                for one in arm.part_places
            ),
        )
        for arm in cell.arms
    )
    return replace(cell, arms=arms)


@pytest.mark.parametrize(
    ("xyz", "rpy_deg", "holds"),
    [
        ((0.0, 0.0, 0.0), (0, 0, 0), True),
        ((0.0015, 0.0, 0.0), (0, 0, 0), True),
        ((0.0025, 0.0, 0.0), (0, 0, 0), False),
        ((0.0, 0.0, -0.0025), (0, 0, 0), False),
        ((0.0, 0.0, 0.0), (0, 0, 2.5), True),
        ((0.0, 0.0, 0.0), (0, 0, -3.5), False),
        ((0.0, 0.0, 0.0), (3.5, 0, 0), False),
        ((0.0, 0.0, 0.0), (180, 0, 0), False),
    ],
)
def test_what_lies_beside_its_place_is_refused_with_how_far(nests, plan, xyz, rpy_deg, holds):
    said = refusals(shifted(nests, pose_from_rpy(xyz, np.deg2rad(rpy_deg))), plan)
    assert (said == []) is holds, said
    if not holds:
        assert any("from its target pose; 2.0 mm and 3.0 deg are allowed" in one for one in said)


def test_a_free_rotation_frees_one_turn_and_no_other(nests, plan):
    free = np.deg2rad(40.0)
    about_z = pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(39)))
    too_far = pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(-47)))
    leaning = pose_from_rpy((0, 0, 0), (0, np.deg2rad(20), 0))
    assert refusals(shifted(nests, about_z, free_rotation=free), plan) == []
    assert refusals(shifted(nests, too_far, free_rotation=free), plan)
    assert refusals(shifted(nests, leaning, free_rotation=np.pi), plan)


def test_a_part_that_does_not_come_as_its_place_says_is_refused(nests, plan):
    here = pin.SE3.Identity()
    lean = np.deg2rad(1.5), np.deg2rad(5.0)
    slightly, clearly = ((0.0, float(np.sin(a)), -float(np.cos(a))) for a in lean)
    assert refusals(shifted(nests, here, approach=slightly), plan) == []
    for approach in (clearly, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)):
        said = refusals(shifted(nests, here, approach=approach), plan)
        assert any("does not come in the direction of its place" in one for one in said), said


def test_a_place_for_another_kind_is_no_place(nests, plan):
    said = refusals(shifted(nests, pin.SE3.Identity(), part="bracket"), plan)
    assert any("the hand opens where the arm has no place" in one for one in said)


def test_a_part_whose_roll_nobody_knows_is_not_proven_to_show_its_key(nests, plan):
    unseen = tuple(replace(one, roll_known=False) for one in plan.detections)
    said = refusals(nests, replace(plan, detections=unseen))
    assert any("its place needs the roll of the part" in one for one in said)
    anyhow = shifted(nests, pin.SE3.Identity(), free_rotation=np.pi)
    said = refusals(anyhow, replace(plan, detections=unseen))
    assert not any("its place needs" in one or "target pose" in one for one in said)


def test_where_the_part_is_in_the_hand_is_what_scan_and_grasp_say(nests, plan):
    """A plan that says otherwise by what a proof lets pass gains nothing at the place."""
    off = pose_from_rpy((0.0009, 0.0, 0.0))
    arms = tuple(replace(one, T_tcp_part=one.T_tcp_part * off) for one in plan.arms)
    moved = shifted(nests, pose_from_rpy((0.0027, 0.0, 0.0)))
    assert any("2.7 mm" in one for one in refusals(moved, replace(plan, arms=arms)))


GROUPS = (
    Symmetry(),
    Symmetry(Z, 2, (0.01, -0.02, 0.005)),
    Symmetry(X, 6, also=(SymmetryAxis(Z, 2),)),
    Symmetry(Y, 0, (0.004, 0.0, 0.01)),
    Symmetry(Z, 0, also=(SymmetryAxis(X, 2),)),
    Symmetry(Z, 0, (0.01, 0.0, 0.0)),
    Symmetry(Z, 0, (0.0, 0.003, 0.0), also=(SymmetryAxis(X, 0),)),
)


def drawn(symmetry: Symmetry, rng: np.random.Generator) -> pin.SE3:
    """A motion of the group, made of turns about its axes alone."""
    T, point = pin.SE3.Identity(), np.array(symmetry.point)
    for _ in range(6):
        for one in symmetry.axes:
            share = rng.random() if one.fold == 0 else rng.integers(one.fold) / one.fold
            T = T * make_turn(one.axis, 2 * np.pi * share, point)
    return T


@settings(max_examples=60, deadline=None)
@given(
    group=st.sampled_from(GROUPS),
    free=st.sampled_from([0.0, 0.3, np.pi]),
    seed=st.integers(0, 2**20),
)
def test_whatever_symmetry_and_place_leave_free_is_found(group, free, seed):
    rng = np.random.default_rng(seed)
    T = pose_from_rpy(rng.uniform(-1, 1, 3), rng.uniform(-1.5, 1.5, 3))
    place = PartPlace(T, free_rotation=free)
    right = T * make_turn(Z, rng.uniform(-free, free)) * drawn(group, rng)
    assert min(max(off) for off in place_offs(place, group, right)) < 1e-5
    # And a small error beside it is found to be no more than it is.
    off = pin.SE3(pin.exp3(0.01 * X), 0.002 * Y)
    offs = place_offs(place, group, right * off)
    assert min(max(far / 0.002, turn / 0.01) for far, turn in offs) < 1.1


@settings(max_examples=20, deadline=None)
@given(
    group=st.sampled_from(GROUPS[:6]), free=st.sampled_from([0.0, 0.3]), seed=st.integers(0, 999)
)
def test_what_is_told_is_never_too_near(group, free, seed):
    """Of poses anywhere none that lies right, tried one by one, is as near as what is told."""
    rng = np.random.default_rng(seed)
    T = pose_from_rpy(rng.uniform(-1, 1, 3), rng.uniform(-1.5, 1.5, 3))
    R = pin.exp3(rng.normal(size=3))
    place = PartPlace(T, free_rotation=free)
    told = min(turn for _, turn in place_offs(place, group, T * pin.SE3(R, np.zeros(3))))
    turns = [make_turn(Z, a).rotation for a in np.linspace(-free, free, 1 if free == 0 else 35)]
    right = np.einsum("aij,mjk->amik", turns, group.motions(180)[:, :3, :3]).reshape(-1, 3, 3)
    cosines = (np.einsum("nij,ij->n", right, R) - 1) / 2
    assert told > np.arccos(np.clip(cosines, -1, 1)).min() - np.deg2rad(2.1)
