"""A session in which a bolt moves in its nest: seen again, sent, and computed again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from assembling import standing_spacer
from assembling_sessions import Remembering, carry_out, lying, plan

from workbench.app.core.cell.kits import lacks_of
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cycle.ahead import GoOn, _is_view_clear
from workbench.app.core.cycle.empty_hand import may_stir
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import WORKER
from workbench.app.core.state import Ahead, Phase, State
from workbench.app.picking.pallets import at_rest, boxes_around
from workbench.app.records.replay import replay
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.app.runtime.work import JOBS
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal
from workbench.model.derived.assembling import rest_pose
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.digest import digest_of
from workbench.model.messages.cells import SeenBaseText
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent
from workbench.web.api.forms import state_form


def cell_file():
    return read_cell(find("robots", "yumi") / "assembly.toml")


@pytest.fixture
def bench(tmp_path):
    made = []

    def effects(cell, do, now):
        made.append(Remembering(cell, do, now))
        return made[-1]

    bench = Bench(cell_file(), Journal(tmp_path / "session"), effects=effects)
    bench.do(ChooseRecipe(2), "ada")
    bench.remembered = made[-1].started
    carry_out(bench, plan(bench, lying()))
    yield bench
    bench.close()


def plan_after_a_scan(bench: Bench, shift: tuple[float, float]) -> PlanResult:
    """The plan for a spacer, once the bolt that was put down has moved [m] in its nest."""
    cell, (placed,) = bench.state.cell, bench.state.placed
    (rest,) = at_rest(cell, (placed,))
    T = pin.SE3(rest.rotation, rest.translation + [*shift, 0.0])
    sure = np.diag(np.square([1e-4] * 3 + [2e-3] * 3))
    spacer = replace(standing_spacer(cell), covariance=sure)
    bench.do(TakeScan(), "ada")
    scan = synthesize(cell, (spacer, Detection("bolt", T)), seed=4)
    bench.do(JobEnded(bench.state.job.number, scan), WORKER)
    bench.do(FindParts(), "ada")
    bench.do(JobEnded(bench.state.job.number, (spacer,)), WORKER)
    bench.do(MakePlan(threshold=None), "ada")
    job = bench.remembered[-1]
    result = JOBS[job.name](cell, job.arguments, silent, never)
    bench.do(JobEnded(bench.state.job.number, result), WORKER)
    return result


def test_the_spacer_is_sent_to_where_the_bolt_is_seen_and_computed_again(bench, tmp_path):
    result = plan_after_a_scan(bench, (0.004, 0.002))
    assert result.plan is not None and result.proof is not None and result.proof.holds
    (box,) = bench.state.obstacles
    assert box.seen is not None and box.seen.scan == bench.state.scan.digest
    assert box.seen.shift == pytest.approx(np.hypot(4, 2) / 1000, abs=3e-4)
    (base,) = state_form(bench.state, Live())["kit"]["bases"]
    assert (base["part"], base["scan"]) == ("bolt", bench.state.scan.digest)
    assert np.allclose(base["T_world_part"], box.seen.T_world_part.homogeneous)
    assert base["said"]["id"] == SeenBaseText.SEEN.id
    carry_out(bench, result)
    assert lacks_of(bench.state) == {}
    # Nothing lacks on it any more, and paths to views, stirring and changes still avoid it there.
    stands, _ = boxes_around(bench.state.cell, bench.state.placed)
    assert rest_pose(bench.state.cell, stands).isApprox(box.seen.T_world_part, 1e-9)
    assert at_rest(bench.state.cell, bench.state.placed)[0].isApprox(box.seen.T_world_part, 1e-9)
    last = bench.state
    bench.close()
    *_, (_, again) = replay(Journal(tmp_path / "session"), cell_file())
    assert digest_of(again) == digest_of(last)
    plans = [task for task in recompute_tasks(Journal(tmp_path / "session")) if task.task == "plan"]
    assert [task.says for task in plans] == ["equal"] * 2


def test_a_bolt_that_has_moved_too_far_is_reported_and_no_reason_to_stir(bench):
    result = plan_after_a_scan(bench, (0.014, 0.0))
    assert result.plan is None
    note = result.verdict.note
    assert note.text is SeenBaseText.TOO_FAR
    assert str(note) in str(bench.state.message)
    (base,) = state_form(bench.state, Live())["kit"]["bases"]
    assert base["T_world_part"] is None and base["said"]["id"] == SeenBaseText.TOO_FAR.id
    policy = replace(bench.state.cell.policy, stirs=3)
    assert not may_stir(replace(bench.state, cell=replace(bench.state.cell, policy=policy)))


def test_the_next_scan_waits_for_a_bolt_that_is_on_its_way():
    wanted = Ahead(GoOn(sees_from=1, placed=()))
    arrived = (SimpleNamespace(step=3, part=None),)
    by_recipe = {number: with_recipe(cell_file(), number) for number in (1, 2)}
    waits = {
        number: not _is_view_clear(State(cell, phase=Phase.SENDING, receipts=arrived), wanted)
        for number, cell in by_recipe.items()
    }
    assert waits == {1: False, 2: True}
