"""What the page says about a state, as text and HTML; no widgets, no side effects.

Everything that comes from outside (names of parts and people, messages of machines) passes
`escape` here, since HTML of the page may run scripts.
"""

import math
import time
from collections.abc import Mapping, Sequence
from html import escape

from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.results import is_failure
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.rights import what_is_missing
from workbench.app.core.state import Phase, State
from workbench.gui.shared.look import View
from workbench.model.calibration import BinCheck
from workbench.model.candidate import Candidate, Reason, Verdict
from workbench.model.cell import Cell
from workbench.model.messages.message import Message
from workbench.model.messages.states import ClearanceText, StateText
from workbench.model.plan import Proof, cycle_words, floored
from workbench.model.prediction import Predictions
from workbench.perception.scene.fill_level import parts_in_words
from workbench.proof.stages import NEAR_MARGIN_LEGS
from workbench.words.words import IN_ENGLISH, Words

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

LONG = 80
"""Letters of a status that are set smaller, so that all of it can be read."""


def sentence(text: str) -> str:
    """A text with a capital letter in front."""
    return text[:1].upper() + text[1:]


def mm(metres: float, digits: int = 1) -> str:
    """A length for people."""
    return f"{metres * 1000:.{digits}f} mm"


def clock(at: float) -> str:
    """A time of day, local, with its zone."""
    return f"{time_of_day(at)} {zone(at)}"


def when(at: float, now: float) -> str:
    """A time, local, with its zone; with its day where that is not today."""
    day, today = (time.strftime("%Y-%m-%d", time.localtime(moment)) for moment in (at, now))
    return clock(at) if day == today else f"{day} {clock(at)}"


def day_and_time(at: float) -> str:
    """A day and a time of it, local, with its zone."""
    return f"{time.strftime('%Y-%m-%d %H:%M', time.localtime(at))} {zone(at)}"


def time_of_day(at: float) -> str:
    """A time of day, local; where it stands its zone stands in the heading."""
    return time.strftime("%H:%M:%S", time.localtime(at))


def zone(at: float) -> str:
    """The name of the zone in which times are reported, as it is at that time."""
    return time.strftime("%Z", time.localtime(at))


def said(message: Message | str, words: Words = IN_ENGLISH) -> str:
    """What is on record of a moment."""
    return sentence(words.render(message))


def short(digest: str) -> str:
    """The beginning of a digest, enough to compare by eye."""
    return digest[:12]


def strip_html(state: State) -> str:
    """The steps of a cycle as a strip: done, current, to come."""
    done = REACHED[state.phase]
    # What is worked on for the next cycle while this one moves is no step of this one.
    job = None if state.phase is Phase.SENDING else state.job
    step = None if job is None else JOB_STEPS.get(job.name)
    current = done if step is None else step
    items: list[str] = []
    for number, name in enumerate(STEPS):
        look = "done" if number < done else "ahead"
        if number == current:
            # A task that is no step of the cycle keeps none of them busy.
            look = "busy" if step is not None or state.phase is Phase.SENDING else "next"
            if state.phase is Phase.FAULT:
                look = "fault"
        mark = {"done": "✓", "fault": "!"}.get(look, str(number + 1))
        items.append(
            f'<li class="wb-{look}"><span class="wb-mark">{mark}</span>'
            f"<span>{escape(name)}</span></li>"
        )
    return f'<ol class="wb-strip" data-phase="{escape(state.phase)}">{"".join(items)}</ol>'


def status_html(view: View, words: Words = IN_ENGLISH) -> str:
    """What happened last, or what goes on now with its elapsed time."""
    state, live = view.state, view.live
    if view.is_recorded:
        is_fault = state.phase is Phase.FAULT
        fault = words.render(state.fault)
        text = f"Fault: {fault}" if is_fault else said(state.message, words)
        return _box("recorded", f"<b>Recorded:</b> {escape(text)}")
    if live.unrecorded:
        what = "The sending" if state.phase is Phase.SENDING else "The task"
        return _box(
            "fault",
            f"<b>{what} has ended without a record:</b> {escape(words.render(live.unrecorded))}",
        )
    if live.getting_ready is not None and state.phase not in (Phase.FAULT, Phase.SENDING):
        # A task may wait for it, and runs then by itself.
        waiting = "" if state.job is None else f"; then: {words.render(state.message)}"
        note = f"<b>{escape(sentence(words.render(live.getting_ready.note)))}</b>{escape(waiting)}"
        return _box("busy", note, f"{100 * live.getting_ready.done:.0f} %")
    if state.job is not None and state.phase is not Phase.SENDING:
        note = words.render(live.told_of(state.job.number)[1] or state.message)
        seconds = max(0.0, view.at - live.started) if live.job == state.job.number else 0.0
        return _box("busy", f"<b>{escape(sentence(note))}</b>", f"{seconds:.1f} s")
    match state.phase:
        case Phase.FAULT:
            return _box("fault", f"<b>Fault:</b> {escape(words.render(state.fault))}")
        case Phase.SENDING:
            return _box("busy", escape(said(state.message, words)), parts_placed(state))
        case Phase.DONE:
            is_good = all(outcome.is_picked for outcome in state.outcomes) and not is_failure(
                state.message
            )
            return _box("good" if is_good else "fault", escape(said(state.message, words)))
        case _:
            text = said(state.message, words) or "Ready. Take a scan to begin."
            is_ready = isinstance(state.message, Message) and state.message.mentions(
                StateText.PLAN_READY
            )
            if state.proof is not None and is_ready:
                text = f"Plan ready: {_takes(state)}, {clearance_words(state.proof, words)}"
            return _box("fault" if is_failure(state.message) else "plain", escape(text))


def changes_html(state: State, words: Words = IN_ENGLISH) -> str:
    """What has changed since the start before, as long as nobody has acknowledged it."""
    if not state.changed:
        return ""
    since = (
        f"This has changed since {state.changed_since}; "
        "nothing is sent before an engineer acknowledges it:"
    )
    listed = "".join(f"<li>{escape(words.render(change))}</li>" for change in state.changed)
    head = f"<b>{escape(since)}</b>"
    return f'<div class="wb-status wb-changes"><div>{head}<ul>{listed}</ul></div></div>'


def _box(kind: str, left: str, right: str = "") -> str:
    # What a plan is takes more than two lines.
    length = " wb-long" if kind != "fault" and len(left) > LONG else ""
    return (
        f'<div class="wb-status wb-status-{kind}{length}"><span>{left}</span>'
        f'<span class="wb-right">{escape(right)}</span></div>'
    )


def parts_placed(state: State) -> str:
    """How many parts the controller says are placed, of how many."""
    expected = sum(len(plan.arms) for plan in state.plans)
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
    text = f"{sentence(str(missing))}." if missing else purpose
    return line(text, kind="hint", span=span, tip=purpose)


def not_saved(state: State) -> str:
    """Why there is nothing to save; empty when there is something."""
    return "" if state.saved != state.cell.digest else "nothing has changed since it was saved"


def not_undone(state: State) -> str:
    """Why no change of the cell can be undone; empty when one can."""
    return "" if state.before else "nothing was changed that could be undone"


def not_redone(state: State) -> str:
    """Why no change of the cell can be made again; empty when one can."""
    return "" if state.undone else "nothing was undone that could be made again"


SCANS = {
    "simulated": "Drops the parts into the simulated bin and scans it from above.",
    "folder": "Takes the next scan from the folder that the cell's scanner writes to.",
    "merged": "Takes a scan of each of the cell's scanners, one after the other.",
    "http": "Asks the address of the cell's scanner for a scan.",
}
"""What the scan step does, by the scanner's source."""


def scan_line(state: State) -> str:
    """What the scan step has brought."""
    purpose = SCANS.get(state.cell.scanner.source, "Takes a scan of the bin by the cell's scanner.")
    if state.scan is None:
        return hint(state, TakeScan, purpose, 2)
    at = f", {clock(state.scan.at)}" if state.scan.at else ""
    return line(f"{len(state.scan.points):,} points ({state.scan.source}){at}", span=2, tip=purpose)


def parts_line(state: State, wrong_sizes: Sequence[str] = (), check: BinCheck | None = None) -> str:
    """What the localizer has brought, of about how many, and of CAD files of a wrong size."""
    purpose = "Fits the CAD model of the part to the scan."
    if state.detections is None:
        return hint(state, FindParts, purpose, 2)
    count = len(state.detections)
    if count == 0:
        return line("No part found in this scan.", kind="bad", span=2, tip=purpose)
    scores = ", ".join(f"{detection.score:.2f}" for detection in state.detections[:4])
    more = " …" if count > 4 else ""
    noun = "part" if count == 1 else "parts"
    parts = f"{count} {noun}"
    if check is not None:
        parts = str(parts_in_words(state.cell, check, state.detections))
    found = f"{parts}, score {scores}{more}"
    warnings = (line(f"{sentence(str(size))}.", kind="bad", span=2) for size in wrong_sizes)
    return line(found, span=2, tip=purpose) + "".join(warnings)


def forecast_line(cell: Cell, predictions: Predictions | None, threshold: float) -> str:
    """What the last study says about a threshold [m]; empty when there was none."""
    forecast = None if predictions is None else predictions.near(threshold)
    if predictions is None or forecast is None:
        return ""
    pieces = [
        "" if forecast.coordinated is None else f"{forecast.coordinated:.0%} far enough apart",
        "" if forecast.success is None else f"{forecast.success:.0%} planned",
        "" if forecast.planning is None else f"in {forecast.planning * 1000:.0f} ms",
        "" if forecast.parts_per_hour is None else f"{forecast.parts_per_hour:.0f} parts an hour",
    ]
    said = ", ".join(piece for piece in pieces if piece)
    changed = "" if predictions.cell_digest == cell.digest else "; the cell was changed since"
    piles, distance = predictions.piles, mm(forecast.threshold, 0)
    where = f"Of {piles} simulated pairs at {distance}"
    return line(f"{where}: {said}{changed}", kind="hint")


def _takes(state: State) -> str:
    plan = state.plan
    if plan is None:
        return ""
    words = f"{plan.strategy.words}, {cycle_words(plan.cycle_seconds, state.bound)}"
    if len(state.plans) < 2:
        return words
    return f"{len(state.plans)} in a row, number {len(state.sent_before) + 1}: {words}"


def plan_line(state: State, words: Words = IN_ENGLISH) -> str:
    """What planning has brought."""
    purpose = "Judges every grasp with every arm, plans the motion and proves it again."
    if state.plan is None:
        if state.verdict is not None:
            kind = "warn" if state.verdict.kind is Reason.WITHIN_MARGIN else "bad"
            no_plan = StateText.NO_PLAN(verdict=state.verdict.message)
            return line(sentence(words.render(no_plan)), kind=kind, tip=purpose)
        if state.stale:
            return line(f"{sentence(words.render(state.stale))}.", kind="bad", tip=purpose)
        return hint(state, MakePlan, purpose, 3)
    plan, proof = state.plan, state.proof
    if proof is None or not proof.holds:
        why = words.render(proof.violations[0].message) if proof is not None else "there is none"
        return line(f"The proof does not hold: {why}", kind="bad", tip=purpose)
    takes = _takes(state)
    text = f"{takes}, {clearance_words(proof, words)}"
    unknown = sum(not obstacle.part for obstacle in plan.obstacles)
    if unknown:
        text += f", clear of {unknown} unknown obstacles"
    text = sentence("; ".join((text, *map(words.render, plan.remarks))))
    return line(text, kind="warn" if plan.goes_unseen else "result", tip=text)


def clearance_words(proof: Proof, words: Words = IN_ENGLISH) -> str:
    """How near a plan comes to anything on its free and on its linear motion."""
    free, linear = floored(proof.clearance), straight_bound(proof)
    if linear is None:
        return words.render(ClearanceText.FREE(free=free))
    return words.render(ClearanceText.BOTH(free=free, linear=floored(max(linear, 0.0))))


def straight_bound(proof: Proof) -> float | None:
    """What is kept [m] at least on the straight ways, where the tool may come near."""
    kept = [
        bounds.min()
        for _, leg, bounds in proof.clearances
        if leg in NEAR_MARGIN_LEGS and len(bounds)
    ]
    return float(min(kept)) if kept else None


def table_html(
    rows: list[tuple[str, str]], *, title: str = "", made: Mapping[str, str] = NOTHING_MADE
) -> str:
    """Names and values in two columns; `made` is HTML that stands instead of values, by name."""
    body = "".join(
        f"<tr><th>{escape(name)}</th><td>{made.get(name) or escape(value)}</td></tr>"
        for name, value in rows
    )
    return f'<table class="wb-facts" title="{escape(title)}">{body}</table>'


def verdict_text(verdict: Verdict) -> str:
    """The evidence of a verdict in English, without its reason."""
    pieces: list[str] = []
    if verdict.pair is not None:
        pieces.append(f"{verdict.pair[0]} · {verdict.pair[1]}")
    if verdict.distance is not None:
        pieces.append(mm(verdict.distance))
    if verdict.note is not None:
        pieces.append(str(verdict.note))
    return ", ".join(pieces)


def candidate_label(candidate: Candidate) -> str:
    """A candidate for the scene: which, its verdict, and the evidence, a line each."""
    lines = [
        f"part-{candidate.detection + 1}, {candidate.grasp.name}, {candidate.arm} arm",
        str(candidate.verdict.kind.message),
        verdict_text(candidate.verdict),
    ]
    return "\n".join(text for text in lines if text)


def joints_html(cell: Cell, joints: Mapping[str, float], heard: str = "") -> str:
    """What the controller reports of its joints [deg], in its own order.

    Args:
        cell: whose joints.
        joints: by name [rad]; empty: none is reported.
        heard: when they were reported, where that is over; empty: they are reported now.
    """
    if not joints:
        return line("The controller reports no joint values.", kind="hint")
    last = line(f"The controller reported these last at {heard}.", kind="warn") if heard else ""
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
    table = f'<table class="wb-facts wb-joints"><tr><th></th>{head}</tr>{rows}</table>'
    return last + table
