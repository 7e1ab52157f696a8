"""What the page says about the robot link; text and HTML, as in `views`."""

from workbench.app.core.state import Phase
from workbench.gui.shared.look import View
from workbench.gui.shared.views import clock, line, parts_placed, table_html
from workbench.model.release import LinkStatus, PartReport, Receipt

NO_SAFETY = (
    "Stop closes the link and asks the controller to stop. It is not a safety function: in danger "
    "use the emergency stop."
)

WORDS = {
    Phase.SENDING: "sending",
    Phase.DONE: "closed; the controller has reported the end",
    Phase.FAULT: "closed by a fault",
}


def link_html(view: View) -> str:
    """Protocol, how the link stands, what went out last and what was answered, and the parts."""
    state, link, controller = view.state, view.live.link, view.state.cell.controller
    phase = WORDS.get(state.phase, "closed")
    if state.phase is Phase.SENDING and link.phase:
        phase = link.phase + (f", step {link.step} of {link.steps}" if link.step else "")
    rows = [
        ("Controller", f"{controller.host} port {controller.port}"),
        ("Robot link", controller.link + (f" (speaks {link.version})" if link.version else "")),
        ("Link", phase),
        ("Robot's last word", str(view.live.robot or "none (no state report)")),
        ("Fault here", str(state.fault or "none to acknowledge")),
    ]
    if link.acknowledged:
        rows.append(("Last answer at", clock(link.acknowledged_at)))
    if link.reported_at and state.phase is Phase.SENDING:
        rows.append(("Last report", f"{max(0.0, view.at - link.reported_at):.1f} s ago"))
    if link.stop:
        rows.append(("Stop", str(link.stop)))
    if state.receipts:
        last = state.receipts[-1]
        rows += [
            ("Messages", f"{last.done} of {last.total}"),
            ("Last message", f"{'sent' if last.sent else 'heard'} at {clock(last.at)}"),
            ("On the wire", _wire(last, link)),
        ]
    if state.plan is not None:
        rows.append(("Parts", parts_placed(state)))
    rows += [(f"{part.arm.capitalize()} arm", _part(part)) for part in state.part_reports]
    bar = ""
    if state.receipts:
        share = 100 * state.receipts[-1].done / state.receipts[-1].total
        bar = f'<div class="wb-bar"><i style="width:{share:.1f}%"></i></div>'
    return table_html(rows) + bar + line(NO_SAFETY, kind="hint")


def _wire(last: Receipt, link: LinkStatus) -> str:
    """The last message and its answer as the protocol has them, for who looks for a fault."""
    words = [last.sent or last.heard, link.acknowledged]
    return ", answered by ".join(word for word in words if word)


def _part(part: PartReport) -> str:
    name = f"part-{part.detection + 1}"
    match part.is_picked:
        case True:
            return f"{name} picked"
        case False:
            return f"{name} failed: {part.why}"
        case None:
            return f"{name} not known: {part.why}"
