"""What the page says about a state, as text and HTML; no widgets, no side effects.

Everything that comes from outside (names of parts and people, messages of machines) passes
`escape` here, since HTML of the page may run scripts.
"""

import re
import time
import unicodedata
from collections.abc import Mapping, Sequence
from html import escape
from itertools import accumulate

from workbench.app.core.cell.views import views_message
from workbench.app.core.cycle.arm_scanner import is_at_view
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.results import is_failure
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import placed_by_now
from workbench.app.core.hands import hands_message
from workbench.app.core.rights import what_is_missing
from workbench.app.core.state import Phase, State
from workbench.gui.shared.look import View
from workbench.gui.texts.cycle import CyclePageText, StatusText
from workbench.gui.texts.labels import LabelText
from workbench.model.calibration import BinCheck
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
from workbench.model.messages.message import Message, as_message
from workbench.model.messages.plans import strategy_message
from workbench.model.messages.states import StateText
from workbench.model.plan import Plan, Proof
from workbench.model.prediction import Predictions
from workbench.model.release import PickResult
from workbench.perception.bins.fill_level import parts_in_words
from workbench.proof.claims.clearance import bounds_message
from workbench.words.words import IN_ENGLISH, Words

CYCLE_STEPS = ("Scan", "Find parts", "Plan", "Approve", "Send")

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

JOB_STEPS = {"scan": 0, "localize": 1, "plan": 2, "view": 2, "stir": 2, "change": 2, "drop": 2}

BEFORE_PLAN = 2
"""Steps that a plan to the view does without."""

MOST_SCORES = 4
"""Of parts that are written one by one; of more the best and the worst."""

AFTER_FAULT = "Bring the robot home, see that its hands are empty, then acknowledge."
AFTER_SIMULATED_FAULT = "The simulated robot goes home by itself; then acknowledge."

LONG = 60
"""Columns of a state line; a letter of Chinese takes two.  What is longer goes on below."""

LINE = 48
"""Columns of the first line of a state that goes on below: the button leaves room for them."""

_BREAKS = re.compile(r"(?<=[,;:] )|(?<=[，；：。])")


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


def message_text(message: Message | str, words: Words = IN_ENGLISH) -> str:
    """What is on record of a moment."""
    return sentence(words.render(message))


def short(digest: str) -> str:
    """The beginning of a digest, enough to compare by eye."""
    return digest[:12]


def strip_html(state: State) -> str:
    """The steps of a cycle as a strip: done, current, to come."""
    done, plan = REACHED[state.phase], state.plan
    is_to_view = plan is not None and not plan.picks and not plan.is_stir_plan
    if is_to_view and state.phase is Phase.DONE:
        done = 0
    # What is worked on for the next cycle while this one moves is no step of this one.
    job = None if state.phase is Phase.SENDING else state.job
    step = None if job is None else JOB_STEPS.get(job.name)
    current = done if step is None else step
    items: list[str] = []
    for number, name in enumerate(CYCLE_STEPS):
        is_skipped = number < BEFORE_PLAN and (is_to_view or state.scan is None)
        look = "done" if number < done and not is_skipped else "ahead"
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
        fault = StatusText.FAULT(fault=as_message(state.fault))
        text = message_text(fault if is_fault else state.message, words)
        return _box("recorded", text, title="Recorded:")
    if live.unrecorded:
        is_sending = state.phase is Phase.SENDING
        what = StatusText.UNRECORDED_SENDING if is_sending else StatusText.UNRECORDED_TASK
        why = words.render(live.unrecorded)
        return _box("fault", why, title=words.render(what()))
    if live.getting_ready is not None and state.phase not in (Phase.FAULT, Phase.SENDING):
        # A task may wait for it, and runs then by itself.
        then = words.render(StatusText.THEN(message=as_message(state.message)))
        waiting = "" if state.job is None else f"; {then}"
        getting_ready = sentence(words.render(live.getting_ready.note))
        right = f"{100 * live.getting_ready.done:.0f}%"
        return _box("busy", waiting, right, title=getting_ready)
    if state.job is not None and state.phase is not Phase.SENDING:
        note = words.render(live.progress_of(state.job.number)[1] or state.message)
        seconds = max(0.0, view.at - live.started) if live.job == state.job.number else 0.0
        return _box("busy", "", f"{seconds:.1f} s", title=sentence(note))
    match state.phase:
        case Phase.FAULT:
            is_simulated = state.cell.controller.is_simulated
            then = AFTER_SIMULATED_FAULT if is_simulated else AFTER_FAULT
            fault, held = words.render(state.fault), words.render(hands_message(state))
            return _box("fault", fault, title="Fault:", then=then, held=held)
        case Phase.SENDING:
            return _box("busy", message_text(state.message, words), parts_placed(state, words))
        case Phase.DONE:
            is_good = all(
                outcome.became is PickResult.PICKED for outcome in state.outcomes
            ) and not is_failure(state.message)
            return _box("good" if is_good else "fault", message_text(state.message, words))
        case _:
            text = message_text(state.message, words) or "Ready. Take a scan to begin."
            if not state.message and not is_at_view(state.cell, live.joints):
                text = "Ready. Take the scanner to its view to begin."
            is_ready = isinstance(state.message, Message) and state.message.mentions(
                StateText.PLAN_READY
            )
            if state.plan is not None and is_ready:
                text = words.render(_ready_message(state, state.plan))
            return _box("fault" if is_failure(state.message) else "plain", text)


def changes_html(state: State, words: Words = IN_ENGLISH) -> str:
    """What has changed since the start before, as long as nobody has acknowledged it."""
    if not state.changed:
        return ""
    since = words.render(StatusText.CHANGED_SINCE(since=state.changed_since))
    listed = "".join(f"<li>{escape(words.render(change))}</li>" for change in state.changed)
    head = f"<b>{escape(since)}</b>"
    return f'<div class="wb-status wb-changes"><div>{head}<ul>{listed}</ul></div></div>'


def _box(
    kind: str, text: str, right: str = "", *, title: str = "", then: str = "", held: str = ""
) -> str:
    """A state: `title` in bold and the text behind it; what is too long goes on below, smaller.

    `held`, what hands may hold, and `then`, the next step, stand below.
    """
    first, rest = split_line(f"{title} {text}".strip() if text[:1] != ";" else title + text)
    rest = f"<small>{escape(rest)}</small>" if rest else ""
    shown = escape(first)
    if title and first.startswith(title):
        shown = f"<b>{escape(title)}</b>{escape(first[len(title) :])}"
    tip = f' title="{escape(text)}"' if rest else ""
    then = "".join(f"<small><b>{escape(below)}</b></small>" for below in (held, then) if below)
    return (
        f'<div class="wb-status wb-status-{kind}"{tip}><span>{shown}{rest}{then}</span>'
        f'<span class="wb-right">{escape(right)}</span></div>'
    )


def split_line(text: str) -> tuple[str, str]:
    """A text as a first line, of up to `LONG` columns, and the rest of it."""
    columns = [2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text]
    if sum(columns) <= LONG:
        return text, ""
    ends = list(accumulate(columns))
    most = sum(end <= LINE for end in ends)
    breaks = [found.end() for found in _BREAKS.finditer(text, 0, most + 1)]
    at = max((place for place in breaks if place > most // 2), default=0)
    at = at or text.rfind(" ", 0, most + 1) + 1 or most
    return text[:at].rstrip(), text[at:]


def parts_placed(state: State, words: Words = IN_ENGLISH) -> str:
    """How many parts are placed, by what the controller reports, of how many."""
    expected = sum(len(plan.picks) for plan in state.plans if not plan.stations)
    if not expected:
        return ""
    return words.render(
        StatusText.PLACED(count=min(placed_by_now(state), expected), total=expected)
    )


def line(text: str, *, kind: str = "result", span: int = 3, tip: str = "") -> str:
    """One line of a step: its result, or in grey what it is for."""
    return (
        f'<div class="wb-line wb-{kind} wb-span{span}" title="{escape(tip or text)}">'
        f"{escape(text)}</div>"
    )


def hint(state: State, command: type, purpose: str, span: int, words: Words = IN_ENGLISH) -> str:
    """What a step is for; nothing while another one has to come before, as its button says."""
    missing = words.render(what_is_missing(state, command))
    return line("" if missing else purpose, kind="hint", span=span, tip=missing or purpose)


def not_saved(state: State) -> str:
    """Why there is nothing to save; empty when there is something."""
    return "" if not state.is_saved else "nothing has changed since it was saved"


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


def scan_line(state: State, words: Words = IN_ENGLISH) -> str:
    """What the scan step has brought."""
    purpose = SCANS.get(state.cell.scanner.source, "Takes a scan of the bin by the cell's scanner.")
    if state.scan is None:
        return hint(state, TakeScan, purpose, 2, words)
    points, source = len(state.scan.points), as_message(state.scan.source)
    scanned = CyclePageText.SCANNED(points=points, source=source)
    if state.scan.at:
        scanned = CyclePageText.SCANNED_AT(points=points, source=source, at=clock(state.scan.at))
    said = line(words.render(scanned), span=2, tip=purpose)
    if (about := views_message(state)) is None:
        return said
    is_off = any(view.is_off for view in state.scan.views)
    return said + line(words.render(about), kind="bad" if is_off else "hint", span=2)


def parts_line(
    state: State,
    wrong_sizes: Sequence[Message | str] = (),
    check: BinCheck | None = None,
    words: Words = IN_ENGLISH,
) -> str:
    """What the localizer has brought, of about how many, and of CAD files of a wrong size."""
    purpose = "Fits the CAD model of the part to the scan."
    if state.detections is None:
        return hint(state, FindParts, purpose, 2, words)
    count = len(state.detections)
    if count == 0:
        return line("No part found in this scan.", kind="bad", span=2, tip=purpose)
    if state.scan is None:
        return line(words.render(CyclePageText.PLACED(count=count)), span=2, tip=purpose)
    found = sorted(part.score for part in state.detections if not part.is_by_hand)
    found = found if count <= MOST_SCORES else [found[0], found[-1]]
    between = " – " if count > MOST_SCORES else ", "
    scores = between.join(f"{score:.2f}" for score in reversed(found)) or words.say("by hand")
    parts = LabelText.PARTS(count=count)
    if check is not None:
        parts = as_message(parts_in_words(state.cell, check, state.detections))
    found = CyclePageText.FOUND(parts=parts, scores=scores)
    problems = (f"{sentence(words.render(size))}." for size in wrong_sizes)
    warnings = (line(problem, kind="bad", span=2) for problem in problems)
    return line(words.render(found), span=2, tip=purpose) + "".join(warnings)


def forecast_line(
    cell: Cell, predictions: Predictions | None, threshold: float, words: Words = IN_ENGLISH
) -> str:
    """What the last study says about a threshold [m]; empty when there was none."""
    forecast = None if predictions is None else predictions.near(threshold)
    if predictions is None or forecast is None:
        return ""
    facts: list[Message] = []
    if forecast.coordinated is not None:
        facts.append(CyclePageText.FORECAST_APART(share=forecast.coordinated))
    if forecast.success is not None:
        facts.append(CyclePageText.FORECAST_PLANNED(share=forecast.success))
    if forecast.planning is not None:
        facts.append(CyclePageText.FORECAST_TIME(time=forecast.planning))
    if forecast.parts_per_hour is not None:
        facts.append(CyclePageText.FORECAST_RATE(count=round(forecast.parts_per_hour)))
    is_same = predictions.cell_digest == cell.digest
    of_pairs = CyclePageText.FORECAST if is_same else CyclePageText.FORECAST_OTHER_CELL
    text = of_pairs(piles=predictions.piles, distance=forecast.threshold, facts=facts)
    return line(words.render(text), kind="hint")


def _ready_message(state: State, plan: Plan) -> Message:
    text = CyclePageText.PLAN(
        strategy=strategy_message(plan.strategy), time=plan.cycle_seconds, count=len(plan.picks)
    )
    if len(state.plans) > 1:
        number = len(state.sent_before) + 1
        text = CyclePageText.PLAN_OF_ROW(count=len(state.plans), number=number, plan=text)
    return StatusText.PLAN_READY(plan=text)


def clearance_words(proof: Proof, words: Words = IN_ENGLISH) -> str:
    """How near a plan comes to anything on its free and on its linear motion."""
    return words.render(bounds_message(proof))


def table_html(
    rows: list[tuple[str, str]], *, title: str = "", made: Mapping[str, str] = NOTHING_MADE
) -> str:
    """Names and values in two columns; `made` is HTML that stands instead of values, by name."""
    body = "".join(
        f"<tr><th>{escape(name)}</th><td>{made.get(name) or escape(value)}</td></tr>"
        for name, value in rows
    )
    return f'<table class="wb-facts" title="{escape(title)}">{body}</table>'


def _evidence(verdict: Verdict) -> str:
    """Which bodies, and how far apart they are [mm]."""
    pieces: list[str] = []
    if verdict.pair is not None:
        pieces.append(f"{verdict.pair[0]} · {verdict.pair[1]}")
    if verdict.distance is not None:
        pieces.append(mm(verdict.distance))
    return ", ".join(pieces)


def candidate_label(candidate: Candidate) -> str:
    """A candidate for the scene: which, the kind of its verdict, and the evidence, a line each.

    All browsers share it, so each line is a name, a number, or a text that is translated whole.
    """
    lines = [
        f"part-{candidate.detection + 1}, {candidate.grasp_label}, {candidate.arm}",
        str(candidate.verdict.kind.message),
        _evidence(candidate.verdict),
    ]
    return "\n".join(text for text in lines if text)
