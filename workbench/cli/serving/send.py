"""`workbench send`: a plan proven, approved by its digest, and sent."""

import sys
import time
from collections import Counter
from dataclasses import replace

from workbench.app.core.rules import approve, check_approvable
from workbench.app.picking.proving import adopted, prove
from workbench.app.records.approvals import CUT_SHORT, ApprovalRecord
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.picking.planning import cell_of, detections_from
from workbench.cli.serving.approving import check_digest, facts_of, start_words, typed_digest
from workbench.cli.serving.controller import HIGHEST_PORT
from workbench.cli.terminal import check_whole, print_json, progress
from workbench.formats.clouds.scans import read_scan
from workbench.formats.plans.plan_files import read_plan
from workbench.model.cell import Cell, Controller
from workbench.model.digest import canonical
from workbench.model.errors import CommandRefused, FileError, JournalError, WorkbenchError
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt
from workbench.plugins.robot_link import controller_by
from workbench.plugins.robot_link import send as send_plan


def send(typed: arguments.Send) -> int:
    """Prove, approve and send a plan; nothing is sent unless everything before it holds."""
    check_whole("--port", typed.port, 1, HIGHEST_PORT)
    if typed.state_port is not None:
        check_whole("--state-port", typed.state_port, 1, HIGHEST_PORT)
    plan, stated = read_plan(typed.plan)
    if stated and stated != plan.digest:
        raise FileError(
            typed.plan,
            f"was changed after the plan was made: it states digest {stated[:12]}, its content "
            f"has {plan.digest[:12]}; make a new plan",
        )
    cell = cell_of(plan, typed.cell)
    if not stated:
        plan = adopted(cell, plan)
    cell = replace(cell, controller=_controller(cell, typed))
    if typed.digest is not None:
        check_digest(plan, typed.digest)
    record = ApprovalRecord(typed.record)
    with progress("send") as report:
        make_ready(report, ("planning",))
        report(0.0, "proving the plan")
        scan = None if typed.scan is None else read_scan(typed.scan, cell.scanner)
        poses = None if typed.poses is None else detections_from(cell, typed.poses, typed.part)
        proof = prove(cell, plan, detections=poses, scan=scan)
    check_approvable(cell, plan, proof, typed.approve_as)
    if cell.approvers > 1:
        raise CommandRefused(
            f"the cell wants {cell.approvers} people to approve a plan; a command is one person's"
        )
    facts = facts_of(cell, plan, proof, _told(typed), start_words(cell, plan))
    if typed.digest is None:
        record.show(plan.digest, typed.approve_as, time.time(), facts)
        for name, value in facts.items():
            print(f"{name:>20}  {value}", file=sys.stderr if typed.json else sys.stdout, flush=True)
        check_digest(plan, typed_digest(typed.approve_as))
    valid = cell.policy.approval_minutes * 60.0
    record.check_shown(plan.digest, typed.approve_as, time.time(), valid, facts)
    # Reading takes its time.
    if start_words(cell, plan) != facts["Robot"]:
        raise CommandRefused("what is reported of the robot is otherwise now; read again")
    approval = approve(cell, plan, proof, typed.approve_as, time.time(), is_unwatched=True)
    record.take(approval)
    return _sent(typed, plan, approval, cell, record)


def _controller(cell: Cell, typed: arguments.Send) -> Controller:
    """The controller that is meant: that of the cell, at another address."""
    protocol, options = typed.protocol or cell.controller.link, cell.controller.options
    if protocol != cell.controller.link:
        options = {}
    return controller_by(protocol, typed.host, typed.port, typed.state_port, options)


def _told(typed: arguments.Send) -> str:
    """What the proof was told of the bin."""
    told = [f"{one}" for one in (typed.scan, typed.poses) if one is not None]
    return f"compared with {' and '.join(told)}" if told else "by the plan's own word"


def _sent(
    typed: arguments.Send, plan: Plan, approval: Approval, cell: Cell, record: ApprovalRecord
) -> int:
    """Send an approved plan, and put on record what became of it."""
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
        try:
            record.end(approval, receipts, problem)
        except JournalError as error:
            print(f"the end of this sending is not on record: {error}", file=sys.stderr)
    seconds = time.monotonic() - began
    sent = Counter(one.arm or "both" for one in receipts if one.sent)
    parts = [one.part for one in receipts if one.part is not None]
    protocol = cell.controller.link
    if typed.json:
        form = {"ok": True, "digest": plan.digest, "approved_by": approval.actor}
        form |= {"watched": not approval.is_unwatched, "protocol": protocol, "messages": dict(sent)}
        print_json({**form, "parts": canonical(parts), "seconds": round(seconds, 3)})
    else:
        counts = ", ".join(f"{count} for {arm}" for arm, count in sent.items())
        print(
            f"plan {plan.digest[:12]} approved by {approval.actor}, who has not seen it played, "
            f"and sent in {seconds:.1f} s"
        )
        print(f"messages by {protocol}: {counts}; the controller has ended the last motion")
        for part in parts:
            print(f"arm {part.arm}: {'picked' if part.is_picked else f'failed, {part.why}'}")
    return 0
