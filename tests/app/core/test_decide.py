"""Decisions move the cycle forward and drop what is stale."""

import dataclasses

import pytest
from line import NOW, Line

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StopJob, StopSending
from workbench.app.core.state import Phase
from workbench.model.cell import PlanOverrides
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, InputError, JobCancelled
from workbench.model.messages.states import StateText
from workbench.model.release import Receipt
from workbench.model.scan import SearchOverrides

RECEIPT = Receipt(NOW, "right", "start", "startR#", 1, 4)


@pytest.fixture
def line(cell) -> Line:
    return Line(cell)


@pytest.fixture
def planned(line, samples) -> Line:
    scan = samples.scan()
    line.do(TakeScan())
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.detections())
    line.do(MakePlan())
    digest = line.ended(samples.planned(scan.digest)).plan.digest
    line.do(WatchPlan(digest))
    return line


@pytest.fixture
def sending(planned) -> Line:
    digest = planned.state.plan.digest
    planned.do(Approve(digest))
    planned.do(SendPlan(digest))
    return planned


def test_the_line_goes_from_a_scan_to_a_finished_cycle(line, samples):
    scan, detections = samples.scan(), samples.detections()
    assert line.do(TakeScan(seed=4, parts=3)).phase is Phase.IDLE
    assert line.ended(scan).phase is Phase.SCANNED
    line.do(FindParts(seed=5))
    assert line.ended(detections).phase is Phase.LOCALIZED
    line.do(MakePlan("right", 0.3, 6, PlanOverrides("sbl", 900, "highest", 0.01, 0.8)))
    result = samples.planned(scan.digest)
    assert line.ended(result).phase is Phase.PLANNED
    assert line.do(WatchPlan(result.plan.digest)).watched == ("ada",)
    assert line.do(Approve(result.plan.digest)).phase is Phase.APPROVED
    assert line.do(SendPlan(result.plan.digest)).phase is Phase.SENDING
    assert line.do(Sent(RECEIPT)).receipts == (RECEIPT,)
    done = line.do(LinkEnded(parts_placed=1))
    assert (done.phase, done.parts_placed) == (Phase.DONE, 1)
    assert str(done.message) == "cycle finished, 1 of 1 part reported placed"
    scanning, finding, planning, send = line.effects
    assert (scanning.name, dict(scanning.arguments)) == (
        "scan",
        {"seed": 4, "parts": 3, "part": ""},
    )
    wanted = {"scan": scan, "seed": 5, "overrides": SearchOverrides()}
    assert (finding.name, dict(finding.arguments)) == ("localize", wanted)
    assert planning.name == "plan"
    assert dict(planning.arguments) == {
        "detections": detections,
        "scan_digest": scan.digest,
        "scan": scan,
        "strategy": "right",
        "threshold": 0.3,
        "overrides": PlanOverrides("sbl", 900, "highest", 0.01, 0.8),
        "placed": (),
        "avoided": (),
        "wanted": None,
        "seed": 6,
    }
    assert isinstance(send, Send)
    assert (send.plan, send.approval) == (result.plan, done.approval)


def test_every_entry_gives_its_number_to_the_state(planned):
    before = planned.state.number
    assert planned.do(Approve(planned.state.plan.digest)).number == before + 1


def test_a_new_scan_drops_everything_made_from_the_old_one(planned, samples):
    planned.do(Approve(planned.state.plan.digest))
    state = planned.do(UseScan(samples.scan(seed=1)))
    assert state.phase is Phase.SCANNED
    for field in ("detections", "candidates", "plan", "proof", "verdict", "approval"):
        assert getattr(state, field) is None


def test_asking_for_a_new_plan_takes_back_the_approval(planned):
    planned.do(Approve(planned.state.plan.digest))
    state = planned.do(MakePlan(threshold=0.5))
    assert (state.phase, state.approval) == (Phase.PLANNED, None)
    assert planned.do(CancelJob()).plan is not None


def test_poses_from_outside_stand_for_the_scan(line, samples):
    detections = samples.detections(seed=3)
    state = line.do(UseDetections(detections))
    assert (state.phase, state.scene_digest) == (Phase.LOCALIZED, digest_of(detections))
    line.do(MakePlan())
    assert line.effects[-1].arguments["scan_digest"] == digest_of(detections)


def test_no_part_found_leaves_the_scan_and_says_so(line, samples):
    line.do(UseScan(samples.scan()))
    line.do(FindParts())
    state = line.ended(())
    assert (state.phase, state.message) == (Phase.SCANNED, StateText.NOTHING_FOUND())
    with pytest.raises(CommandRefused, match="find the parts first"):
        line.do(MakePlan())


def test_a_refused_plan_leaves_candidates_and_verdict_for_the_page(planned, samples):
    planned.do(MakePlan(seed=1))
    refused = samples.refused()
    state = planned.ended(refused)
    assert state.phase is Phase.LOCALIZED
    assert state.candidates == refused.candidates
    assert (state.verdict, state.plan, state.proof) == (refused.verdict, None, None)
    assert str(state.message) == "no plan: in collision: link and bin_floor, penetration 2.0 mm"


def test_a_plan_whose_proof_does_not_hold_stays_visible_and_cannot_be_approved(planned, samples):
    planned.do(MakePlan(seed=1))
    state = planned.ended(samples.planned(planned.state.scene_digest, holds=False))
    assert state.phase is Phase.PLANNED
    assert "its proof does not hold: arm right leg reach" in str(state.message)
    with pytest.raises(CommandRefused, match="does not hold"):
        planned.do(Approve(state.plan.digest))


def test_a_result_whose_job_is_no_longer_current_is_not_made_current(line, samples):
    line.do(TakeScan())
    late = line.state.job.number
    line.do(CancelJob())
    line.do(UseScan(samples.scan(seed=1)))
    before = line.state
    after = line.do(JobEnded(late, samples.scan(seed=2)))
    assert dataclasses.replace(after, number=before.number).scan is before.scan
    assert (after.number, after.phase, after.message) == (
        before.number + 1,
        before.phase,
        before.message,
    )
    assert line.effects[1].number == late
    assert isinstance(line.effects[1], StopJob)


def test_a_failed_or_cancelled_job_leaves_what_was_there_and_a_sentence(planned):
    plan = planned.state.plan
    planned.do(MakePlan())
    state = planned.ended(InputError("coordinated plans are not available"))
    assert state.plan is plan
    assert str(state.message) == "the planning failed: coordinated plans are not available"
    planned.do(MakePlan())
    assert str(planned.ended(JobCancelled("")).message) == "the planning was cancelled"


def test_a_job_that_brings_the_wrong_thing_has_failed(line, samples):
    line.do(TakeScan())
    state = line.ended(samples.detections())
    assert (state.phase, state.job) == (Phase.IDLE, None)
    assert str(state.message) == "the scan failed: the result was a tuple"


def test_a_stop_is_passed_on_and_the_end_of_the_link_decides_the_phase(sending):
    state = sending.do(Stop())
    assert (state.phase, str(state.message)) == (Phase.SENDING, "ada stops the sending")
    assert isinstance(sending.effects[-1], StopSending)
    assert sending.do(LinkEnded("stopped before the end")).phase is Phase.FAULT


def test_a_fault_is_acknowledged_into_an_empty_cycle(sending):
    state = sending.do(LinkEnded("the controller closed the connection", 1))
    assert (state.phase, state.fault) == (Phase.FAULT, "the controller closed the connection")
    assert str(state.message) == "fault while sending: the controller closed the connection"
    assert state.parts_placed == 1
    cleared = sending.do(AcknowledgeFault())
    assert (cleared.phase, cleared.fault, cleared.plan) == (Phase.IDLE, "", None)


def test_a_plan_is_not_sent_a_second_time(sending):
    digest = sending.state.plan.digest
    with pytest.raises(CommandRefused, match="on its way"):
        sending.do(SendPlan(digest))
    sending.do(LinkEnded(parts_placed=1))
    with pytest.raises(CommandRefused, match="take a new scan first"):
        sending.do(SendPlan(digest))
    with pytest.raises(CommandRefused, match="take a new scan first"):
        sending.do(Approve(digest))


def test_plannings_for_the_same_parts_are_remembered_until_there_are_others(line, samples):
    scan = samples.scan()
    line.do(TakeScan())
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.detections())
    line.do(MakePlan())
    line.ended(samples.refused())
    line.do(MakePlan(seed=1))
    planned = samples.planned(scan.digest)
    state = line.ended(planned)
    first, second = state.outlines
    assert "in collision" in str(first.verdict) and first.cycle is None
    assert (second.digest, second.verdict) == (planned.plan.digest, None)
    assert second.cycle == planned.plan.cycle_seconds
    line.do(FindParts())
    assert line.ended(samples.detections()).outlines == ()


def test_each_plan_for_the_same_parts_stands_once_and_says_how_it_is_made_again(line, samples):
    scan = samples.scan()
    line.do(TakeScan())
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.detections())
    one, other = samples.planned(scan.digest), samples.planned(scan.digest, seed=1)
    line.do(MakePlan("auto", 0.3, 7))
    # With two arms, both strategies would be asked for.
    line.state = dataclasses.replace(
        line.state, job=dataclasses.replace(line.state.job, strategy="both")
    )
    state = line.ended(dataclasses.replace(other, beside=(one,)))
    first, second = state.outlines
    assert [first.digest, second.digest] == [one.plan.digest, other.plan.digest]
    assert (first.asked, first.threshold, first.seed) == ("right", 0.3, 7)
    assert state.plan.digest == second.digest
    line.do(MakePlan(first.asked, first.threshold, first.seed, first.overrides))
    state = line.ended(one)
    assert [outline.digest for outline in state.outlines] == [first.digest, second.digest]
    assert state.plan.digest == first.digest
    line.do(MakePlan("auto"))
    assert [outline.asked for outline in line.ended(other).outlines] == ["right", "auto"]
