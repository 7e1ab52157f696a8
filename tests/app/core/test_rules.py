"""The rules let through what is in order, and say what to do about everything else."""

import dataclasses
import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.app.core import control
from workbench.app.core.cell.bins import NewBin
from workbench.app.core.commands import COMMANDS, commands_of
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve, approve, staleness
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, NextStep, SendPlan, Stop
from workbench.app.core.decide import check_allowed
from workbench.app.core.rights import NEXT, obstacle
from workbench.app.core.session import AcknowledgeChanges, Opened, PosesRefused, Started, WriteNote
from workbench.app.core.state import Job, Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import PlanOverrides
from workbench.model.errors import CommandRefused
from workbench.model.scan import Detection

NOW = 1_000_000.0
CONTROL = set(commands_of(control))


def refusal(state, command, actor="ada", now=NOW) -> str:
    with pytest.raises(CommandRefused) as refused:
        check_allowed(state, command, actor, now)
    return str(refused.value)


@pytest.fixture
def planned(cell, samples) -> State:
    """A state with a proven plan."""
    scan = samples.scan()
    result = samples.planned(scan.digest)
    return State(
        cell,
        Phase.PLANNED,
        number=7,
        scan=scan,
        detections=samples.detections(),
        scene_digest=scan.digest,
        candidates=result.candidates,
        plan=result.plan,
        proof=result.proof,
        verdict=result.verdict,
        watched=("ada",),
    )


@pytest.fixture
def approved(planned) -> State:
    approval = approve(planned.cell, planned.plan, planned.proof, "ada", NOW)
    return dataclasses.replace(planned, phase=Phase.APPROVED, approval=approval)


def test_every_phase_names_what_comes_next():
    assert set(NEXT) == set(Phase)


@pytest.mark.parametrize("phase", Phase)
@pytest.mark.parametrize("command", COMMANDS)
def test_every_obstacle_is_a_sentence_and_no_obstacle_means_the_table_says_so(cell, phase, command):
    state = State(cell, phase, fault="link lost" if phase is Phase.FAULT else "")
    problem = str(obstacle(state, command) or "")
    in_order = phase in command.right.phases and command is not CancelJob
    assert (problem == "") == in_order
    assert in_order or len(problem) > 10


def test_nothing_but_reports_passes_beside_a_running_task_except_to_cancel_it(planned):
    busy = dataclasses.replace(planned, job=Job(3, "plan"))
    free = {command for command in COMMANDS if not obstacle(busy, command)}
    reports = {JobEnded, Opened, PosesRefused, Started}
    people = {AcknowledgeChanges, CancelJob, NewBin, WantThreshold, WriteNote}
    assert free == people | reports | CONTROL
    assert "the planning ends or is cancelled" in refusal(busy, Approve(planned.plan.digest))


def test_a_fault_lets_pass_only_its_acknowledgement_and_late_results(cell):
    state = State(cell, Phase.FAULT, fault="the controller closed the connection")
    assert {c for c in COMMANDS if not obstacle(state, c)} == {
        AcknowledgeFault,
        JobEnded,
        NewBin,
        Opened,
        PosesRefused,
        ReportPick,
        Started,
        WriteNote,
    } | CONTROL
    assert "the controller closed the connection" in refusal(state, TakeScan())


def test_while_sending_only_a_stop_and_reports_pass(approved):
    state = dataclasses.replace(approved, phase=Phase.SENDING)
    people = {c for c in COMMANDS if not obstacle(state, c) and not c.right.by_machine}
    assert people == {Stop, NewBin, NextStep, ReportPick, GoOn, WriteNote} | CONTROL


@pytest.mark.parametrize(
    ("phase", "command", "advice"),
    [
        (Phase.IDLE, FindParts(), "take a scan first"),
        (Phase.SCANNED, MakePlan(), "find the parts first"),
        (Phase.LOCALIZED, Approve("x"), "make a plan first"),
        (Phase.PLANNED, SendPlan("x"), "have the plan approved first"),
        (Phase.DONE, MakePlan(), "take a new scan first"),
        (Phase.IDLE, Stop(), "nothing is being sent"),
        (Phase.IDLE, CancelJob(), "no task is running"),
    ],
)
def test_a_refusal_says_what_to_do_first(cell, phase, command, advice):
    assert advice in refusal(State(cell, phase), command)


@pytest.mark.parametrize("seed", [-1, 2**31, 1.0, True, "7", math.nan, None])
def test_seeds_that_are_no_seeds_are_refused(cell, seed):
    assert "seed must be a whole number" in refusal(State(cell), TakeScan(seed=seed))


@pytest.mark.parametrize("parts", [31, -1, 2.5, math.inf, None])
def test_impossible_numbers_of_parts_are_refused(cell, parts):
    assert "parts must be a whole number from 0 to 30" in refusal(
        State(cell), TakeScan(parts=parts)
    )


@pytest.mark.parametrize("threshold", [-0.01, 1.01, math.nan, math.inf, 10**400, "0.2", True])
def test_thresholds_outside_of_a_metre_are_refused(planned, threshold):
    assert "threshold must lie between" in refusal(planned, MakePlan(threshold=threshold))


@pytest.mark.parametrize("strategy", ["neither", "alternated", "both", "left", ["auto"]])
def test_a_strategy_that_the_cell_cannot_have_is_refused_with_those_there_are(planned, strategy):
    assert "there are auto, right" in refusal(planned, MakePlan(strategy=strategy))


def test_a_cell_with_two_arms_has_strategies_for_both_and_for_each():
    state = State(read_cell("yumi"), Phase.LOCALIZED, detections=())
    there = ("auto", "alternated", "coordinated", "right", "left", "both")
    for strategy in there:
        check_allowed(state, MakePlan(strategy), "ada", NOW)
    assert f"there are {', '.join(there)}" in refusal(state, MakePlan("manipulator"))


@given(
    seed=st.integers(0, 2**31 - 1),
    parts=st.integers(1, 30),
    threshold=st.floats(0, 1),
    strategy=st.sampled_from(("auto", "right")),
)
def test_everything_within_the_ranges_passes(cell, samples, seed, parts, threshold, strategy):
    check_allowed(State(cell), TakeScan(seed, parts), "ada", NOW)
    state = State(cell, Phase.LOCALIZED, detections=samples.detections())
    check_allowed(state, MakePlan(strategy, threshold, seed), "ada", NOW)


def test_poses_of_parts_that_the_cell_does_not_have_are_refused(cell):
    stranger = Detection("gear", pin.SE3.Identity())
    assert "no part 'gear'; it has peg" in refusal(State(cell), UseDetections((stranger,)))
    assert "1 to 30 poses are needed, not 0" in refusal(State(cell), UseDetections(()))


def test_finding_parts_needs_a_scan_even_when_poses_came_from_outside(cell, samples):
    state = State(cell, Phase.LOCALIZED, detections=samples.detections())
    assert "take a scan first" in refusal(state, FindParts())


@pytest.mark.parametrize("actor", ["", "   ", "a\nb", "x" * 81, "worker", "robot link"])
def test_only_a_named_person_may_ask_for_something(planned, approved, actor):
    refusal(planned, Approve(planned.plan.digest), actor)
    refusal(approved, SendPlan(planned.plan.digest), actor)
    with pytest.raises(CommandRefused):
        approve(planned.cell, planned.plan, planned.proof, actor, NOW)


def test_only_machines_report_what_machines_did(approved):
    sending = dataclasses.replace(approved, phase=Phase.SENDING)
    assert "reported by a machine" in refusal(sending, LinkEnded())
    check_allowed(sending, LinkEnded(), "robot link", NOW)


def test_an_approval_names_everything_it_stands_for(planned):
    approval = approve(planned.cell, planned.plan, planned.proof, "ada", NOW)
    assert approval.plan_digest == planned.plan.digest
    assert approval.proof_digest == planned.proof.digest
    assert approval.cell_digest == planned.cell.digest
    assert approval.scan_digest == planned.scan.digest
    assert (approval.actor, approval.at, approval.until) == ("ada", NOW, NOW + 300)
    assert staleness(approval, planned.plan, planned.cell, planned.scan.digest, NOW) is None


def test_a_plan_whose_proof_does_not_hold_cannot_be_approved(planned, samples):
    bent = dataclasses.replace(planned, proof=samples.proof(planned.plan, holds=False))
    said = refusal(bent, Approve(planned.plan.digest))
    assert "does not hold: arm right leg reach after waypoint 1: too close" in said


def test_a_plan_without_a_proof_cannot_be_approved(planned):
    bare = dataclasses.replace(planned, proof=None)
    assert "no proof" in refusal(bare, Approve(planned.plan.digest))


def test_a_digest_that_is_not_the_current_plan_is_refused(planned, approved):
    assert "the current plan is" in refusal(planned, Approve("0" * 64))
    assert "the current plan is" in refusal(approved, SendPlan("0" * 64))


def test_the_proof_of_another_plan_does_not_count(planned, samples):
    other = samples.proof(samples.plan(planned.scan.digest, seed=5))
    state = dataclasses.replace(planned, proof=other)
    assert "proof is that of another plan" in refusal(state, Approve(planned.plan.digest))


def test_a_plan_for_another_cell_or_scan_cannot_be_approved(planned, samples, make_cell):
    other = samples.plan(planned.scan.digest, cell=make_cell("other"))
    state = dataclasses.replace(planned, plan=other, proof=samples.proof(other))
    assert "cell has changed" in refusal(state, Approve(other.digest))
    newer = dataclasses.replace(planned, scene_digest=samples.scan(seed=9).digest)
    assert "newer scan" in refusal(newer, Approve(planned.plan.digest))


def test_an_approval_ends_after_its_minutes_and_before_its_time(approved):
    digest = approved.plan.digest
    check_allowed(approved, SendPlan(digest), "ada", NOW + 299)
    assert "has run out" in refusal(approved, SendPlan(digest), now=NOW + 300)
    assert "has run out" in refusal(approved, SendPlan(digest), now=NOW - 1)


def test_an_approval_does_not_cover_another_plan_cell_or_scan(approved, samples, make_cell):
    approval, plan, cell = approved.approval, approved.plan, approved.cell
    scan = approved.scene_digest
    assert "another plan" in str(staleness(approval, samples.plan(scan, seed=5), cell, scan, NOW))
    assert "cell has changed" in str(staleness(approval, plan, make_cell("other"), scan, NOW))
    assert "newer scan" in str(staleness(approval, plan, cell, samples.scan(seed=9).digest, NOW))
    assert "nobody" in str(staleness(None, plan, cell, scan, NOW))


def test_a_plan_bent_in_memory_after_approval_is_not_sent(approved):
    # SE3 is mutable: a frozen plan does not protect the pose that it holds.
    plan = approved.plan
    plan.arms[0].T_tcp_part.translation = np.array([0.0, 0.0, 0.5])
    try:
        assert "changed after it was made" in refusal(approved, SendPlan(plan.digest))
    finally:
        plan.arms[0].T_tcp_part.translation = np.zeros(3)


@pytest.mark.parametrize(
    ("wish", "expected"),
    [
        ({"planner": 7}, "planner must be a text"),
        ({"order": "lowest"}, "order 'lowest' is not known"),
        ({"iterations": 0}, "iterations must be"),
        ({"iterations": 1.5}, "iterations must be"),
        ({"iterations": 10**9}, "iterations must be"),
        ({"margin": 0.004}, "margin must lie between 0.005 and 0.2 m"),
        ({"margin": math.nan}, "margin must lie"),
        ({"margin": "5"}, "margin must lie"),
        ({"metric": 0.0}, "metric must lie"),
        ({"metric": 1.1}, "metric must lie"),
    ],
)
def test_every_wish_is_checked(planned, wish, expected):
    assert expected in refusal(planned, MakePlan(overrides=PlanOverrides(**wish)))
