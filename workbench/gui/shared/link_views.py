"""What the page says about the robot link; text and HTML, as in `views`."""

from collections.abc import Mapping
from html import escape

import numpy as np

from workbench.app.core.cycle.sending import step_reported
from workbench.app.core.state import Phase, State
from workbench.gui.shared.look import View
from workbench.gui.shared.views import clock, line, parts_placed, table_html
from workbench.gui.texts.cycle import LinkPageText
from workbench.gui.texts.labels import LabelText, arm_label
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import shown_axes, units_said
from workbench.model.messages.message import FoundPart, Message, as_message
from workbench.model.release import LinkStatus, PartReport, Receipt
from workbench.words.words import IN_ENGLISH, Words

NO_SAFETY = (
    "Stop closes the link and asks the controller to stop. It is not a safety function: in danger "
    "use the emergency stop."
)

WORDS = {
    Phase.SENDING: "sending",
    Phase.DONE: "closed; the controller has reported the end",
    Phase.FAULT: "closed by a fault",
}


def unproven_html(state: State, words: Words = IN_ENGLISH) -> str:
    """What is not proven, and whether anybody approves; empty where the link sends paths."""
    if not state.cell.controller.motion.sends_poses:
        return ""
    lines = line(words.render(LinkPageText.POSES()), kind="warn")
    if state.unapproved_by:
        by = LinkPageText.UNAPPROVED(person=state.unapproved_by)
        lines += line(words.render(by), kind="warn")
    return lines


def link_html(view: View, words: Words = IN_ENGLISH) -> str:
    """Protocol, how the link stands, what went out last and what was answered, and the parts."""
    state, link, controller = view.state, view.live.link, view.state.cell.controller
    phase = as_message(WORDS.get(state.phase, "closed"))
    if state.phase is Phase.SENDING and link.phase:
        phase = as_message(link.phase)
        number = step_reported(state)
        if number and state.plan is not None:
            phase = LinkPageText.STEP(phase=phase, number=number, total=len(state.plan.sequence))
    name = LabelText.NAME(name=controller.link)
    if link.version:
        name = LinkPageText.VERSION(link=controller.link, version=link.version)
    facts: list[tuple[Message | str, Message | str]] = [
        ("Controller", LabelText.ADDRESS(host=controller.host, port=controller.port)),
        ("Robot link", name),
        ("Link", phase),
        ("Last report of the robot", view.live.robot or "none (no state report)"),
        ("Fault", state.fault or "none to acknowledge"),
    ]
    if link.acknowledged:
        facts.append(("Last answer at", clock(link.acknowledged_at)))
    if link.reported_at and state.phase is Phase.SENDING:
        age = max(0.0, view.at - link.reported_at)
        facts.append(("Last report", LinkPageText.AGO(age=age)))
    if link.stop:
        facts.append(("Stop", link.stop))
    if state.receipts:
        last = state.receipts[-1]
        at = (LinkPageText.SENT_AT if last.sent else LinkPageText.RECEIVED_AT)(at=clock(last.at))
        facts += [
            ("Messages", LinkPageText.COUNT(count=last.done, total=last.total)),
            ("Last message", at),
            ("Content", _wire(last, link)),
        ]
    if state.plan is not None:
        facts.append(("Parts", parts_placed(state, words)))
    facts += [(arm_label(r.arm), _part(r)) for r in state.part_reports]
    rows = [(words.render(title), words.render(fact)) for title, fact in facts]
    bar = ""
    if state.receipts:
        share = 100 * state.receipts[-1].done / state.receipts[-1].total
        bar = f'<div class="wb-bar"><i style="width:{share:.1f}%"></i></div>'
    return table_html(rows) + bar + line(NO_SAFETY, kind="hint")


def _wire(last: Receipt, link: LinkStatus) -> Message:
    """The last message and its answer as the protocol has them, for who looks for a fault."""
    sent, answer = last.sent or last.heard, link.acknowledged
    if sent and answer:
        return LinkPageText.ANSWERED(sent=sent, answer=answer)
    return LabelText.NAME(name=sent or answer)


def _part(report: PartReport) -> Message:
    part = FoundPart(report.detection)
    if report.is_picked:
        return LinkPageText.PICKED(part=part)
    why = as_message(report.why)
    text = LinkPageText.UNKNOWN if report.is_picked is None else LinkPageText.FAILED
    return text(part=part, why=why)


def joints_html(
    cell: Cell, joints: Mapping[str, float], heard: str = "", words: Words = IN_ENGLISH
) -> str:
    """What the controller reports of its joints [deg, mm], as it counts them.

    Args:
        cell: whose joints.
        joints: by name [rad]; empty: none is reported.
        heard: when they were reported, where that is over; empty: they are reported now.
        words: of who reads it.
    """
    if not joints:
        return line("The controller reports no joint values.", kind="hint")
    reported = words.render(LinkPageText.REPORTED_LAST(at=heard))
    last = line(reported, kind="warn") if heard else ""
    most = max(len(arm.joints) for arm in cell.arms)
    shown = [_shown(cell, arm, joints) for arm in cell.arms]
    heads = (
        words.render(LinkPageText.ARM_UNITS(arm=arm.name, units=units_said(cell, arm)))
        for arm in cell.arms
    )
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    rows = ""
    for axis in range(most):
        cells = ""
        for values in shown:
            text = f"{values[axis]:.2f}" if axis < len(values) else "-"
            cells += f'<td class="wb-number">{text}</td>'
        name = words.render(LabelText.AXIS(number=axis + 1))
        rows += f"<tr><th>{escape(name)}</th>{cells}</tr>"
    table = f'<table class="wb-facts wb-joints"><tr><th></th>{head}</tr>{rows}</table>'
    return last + table


def _shown(cell: Cell, arm: Arm, joints: Mapping[str, float]) -> list[float]:
    """An arm's axes [deg, mm] as its controller counts them; none where one is not reported."""
    if not all(name in joints for name in arm.joints):
        return []
    q = np.array([joints[name] for name in arm.joints])
    return shown_axes(cell, arm, q).tolist()
