"""No sequence of commands, however odd, sends without a fresh and matching approval."""

import dataclasses
from typing import Any, ClassVar

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    rule,
    run_state_machine_as_test,
)
from line import NOW, Line
from sequence_checks import Checks, row_of, shown_of

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.command import Command
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ForgetAvoided, ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.rows import ShortenRow
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send
from workbench.app.core.people import ROBOT_LINK, SESSION_START
from workbench.app.core.session import Opened
from workbench.app.core.state import Phase, State
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.prediction import Emptying
from workbench.model.release import PartReport, Receipt
from workbench.model.scan import Scan

RECEIPT = Receipt(NOW, "right", "start", "startR#", 1, 4)
SEEDS = st.integers(0, 2)
PICKED = (PartReport("right", 0, True),)


class AnySequence(Checks, RuleBasedStateMachine):
    """People and machines do whatever they like, in any order, with right and wrong values."""

    samples: ClassVar[Any]

    @initialize(steps=st.integers(0, 9), people=st.sampled_from([1, 1, 2, 3]))
    def begin(self, steps, people):
        self.people = people
        self.line = Line(dataclasses.replace(self.samples.cell, approvers=people))
        self.sent: set[str] = set()
        self.is_opened_again = False
        # What was said and shown for each plan, kept by this test alone.
        self.said: list[tuple[tuple[str, ...], str, float]] = []
        self.shown: set[tuple[str, ...]] = set()
        self.let_out: tuple[str, ...] = ()
        self.is_stopped = False
        # Rows need a controller that says where the robot stands.
        self.line.joints = {"joint_1": 0.0} if self.line.state.cell.policy.picks > 1 else {}
        self.threshold_of: dict[str, float] = {}
        self.threshold = self.asked = 0.2
        # Pure chance seldom gets far: some sequences begin where a good cycle has led.
        scan = self.samples.scan()
        result = self.samples.planned(scan.digest)
        cycle = (
            UseScan(scan),
            FindParts(),
            JobEnded(2, self.samples.detections()),
            MakePlan(),
            JobEnded(4, result),
            WatchPlan(result.plan.digest, row=tuple(one.plan.digest for one in result.row)),
            Approve(result.plan.digest, row=tuple(one.plan.digest for one in result.row)),
            SendPlan(result.plan.digest),
            LinkEnded("", 1, PICKED),
        )
        for command in cycle[:steps]:
            self.attempt(command)
        self.line.effects.clear()

    def attempt(self, command: Command, actor: str = "") -> None:
        self.line.now += 0.001
        before, effects = self.line.state, len(self.line.effects)
        try:
            after = self.line.do(command, actor)
        except CommandRefused:
            assert self.line.state is before
            return
        self.note(before, after, command, actor or "ada")
        self.check_results(before, after, command)
        is_new = after.approval is not None and after.approval is not before.approval
        if is_new and after.phase is not Phase.SENDING:
            self.check_approval(before, after, command, actor)
        sends = [one for one in self.line.effects[effects:] if isinstance(one, Send)]
        is_other = before.phase is not Phase.SENDING or after.plan is not before.plan
        assert (after.phase is Phase.SENDING and is_other) == bool(sends)
        for send in sends:
            check = self.check_sending if isinstance(command, SendPlan) else self.check_following
            check(before, command, send)

    def note(self, before: State, after: State, command: Command, actor: str) -> None:
        match command:
            case SendPlan():
                self.is_opened_again = self.is_stopped = False
            case Stop():
                self.is_stopped = True
            case WatchPlan():
                # Who has seen all of a row has seen a shorter one.
                seen = shown_of(command)
                self.shown |= {seen[:number] for number in range(1, len(seen) + 1)}
            case Approve():
                self.said.append((shown_of(command), actor.casefold(), self.line.now))
            case ShortenRow():
                self.said.clear()
                assert after.approval is None and not after.votes
            case MakePlan(threshold=threshold):
                self.threshold = self.asked = threshold
                self.said.clear()
            case GoOn() if before.phase is Phase.SENDING:
                assert after.plan is before.plan and after.approval is before.approval
            case LinkEnded() if before.ahead is not None and after.phase is not Phase.SENDING:
                if after.job is not None or after.phase not in (Phase.DONE, Phase.FAULT):
                    self.threshold = self.asked = before.ahead.wanted.plan.threshold
                    self.said.clear()
            case GoOn(plan=MakePlan(threshold=threshold)):
                self.threshold = self.asked = threshold
                self.said.clear()
            case WantThreshold(threshold=threshold):
                self.threshold = threshold
                if after.job is not None and after.job.then is not None:
                    self.asked = threshold
            case TakeScan() | FindParts():
                self.said.clear()
            case Opened():
                self.said.clear()
                self.shown.clear()
                self.is_opened_again = True
                assert after.approval is None and not after.votes and not after.watched
            case _:
                pass
        if after.plan is not None and after.plan is not before.plan:
            # The same plan made again is another one: it has to be looked at again.
            self.threshold_of[after.plan.digest] = self.asked
            if after.phase is not Phase.SENDING:
                self.shown = {one for one in self.shown if one[0] != after.plan.digest}
                self.said.clear()

    @rule(steps=st.integers(1, 3), holds=st.sampled_from([True, True, False]), seed=SEEDS)
    def go_on(self, steps, holds, seed):
        """Do what a sensible person would do next, or let the running task end well."""
        for _ in range(steps):
            state = self.line.state
            if state.job is not None:
                self.job_ends("right", seed, holds, False)
                continue
            digest = state.plan.digest if state.plan is not None else ""
            sensible = {
                Phase.IDLE: TakeScan(seed),
                Phase.SCANNED: FindParts(seed),
                Phase.LOCALIZED: MakePlan(seed=seed),
                Phase.PLANNED: Approve(digest, row=row_of(state))
                if state.watched
                else WatchPlan(digest, row=row_of(state)),
                Phase.APPROVED: SendPlan(digest),
                Phase.SENDING: LinkEnded("" if holds else "lost", 1, PICKED),
                Phase.DONE: GoOn(TakeScan(seed)) if holds else TakeScan(seed),
                Phase.FAULT: AcknowledgeFault(),
            }
            command = sensible[state.phase]
            people = ("ada", "bob", "eve")
            actor = people[len(state.votes) % 3] if isinstance(command, Approve) else "operator"
            self.attempt(command, ROBOT_LINK if isinstance(command, LinkEnded) else actor)

    @rule(
        meddle=st.sampled_from(
            ["nothing", "robot", "threshold", "cell", "scan", "plan", "time", "late"]
        ),
        pause=st.sampled_from([0.0, 150.0]),
        seed=SEEDS,
    )
    def hurry(self, meddle, pause, seed):
        """Get to an approved plan, let one thing go wrong, and send all the same."""
        for _ in range(12):
            if self.line.state.phase is Phase.APPROVED:
                break
            if self.line.state.votes:
                self.line.now += pause
            self.go_on(1, True, seed)
        match meddle:
            case "robot":
                self.robot_moves(5.0)
            case "threshold":
                self.want_threshold(0.3)
            case "cell":
                self.change_cell(1)
            case "scan":
                self.use_scan(seed + 1)
            case "plan":
                self.plan(seed + 1, 0.2)
            case "time":
                self.line.now += 151.0
            case "late":
                self.line.now += 301.0
            case _:
                pass
        self.insist_on_sending()

    def insist_on_sending(self):
        plan = self.line.state.plan
        self.attempt(SendPlan(plan.digest if plan is not None else "0" * 64), "ada")

    @rule(seed=SEEDS, parts=st.integers(0, 3))
    def scan(self, seed, parts):
        self.attempt(TakeScan(seed, parts))

    @rule(seed=SEEDS)
    def use_scan(self, seed):
        self.attempt(UseScan(self.samples.scan(seed)))

    @rule(seed=SEEDS, is_compared=st.booleans())
    def find(self, seed, is_compared):
        self.attempt(FindParts(seed, is_compared=is_compared))

    @rule(seed=SEEDS, piles=st.integers(0, 2))
    def try_emptying(self, seed, piles):
        self.attempt(TryEmptying(count=2, piles=piles, seed=seed))

    @rule(seed=SEEDS)
    def use_detections(self, seed):
        self.attempt(UseDetections(self.samples.detections(seed)))

    @rule(seed=SEEDS, threshold=st.sampled_from([0.2, 0.3, float("nan")]))
    def plan(self, seed, threshold):
        self.attempt(MakePlan("auto", threshold, seed))

    @rule(
        kind=st.sampled_from(["right", "right", "right", "wrong", "late", "error"]),
        seed=SEEDS,
        holds=st.sampled_from([True, True, False]),
        other_scan=st.sampled_from([False, False, True]),
    )
    def job_ends(self, kind, seed, holds, other_scan):
        job = self.line.state.job
        number = job.number if job is not None else 1
        ahead = self.line.state.ahead
        brought = () if ahead is None else ahead.brought
        scans = [result.digest for _, result, _ in brought if isinstance(result, Scan)]
        scene = scans[0] if scans else self.line.state.scene_digest
        scene = "0" * 64 if other_scan else scene
        results = {
            "scan": self.samples.scan(seed),
            "localize": self.samples.detections(seed),
            "plan": self.samples.planned(scene, seed, holds=holds),
            "emptying": Emptying(self.line.state.cell.digest, ()),
        }
        name = job.name if job is not None else "plan"
        match kind:
            case "right":
                self.attempt(JobEnded(number, results[name]))
            case "wrong":
                self.attempt(JobEnded(number, results["scan" if name == "plan" else "plan"]))
            case "late":
                self.attempt(JobEnded(number - 1, results[name]))
            case _:
                self.attempt(JobEnded(number, InputError("no")))

    @rule(
        actor=st.sampled_from(["ada", "ADA", "bob", "eve", "", "worker"]),
        wrong=st.sampled_from([0, 0, 1]),
    )
    def approve(self, actor, wrong):
        plan = self.line.state.plan
        digest = plan.digest if plan is not None and not wrong else "0" * 64
        allowed_actor = actor or " "
        self.attempt(Approve(digest, row=row_of(self.line.state)), allowed_actor)

    @rule(
        actor=st.sampled_from(["ada", "bob", "robot link"]),
        wait=st.sampled_from([0.0, 1.0, 299.0, 301.0, -2.0]),
    )
    def send(self, actor, wait):
        self.line.now += wait
        plan = self.line.state.plan
        self.attempt(SendPlan(plan.digest if plan is not None else "0" * 64), actor)

    @rule(actor=st.sampled_from(["ada", "bob", "operator", "worker"]))
    def watch(self, actor):
        plan = self.line.state.plan
        digest = plan.digest if plan is not None else "0" * 64
        self.attempt(WatchPlan(digest, row=row_of(self.line.state)), actor)

    @rule(picks=st.integers(0, 4), kept=st.integers(0, 3))
    def shorten(self, picks, kept):
        """Another length of the row, and an approval of some other length still."""
        state = self.line.state
        digest = state.plan.digest if state.plan is not None else "0" * 64
        self.attempt(ShortenRow(digest, picks))
        self.attempt(Approve(digest, row=row_of(state)[:kept]), "ada")
        self.attempt(SendPlan(digest), "ada")

    @rule(threshold=st.sampled_from([0.2, 0.2, 0.3, -1.0]))
    def want_threshold(self, threshold):
        self.attempt(WantThreshold(threshold))

    @rule(degrees=st.sampled_from([None, 0.0, 0.0, 0.5, 5.0]))
    def robot_moves(self, degrees):
        self.line.joints = {} if degrees is None else {"joint_1": np.deg2rad(degrees)}

    @rule(millimetres=st.integers(0, 2))
    def change_cell(self, millimetres):
        cell = self.line.state.cell
        away = pose_from_rpy((millimetres / 1000, 0.0, 0.0))
        moved = dataclasses.replace(cell.bin, T_world_bin=away)
        self.attempt(ChangeCell(dataclasses.replace(cell, bin=moved), "the bin is moved"))

    @rule(detection=st.integers(0, 1), is_picked=st.booleans())
    def outcome(self, detection, is_picked):
        self.attempt(ReportPick(detection, is_picked))

    @rule()
    def insist(self):
        """Approve and send what is there, whatever the phase."""
        plan = self.line.state.plan
        if plan is not None:
            self.attempt(SendPlan(plan.digest), "ada")
            self.attempt(Approve(plan.digest, row=row_of(self.line.state)), "ada")
            self.attempt(SendPlan(plan.digest), "ada")

    @rule(step=st.integers(0, 2))
    def message_goes_out(self, step):
        self.attempt(Sent(dataclasses.replace(RECEIPT, step=step)))

    @rule(
        sees_from=st.integers(0, 2),
        threshold=st.sampled_from([0.2, 0.3]),
        tasks=st.integers(0, 3),
        seed=SEEDS,
    )
    def go_on_ahead(self, sees_from, threshold, tasks, seed):
        """Ask for the next cycle while a plan is on its way, and let some of it be done."""
        plan = MakePlan(threshold=threshold, seed=seed)
        self.attempt(GoOn(TakeScan(seed), plan=plan, sees_from=sees_from, placed=()))
        self.message_goes_out(2)
        for _ in range(tasks):
            if self.line.state.job is not None:
                self.job_ends("right", seed, True, False)

    @rule(
        fault=st.sampled_from(["", "", "lost"]),
        actor=st.sampled_from(["", "", "ada"]),
        is_picked=st.sampled_from([True, True, False, None]),
    )
    def link_ends(self, fault, actor, is_picked):
        self.attempt(LinkEnded(fault, 1, (PartReport("right", 0, is_picked),)), actor)

    @rule()
    def opened_again(self):
        """As a bench does it, where a session is continued."""
        if self.line.state.phase is Phase.SENDING:
            self.attempt(LinkEnded("ended while sending", 0))
        self.attempt(Opened(), SESSION_START)

    @rule(command=st.sampled_from([Stop(), CancelJob(), AcknowledgeFault(), ForgetAvoided()]))
    def interrupt(self, command):
        self.attempt(command)


def _run(samples: Any) -> None:
    AnySequence.samples = samples
    run_state_machine_as_test(
        AnySequence, settings=settings(max_examples=300, stateful_step_count=30, deadline=None)
    )


def test_no_sequence_of_commands_sends_without_a_fresh_matching_approval(samples):
    _run(samples)


def test_no_sequence_sends_a_plan_of_a_row_that_nobody_has_let_out(in_rows):
    _run(dataclasses.replace(in_rows, always=True))
