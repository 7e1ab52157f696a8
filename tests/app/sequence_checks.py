"""What must never be otherwise in any sequence of commands, said without the code under test."""

import dataclasses

import numpy as np
from hypothesis.stateful import invariant
from line import Line

from workbench.app.core.command import Command
from workbench.app.core.cycle.approval import Approve, staleness
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send, StartJob
from workbench.app.core.state import Phase, State
from workbench.model.digest import digest_of
from workbench.model.plan import UNSIGNED


def row_of(state: State) -> tuple[str, ...]:
    """The digests of the plans after the plan."""
    return tuple(one.plan.digest for one in state.row)


def shown_of(command: WatchPlan | Approve) -> tuple[str, ...]:
    """The digests of all plans that somebody has seen, or agrees to."""
    return (command.plan_digest, *command.row)


class Checks:
    """Looks at each step; what was said, shown and sent is kept by these tests alone."""

    line: Line
    people: int
    said: list[tuple[tuple[str, ...], str, float]]
    shown: set[tuple[str, ...]]
    sent: set[str]
    let_out: tuple[str, ...]
    is_stopped: bool
    is_opened_again: bool
    threshold: float
    threshold_of: dict[str, float]

    def check_results(self, before: State, after: State, command: Command) -> None:
        if isinstance(command, JobEnded) and (
            before.job is None or before.job.number != command.number
        ):
            assert dataclasses.replace(after, number=before.number).message == before.message
            for field in ("scan", "detections", "plan", "proof", "approval", "phase", "job"):
                assert getattr(after, field) is getattr(before, field)

    def check_approval(self, before: State, after: State, command: Command, actor: str) -> None:
        assert isinstance(command, Approve)
        assert (actor or "ada") == after.approval.actor
        assert len({name.casefold() for name in after.approval.people}) == self.people
        assert shown_of(command) in self.shown
        assert tuple(digest for digest, _ in after.approval.row) == command.row == row_of(after)
        assert all(one.proof.holds for one in before.row)
        assert before.proof.holds
        assert before.proof.plan_digest == before.plan.digest == command.plan_digest
        assert before.plan.scan_digest == before.scene_digest
        assert before.plan.cell_digest == before.cell.digest

    def check_sending(self, before: State, command: Command, send: Send) -> None:
        assert isinstance(command, SendPlan)
        assert before.phase is Phase.APPROVED
        approval = before.approval
        assert send.approval is approval
        assert approval.at <= self.line.now < approval.until
        assert approval.plan_digest == command.plan_digest == send.plan.digest
        assert approval.plan_digest == digest_of(send.plan, without=UNSIGNED)
        assert approval.scan_digest == before.scene_digest == send.plan.scan_digest
        assert before.proof.holds
        now, digest = self.line.now, send.plan.digest
        row = (digest, *row_of(before))
        assert approval.row == tuple((one.plan.digest, one.proof.digest) for one in before.row)
        gave = {name for plans, name, at in self.said if plans == row and at <= now < at + 300}
        assert len(gave) >= self.people, "everybody's word is for this plan, and has not lapsed"
        assert gave >= {name.casefold() for name in approval.people}
        assert abs(self.line.joints.get("joint_1", 0.0)) <= np.deg2rad(1.0)
        assert self.threshold == self.threshold_of[digest]
        assert send.plan.cell_digest == before.cell.digest
        assert approval.digest not in self.sent, "one approval, one sending"
        self.sent.add(approval.digest)
        self.let_out = row

    def check_following(self, before: State, command: Command, send: Send) -> None:
        """The next plan of a row: let out with the first one, and nothing was odd meanwhile."""
        assert isinstance(command, LinkEnded)
        assert not command.fault and not self.is_stopped
        assert [one.is_picked for one in command.parts] == [True]
        assert all(one.is_picked for one in self.line.state.outcomes)
        done = len(before.sent_before) + 1
        assert send.plan.digest == digest_of(send.plan, without=UNSIGNED) == self.let_out[done]
        assert before.row[0].plan is send.plan and before.row[0].proof.holds
        approval = send.approval
        assert approval.first in self.sent and approval.digest not in self.sent
        self.sent.add(approval.digest)
        assert approval.plan_digest == send.plan.digest
        assert approval.proof_digest == before.row[0].proof.digest
        assert approval.scan_digest == before.scene_digest == send.plan.scan_digest
        assert approval.at <= self.line.now < approval.until
        assert abs(self.line.joints["joint_1"]) <= np.deg2rad(1.0)
        assert send.plan.cell_digest == before.cell.digest

    @invariant()
    def what_stands_together_belongs_together(self):
        if not hasattr(self, "line"):
            return
        state = self.line.state
        assert (state.phase is Phase.FAULT) == bool(state.fault)
        if state.approval is not None:
            assert state.plan is not None
            assert not staleness(
                state.approval, state.plan, state.cell, state.scene_digest, state.approval.at
            )
        if state.phase is Phase.APPROVED:
            assert state.approval is not None
        assert state.ahead is None or state.phase is Phase.SENDING
        if state.phase in (Phase.SENDING, Phase.FAULT):
            assert state.job is None or state.ahead is not None
            # What was spent stays to be seen until the session is opened again.
            assert (state.approval is None) == self.is_opened_again

    @invariant()
    def a_stage_leaves_the_digests_of_its_inputs_alone(self):
        if not hasattr(self, "line"):
            return
        for effect in self.line.effects:
            if isinstance(effect, StartJob) and "scan" in effect.arguments:
                scan = effect.arguments["scan"]
                if scan is None:
                    continue
                assert digest_of(scan, without=frozenset({"at", "source"})) == scan.digest
