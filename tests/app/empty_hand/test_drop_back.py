"""A drop back, planned from where an arm stands: what is refused, and what its file states."""

from dataclasses import replace

import numpy as np
import pytest
from dropping import OVER_BIN

from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.cli.main import main
from workbench.cli.picking import planning
from workbench.cli.picking.planning import _joints_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.candidate import Reason
from workbench.model.derived.controller_axes import shown_axes
from workbench.model.errors import InputError
from workbench.model.robot import AxisMapping
from workbench.model.tools.held_body import (
    HeldAmount,
    held_labels,
    held_radius,
    recipe_problem,
    with_held,
)
from workbench.planning.collision.world import World
from workbench.plugins.robot_link import spoken_to_by


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


def test_a_file_states_what_the_hand_holds(cell, tmp_path):
    plan = plan_drop_back(cell, "right", OVER_BIN, HeldAmount.ONE).plan
    write_plan(tmp_path / "plan.json", plan)
    again, _ = read_plan(tmp_path / "plan.json")
    assert again.arms[0].held == "one" and again.digest == plan.digest
    assert again.is_drop_plan and not again.is_view_plan


def test_a_ball_that_meets_something_at_the_start_is_named(cell):
    verdict = plan_drop_back(cell, "right", cell.arm("right").home, HeldAmount.ONE).verdict
    assert verdict.reason is Reason.IN_COLLISION
    assert "body and the part in the right hand" in str(verdict)
    for held in (HeldAmount.TWO, HeldAmount.UNKNOWN):
        verdict = plan_drop_back(cell, "right", OVER_BIN, held).verdict
        assert "the ball of what is held meets arm right" in str(verdict)


def test_a_link_that_opens_the_hand_first_is_refused(cell):
    other = spoken_to_by(cell, "abb-egm")
    with pytest.raises(InputError, match="cannot begin a plan with a part in the hand"):
        plan_drop_back(other, "right", cell.arm("right").home, HeldAmount.ONE)


def test_what_is_less_known_needs_more_room(cell):
    one, two, unknown = (held_radius(cell, held) for held in HeldAmount)
    assert 0.09 < one < two == unknown
    tool = cell.arm("right").tool
    bare = replace(cell, parts=tuple(replace(part, mass=0.2) for part in cell.parts))
    heavy = with_held(bare, "right", HeldAmount.TWO).arm("right").tool
    assert tool.mass is None or heavy.mass == pytest.approx(tool.mass + 0.2)


def test_boxes_hold_the_fingers_at_every_opening(cell):
    holding = with_held(cell, "right", HeldAmount.ONE)
    assert len(held_labels(holding)) == 1 + len(cell.arm("right").tool.fingers)
    solids = {solid.name: solid for solid in holding.arm("right").tool.body}
    for finger in cell.arm("right").tool.fingers:
        box = solids[f"held_body_{finger.solid.name}"]
        T = box.T_owner_shape.inverse() * finger.solid.T_owner_shape
        for share in (0.0, 0.5, 1.0):
            moved = T.translation + T.rotation @ (
                finger.solid.T_owner_shape.rotation.T @ finger.direction
            ) * (share * 0.05 / 2)
            reach = abs(T.rotation) @ (finger.solid.shape.size / 2)
            assert (abs(moved) + reach <= box.shape.size / 2 + 1e-9).all()


def test_it_is_typed_with_the_axes_that_the_controller_shows(cell, tmp_path, capsys):
    arm, out = cell.arm("right"), tmp_path / "plan.json"
    q = World(cell, (), ()).motion.rounded(OVER_BIN)
    axes = ",".join(f"{value:.2f}" for value in arm.to_axes(q) * 57.29577951308232)
    typed = ["plan", "yumi", "--out", str(out), "--drop-back", "one", "--strategy", "right"]
    assert main([*typed, f"--joints={axes}"]) == 0
    assert "drops back what it holds (one)" in capsys.readouterr().out
    assert read_plan(out)[0].arms[0].held == "one"
    assert main([*typed, "--joints=1,2"]) == 2
    assert main([*typed, "--joints=0,0,0,0,0,0,999"]) != 0, "no joint goes there"


def test_a_recipe_that_leaves_kinds_out_is_refused(monkeypatch, tmp_path, capsys):
    whole = read_cell("yumi")
    fewer = replace(whole, parts=())
    assert recipe_problem(whole, whole) is None
    monkeypatch.setattr(planning, "_chosen", lambda typed: fewer)
    out = str(tmp_path / "plan.json")
    assert main(["plan", "yumi", "--out", out, "--drop-back", "one"]) == 2
    assert "which the recipe leaves out" in capsys.readouterr().err


def test_typed_axes_are_read_as_the_controller_counts_them_coupled_and_shifted(cell):
    arm = read_cell("tx2_90").arms[0]
    coupling = np.eye(6)
    coupling[2, 1] = -1.0
    arm = replace(arm, mapping=AxisMapping(coupling, np.deg2rad([0.0, 5.0, 0.0, 0.0, 0.0, 0.0])))
    coupled = replace(read_cell("tx2_90"), arms=(arm,))
    q = arm.home + np.deg2rad([0.0, 30.0, 0.0, 10.0, 0.0, 0.0])
    typed = ",".join(f"{value:.4f}" for value in shown_axes(coupled, arm, q))
    assert np.allclose(_joints_of(coupled, arm, typed), q, atol=1e-6)
