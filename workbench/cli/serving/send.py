"""`workbench send`: a plan proven, approved by name, and sent."""

import time
from collections import Counter
from dataclasses import replace

from workbench.app.core.rules import approve
from workbench.app.picking.proving import adopted, prove
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.picking.planning import cell_of
from workbench.cli.serving.controller import HIGHEST_PORT
from workbench.cli.terminal import check_whole, print_json, progress
from workbench.formats.plans.plan_files import read_plan
from workbench.model.digest import canonical
from workbench.model.errors import FileError
from workbench.model.release import PartReport
from workbench.plugins.robot_link import controller_by
from workbench.plugins.robot_link import send as send_plan


def send(typed: arguments.Send) -> int:
    """Prove, approve and send a plan; nothing is sent unless everything before it holds."""
    check_whole("--port", typed.port, 1, HIGHEST_PORT)
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
    protocol, options = typed.protocol or cell.controller.link, cell.controller.options
    if protocol != cell.controller.link:
        options = {}
    controller = controller_by(protocol, typed.host, typed.port, options=options)
    cell = replace(cell, controller=controller)
    with progress("send") as report:
        make_ready(report, ("planning",))
        began = time.monotonic()
        report(0.0, "proving the plan")
        proof = prove(cell, plan)
        approval = approve(cell, plan, proof, typed.approve_as, time.time())
        sent: Counter[str] = Counter()
        parts: list[PartReport] = []
        for receipt in send_plan(plan, approval, cell):
            if receipt.sent:
                sent[receipt.arm or "both"] += 1
            if receipt.part is not None:
                parts.append(receipt.part)
            report(receipt.done / receipt.total, f"{receipt.arm} {receipt.sent or receipt.heard}")
    seconds = time.monotonic() - began
    if typed.json:
        form = {"ok": True, "digest": plan.digest, "approved_by": approval.actor}
        form |= {"protocol": protocol, "messages": dict(sent), "parts": canonical(parts)}
        print_json({**form, "seconds": round(seconds, 3)})
    else:
        counts = ", ".join(f"{count} for {arm}" for arm, count in sent.items())
        print(f"plan {plan.digest[:12]} approved by {approval.actor} and sent in {seconds:.1f} s")
        print(f"messages by {protocol}: {counts}; the controller has ended the last motion")
        for part in parts:
            print(f"arm {part.arm}: {'picked' if part.is_picked else f'failed, {part.why}'}")
    return 0
