"""Why a part stayed."""

import pytest

from workbench.app.emptying.remaining_parts import left_in
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.scan import Detection


def lying(cell, x: float) -> Detection:
    T = cell.bin.T_world_bin * pose_from_rpy((x, 0, 0.019), (0, 1.5707963, 0))
    return Detection(cell.parts[0].name, T)


@pytest.mark.extensive
def test_parts_are_named_as_they_fell_with_the_verdict_that_got_furthest():
    cell = read_cell("yumi")
    # The second one lies within the first: nothing can take either.
    pile = [(3, lying(cell, 0.0)), (8, lying(cell, 0.004))]
    told = left_in(cell, pile, refusal=None, seed=0)
    assert [one.part for one in told] == ["part-4", "part-9"]
    assert all(str(one.reason).startswith("none of 30 candidates works (") for one in told)
    assert any("part-4" in str(one.reason) or "part-9" in str(one.reason) for one in told)
    assert not any("part-1 " in str(one.reason) or "part-2 " in str(one.reason) for one in told)


def test_a_part_that_a_grasp_could_take_says_what_stood_against_the_plan():
    cell = read_cell("yumi")
    refusal = Verdict(Reason.NO_PATH, Stage.ROUTE, note=plain("no way home"))
    (told,) = left_in(cell, [(0, lying(cell, 0.0))], refusal=refusal, seed=0)
    assert told.kind == "no path" and "no way home" in str(told.reason)
    (unseen,) = left_in(cell, [(0, lying(cell, 0.0))], refusal=None, seed=0)
    assert unseen.kind == "not found"


def test_a_part_that_was_found_says_what_stood_against_it_as_it_was_found():
    cell = read_cell("yumi")
    pile = [(3, lying(cell, -0.05)), (8, lying(cell, 0.05))]
    beside = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, pair=("finger", "part-1"))
    other = Verdict(Reason.NO_PLACE, Stage.PLACE)
    # Found the other way round: part-1 is what fell as part-9.
    looked = [(lying(cell, 0.051), other), (lying(cell, -0.049), beside)]
    one, two = left_in(cell, pile, refusal=None, looked=looked, seed=0)
    assert one.kind == "tool collision" and "finger and part-9" in str(one.reason)
    assert two.kind == str(Reason.NO_PLACE) and "not found" not in f"{one.reason} {two.reason}"
    (far,) = left_in(cell, pile[:1], refusal=None, looked=looked[:1], seed=0)
    assert far.kind == "not found"


def test_a_part_left_by_failed_picks_says_that_and_nothing_of_a_plan():
    cell = read_cell("yumi")
    (told,) = left_in(cell, [(0, lying(cell, 0.0))], refusal=None, seed=0, is_stopped=True)
    assert told.kind == "stopped" and "stopped after 3 failed picks in a row" in str(told.reason)
    assert "found" not in str(told.reason) and "no plan" not in str(told.reason)
