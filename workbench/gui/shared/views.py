"""What the page says about a state, as text and HTML; no widgets, no side effects.

Everything that comes from outside (names of parts and people, messages of machines) passes
`escape` here, since HTML of the page may run scripts.
"""

import math
import time
from collections.abc import Mapping
from html import escape

from workbench.app.core.commands import FindParts, MakePlan, TakeScan
from workbench.app.core.rights import what_is_missing
from workbench.app.core.state import Outline, Phase, State
from workbench.gui.shared.colours import arm_colour
from workbench.gui.shared.look import View
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
from workbench.model.plan import Plan
from workbench.model.prediction import Predictions
from workbench.model.scan import Detection

STEPS = ("Scan", "Find parts", "Plan", "Approve", "Send")

REACHED = {
    Phase.IDLE: 0,
    Phase.SCANNED: 1,
    Phase.LOCALIZED: 2,
    Phase.PLANNED: 3,
    Phase.APPROVED: 4,
    Phase.SENDING: 4,
    Phase.FAULT: 4,
    Phase.DONE: 5,
}
"""How many of the steps are done."""

NOTHING_MADE: Mapping[str, str] = {}

JOB_STEPS = {"scan": 0, "localize": 1, "plan": 2}


def sentence(text: str) -> str:
    """A text with a capital letter in front."""
    return text[:1].upper() + text[1:]


def mm(metres: float, digits: int = 1) -> str:
    """A length for people."""
    return f"{metres * 1000:.{digits}f} mm"


def clock(at: float) -> str:
    """A time of day, local."""
    return time.strftime("%H:%M:%S", time.localtime(at))


def short(digest: str) -> str:
    """The beginning of a digest, enough to compare by eye."""
    return digest[:12]


def strip_html(state: State) -> str:
    """The steps of a cycle as a strip: done, current, to come."""
    done = REACHED[state.phase]
    current = JOB_STEPS.get(state.job.name, done) if state.job is not None else done
    items: list[str] = []
    for number, name in enumerate(STEPS):
        look = "done" if number < done else "ahead"
        if number == current:
            look = "busy" if state.job is not None or state.phase is Phase.SENDING else "next"
            if state.phase is Phase.FAULT:
                look = "fault"
        mark = {"done": "✓", "fault": "!"}.get(look, str(number + 1))
        items.append(
            f'<li class="wb-{look}"><span class="wb-mark">{mark}</span>'
            f"<span>{escape(name)}</span></li>"
        )
    return f'<ol class="wb-strip" data-phase="{escape(state.phase)}">{"".join(items)}</ol>'


def status_html(view: View) -> str:
    """What happened last, or what goes on now with its elapsed time."""
    state, live = view.state, view.live
    if live.getting_ready is not None and state.phase not in (Phase.FAULT, Phase.SENDING):
        # A task may wait for it, and runs then by itself.
        waiting = "" if state.job is None else f"; then: {state.message}"
        note = f"<b>{escape(sentence(live.getting_ready.note))}</b>{escape(waiting)}"
        return _box("busy", note, f"{100 * live.getting_ready.done:.0f} %")
    if state.job is not None:
        note = live.told_of(state.job.number)[1] or state.message
        seconds = max(0.0, view.at - live.started) if live.job == state.job.number else 0.0
        return _box("busy", f"<b>{escape(sentence(note))}</b>", f"{seconds:.1f} s")
    match state.phase:
        case Phase.FAULT:
            return _box("fault", f"<b>Fault:</b> {escape(state.fault)}")
        case Phase.SENDING:
            return _box("busy", escape(sentence(state.message)), parts_placed(state))
        case Phase.DONE:
            is_good = all(one.is_picked for one in state.outcomes)
            return _box("good" if is_good else "fault", escape(sentence(state.message)))
        case _:
            message = sentence(state.message) or "Ready. Take a scan to begin."
            return _box("plain", escape(message))


def _box(kind: str, left: str, right: str = "") -> str:
    return (
        f'<div class="wb-status wb-status-{kind}"><span>{left}</span>'
        f'<span class="wb-right">{escape(right)}</span></div>'
    )


def parts_placed(state: State) -> str:
    """How many parts the controller says are placed, of how many."""
    expected = len(state.plan.arms) if state.plan is not None else 0
    return f"{state.parts_placed} of {expected} placed"


def line(text: str, *, kind: str = "result", span: int = 3, tip: str = "") -> str:
    """One line of a step: its result, or in grey what it is for."""
    return (
        f'<div class="wb-line wb-{kind} wb-span{span}" title="{escape(tip or text)}">'
        f"{escape(text)}</div>"
    )


def hint(state: State, command: type, purpose: str, span: int) -> str:
    """What a step is for, or what has to be done before."""
    missing = what_is_missing(state, command)
    text = f"{sentence(missing)}." if missing else purpose
    return line(text, kind="hint", span=span, tip=purpose)


def scan_line(state: State) -> str:
    """What the scan step has brought."""
    purpose = "Drops the parts into the simulated bin and scans it from above."
    if state.scan is None:
        return hint(state, TakeScan, purpose, 3)
    at = f", {clock(state.scan.at)}" if state.scan.at else ""
    return line(f"{len(state.scan.points):,} points ({state.scan.source}){at}", tip=purpose)


def parts_line(state: State, threshold: float) -> str:
    """What the localizer has brought."""
    purpose = "Fits the CAD model of the part to the scan."
    if state.detections is None:
        return hint(state, FindParts, purpose, 2)
    count = len(state.detections)
    if count == 0:
        return line("No part found in this scan.", kind="bad", span=2, tip=purpose)
    scores = ", ".join(f"{detection.score:.2f}" for detection in state.detections[:4])
    more = " …" if count > 4 else ""
    noun = "part" if count == 1 else "parts"
    found = f"{count} {noun}, score {scores}{more}{_apart(state.detections, threshold)}"
    return line(found, span=2, tip=purpose)


def _apart(detections: tuple[Detection, ...], threshold: float) -> str:
    """How far two parts lie from each other, and on which side of the threshold [m] that is."""
    if len(detections) != 2:
        return ""
    first, second = (detection.T_world_part.translation for detection in detections)
    distance = math.dist(first, second)
    side = "nearer than" if distance < threshold else "at least"
    return f", {mm(distance, 0)} apart, {side} the threshold"


def forecast_line(cell: Cell, predictions: Predictions | None, threshold: float) -> str:
    """What the last study says about a threshold [m]; empty when there was none."""
    forecast = None if predictions is None else predictions.near(threshold)
    if predictions is None or forecast is None:
        return ""
    pieces = [
        "" if forecast.coordinated is None else f"{forecast.coordinated:.0%} coordinated",
        "" if forecast.success is None else f"{forecast.success:.0%} planned",
        "" if forecast.planning is None else f"in {forecast.planning * 1000:.0f} ms",
        "" if forecast.parts_per_hour is None else f"{forecast.parts_per_hour:.0f} parts an hour",
    ]
    said = ", ".join(piece for piece in pieces if piece)
    changed = "" if predictions.cell_digest == cell.digest else "; the cell was changed since"
    text = f"Study of {predictions.piles} pairs at {mm(forecast.threshold, 0)}: {said}{changed}"
    return line(text, kind="hint")


def plan_line(state: State) -> str:
    """What planning has brought."""
    purpose = "Judges every grasp with every arm, plans the motion and proves it again."
    if state.plan is None:
        if state.verdict is not None:
            return line(f"No plan: {state.verdict}", kind="bad", tip=purpose)
        if state.stale:
            return line(f"{sentence(state.stale)}.", kind="bad", tip=purpose)
        return hint(state, MakePlan, purpose, 3)
    plan, proof = state.plan, state.proof
    if proof is None or not proof.holds:
        why = str(proof.findings[0]) if proof is not None else "there is none"
        return line(f"The proof does not hold: {why}", kind="bad", tip=purpose)
    takes = f"{plan.strategy.words}, {plan.cycle_seconds:.1f} s"
    text = f"{takes}, smallest clearance {mm(proof.clearance)}"
    if plan.obstacles:
        text += f", clear of {len(plan.obstacles)} unknown obstacles"
    text = sentence(f"{text}; {plan.note}" if plan.note else text)
    return line(text, tip=text)


def send_line(state: State) -> str:
    """How far the plan has gone out."""
    purpose = "Sends the approved plan to the robot controller."
    if not state.receipts:
        return line("Nothing sent.", kind="hint", span=1, tip=purpose)
    last = state.receipts[-1]
    return line(f"{last.done} of {last.total} messages sent", span=1, tip=purpose)


def table_html(
    rows: list[tuple[str, str]], *, title: str = "", made: Mapping[str, str] = NOTHING_MADE
) -> str:
    """Names and values in two columns; `made` is HTML that stands in place of values, by name."""
    body = "".join(
        f"<tr><th>{escape(name)}</th><td>{made.get(name) or escape(value)}</td></tr>"
        for name, value in rows
    )
    return f'<table class="wb-facts" title="{escape(title)}">{body}</table>'


def verdict_text(verdict: Verdict) -> str:
    """The evidence of a verdict, without its reason."""
    pieces: list[str] = []
    if verdict.pair is not None:
        pieces.append(f"{verdict.pair[0]} · {verdict.pair[1]}")
    if verdict.distance is not None:
        pieces.append(mm(verdict.distance))
    if verdict.note:
        pieces.append(verdict.note)
    return ", ".join(pieces)


def candidate_label(candidate: Candidate) -> str:
    """A candidate for the scene: which, its verdict, and the evidence, a line each."""
    lines = [
        f"part-{candidate.detection + 1}, {candidate.grasp.name}, {candidate.arm} arm",
        str(candidate.verdict.reason),
        verdict_text(candidate.verdict),
    ]
    return "\n".join(text for text in lines if text)


def plan_html(cell: Cell, plan: Plan, seconds: tuple[tuple[str, float], ...]) -> str:
    """The plan in a few chips: what, how long, and what computing it took."""
    arms = [arm.name for arm in cell.arms]
    chips = [
        f'<span class="wb-chip" style="background:{arm_colour(arms.index(arm.arm))}">'
        f"{escape(arm.arm)}: part-{arm.detection + 1}, {escape(arm.grasp)}</span>"
        for arm in plan.arms
    ]
    times = " · ".join(f"{stage} {value * 1000:.0f} ms" for stage, value in seconds)
    note = f'<div class="wb-small">{escape(sentence(plan.note))}</div>' if plan.note else ""
    return (
        f'<div class="wb-pad">{"".join(chips)}'
        f'<div class="wb-small" title="{escape(plan.digest)}">{escape(plan.strategy.words)}, '
        f"{escape(plan.guarantee)}, plan {short(plan.digest)}</div>"
        f"{note}"
        f'<div class="wb-small">computed in {escape(times)}</div></div>'
    )


def outlines_html(outlines: tuple[Outline, ...]) -> str:
    """What the plannings for these parts brought, the latest first, when there is a choice."""
    if len(outlines) < 2:
        return ""
    heads = "".join(
        f'<th class="{"wb-number" if is_number else ""}">{title}</th>'
        for title, is_number in (
            ("Plans for these parts", False),
            ("Planner", False),
            ("Cycle", True),
            ("Planning", True),
            ("Clearance", True),
            ("Arms apart", True),
        )
    )
    rows = "".join(
        _outline_row(outline, place == 0) for place, outline in enumerate(reversed(outlines))
    )
    return (
        f'<table class="wb-facts wb-plans"><thead><tr>{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table>"
    )


def _outline_row(outline: Outline, is_latest: bool) -> str:
    what = f"{outline.strategy}, {outline.parts} part{'' if outline.parts == 1 else 's'}"
    what = outline.verdict if outline.verdict else what
    values = (
        "" if outline.cycle is None else f"{outline.cycle:.1f} s",
        f"{outline.planning * 1000:.0f} ms",
        "" if outline.clearance is None else mm(outline.clearance),
        "" if outline.apart is None else mm(outline.apart, 0),
    )
    numbers = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    chosen = ' class="wb-latest"' if is_latest else ""
    title = escape(f"{outline.guarantee} {short(outline.digest)}".strip())
    return (
        f'<tr{chosen} title="{title}"><td>{escape(what)}</td>'
        f"<td>{escape(outline.planner)}</td>{numbers}</tr>"
    )


def joints_html(cell: Cell, joints: Mapping[str, float]) -> str:
    """What the controller reports of its joints [deg], in its own order."""
    if not joints:
        return line("The controller reports no joint values.", kind="hint")
    most = max(len(arm.joints) for arm in cell.arms)
    head = "".join(f"<th>{escape(arm.name)} [deg]</th>" for arm in cell.arms)
    rows = ""
    for axis in range(most):
        cells = ""
        for arm in cell.arms:
            known = axis < len(arm.joints)
            joint = arm.joints[arm.axis_order[axis]] if known else ""
            value = joints.get(joint)
            text = "-" if value is None else f"{math.degrees(value) * arm.axis_signs[axis]:.2f}"
            cells += f'<td class="wb-number">{text}</td>'
        rows += f"<tr><th>Axis {axis + 1}</th>{cells}</tr>"
    return f'<table class="wb-facts wb-joints"><tr><th></th>{head}</tr>{rows}</table>'
