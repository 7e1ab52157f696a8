"""Statistics of a session: number of parts, success rate, speed, and reasons of refusals.

A pure function from the entries of a journal to a value.  It reads only the kinds of entries that
count, so that the many messages to the controller cost nothing.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any

from workbench.app.core.cell.kits import NewKit
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.statistics.cycles import CycleRecord, PickRecord, Rate
from workbench.app.statistics.drops import DropCount, Drops
from workbench.app.statistics.grasp_use import NO_USES, Uses, add_uses, count_judged, count_taken
from workbench.app.statistics.kits import KitCount, Kits, add_kits
from workbench.app.statistics.remaining import MOST_REMEMBERED, Remaining, RemainingPart
from workbench.app.statistics.rows import numbers_of_row, picks_of_row, takes_no_part
from workbench.app.statistics.turns import Turns
from workbench.journal.journal import Row
from workbench.model.candidate import Reason, kind_of
from workbench.model.errors import JournalError
from workbench.model.release import PickResult, result_of

SCANS = frozenset({TakeScan.__name__, UseScan.__name__, GoOn.__name__})
"""A cycle begins with one of these, or with poses from outside after the one before has ended."""

COUNTED = SCANS | {
    kind.__name__
    for kind in (
        FindParts,
        UseDetections,
        MakePlan,
        CancelJob,
        JobEnded,
        SendPlan,
        LinkEnded,
        NewKit,
        ReportPick,
    )
}

NOTHING_BEGUN = ("", 0.0, 0)
"""Tasks have the numbers of entries, which begin with 1."""

TAKEN = {result for result in PickResult if result.is_picked}

STAGES = ("scan", "find parts", "plan", "approve", "send")


@dataclass(frozen=True, slots=True)
class Statistics:
    """All cycles of one or more sessions, and what is counted beside them.

    `refusals` are what is said of refused candidates (`kind_of`), and of how many; `judged` how
    often each grasp was tried and would have worked; `remaining` are the parts that stayed when a
    planning brought no plan, the latest ones; `kits` are those that were taken away, `drops` what
    arms have dropped back.
    """

    cycles: tuple[CycleRecord, ...] = ()
    refusals: tuple[tuple[str, int], ...] = ()
    judged: Uses = field(default_factory=lambda: NO_USES)
    remaining: tuple[RemainingPart, ...] = ()
    kits: tuple[KitCount, ...] = ()
    drops: DropCount = field(default_factory=DropCount)

    @property
    def picks(self) -> tuple[tuple[CycleRecord, PickRecord], ...]:
        """Every part that was sent for, with its cycle."""
        return tuple((cycle, pick) for cycle in self.cycles if cycle.end for pick in cycle.picks)

    @property
    def picked(self) -> int:
        """Parts taken, also those with which a second one came."""
        return sum(pick.result in TAKEN for _, pick in self.picks)

    @property
    def picks_per_hour(self) -> float | None:
        """Parts taken for each hour that cycles took; pauses between cycles do not count."""
        hours = sum(cycle.until - cycle.at for cycle in self.cycles if cycle.end) / 3600
        return self.picked / hours if hours > 0 else None

    def rates(self, of: Callable[[CycleRecord, PickRecord], str]) -> tuple[Rate, ...]:
        """Success by part, grasp, arm, or whatever `of` makes of a pick; the most tried first."""
        counted: defaultdict[str, Counter[str]] = defaultdict(Counter)
        for cycle, pick in self.picks:
            counted[of(cycle, pick)][pick.result] += 1
        rates = [
            Rate(name, *(counts[result] for result in PickResult))
            for name, counts in counted.items()
        ]
        return tuple(sorted(rates, key=lambda rate: (-rate.known, rate.name)))

    def grasps(self) -> Uses:
        """How each grasp of each part has done."""
        return add_uses(
            self.judged,
            count_taken((pick.part, pick.grasp, pick.result) for _, pick in self.picks),
        )

    def stage_medians(self) -> tuple[tuple[str, float, float], ...]:
        """Stage, its median and its largest time [s], for stages that there were."""
        found: list[tuple[str, float, float]] = []
        for stage in STAGES:
            times = [cycle.seconds[stage] for cycle in self.cycles if stage in cycle.seconds]
            if times:
                found.append((stage, median(times), max(times)))
        return tuple(found)

    def by_hour(self) -> tuple[tuple[float, int, int], ...]:
        """Each hour with cycles, by the clock: when it began [s], parts taken, and failed."""
        hours: defaultdict[float, Counter[bool]] = defaultdict(Counter)
        for cycle, pick in self.picks:
            if pick.result != "unknown":
                hours[cycle.until // 3600 * 3600][pick.result in TAKEN] += 1
        return tuple((at, hour[True], hour[False]) for at, hour in sorted(hours.items()))


GROUPS: Mapping[str, Callable[[CycleRecord, PickRecord], str]] = {
    "part": lambda cycle, pick: pick.part,
    "grasp": lambda cycle, pick: pick.grasp,
    "arm": lambda cycle, pick: pick.arm,
    "strategy": lambda cycle, pick: cycle.strategy,
}
"""What success is reported by."""


WITHOUT_SCAN = {UseDetections.__name__, MakePlan.__name__}
"""A cycle begins with poses from outside, or with a plan in the scan of a cycle that has ended."""

OF_A_PLAN = {SendPlan.__name__, LinkEnded.__name__}
"""Entries that are about the plan that was made last."""


class Count:
    """Counts entries as they come, so that a page does not read a long session again and again.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self.last = 0
        """Number of the last entry that was counted."""
        self._cycles: list[CycleRecord] = []
        self._refusals: Counter[str] = Counter()
        # The stage under way, since when, and the number of its task.
        self._begun: tuple[str, float, int] = NOTHING_BEGUN
        self._turns = Turns(COUNTED)
        self._found: Any = ()
        self._judged: Uses = NO_USES
        self._remaining = Remaining()
        self._kits = Kits()
        # Of a row: what each plan takes, and its parts by the numbers of the first; which is sent.
        self._row: tuple[tuple[PickRecord, ...], ...] = ()
        self._numbers: tuple[tuple[int, ...], ...] = ()
        self._place = 0
        self._takes_no_part = False  # whether the plan is no cycle: to a view, or to stir
        self._drops = Drops()

    def add(self, rows: Iterable[Row]) -> None:
        """Count entries, in their order.

        Raises:
            JournalError: an entry cannot be read.
        """
        for row in rows:
            self.last = row.number
            try:
                for kind, number, body in self._turns.release_entries(row):
                    self._add(kind, number, body)
            except (AttributeError, LookupError, TypeError, ValueError) as error:
                raise JournalError(
                    f"entry {row.number} ({row.kind}) cannot be read: {error!r}"
                ) from error

    def _add(self, kind: str, number: int, body: Any) -> None:
        if kind == NewKit.__name__:
            return self._kits.add(body["after"])
        at, stage = float(body["at"]), self._begun[0]
        self._take(kind, number, at, body["command"])
        if kind == GoOn.__name__:
            self._begun = ("scan", float(body.get("began", at)), number)
        if kind == LinkEnded.__name__ and body["after"].get("phase") == "sending":
            self._follows()
        if kind == JobEnded.__name__ and body["after"]["job"] == number:
            # What that task brought was taken without a person; a corrected part is searched again.
            result = body["command"]["result"]
            follows = "find parts" if "part" in result else STAGES[STAGES.index(stage) + 1]
            # Where no plan was made, a scan follows.
            self._begun = ("scan" if "plan" in result else follows, at, number)

    @property
    def value(self) -> Statistics:
        """The statistics until now."""
        return Statistics(
            tuple(self._cycles),
            tuple(self._refusals.most_common()),
            self._judged,
            self._remaining.value,
            self._kits.value,
            self._drops.value,
        )

    def _take(self, kind: str, number: int, at: float, command: Any) -> None:
        is_planned = kind == JobEnded.__name__ and "plan" in command["result"]
        if is_planned:
            self._takes_no_part = takes_no_part(command["result"]["plan"])
        self._drops.take(command)
        if self._takes_no_part and (is_planned or kind in OF_A_PLAN):
            return
        if kind in SCANS:
            # From another view it may be the next scan of the same cycle.
            goes_on = self._takes_no_part and bool(self._cycles) and not self._cycles[-1].end
            if not goes_on:
                self._cycles.append(CycleRecord(number, at, at))
            self._begun = ("scan", at, number)
            return
        is_sent = bool(self._cycles) and self._cycles[-1].end in ("done", "fault")
        if not self._cycles or (is_sent and kind in WITHOUT_SCAN):
            self._cycles.append(CycleRecord(number, at, at))
        match kind:
            case FindParts.__name__ if command.get("is_compared"):
                # What it finds is not taken by that: who takes it says so.
                self._begun = NOTHING_BEGUN
            case FindParts.__name__:
                self._begun = ("find parts", at, number)
            case UseDetections.__name__:
                self._count_found(command["detections"])
            case MakePlan.__name__:
                self._begun = ("plan", at, number)
            case CancelJob.__name__:
                self._begun = NOTHING_BEGUN
            case JobEnded.__name__:
                self._job_ended(at, command)
            case SendPlan.__name__:
                self._count_sent(at)
            case LinkEnded.__name__:
                self._link_ended(at, command)
            case _:
                self._count_report(command)

    def _job_ended(self, at: float, command: Any) -> None:
        stage, began, number = self._begun
        if command["number"] != number:
            return  # the late end of a task that was cancelled, or a task that is not counted
        result = command["result"]
        self._begun = NOTHING_BEGUN
        if "error" in result:
            return
        # After a missed grip the next cycle begins with its plan.
        self._took("plan" if "plan" in result else stage, began, at)
        if "detections" in result:
            self._count_found(result["detections"])
        if "plan" in result:
            self._count_planned(at, result["plan"])

    def _count_found(self, detections: Any) -> None:
        self._found = detections

    def _count_planned(self, at: float, result: Any) -> None:
        kinds = tuple(detection["part"] for detection in self._found)
        self._judged = add_uses(self._judged, count_judged(kinds, result["candidates"]))
        verdicts = (candidate["verdict"] for candidate in result["candidates"])
        self._refusals.update(
            kind_of(Reason(verdict["reason"]), is_apart=(verdict["distance"] or 0.0) > 0)
            for verdict in verdicts
            if verdict["reason"] != Reason.OK
        )
        self._remaining.add(self._found, result)
        plan = result["plan"]
        if plan is None:
            self._change(end="no plan", strategy="", picks=(), until=at)
            return
        self._numbers = numbers_of_row(result)
        self._row = tuple(
            tuple(PickRecord(*named_pick) for named_pick in picks)
            for picks in picks_of_row(result, self._numbers)
        )
        self._place = 0
        self._change(end="", strategy=plan["strategy"], picks=self._row[0], until=at)
        # Of a plan that was made beside the cycle before nobody can be asked earlier.
        self._begun = ("approve", max(at, self._cycles[-1].at), 0)

    def _count_sent(self, at: float) -> None:
        stage, began, _ = self._begun
        if stage == "approve":
            self._took(stage, began, at)
        self._begun = ("send", at, 0)

    def _link_ended(self, at: float, command: Any) -> None:
        self._took("send", self._begun[1], at)
        # The controller's word on each part, where its protocol has one; a person sees more.
        doubted = {
            pick.detection
            for pick in self._cycles[-1].picks
            if pick.result not in ("unknown", PickResult.PICKED)
        }
        for part in command.get("parts", ()):
            if part["is_picked"] is not None:
                number = part["detection"]
                if self._place:
                    number = self._numbers[self._place][number]
                if number not in doubted:
                    self._count_report({**part, "detection": number})
        picks = self._cycles[-1].picks
        sent = {pick.detection for pick in self._row[self._place]} if self._row else set[int]()
        if not command["fault"] and command["parts_placed"] == len(sent):
            # It has counted every part, unless somebody says otherwise.
            picks = tuple(
                replace(pick, result=PickResult.PICKED)
                if pick.result == "unknown" and pick.detection in sent
                else pick
                for pick in picks
            )
        self._change(end="fault" if command["fault"] else "done", picks=picks, until=at)
        moved = command.get("may_have_moved")
        if moved is not None:
            gone = {*moved, *(part["detection"] for part in command["parts"])}
            numbers = self._numbers[self._place]
            rest = [number for place, number in enumerate(numbers) if place not in gone]
            self._count_found([self._found[number] for number in rest])

    def _follows(self) -> None:
        """The next plan of the row is on its way, in the same cycle."""
        self._place += 1
        picks = self._row[self._place]
        again = {pick.detection for pick in picks}
        # A part that was put on a station is one pick, by who brings it to its place.
        done = (pick for pick in self._cycles[-1].picks if pick.detection not in again)
        self._change(end="", picks=(*done, *picks))

    def _count_report(self, report: Any) -> None:
        stated = report.get("result")
        result = result_of(report["is_picked"], None if stated is None else PickResult(stated))
        sent = self._sent_last()
        if sent is None:
            return
        picks = tuple(
            replace(pick, result=result, why=report["why"])
            if pick.detection == report["detection"] and pick.result != result
            else pick
            for pick in self._cycles[sent].picks
        )
        self._cycles[sent] = replace(self._cycles[sent], picks=picks)

    def _sent_last(self) -> int | None:
        """Which cycle the robot has carried out, or does: a scan that failed may come after it."""
        last = len(self._cycles) - 1
        if self._begun[0] == "send" and self._cycles[last].picks:
            return last
        ended = (n for n in range(last, -1, -1) if self._cycles[n].end in ("done", "fault"))
        return next(ended, None)

    def _took(self, stage: str, began: float, at: float) -> None:
        seconds = {**self._cycles[-1].seconds, stage: max(0.0, at - began)}
        self._change(seconds=seconds, until=at)

    def _change(self, **fields: Any) -> None:
        last = self._cycles[-1]
        fields["until"] = max(fields.get("until", last.until), last.at)
        self._cycles[-1] = replace(last, **fields)


def statistics(rows: Iterable[Row]) -> Statistics:
    """What the entries of a session tell.

    Raises:
        JournalError: an entry cannot be read.
    """
    count = Count()
    count.add(rows)
    return count.value


def together(parts: Iterable[Statistics]) -> Statistics:
    """Several sessions as one."""
    parts = tuple(parts)
    refusals: Counter[str] = Counter()
    uses: Uses = NO_USES
    for part in parts:
        refusals.update(dict(part.refusals))
        uses = add_uses(uses, part.judged)
    cycles = (cycle for part in parts for cycle in part.cycles)
    return Statistics(
        tuple(sorted(cycles, key=lambda cycle: cycle.at)),
        tuple(refusals.most_common()),
        uses,
        tuple(left for part in parts for left in part.remaining)[-MOST_REMEMBERED:],
        add_kits(*(part.kits for part in parts)),
        sum((part.drops for part in parts), DropCount()),
    )
