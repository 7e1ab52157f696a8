"""A session is computed again task by task, whoever began each."""

import pytest
from prepared_bench import Canned, make_results
from waiting import PATIENCE

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.review import recompute
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal


@pytest.fixture
def session(tmp_path):
    """A cycle and what was gone on to after it; its folder, and the results of its tasks."""
    results = make_results()

    def effects(cell, do, now):
        return Canned(results, do)

    bench = Bench(results.cell, Journal(tmp_path / "session"), effects=effects)

    def reach(phase):
        state = bench.wait(lambda state: state.phase == phase and not state.job, PATIENCE)
        assert state.phase == phase, state.message

    digest = results.planned.plan.digest
    for command, phase in (
        (TakeScan(), "scanned"),
        (FindParts(), "localized"),
        (MakePlan(), "planned"),
        (WatchPlan(digest), "planned"),
        (Approve(digest), "approved"),
        (SendPlan(digest), "done"),
        (GoOn(), "planned"),
    ):
        bench.do(command, "ada")
        reach(phase)
    bench.close()
    return tmp_path / "session", results


def test_tasks_that_were_gone_on_to_are_computed_again_too(session, monkeypatch):
    folder, results = session
    asked = []

    def job(name, result):
        def run(cell, arguments, report, cancelled):
            asked.append((name, arguments.get("scan", results.scan)))
            return result

        return run

    jobs = {"scan": results.scan, "localize": results.detections, "plan": results.planned}
    monkeypatch.setattr(recompute, "JOBS", {name: job(name, one) for name, one in jobs.items()})
    found = list(recompute.recompute_tasks(Journal(folder)))
    assert [one.task for one in found] == ["scan", "localize", "plan"] * 2
    assert all(one.says == "equal" for one in found)
    # Those after the first began with the end of the one before.
    assert [one.number for one in found][3:] == [12, 13, 14]
    assert [name for name, _ in asked] == ["scan", "localize", "plan"] * 2
    assert all(scan.digest == results.scan.digest for _, scan in asked)
