"""Whatever nobody has thought of goes wrong: it is told, and nothing seems to go on for ever."""

import dataclasses
from pathlib import Path

import pytest
from controller_ports import at
from waiting import PATIENCE, wait_until

from workbench.app.core.cell.changes import ChangeCell, SaveCell
from workbench.app.core.cell.part_edits import DropDraft
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.state import Phase
from workbench.app.runtime import effect_runner
from workbench.app.runtime.robot_link import LinkRunner


@pytest.mark.parametrize("broken", ["_parts", "_await_rest", "_end"])
def test_whatever_goes_wrong_at_the_end_of_a_sending_it_is_a_fault_on_record(
    cell, controller, bench_at, monkeypatch, broken
):
    whole = getattr(LinkRunner, broken)

    def fail(self, fault="", *more):
        if broken == "_end" and not more:
            return whole(self, fault)
        raise RuntimeError("what nobody thought of")

    monkeypatch.setattr(LinkRunner, broken, fail)
    simulated = controller(speed=0.001)
    bench = bench_at(at(cell, simulated.port, simulated.state_port))
    bench.do(SendPlan(bench.state.plan.digest), "ada")
    bench.wait(lambda state: len(state.receipts) == 2, PATIENCE)
    bench.do(Stop(), "ada")
    state = bench.wait(lambda state: state.phase is Phase.FAULT, PATIENCE)
    says = "internal error" if broken == "_await_rest" else "sending was stopped"
    assert says in str(state.fault)
    wait_until(lambda: bench.live.link.phase == "closed")


def test_a_cell_that_could_not_be_written_is_told_whatever_the_reason(bench, cell, monkeypatch):
    def fail(*arguments):
        raise RuntimeError("what nobody thought of")

    monkeypatch.setattr(effect_runner, "read_cell", fail)
    monkeypatch.setattr(bench._effects, "_cell_file", Path("cell.toml"))
    bench.do(ChangeCell(dataclasses.replace(cell, name="other"), "renamed"), "ada")
    bench.do(SaveCell("why"), "ada")
    state = bench.wait(lambda state: state.cell_problem != "", PATIENCE)
    assert "internal error" in state.cell_problem
    assert "what nobody thought of" in state.cell_problem


def test_a_draft_that_could_not_be_kept_is_in_the_log_whatever_the_reason(
    bench, cell, monkeypatch, caplog
):
    def fail(*arguments):
        raise RuntimeError("what nobody thought of")

    monkeypatch.setattr(effect_runner, "part_folders", fail)
    monkeypatch.setattr(bench._effects, "_cell_file", Path("cell.toml"))
    bench.do(DropDraft(cell.parts[0].name), "ada")
    wait_until(lambda: "what nobody thought of" in caplog.text)
