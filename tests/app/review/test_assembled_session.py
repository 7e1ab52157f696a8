"""A session in which a kit is assembled: sent part by part, and computed again."""

import pytest
from assembling_sessions import Remembering, carry_out, lying, plan

from workbench.app.core.cell.kits import NewKit, lacks_of
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import ROBOT_LINK
from workbench.app.picking.pallets import at_rest
from workbench.app.records.replay import replay
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal
from workbench.model.candidate import Reason
from workbench.model.digest import digest_of
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.release import PartReport


@pytest.fixture
def bench(tmp_path):
    made = []

    def effects(cell, do, now):
        made.append(Remembering(cell, do, now))
        return made[-1]

    cell = read_cell(find("robots", "yumi") / "assembly.toml")
    bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
    bench.do(ChooseRecipe(1), "ada")
    bench.remembered = made[-1].started
    yield bench
    bench.close()


def test_a_kit_is_assembled_and_the_session_is_computed_again(bench, tmp_path):
    bolt, spacer = lying()
    first = plan(bench, (bolt, spacer))
    assert first.proof is not None and first.proof.holds
    assert first.plan.detections[first.plan.picks[0].detection].part == "bolt"
    carry_out(bench, first)
    assert lacks_of(bench.state) == {"spacer": 1}
    second = plan(bench, (spacer,))
    assert second.proof is not None and second.proof.holds, str(second.verdict)
    assert [box.part for box in second.plan.obstacles] == ["bolt"]
    carry_out(bench, second)
    assert lacks_of(bench.state) == {}
    placed = bench.state.placed
    stands, seated = at_rest(bench.state.cell, placed)
    off = stands.actInv(seated)
    # The page draws them there: the spacer on the head of the bolt.
    assert [one.part for one in placed] == ["bolt", "spacer"]
    assert abs(off.translation - [0.0, 0.0, -0.015]).max() < 5e-4
    bench.do(NewKit(), "ada")
    assert bench.state.placed == () and bench.state.kit.complete == 1
    last = bench.state
    bench.close()
    *_, (_, again) = replay(
        Journal(tmp_path / "session"), read_cell(find("robots", "yumi") / "assembly.toml")
    )
    assert digest_of(again) == digest_of(last)
    tasks = list(recompute_tasks(Journal(tmp_path / "session")))
    assert [(task.task, task.says) for task in tasks] == [("plan", "equal")] * 2


def test_one_approval_of_a_row_assembles_a_whole_kit(bench):
    result = plan(bench, lying(), picks=2)
    assert len(result.plans) == 2 and all(one.proof.holds for one in result.row)
    first, second = result.plans
    row = (second.digest,)
    bench.do(WatchPlan(first.digest, row=row), "ada")
    bench.do(Approve(first.digest, row=row), "ada")
    bench.do(SendPlan(first.digest), "ada")
    for one in result.plans:
        assert bench.state.plan.digest == one.digest
        (pick,) = one.picks
        parts = (PartReport(pick.arm, pick.detection, True),)
        bench.do(LinkEnded(parts_placed=1, parts=parts), ROBOT_LINK)
    assert lacks_of(bench.state) == {} and len(bench.state.placed) == 2


def test_onto_a_part_that_may_have_fallen_nothing_is_put_until_a_new_kit_is_begun(bench):
    bolt, spacer = lying()
    first = plan(bench, (bolt, spacer))
    carry_out(bench, first)
    number = first.plan.picks[0].detection
    bench.do(ReportPick(number, is_picked=False, why="it fell"), "ada")
    assert lacks_of(bench.state) == {"bolt": 1, "spacer": 1}
    bench.do(ReportPick(number, is_picked=True), "ada")
    assert lacks_of(bench.state) == {"spacer": 1}
    refused = plan(bench, (spacer,))
    assert refused.plan is None and refused.verdict.reason is Reason.NO_PLACE
    assert refused.verdict.note == VerdictNote.NO_BASE(base="bolt")
    bench.do(NewKit(), "ada")
    assert lacks_of(bench.state) == {"bolt": 1, "spacer": 1}
