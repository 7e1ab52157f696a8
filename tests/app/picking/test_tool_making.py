"""A tool from CAD is carried by an arm, as a task, and a plan is made with it."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from cad_tools import PALM, drawn_gripper, stl
from idle import done
from waiting import PATIENCE

from workbench.app.core.cell.changes import ChangeCell, SaveCell, UndoCell
from workbench.app.core.cell.making import AddTool, carrying
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import WORKER, Role
from workbench.app.core.state import Phase
from workbench.app.picking.tool_making import tool_for
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.drawn_tools import CadDrawing, TwoFingers, made_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.shared.movable_frames import move_frame, pose_of
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused, InputError, JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.plugins.progress import never, silent


@pytest.fixture
def bench(tmp_path, cell_file):
    machines = partial(EffectRunner, cell_file=cell_file)
    bench = Bench(read_cell(cell_file), Journal(tmp_path / "session"), effects=machines)
    yield bench
    bench.close()


def like_the_yumis():
    """The gripper of the YuMi, described anew from the mesh of its palm."""
    palm = (find("robots", "yumi") / "meshes" / "palm.convex.obj").read_bytes()
    return drawn_gripper(
        body=CadDrawing("palm.convex.obj", np.frombuffer(palm, np.uint8), "m"),
        takes_by=TwoFingers(np.array([0.006, 0.01, 0.052]), 0.05),
        begins=0.084,
        is_mended=True,
    )


@pytest.mark.extensive
def test_a_drawn_gripper_is_carried_takes_a_part_and_is_saved(bench, tmp_path, cell_file):
    before, arm = bench.state.cell, bench.state.cell.arms[0].name
    bench.do(AddTool(arm, like_the_yumis()), "ada")
    state = done(bench)
    assert str(state.message) == f"the {arm} arm carries tool drawn; check its TCP"
    assert state.cell.arm(arm).tool.name == "drawn"
    T = pose_of(state.cell, "TCP drawn") * pose_from_rpy((0, 0, 0), (0, 0, -np.pi / 2))
    bench.do(ChangeCell(move_frame(state.cell, "TCP drawn", T), "its TCP is turned"), "ada")

    bench.do(TakeScan(parts=1), "ada")
    assert done(bench).phase is Phase.SCANNED
    bench.do(FindParts(), "ada")
    assert done(bench).phase is Phase.LOCALIZED
    bench.do(MakePlan(strategy=arm), "ada")
    state = done(bench)
    assert state.plan is not None and state.proof.holds, state.message
    assert [one.arm for one in state.plan.arms] == [arm]

    bench.do(SaveCell("another hand"), "ada")
    bench.wait(lambda state: state.saved == state.cell.digest, PATIENCE)
    assert bench.state.cell_problem == ""
    again = read_cell(cell_file).arm(arm)
    assert [tool.name for tool in again.tools] == [before.arm(arm).tool.name, "drawn"]
    np.testing.assert_allclose(again.tool.T_flange_tcp.translation, (0, 0, 0.136), atol=1e-6)
    assert all(
        file.parent == cell_file.parent / "tools" for file in cell_file.parent.rglob("drawn_*")
    )

    digest = bench.state.cell.digest
    bench.close()
    with_it = [state for _, state in replay(Journal(tmp_path / "session"), before)]
    assert with_it[-1].cell.digest == digest, "the same from what is on record"


def test_a_tool_is_undone_and_one_that_was_cancelled_is_not_taken(idle):
    cell = idle.state.cell
    tool = made_of(drawn_gripper())
    idle.do(AddTool("right", drawn_gripper()), "ada")
    number = idle.state.job.number
    idle.do(CancelJob(), "ada")
    idle.do(JobEnded(number, tool), WORKER)
    assert idle.state.cell.digest == cell.digest, "it comes too late"

    idle.do(AddTool("right", drawn_gripper()), "ada")
    idle.do(JobEnded(idle.state.job.number, tool), WORKER)
    assert idle.state.cell.digest == carrying(cell, "right", tool).digest
    assert idle.state.cell.arm("left").tool.name == cell.arm("left").tool.name
    idle.do(UndoCell(), "ada")
    assert idle.state.cell.digest == cell.digest


@pytest.mark.parametrize(
    ("arm", "changed", "says"),
    [
        ("third", {}, "arm 'third'"),
        ("right", {"name": "../hand"}, "letters, digits"),
        ("right", {"name": "smart_gripper"}, "has a tool smart_gripper already"),
        ("right", {"body": CadDrawing("palm.exe", stl(PALM))}, "is no CAD file"),
    ],
)
def test_what_cannot_be_meant_is_refused(idle, arm, changed, says):
    with pytest.raises(CommandRefused, match=says):
        idle.do(AddTool(arm, drawn_gripper(**{"name": "drawn", **changed})), "ada")


def test_an_operator_may_not_add_tools(idle):
    with pytest.raises(CommandRefused, match="engineer"):
        idle.do(AddTool("right", drawn_gripper()), "ada", Role.OPERATOR)


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_a_tool_that_looks_into_its_arm_is_refused(name):
    cell = read_cell(name)
    arm = cell.arms[0].name
    assert tool_for(cell, arm, drawn_gripper(), silent, never).name == "drawn"
    back = replace(drawn_gripper(), T_flange_drawing=pose_from_rpy((0, 0, 0), (np.pi, 0, 0)))
    with pytest.raises(InputError, match=r"reaches into .*link_4 with the arm at home"):
        tool_for(cell, arm, back, silent, never)


def test_a_cancelled_tool_is_not_made():
    with pytest.raises(JobCancelled):
        tool_for(read_cell("yumi"), "right", drawn_gripper(), silent, lambda: True)
