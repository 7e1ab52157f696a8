"""A cycle that begins with a plan, after a missed grip, is counted as any other."""

from dataclasses import replace

import numpy as np
import pytest
from missed import END, sending, with_policy
from written import Written

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.empty_hand import PlanStir
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.statistics.statistics import statistics
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.plan import PlanResult


@pytest.fixture
def cell(in_rows):
    return with_policy(in_rows.cell, pair_gap=0.01, retry_without_scan=True)


def with_plan(line, samples):
    """The plan for the last part, as it is made after the miss."""
    scan = line.state.scan.digest
    plan = replace(samples.plan(scan, cell=line.state.cell), detections=line.state.detections)
    line.now += 4
    line.ended(replace(samples.planned(scan), plan=plan, proof=samples.proof(plan)))


@pytest.mark.parametrize("command", [MakePlan(), GoOn()])
def test_the_next_plan_is_a_cycle_of_its_own(in_rows, cell, command):
    line = sending(in_rows, cell, made=Written)
    line.do(END)
    line.do(command)
    with_plan(line, in_rows)
    missed, planned = statistics(line.rows).cycles
    assert [(pick.detection, pick.result) for pick in missed.picks] == [(0, "failed")]
    assert (missed.end, planned.end) == ("done", "")
    assert dict(planned.seconds) == {"plan": 5.0}


def test_so_is_the_one_that_was_asked_for_ahead(in_rows, cell):
    line = sending(in_rows, cell, made=Written)
    line.do(GoOn(sees_from=0, placed=()))
    line.do(END)
    with_plan(line, in_rows)
    missed, planned = statistics(line.rows).cycles
    assert [pick.result for pick in missed.picks] == ["failed"]
    assert dict(planned.seconds) == {"plan": 5.0}


def test_a_scan_after_a_plan_that_takes_nothing_has_its_own_time(in_rows, cell):
    line = sending(in_rows, cell, made=Written)
    line.do(END)
    line.do(GoOn())
    line.ended(in_rows.refused())
    line.now += 6
    line.ended(in_rows.scan(2))
    assert statistics(line.rows).cycles[-1].seconds["scan"] == 7.0


def test_only_the_rest_counts_as_left_without_a_plan(in_rows, cell):
    line = sending(in_rows, cell, made=Written)
    assert len(line.state.detections) == 3
    line.do(END)
    line.do(MakePlan())
    line.ended(in_rows.refused())
    assert len(statistics(line.rows).remaining) == 1


def test_a_stirring_that_finds_no_path_leaves_the_reasons_of_the_planning(in_rows):
    wide = replace(in_rows.cell.bin, size=np.array([4.0, 4.0, 0.2]))
    cell = replace(in_rows.cell, bin=wide)
    line = Written(cell)
    line.plan(replace(in_rows, cell=cell), is_possible=False)
    before = statistics(line.rows)
    line.do(PlanStir())
    line.ended(PlanResult((), None, None, Verdict(Reason.OUT_OF_REACH, Stage.ROUTE), {}))
    after = statistics(line.rows)
    reasons = [[left.hindrance for left in each.remaining] for each in (before, after)]
    assert reasons == [["floor"], ["floor"]]
    assert after.cycles[-1].seconds == before.cycles[-1].seconds
