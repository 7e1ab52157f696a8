"""The record by which a customer accepts a cell: picks against targets, causes, signatures."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.special import betaincinv

from workbench import __version__
from workbench.app.core.state import State
from workbench.app.review.commissioning import CheckedStep, Targets, checklist
from workbench.app.statistics.cycles import CycleRecord, PickRecord
from workbench.app.statistics.statistics import GROUPS, Statistics
from workbench.extras.evidence.pages import html_page
from workbench.extras.evidence.report import ReportTable, clock

DOUBT = 0.05
"""Chance that the share which would be taken in the long run is below the stated bound."""

SIMULATED = "simulated"

SIGNED_BY = ("Supplier", "Customer")


Picks = Sequence[tuple[CycleRecord, PickRecord]]


@dataclass(frozen=True, slots=True)
class Acceptance:
    """The record as tables; whether all targets are met, and the table that says so."""

    title: str
    is_met: bool
    result: ReportTable
    tables: tuple[ReportTable, ...]


def session_words(name: str, count: int, head: str) -> str:
    """What identifies a session up to an entry: its name, that entry's number and its hash."""
    return f"{name}, {count} entries, head {head}"


def acceptance_page(
    state: State, session: tuple[str, int, str], counted: Statistics, targets: Targets, at: float
) -> bytes:
    """The record of a session that runs, as one HTML file.

    Args:
        state: of the cell.
        session: its name, the number of its last entry and that entry's hash.
        counted: of this session.
        targets: what was agreed.
        at: when the record is made [s since the epoch].

    Raises:
        InputError: a target cannot be met.
    """
    judged = judge_acceptance(state, [session_words(*session)], counted, targets, at)
    return html_page(judged.title, judged.tables)


def judge_acceptance(
    state: State,
    sessions: Sequence[str],
    counted: Statistics,
    targets: Targets,
    at: float,
) -> Acceptance:
    """Compare the last picks with the targets.

    A pick whose result nobody reported counts as one that was not taken.

    Args:
        state: of the cell, at the end of the last session.
        sessions: what identifies each, see `session_words`.
        counted: of these sessions.
        targets: what was agreed.
        at: when the record is made [s since the epoch].

    Raises:
        InputError: a target cannot be met.
    """
    targets.check()
    picks = counted.picks[-targets.picks :]
    taken = sum(pick.result == "picked" for _, pick in picks)
    share = taken / len(picks) if picks else 0.0
    rows = [
        ("Picks", f"at least {targets.picks}", f"{len(counted.picks)}"),
        (
            "Parts taken",
            f"at least {targets.share:.1%}",
            f"{taken} of the last {len(picks)} ({share:.1%})",
        ),
    ]
    met = [len(picks) >= targets.picks, share >= targets.share]
    seconds = _seconds_of(picks)
    if targets.seconds is not None:
        rows.append(("Time of a part taken", f"at most {targets.seconds:.1f} s", _time(seconds)))
        met.append(seconds is not None and seconds <= targets.seconds)
    answers = ["met" if is_met else "missed" for is_met in met]
    result = ReportTable(
        "All targets are met" if all(met) else "Not all targets are met",
        f"With 95% confidence the cell takes at least {_least_share(taken, len(picks)):.1%}. "
        "A pick without a report counts as not taken. Times are those of whole cycles without "
        f"the approval: {_time(seconds)} for a part.",
        ("Target", "Agreed", "Reached", ""),
        tuple((*row, answer) for row, answer in zip(rows, answers, strict=True)),
    )
    return Acceptance(
        f"Acceptance of cell {state.cell.name}",
        all(met),
        result,
        (
            _head(state, sessions, at),
            result,
            _steps(checklist(state, counted, at)),
            _causes(picks),
            _rates(picks),
            ReportTable(
                "Signatures",
                "",
                ("", "Name", "Date", "Signature"),
                tuple((who, "", "", "") for who in SIGNED_BY),
            ),
        ),
    )


def _head(state: State, sessions: Sequence[str], at: float) -> ReportTable:
    cell = state.cell
    controller = cell.controller
    rows = [
        ("cell", f"{cell.name}, {cell.digest}"),
        ("scanner", cell.scanner.source),
        ("robot", f"{controller.link} at {controller.host}:{controller.port}"),
        *((f"session {number}", says) for number, says in enumerate(sessions, 1)),
        ("this record", f"{clock(at)} by workbench {__version__}"),
    ]
    says = ""
    if cell.scanner.source == SIMULATED:
        says = "The scanner is simulated: this is no record of a real cell."
    return ReportTable("Cell", says, (), tuple(rows))


def _seconds_of(picks: Picks) -> float | None:
    """Time of their cycles without the approval [s] for each part taken; None where none was."""
    cycles = {cycle.at: cycle for cycle, _ in picks}.values()
    spent = sum(cycle.until - cycle.at - cycle.seconds.get("approve", 0.0) for cycle in cycles)
    taken = sum(pick.result == "picked" for cycle in cycles for pick in cycle.picks)
    return spent / taken if taken else None


def _time(seconds: float | None) -> str:
    return "no part was taken" if seconds is None else f"{seconds:.1f} s"


def _least_share(taken: int, count: int) -> float:
    """The share that is taken in the long run, from below: Clopper and Pearson, 1934."""
    return float(betaincinv(taken, count - taken + 1, DOUBT)) if taken else 0.0


def _steps(checked: Sequence[CheckedStep]) -> ReportTable:
    rows = tuple(
        (each.step.value, "done" if each.is_done else "missing", str(each.says)) for each in checked
    )
    return ReportTable("Commissioning", "Checked by the program.", ("Step", "", "What"), rows)


def _causes(picks: Picks) -> ReportTable:
    missed = [(cycle, pick) for cycle, pick in picks if pick.result != "picked"]
    causes = Counter(pick.why or "no report" for _, pick in missed)
    last = {pick.why or "no report": (cycle, pick) for cycle, pick in missed}
    rows = tuple(
        (cause, str(count), clock(last[cause][0].until), last[cause][1].part, last[cause][1].grasp)
        for cause, count in causes.most_common()
    )
    return ReportTable(
        "Not taken", "", ("Cause", "Picks", "Last one", "Its part", "Its grasp"), rows
    )


def _rates(picks: Picks) -> ReportTable:
    cycles = tuple({cycle.at: cycle for cycle, _ in picks}.values())
    rows = tuple(
        (group, rate.name, *map(str, rate.counts.values()), f"{rate.share:.1%}")
        for group, of in GROUPS.items()
        for rate in Statistics(cycles).rates(of)
    )
    return ReportTable(
        "Success",
        "Of the cycles of these picks. Picks without a report do not count here.",
        ("By", "", "Taken", "Failed", "Dropped", "Double", "Share"),
        rows,
    )
