"""Parts that no grasp of the tool can take, and parts that some could."""

from dataclasses import replace

from workbench.app.emptying.bound import any_grasp, bound_of, holdable
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection


def lying(cell, x: float, y: float = 0.0) -> Detection:
    T = cell.bin.T_world_bin * pose_from_rpy((x, y, 0.019), (0, 1.5707963, 0))
    return Detection(cell.parts[0].name, T)


def test_a_part_that_lies_free_is_taken_by_some_grasp_whatever_its_library_holds():
    cell = read_cell("yumi")
    bare = replace(cell, parts=(replace(cell.parts[0], library=GraspLibrary(())),))
    found = any_grasp(bare, (lying(bare, 0.0),), 0, seed=0)
    assert found.pick is not None and 0 < found.holds <= found.fits < found.tried
    assert "not in the library" in str(found.message)
    assert holdable(bare, (lying(bare, 0.0),), seed=0) == 1
    told, taken = bound_of(bare, (lying(bare, 0.0),), settles=False, seed=0)
    assert taken == 1 and told[0].pick is not None


def test_no_grasp_takes_a_part_that_lies_within_another():
    cell = read_cell("yumi")
    pile = (lying(cell, 0.0), lying(cell, 0.004))
    assert holdable(cell, pile, seed=0) == 0
    told, taken = bound_of(cell, pile, settles=False, seed=0)
    assert taken == 0 and all(one.pick is None for one in told)
    assert all(str(one.message).startswith("no grasp takes it (of ") for one in told)


def test_a_cup_is_tried_all_over_a_part():
    cell = read_cell("tx2_90")
    T = cell.bin.T_world_bin * pose_from_rpy((0.05, 0.1, 0.007))
    found = any_grasp(cell, (Detection("puck", T),), 0, seed=0)
    assert found.pick is not None and found.holds > 0
