"""`workbench send`: a plan, or a row of plans, proven, approved by its digest, and sent."""

import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from workbench.app.core.cycle.approval import approve, check_approvable
from workbench.app.core.cycle.standing import left_on_station, moved_away
from workbench.app.picking.proving import adopt_plan
from workbench.app.picking.row import prove_row
from workbench.app.records.approvals import CUT_SHORT, ApprovalRecord
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.picking.planning import cell_of, detections_from
from workbench.cli.serving.approving import (
    REPORTS,
    check_digest,
    reported_joints,
    row_digest,
    row_facts,
    start_words,
    typed_digest,
)
from workbench.cli.serving.controller import HIGHEST_PORT
from workbench.cli.terminal import check_whole, print_json, progress
from workbench.formats.clouds.scans import read_scan
from workbench.formats.plans.plan_files import read_plan
from workbench.model.cell import MOST_PICKS, Cell, Controller
from workbench.model.digest import canonical
from workbench.model.errors import (
    CommandRefused,
    FileError,
    InputError,
    JournalError,
    WorkbenchError,
)
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt
from workbench.plugins.robot_link import controller_by
from workbench.plugins.robot_link import send as send_plan


def send(typed: arguments.SendArguments) -> int:
    """Prove, approve and send plans; nothing is sent unless everything before it holds."""
    check_whole("--port", typed.port, 1, HIGHEST_PORT)
    if typed.state_port is not None:
        check_whole("--state-port", typed.state_port, 1, HIGHEST_PORT)
    files = (typed.plan, *typed.row)
    if len(files) > MOST_PICKS:
        raise InputError(f"a row has at most {MOST_PICKS} plans, not {len(files)}")
    cell, plans = _read(files, typed.cell)
    if problem := left_on_station(plans):
        raise CommandRefused(f"{problem}: send both in a row")
    usual = cell.controller
    cell = replace(cell, controller=_controller(cell, typed))
    if typed.row:
        _check_reports(cell)
    if typed.digest is not None:
        check_digest(plans, typed.digest)
    record = ApprovalRecord(typed.record)
    with progress("send") as report:
        make_ready(report, ("planning",))
        report(0.0, "proving the plan")
        scan = None if typed.scan is None else read_scan(typed.scan, cell.scanner)
        poses = None if typed.poses is None else detections_from(cell, typed.poses, typed.part)
        row = list(prove_row(cell, plans, detections=poses, scan=scan))
    for proven_plan in row:
        if not proven_plan.proof.holds and cell.controller.motion != usual.motion:
            raise CommandRefused(
                f"the proof does not hold: {proven_plan.proof.violations[0]}; "
                f"{cell.controller.link} moves otherwise than the cell's {usual.link}: "
                f"plan with --protocol {cell.controller.link}"
            )
        check_approvable(cell, proven_plan.plan, proven_plan.proof, typed.approve_as)
    if cell.approvers > 1:
        raise CommandRefused(
            f"the cell wants {cell.approvers} people to approve a plan; a command is one person's"
        )
    start = start_words(cell, plans[0])
    facts, digest = row_facts(cell, row, _describe(typed), start), row_digest(plans)
    if typed.digest is None:
        record.show(digest, typed.approve_as, time.time(), facts)
        for name, value in facts.items():
            print(f"{name:>20}  {value}", file=sys.stderr if typed.json else sys.stdout, flush=True)
        check_digest(plans, typed_digest(typed.approve_as))
    valid = cell.policy.approval_minutes * 60.0
    record.check_shown(digest, typed.approve_as, time.time(), valid, facts)
    # Reading takes its time.
    if start_words(cell, plans[0]) != facts["Robot"]:
        raise CommandRefused("what is reported of the robot is otherwise now; read again")
    first, *rest = row
    now, actor = time.time(), typed.approve_as
    approval = approve(cell, first.plan, first.proof, actor, now, row=rest)
    approval = replace(approval, is_unwatched=True)
    approvals = [approval]
    while (following := approvals[-1].onward()) is not None:
        approvals.append(following)
    record.take(*approvals)
    forms = _sent_in_turn(typed, plans, approvals, cell, record)
    if typed.json:
        more = {"row": forms[1:]} if len(forms) > 1 else {}
        print_json({"ok": True, **forms[0], **more})
    return 0


def _read(files: Sequence[Path], name: str | None) -> tuple[Cell, tuple[Plan, ...]]:
    """The plans in the files, and the cell of the first."""
    plans: list[Plan] = []
    for file in files:
        plan, stated = read_plan(file)
        if stated and stated != plan.digest:
            raise FileError(
                file,
                f"was changed after the plan was made: it states digest {stated[:12]}, its content "
                f"has {plan.digest[:12]}; make a new plan",
            )
        plans.append(plan if stated else adopt_plan(cell_of(plan, name), plan))
    return cell_of(plans[0], name), tuple(plans)


def _controller(cell: Cell, typed: arguments.SendArguments) -> Controller:
    """The controller that is meant: that of the cell, at another address."""
    protocol, options = typed.protocol or cell.controller.link, cell.controller.options
    if protocol != cell.controller.link:
        options = {}
    return controller_by(protocol, typed.host, typed.port, typed.state_port, options)


def _describe(typed: arguments.SendArguments) -> str:
    """What the proof knew of the bin."""
    sources = [f"{path}" for path in (typed.scan, typed.poses) if path is not None]
    return f"compared with {' and '.join(sources)}" if sources else "by the plan's own word"


def _check_reports(cell: Cell) -> None:
    """Look whether anybody can know, between two plans, how it stands.

    Raises:
        CommandRefused: the controller does not say what became of parts, or where the robot is.
    """
    link = cell.controller.link
    if not cell.controller.motion.reports_progress:
        raise CommandRefused(
            f"the robot link {link} does not report what became of each part, so only one plan can "
            "be sent at a time"
        )
    if not reported_joints(cell):
        raise CommandRefused(
            "the controller reports no joints, so only one plan can be sent at a time"
        )


def _sent_in_turn(
    typed: arguments.SendArguments,
    plans: Sequence[Plan],
    approvals: Sequence[Approval],
    cell: Cell,
    record: ApprovalRecord,
) -> list[dict[str, Any]]:
    """Send one plan after the other as long as all is well; what was said of each.

    What is in doubt ends the row, and the approvals of what was not sent with it.
    """
    forms: list[dict[str, Any]] = []
    waiting = list(approvals)
    try:
        for plan in plans:
            if forms:
                _check_onward(cell, plan, forms[-1], len(forms), len(plans))
            forms.append(_send(typed, plan, waiting.pop(0), cell, record))
    finally:
        # Nothing of these was sent.
        for approval in waiting:
            _end(record, approval, [], "the row had ended before")
    return forms


def _check_onward(cell: Cell, plan: Plan, before: dict[str, Any], done: int, count: int) -> None:
    """Look whether the next plan of a row may follow.

    Raises:
        CommandRefused: a part was not picked, or the robot does not stand where the plan starts.
    """
    ended = f"the row has ended after {done} of {count} plans"
    for part in before["parts"]:
        if part["is_picked"] is not True:
            raise CommandRefused(f"{ended}: the pick of arm {part['arm']} failed, {part['why']}")
    # What is reported may be as old as the last bit of the motion.
    until = time.monotonic() + REPORTS
    while problem := _elsewhere(cell, plan):
        if time.monotonic() > until:
            raise CommandRefused(f"{ended}: {problem}")


def _elsewhere(cell: Cell, plan: Plan) -> str:
    """Why it is not known that the robot stands where a plan starts; empty when it is."""
    try:
        joints = reported_joints(cell)
    except CommandRefused as error:
        return str(error)
    if not joints:
        return "the controller reports no joints"
    moved = moved_away(cell, plan, joints)
    return "" if moved is None else str(moved)


def _end(record: ApprovalRecord, approval: Approval, receipts: list[Receipt], problem: str) -> None:
    try:
        record.end(approval, receipts, problem)
    except JournalError as error:
        print(f"the end of this sending is not on record: {error}", file=sys.stderr)


def _send(
    typed: arguments.SendArguments,
    plan: Plan,
    approval: Approval,
    cell: Cell,
    record: ApprovalRecord,
) -> dict[str, Any]:
    """Send an approved plan, put on record what became of it, and tell it."""
    receipts: list[Receipt] = []
    problem, began = CUT_SHORT, time.monotonic()
    try:
        with progress("send") as report:
            for receipt in send_plan(plan, approval, cell):
                receipts.append(receipt)
                words = f"{receipt.arm} {receipt.sent or receipt.heard}"
                report(receipt.done / receipt.total, words)
        problem = ""
    except WorkbenchError as error:
        problem = str(error)
        raise
    finally:
        _end(record, approval, receipts, problem)
    seconds = time.monotonic() - began
    sent = Counter(sent_receipt.arm or "both" for sent_receipt in receipts if sent_receipt.sent)
    parts = [sent_receipt.part for sent_receipt in receipts if sent_receipt.part is not None]
    protocol = cell.controller.link
    if not typed.json:
        counts = ", ".join(f"{count} for {arm}" for arm, count in sent.items())
        print(
            f"plan {plan.digest[:12]} approved by {approval.actor}, who has not seen it played, "
            f"and sent in {seconds:.1f} s"
        )
        print(f"messages by {protocol}: {counts}; the controller has ended the last motion")
        for arm in plan.arms if plan.is_tool_plan else ():
            print(
                f"{arm.arm} arm: carries {arm.tool} now: before the next plan, state "
                f'tool = "{arm.tool}" in the cell file'
            )
        for part in parts:
            print(f"arm {part.arm}: {'picked' if part.is_picked else f'failed, {part.why}'}")
    form = {"digest": plan.digest, "approved_by": approval.actor}
    form |= {"watched": not approval.is_unwatched, "protocol": protocol, "messages": dict(sent)}
    return {**form, "parts": canonical(parts), "seconds": round(seconds, 3)}
