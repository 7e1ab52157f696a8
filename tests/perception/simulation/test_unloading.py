"""A part lifted out of a pile, and what becomes of the others."""

from dataclasses import replace
from itertools import product

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry
from workbench.perception.simulation.physics import model_of
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.unloading import is_in_bin, left_of, unloaded


def up(T: pin.SE3, far: float = 0.15) -> list[pin.SE3]:
    return [T, pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, far]))]


def moved(before: Detection, after: Detection) -> float:
    return float(np.linalg.norm(before.T_world_part.translation - after.T_world_part.translation))


@pytest.fixture(scope="module")
def heap(cell, part):
    return drop_parts((part,) * 12, cell.bin, seed=5)


def height(one: Detection) -> float:
    return float(one.T_world_part.translation[2])


def test_what_lay_on_the_part_is_pushed_away_or_falls(cell, heap):
    lowest = min(range(len(heap)), key=lambda k: height(heap[k]))
    rest = unloaded(cell, heap, lowest, up(heap[lowest].T_world_part))
    others = [one for k, one in enumerate(heap) if k != lowest]
    assert len(rest) == len(others)
    assert max(map(moved, others, rest)) > 0.005


def turned(before: Detection, after: Detection) -> float:
    R = before.T_world_part.rotation.T @ after.T_world_part.rotation
    return float(np.linalg.norm(pin.log3(R)))


@pytest.mark.parametrize("seed", [5, 31, 32, 33])
def test_a_pile_at_rest_stays_at_rest_when_nothing_touches_it(cell, part, seed):
    pile = drop_parts((part,) * 4, cell.bin, seed=seed)
    far = Detection(part.name, cell.bin.T_world_bin * pose_from_rpy((0, 0, 2.0)))
    rest = unloaded(cell, (*pile, far), 4, up(far.T_world_part))
    assert max(map(moved, pile, rest)) < 0.0005
    assert max(map(turned, pile, rest)) < np.deg2rad(0.5)


def test_the_last_part_leaves_nothing(cell, pile):
    assert unloaded(cell, pile[:1], 0, up(pile[0].T_world_part)) == ()


def test_a_part_beside_the_bin_is_not_in_it(cell, part):
    beside = pose_from_rpy((0, cell.bin.size[1], 0.02))
    assert is_in_bin(cell.bin, part, cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.02)))
    assert not is_in_bin(cell.bin, part, cell.bin.T_world_bin * beside)


def test_a_part_whose_frame_is_at_its_edge_lies_in_the_bin_where_that_sinks_into_the_floor(cell):
    bracket = read_part("bracket")
    sunk = pose_from_rpy((0.01, 0.0, -0.0003))
    assert is_in_bin(cell.bin, bracket, cell.bin.T_world_bin * sunk)
    assert not is_in_bin(cell.bin, bracket, cell.bin.T_world_bin * pose_from_rpy((0, 0, -0.2)))


def test_flat_parts_of_many_pieces_keep_all_their_contacts_with_the_floor(cell, part):
    turns = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    Ts = [pin.SE3(pin.exp3(np.array([0.0, 0.0, a])), np.zeros(3)) for a in turns]
    away = pin.SE3(np.eye(3), np.array([0.005, 0.0, 0.0]))
    block = Box(np.array([0.004, 0.0014, 0.005]))
    pieces = tuple(Solid(f"block_{k}", block, T * away) for k, T in enumerate(Ts))
    ring = replace(part, pieces=pieces, library=GraspLibrary(), symmetry=Symmetry())
    model = model_of([ring] * 12, cell.bin)
    data = mujoco.MjData(model)
    for number, place in enumerate(product((-0.06, -0.02, 0.02, 0.06), (-0.05, 0.0, 0.05))):
        data.qpos.reshape(-1, 7)[number, :3] = (*place, 0.0024)
    mujoco.mj_fwdPosition(model, data)
    assert data.ncon >= 12 * len(pieces)
    assert data.warning[mujoco.mjtWarning.mjWARN_CNSTRFULL].number == 0


def test_what_was_taken_is_gone_and_the_rest_lies_where_it_did(cell, heap):
    seen = [
        pin.SE3(heap[k].T_world_part.rotation, heap[k].T_world_part.translation + 1e-3)
        for k in (11, 4)
    ]
    rest = left_of(cell, heap, seen)
    assert len(rest) == 10
    kept = [one for k, one in enumerate(heap) if k not in (4, 11)]
    assert sum(moved(a, b) < 0.01 for a, b in zip(kept, rest, strict=True)) >= 5
    elsewhere = pin.SE3(np.eye(3), np.array([9.0, 0.0, 0.0]))
    assert left_of(cell, heap, (elsewhere,)) == heap and left_of(cell, heap, ()) == heap
