"""Parts of unknown roll: taken where every turn will do, else refused for that."""

from dataclasses import replace

import pytest
from bending import with_grasps

from workbench.app.core.state import State
from workbench.app.picking.fixing import make_fix_command
from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.model.candidate import Reason
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.planning.picking.nearest_fix import ROLL_CHANGE, Fixes, nearest_fix


@pytest.fixture(scope="module")
def rolled(detections):
    return tuple(replace(one, roll_known=False) for one in detections)


@pytest.fixture(scope="module")
def over_key(cell):
    """Every grasp 30 mm further along the part: the pads may be where the key is."""
    return with_grasps(
        cell, lambda g: replace(g, T_part_tcp=pose_from_rpy((0, 0, 0.03)) * g.T_part_tcp)
    )


@pytest.fixture(scope="module")
def judged(over_key, rolled):
    return judge(over_key, rolled)


def test_grasps_beside_the_key_take_a_part_whatever_its_roll(cell, rolled):
    result = plan_pick(cell, rolled, "scan", seed=0)
    assert result.plan is not None and result.proof is not None
    assert result.proof.holds, [str(violation) for violation in result.proof.violations]
    assert not any(one.roll_known for one in result.plan.detections)


def test_grasps_over_the_key_are_refused_for_the_roll_with_a_number(over_key, detections, judged):
    as_found = {(c.detection, c.grasp.name, c.arm): c.verdict for c in judge(over_key, detections)}
    assert any(verdict.is_ok for verdict in as_found.values())
    assert not any(one.verdict.is_ok for one in judged)
    would_do = [c for c in judged if as_found[c.detection, c.grasp.name, c.arm].is_ok]
    for one in would_do:
        assert one.verdict.reason is Reason.ROLL_UNKNOWN
        assert one.verdict.note.mentions(VerdictNote.ROLL_UNSEEN)
        assert one.verdict.pair is not None and one.verdict.pair[1] == f"part-{one.detection + 1}"
        assert any(letter.isdigit() for letter in str(one.verdict))


def test_the_nearest_fix_leads_beside_the_key_or_asks_for_the_roll(
    over_key, rolled, detections, judged
):
    fix = nearest_fix(over_key, rolled, judged, seed=0)
    assert fix is not None
    fixes = Fixes(over_key, rolled, seed=0)
    as_found = {(c.detection, c.grasp.name, c.arm): c.verdict for c in judge(over_key, detections)}
    one = next(c for c in judged if as_found[c.detection, c.grasp.name, c.arm].is_ok)
    shown = fixes.of(one)[-1]
    assert fixes.admits(shown)
    assert (shown.change, shown.grasp, shown.policy) == (ROLL_CHANGE, None, None)
    with pytest.raises(InputError, match="this change cannot be made here"):
        make_fix_command(State(over_key, detections=rolled, candidates=(one,)), shown)
    known = Fixes(over_key, detections, seed=0).of(one)
    assert ROLL_CHANGE not in {fix.change for fix in known}


def test_places_that_need_the_roll_take_no_part_without_it(cell, detections, rolled):
    careful = replace(cell, arms=tuple(replace(arm, needs_roll=True) for arm in cell.arms))
    refused = judge(careful, rolled)
    assert {one.verdict.reason for one in refused} == {Reason.ROLL_UNKNOWN}
    assert "places of arm right need the roll" in str(
        next(one.verdict for one in refused if one.arm == "right")
    )
    assert any(one.verdict.is_ok for one in judge(careful, detections))


def test_one_unknown_roll_leaves_the_other_part_as_it_is(cell, detections, rolled):
    mixed = (detections[0], rolled[1])
    before = [c for c in judge(cell, detections) if c.detection == 0]
    after = [c for c in judge(cell, mixed) if c.detection == 0]
    key = [(c.grasp.name, c.arm, c.verdict.reason) for c in before]
    assert sorted(key) == sorted((c.grasp.name, c.arm, c.verdict.reason) for c in after)
