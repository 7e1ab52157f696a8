"""The shipped cells as they are set up for a full bin."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.picking.judging import judge
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.model.digest import digest_of
from workbench.model.prediction import PileTask
from workbench.model.scan import Detection
from workbench.studies.emptying.piles import empty_pile

both = pytest.mark.parametrize("name", ["yumi", "tx2_90"])


@both
def test_a_cell_for_a_full_bin_is_the_cell_but_for_lifts_fingers_places_and_grasps(name):
    cell, full = read_cell(name), read_cell(find("robots", name) / "full_bin.toml")
    alike = replace(
        full.policy,
        lifts=cell.policy.lifts,
        least_air=cell.policy.least_air,
        pair_gap=cell.policy.pair_gap,
    )
    assert alike == cell.policy and full.policy != cell.policy
    for arm, other in zip(cell.arms, full.arms, strict=True):
        # Its own places first, and then higher ones.
        count = len(arm.Ts_world_place)
        alike = replace(other, Ts_world_place=other.Ts_world_place[:count])
        assert digest_of(alike) == digest_of(arm)
        assert all(
            T.translation[2] > arm.Ts_world_place[0].translation[2]
            for T in other.Ts_world_place[count:]
        )
    for field in ("robot", "bin", "fixtures", "scanner"):
        assert digest_of(getattr(full, field)) == digest_of(getattr(cell, field)), field


@both
def test_the_parts_for_it_are_the_parts_with_spare_grasps(name):
    cell, full = read_cell(name), read_cell(find("robots", name) / "full_bin.toml")
    for part, other in zip(cell.parts, full.parts, strict=True):
        assert part.name == other.name and part.mass == other.mass
        assert digest_of(part.mesh) == digest_of(other.mesh)
        assert digest_of(part.pieces) == digest_of(other.pieces)
        first = [grasp for grasp in other.library.grasps if grasp.priority >= 0]
        assert [digest_of(grasp) for grasp in first] == [
            digest_of(grasp) for grasp in part.library.grasps
        ]
        assert len(other.library.grasps) > len(first)


def test_more_of_a_pile_is_taken_with_it():
    full = str(find("robots", "yumi") / "full_bin.toml")
    usual, more = (empty_pile(PileTask(cell, "", 6, 4, settles=False)) for cell in ("yumi", full))
    assert more.taken > usual.taken
    assert more.touches == 0 and sum(more.failed) == 0


def test_a_cylinder_along_a_wall_is_taken_across_its_collar():
    cell = read_cell(find("robots", "yumi") / "full_bin.toml")
    # Tilted onto collar and key, 17 mm off the wall: fingers find no room beside the body.
    turn = pin.rpy.rpyToMatrix(*np.deg2rad([-84.9, 51.5, 7.2]))
    T_bin_part = pin.SE3(turn, np.array([0.0828, -0.0552, 0.0172]))
    lying = (Detection(cell.parts[0].name, cell.bin.T_world_bin * T_bin_part),)
    taken_by = {one.grasp.name for one in judge(cell, lying) if one.verdict.is_ok}
    assert taken_by and all(name.startswith("rim-") for name in taken_by)


def test_a_bolt_with_its_head_off_the_wall_is_taken_across_the_rim_of_the_head():
    """As one stayed in a pile: there is no room for fingers beside the shank, nor for the palm."""
    bolt = read_part(find("parts", "bolt") / "full_bin")
    cell = replace(read_cell(find("robots", "yumi") / "full_bin.toml"), parts=(bolt,))
    turn = pin.rpy.rpyToMatrix(*np.deg2rad([95.0, 21.8, -82.7]))
    T_bin_part = pin.SE3(turn, np.array([-0.0186, -0.1387, 0.0108]))
    lying = (Detection("bolt", cell.bin.T_world_bin * T_bin_part),)
    taken_by = {one.grasp.name for one in judge(cell, lying) if one.verdict.is_ok}
    assert taken_by and all(name.startswith("rim-") for name in taken_by)
