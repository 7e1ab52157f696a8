"""Cells with one arm of any name and with three arms, over real TCP."""

import time
from dataclasses import replace

import pytest
from patient import running, send
from three_arms import write_cell

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import pose_from_rpy
from workbench.model.release import Approval
from workbench.model.scan import Detection
from workbench.plugins.robot_link import controller_by

PARTS = tuple(Detection("puck", pose_from_rpy((x, -0.08, 0.0075))) for x in (-0.1, 0.1))


def sent(cell, controller, strategy, protocol="abb-socket/2"):
    """A plan, and the receipts of its sending to that controller."""
    address = controller_by(protocol, "127.0.0.1", controller.port, controller.state_port)
    cell = replace(cell, controller=address)
    result = plan_pick(cell, PARTS, "scan", strategy=strategy, seed=0)
    assert result.proof.holds
    now, plan = time.time(), result.plan
    approval = Approval(plan.digest, "proof", cell.digest, "scan", "tester", now, now + 3600)
    return plan, list(send(plan, approval, cell))


@pytest.mark.parametrize("protocol", ["abb-socket", "abb-socket/2"])
def test_the_only_arm_is_sent_whatever_it_is_called(tmp_path, protocol):
    cell = read_cell(write_cell(tmp_path / "cell", ("manipulator",)))
    with running(cell) as controller:
        _, receipts = sent(cell, controller, "auto", protocol)
        assert controller.state()["placed"] == 1
    assert {one.arm for one in receipts} - {""} == {"manipulator"}


@pytest.mark.parametrize("strategy", ["alternated", "coordinated", "north"])
def test_arms_that_do_nothing_are_told_where_they_stand(tmp_path, strategy):
    cell = read_cell(write_cell(tmp_path / "cell"))
    with running(cell) as controller:
        plan, receipts = sent(cell, controller, strategy)
        assert controller.state()["placed"] == len(plan.arms)
    starts = {one.arm for one in receipts if one.kind == "start"}
    assert starts == {arm.name for arm in cell.arms}
    assert {one.arm for one in receipts if one.kind == "leg"} == {one.arm for one in plan.arms}


def test_a_controller_with_fewer_arms_is_refused_before_anything_is_loaded(tmp_path):
    cell = read_cell(write_cell(tmp_path / "cell"))
    with running(replace(cell, arms=cell.arms[:2])) as controller:
        with pytest.raises(ProtocolError, match="has the arms A6 B6, cell around A6 B6 C6"):
            sent(cell, controller, "alternated")
        assert controller.state()["received"] <= 2, "more than hello and abort came"
