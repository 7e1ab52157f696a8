"""What a person reads of a session: who, when, what was shown, proven, sent, heard, done besides.

Tables of texts, made from the states of the session computed again; how they look is the matter of
`pages`.
"""

import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from workbench.app.core.command import Entry
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, NextStep, SendPlan, Sent, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import MACHINES
from workbench.app.core.session import AcknowledgeChanges, Started
from workbench.app.core.state import Phase, State, format_count
from workbench.model.plan import Plan, PlanResult, Proof
from workbench.model.release import manner_words
from workbench.model.scan import Scan
from workbench.proof.claims.clearance import speed_message

BROUGHT: Mapping[type[object], str] = {Scan: "scan", tuple: "parts", PlanResult: "plan"}
"""What a task brought, by the type of its result."""

USUAL_COMMANDS = (
    GoOn,
    TakeScan,
    FindParts,
    MakePlan,
    WantThreshold,
    WatchPlan,
    Approve,
    SendPlan,
    NextStep,
)
"""What people do in every cycle; whatever else they do is an intervention."""


@dataclass(frozen=True, slots=True)
class ReportTable:
    """A table with what it says in a sentence or two; without columns, rows are name and value."""

    title: str
    says: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


Moment = tuple[Entry, State]


def tables_of(
    head: Mapping[str, str], moments: Iterable[Moment], broke: str = ""
) -> list[ReportTable]:
    """The report of a session.

    Args:
        head: name -> value, what is known of the session and this bundle.
        moments: entries with the states after them, in order.
        broke: why they end before the journal does; empty when they do not.
    """
    entries = list(moments)
    says = (
        "Times are UTC by the clock of the machine. Digests are SHA-256. Whether anything was "
        "changed since it was signed is told by verify.py with the signer's public key, not by "
        "this report."
    )
    if broke:
        says += f" The session could not be computed again to its end: {broke}."
    tables = [ReportTable("Session", says, (), tuple(head.items()))]
    tables.append(_starts(entries))
    tables.append(_people(entries))
    for number, cycle in enumerate(_cycles(entries), 1):
        tables.append(_cycle(number, cycle))
    tables.append(_interventions(entries))
    tables.append(_log(entries))
    return tables


def clock(at: float) -> str:
    """A time [s since the epoch] as people read it, in UTC."""
    return time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(at)) + f".{int(at * 1000) % 1000:03d}"


def _starts(entries: list[Moment]) -> ReportTable:
    rows: list[tuple[str, ...]] = []
    for entry, state in entries:
        match entry.command:
            case Started(ran=ran, changes=changes):
                what = f"workbench {ran.workbench} ({ran.files[:12]}), {ran.python}"
                users = ", ".join(f"{name} ({role})" for name, role in ran.users.items()) or "none"
                parts = ", ".join(f"{name} {digest[:12]}" for name, digest in ran.parts.items())
                listed = f"{len(ran.distributions)} distributions; users: {users}; parts: {parts}"
                changed = "; changed: " + "; ".join(map(str, changes)) if changes else ""
                says = f"{what}, {ran.processor}, {ran.system}; {listed}{changed}"
                rows.append((clock(entry.at), "start", f"{says}; inventory {ran.digest[:12]}"))
            case AcknowledgeChanges():
                rows.append((clock(entry.at), entry.actor, str(state.message)))
            case _:
                pass
    says = "At every start; the inventory is in the journal with all its digests."
    if not rows:
        says = "Nothing is on record: the session is from before that was."
    return ReportTable("What ran", says, ("when", "who", "what"), tuple(rows))


def _people(entries: list[Moment]) -> ReportTable:
    counts = Counter((e.actor, str(e.role)) for e, _ in entries if e.actor not in MACHINES)
    rows = tuple((name, role, str(count)) for (name, role), count in sorted(counts.items()))
    return ReportTable("Who acted", "", ("name", "role", "commands"), rows)


def _cycles(entries: list[Moment]) -> Iterator[list[Moment]]:
    """From one sending to the next: all moments from the end of the cycle before.

    Of a row the end of a sending is the beginning of the next one, too.
    """
    cycle: list[Moment] = []
    for moment in entries:
        cycle.append(moment)
        if isinstance(moment[0].command, LinkEnded):
            yield cycle
            cycle = [moment] if moment[1].phase is Phase.SENDING else []
    if any(isinstance(entry.command, SendPlan | LinkEnded) for entry, _ in cycle):
        yield cycle


def _cycle(number: int, cycle: list[Moment]) -> ReportTable:
    sent = next((place for place, (e, _) in enumerate(cycle) if isinstance(e.command, SendPlan)), 0)
    entry, state = cycle[sent]
    before = cycle[:sent]
    rows: list[tuple[str, str]] = []
    if state.plan is not None and state.proof is not None:
        rows += _plan(state.plan, state.proof)
    rows += _in_row(state)
    rows += _list_shown(before, state)
    rows += _list_approval(before, state)
    sender = f"by {entry.actor}" if isinstance(entry.command, SendPlan) else "after the one before"
    rows.append(("sent", f"{clock(entry.at)} {sender} (entry {entry.number})"))
    rows += _list_reports(cycle[sent + 1 :])
    return ReportTable(f"Sending {number}", "", (), tuple(rows))


def _in_row(state: State) -> Iterator[tuple[str, str]]:
    if len(state.plans) > 1:
        place = f"plan {len(state.sent_before) + 1} of {len(state.plans)}"
        digests = ", ".join(plan.digest[:12] for plan in state.plans)
        yield "row", f"{place} by one approval: {digests}"


def _plan(plan: Plan, proof: Proof) -> Iterator[tuple[str, str]]:
    of = format_count(len(plan.picks), "part")
    if not plan.picks:
        of = "between home and view" if plan.is_view_plan else "stirs the parts in the bin"
        if plan.is_tool_plan:
            of = f"changes the tool to {plan.arms[0].tool}"
        if plan.is_drop_plan:
            of = f"drops back what the hand holds: {plan.arms[0].held}"
    yield "plan", f"{plan.digest}: {of}, strategy {plan.strategy}, {plan.guarantee}"
    yield "cell", plan.cell_digest
    yield "scan", plan.scan_digest
    for arm in plan.arms:
        words = "not stated" if arm.loads is None else str(arm.loads.words)
        yield f"load, {arm.arm} arm", words
    verdict = "holds" if proof.holds else f"does not hold: {proof.violations[0]}"
    yield (
        "proof",
        f"{proof.digest}: {verdict}; {proof.checks} states, smallest clearance on free legs "
        f"{proof.clearance * 1000:.1f} mm, to {proof.resolution * 1000:g} mm; {_corners(proof)}",
    )
    if (speeds := speed_message(proof)) is not None:
        yield "speed", str(speeds)


def _corners(proof: Proof) -> str:
    if proof.zone == 0.0:
        return "where the robot stops at every waypoint"
    return f"corners sharp or rounded by up to {proof.zone:.0%} of the shorter segment beside them"


def _list_shown(before: list[Moment], state: State) -> Iterator[tuple[str, str]]:
    digest = None if state.plan is None else state.plan.digest
    for entry, _ in before:
        command = entry.command
        if isinstance(command, WatchPlan) and command.plan_digest == digest:
            how = "told by a program" if command.is_reported else "drawn by a browser to its end"
            yield "shown", f"{clock(entry.at)} to {entry.actor}, {how} (entry {entry.number})"


def _list_approval(before: list[Moment], state: State) -> Iterator[tuple[str, str]]:
    digest = None if state.plan is None else state.plan.digest
    for entry, _ in before:
        if isinstance(entry.command, Approve) and entry.command.plan_digest == digest:
            stood = f"; the robot reported {len(entry.joints)} joints" if entry.joints else ""
            role = f"{entry.actor} ({entry.role})"
            yield "approved", f"{clock(entry.at)} by {role} (entry {entry.number}){stood}"
    if (approval := state.approval) is not None:
        unseen = ", no page has shown it to all of them" if approval.is_unwatched else ""
        ran = f", inventory {approval.ran[:12]}" if approval.ran else ""
        people = " and ".join(approval.people)
        if approval.is_switched_off:
            people = f"nobody; {approval.actor} had switched approval off, for poses alone"
        words = manner_words(*approval.manner)
        how = f", {words}" if words else ""
        until = clock(approval.until)
        yield "approval", f"{approval.digest}: {people}, until {until}{how}{unseen}{ran}"


def _list_reports(after: list[Moment]) -> Iterator[tuple[str, str]]:
    messages = [e.command.receipt for e, _ in after if isinstance(e.command, Sent)]
    if messages:
        began, ended = messages[0].at, messages[-1].at
        answered = sum(bool(message.heard) for message in messages)
        yield "messages", f"{len(messages)} in {ended - began:.1f} s, {answered} answered; wire.txt"
    for entry, state in after:
        match entry.command:
            case NextStep(number=number):
                let = f"{clock(entry.at)} let run by {entry.actor} (entry {entry.number})"
                yield f"step {number}", let
            case Stop():
                yield "stop", f"{clock(entry.at)} by {entry.actor} (entry {entry.number})"
            case LinkEnded(fault=fault, parts_placed=placed, parts=parts):
                said = f"fault: {fault}" if fault else str(state.message)
                put = format_count(placed, "part")
                yield "the robot said", f"{clock(entry.at)} {said}; {put} placed"
                for part in parts:
                    became = {True: "picked", False: "failed", None: "not known"}[part.is_picked]
                    why = f"; {part.why}" if part.why else ""
                    yield f"part {part.detection + 1}", f"{became} by the {part.arm} arm{why}"
            case _:
                pass


def _interventions(entries: list[Moment]) -> ReportTable:
    rows: list[tuple[str, ...]] = []
    for entry, state in entries:
        command = entry.command
        by_person = entry.actor not in MACHINES and not isinstance(command, USUAL_COMMANDS)
        faulty = state.phase is Phase.FAULT and isinstance(command, LinkEnded)
        if by_person or faulty:
            kind = "fault" if faulty else type(command).__name__
            rows.append((str(entry.number), clock(entry.at), entry.actor, kind, str(state.message)))
    says = "What people did besides scanning, planning, watching, approving, sending; and faults."
    columns = ("entry", "when", "who", "what", "what came of it")
    return ReportTable("Interventions and faults", says, columns, tuple(rows))


def _log(entries: list[Moment]) -> ReportTable:
    shown = [(e, s) for e, s in entries if not isinstance(e.command, Sent)]
    rows = tuple(
        (str(e.number), clock(e.at), e.actor, _kind(e), str(s.phase), str(s.message))
        for e, s in shown
    )
    left_out = len(entries) - len(shown)
    says = f"Every entry after the first but {left_out} messages to the robot, which wire.txt has."
    return ReportTable("Log", says, ("entry", "when", "who", "what", "phase", "says"), rows)


def _kind(entry: Entry) -> str:
    if not isinstance(entry.command, JobEnded):
        return type(entry.command).__name__
    result = entry.command.result
    if isinstance(result, Exception):
        return "JobEnded (failed)"
    return f"JobEnded ({BROUGHT.get(type(result), type(result).__name__)})"
