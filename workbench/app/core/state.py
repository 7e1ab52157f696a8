"""The one state of the workbench: an immutable value, made by `decide` and nothing else."""

import dataclasses
import enum
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from workbench.app.core.picks import Avoided, Outcome, SentFor, SimulatedPile
from workbench.app.provenance.inventory import Inventory
from workbench.model.calibration import SPACING_LIMIT, BallScan, PlateObservation, Touch
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell, PlanOverrides
from workbench.model.digest import LATER
from workbench.model.messages.commands import StaleText
from workbench.model.messages.message import Message
from workbench.model.messages.states import StateText
from workbench.model.plan import Plan, Proof, Proven
from workbench.model.prediction import Emptying
from workbench.model.recipes.kit import KitProgress
from workbench.model.release import Approval, PartReport, Receipt, Vote
from workbench.model.scan import Detection, Obstacle, Remark, Scan, SearchOverrides, SearchRecord

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn


class Phase(enum.StrEnum):
    """Where the cycle stands."""

    IDLE = "idle"
    SCANNED = "scanned"
    LOCALIZED = "localized"
    PLANNED = "planned"
    APPROVED = "approved"
    SENDING = "sending"
    DONE = "done"
    FAULT = "fault"


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """A long computation that runs in the worker process.

    Attributes:
        number: number of the journal entry that started the job.
        at: start time [s since the epoch].
        threshold: distance of two parts [m] from which both arms may work at once.
        overrides: parameters of a search that replace those of the cell.
        planning: parameters of a planning that replace those of the cell.
        is_compared: whether a search is only listed until a person decides to use it.
        then: command that continues the cycle with the result; None: a person decides.
        arm: arm that gets the tool, when a tool is designed.
        by: person who requested the correction of a part.
        pile: pile that a simulated scan shows.
    """

    number: int
    name: str
    at: float = 0.0
    threshold: float | None = None
    seed: int = 0
    overrides: SearchOverrides = field(default_factory=SearchOverrides)
    strategy: str = ""
    planning: PlanOverrides = field(default_factory=PlanOverrides)
    is_compared: bool = False
    then: "GoOn | None" = field(default_factory=lambda: None, metadata=LATER)
    arm: str = field(default_factory=str, metadata=LATER)
    by: str = field(default_factory=str, metadata=LATER)
    pile: SimulatedPile | None = field(default_factory=lambda: None, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """Summary of one planning result, for comparison with others.

    For a row of several plans the figures are those of the whole row, `digest` that of its first
    plan.  The same `asked`, `threshold`, `seed` and `overrides` give the same plan again.

    Attributes:
        planning: computing time [s].
        cycle: duration of the motion [s].
        apart: smallest distance between the arms [m]; `clearance` [m] is that of the proof.
        verdict: why there is no plan, or what is wrong with it.
        asked: strategy of the request; `strategy` is that of the plan.
    """

    planner: str
    planning: float
    strategy: str = ""
    guarantee: str = ""
    parts: int = 0
    cycle: float | None = None
    clearance: float | None = None
    apart: float | None = None
    digest: str = ""
    verdict: Message | None = None
    asked: str = ""
    threshold: float = 0.0
    seed: int = 0
    overrides: PlanOverrides = field(default_factory=PlanOverrides)
    plans: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Ahead:
    """Work for the next cycle, which the command `wanted` starts while a plan is sent.

    `brought` holds the finished jobs with their results and end times [s since the epoch].
    """

    wanted: "GoOn"
    brought: tuple[tuple[Job, Any, float], ...] = ()


class EditedCell(NamedTuple):
    """A cell that an undo or a redo restores, and the change that it undoes or repeats."""

    cell: Cell
    change: Message


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SessionState:
    """State that lasts for the whole session.

    Attributes:
        cell: the cell, as the chosen recipe and bin change it.
        number: of the last journal entry.
        before, undone: cells that undo and redo restore, the next one first.
        saved: digest of the cell in the cell file.
        cell_problem: why the cell file cannot be used at present; empty when it can.
        placed: parts on pallets, in order of placing; with a score of 0 a part may be missing.
        failures: number of failed picks in a row, over all cycles.
        avoided: places where picks failed.
        observations: poses of the calibration in progress.
        emptying: result of the last simulated emptying, of any cell.
        ran: inventory of this installation since the last start.
        changed: differences to session `changed_since`, until a person acknowledges them.
        control, asking: person in control, empty: nobody; those who request it, in order.
        unscanned: what was sent and not scanned since, when the plan itself is gone.
        whole: the cell in the cell file, while a recipe or another bin than the first is chosen.
        unapproved_by: engineer who switched approval off (pose-only robot links); empty: on.
        kit: progress of the kits of the chosen recipe.
        empty_bins: bins of several in which the last scan showed nothing to take.
        views_without: views of the chosen bin without a pickable part since the last pick.
        earlier: scan from other views, to be merged with the next scan.
        stirs: how often the bin was stirred since a plan could pick.
        tools_unknown: arms whose tool change failed, until a person states what they carry.
        hands_emptied: arms emptied since the last pick: dropped back, or as a person states.
        largest_sent: longest [m] and heaviest part [kg] that a hand may hold, by what was sent.
        hands_open: arms that may still hold a part from before a stop, although a scan followed.
        pile: pile that the last simulated scan showed.
        ball_scans: scans that check the calibrated scanner, together with `touches`.
        check_limits: largest error of spacings and touches [m]; 0: as the calibration predicts.
    """

    cell: Cell = field(kw_only=False)
    number: int = 0
    before: tuple[EditedCell, ...] = ()
    undone: tuple[EditedCell, ...] = ()
    saved: str = ""
    cell_problem: str = ""
    placed: tuple[Detection, ...] = ()
    failures: int = 0
    avoided: tuple[Avoided, ...] = ()
    observations: tuple[PlateObservation, ...] = ()
    emptying: Emptying | None = None
    ran: Inventory | None = None
    changed: tuple[Message | str, ...] = ()
    changed_since: str = ""
    control: str = ""
    asking: tuple[str, ...] = ()
    unscanned: SentFor | None = field(default_factory=lambda: None, metadata=LATER)
    whole: Cell | None = field(default_factory=lambda: None, metadata=LATER)
    unapproved_by: str = field(default_factory=str, metadata=LATER)
    kit: KitProgress = field(default_factory=KitProgress, metadata=LATER)
    empty_bins: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    views_without: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    earlier: Scan | None = field(default_factory=lambda: None, metadata=LATER)
    stirs: int = field(default_factory=int, metadata=LATER)
    pile: SimulatedPile | None = field(default_factory=lambda: None, metadata=LATER)
    tools_unknown: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    hands_emptied: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    hands_open: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    largest_sent: tuple[float, float] = field(default_factory=lambda: (0.0, 0.0), metadata=LATER)
    ball_scans: tuple[BallScan, ...] = field(default_factory=tuple, metadata=LATER)
    touches: tuple[Touch, ...] = field(default_factory=tuple, metadata=LATER)
    check_limits: tuple[float, float] = field(
        default_factory=lambda: (SPACING_LIMIT, 0.0), metadata=LATER
    )

    @property
    def is_saved(self) -> bool:
        """Whether the cell equals the one in its file, whichever recipe is chosen."""
        return self.saved == (self.whole or self.cell).digest


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ScanState(SessionState):
    """State that a new scan replaces.

    Attributes:
        searches: searches in the scan, the latest last.
        disturbed: parts that a missed grip may have moved.
    """

    scan: Scan | None = None
    searches: tuple[SearchRecord, ...] = ()
    disturbed: tuple[Detection, ...] = field(default_factory=tuple, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PartsState(ScanState):
    """State that a new set of detections replaces.

    Attributes:
        scene_digest: digest of the scan, or of detections from outside; plans must refer to it.
        remarks: changes that people made to the detections.
        parts_before: detections that undo restores, the next ones first.
    """

    detections: tuple[Detection, ...] | None = None
    scene_digest: str = ""
    remarks: tuple[Remark, ...] = ()
    parts_before: tuple[tuple[Detection, ...], ...] = ()


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlanState(PartsState):
    """State that a new planning replaces.

    Attributes:
        verdict: why there is no plan, or what is wrong with it.
        seconds: computing time of each stage [s], by name.
        outlines: summaries of all plannings for these parts, the latest last, without repeats.
        planned_threshold: threshold of the plan [m], see `Job`.
        wanted_threshold: threshold that the person wants now [m].
        stale: why the last plan is no longer valid.
        bound: lower bound of the cycle time for the plan's parts [s]; 0: not computed.
        row: proven plans that follow the plan.
        row_ends: why the row has no further plan.
        left_out: plans after the row, which a person has shortened.
    """

    candidates: tuple[Candidate, ...] | None = None
    plan: Plan | None = None
    proof: Proof | None = None
    verdict: Verdict | None = None
    seconds: tuple[tuple[str, float], ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    outlines: tuple[Outline, ...] = ()
    planned_threshold: float | None = None
    wanted_threshold: float | None = None
    stale: Message | None = None
    bound: float = 0.0
    row: tuple[Proven, ...] = field(default_factory=tuple, metadata=LATER)
    row_ends: Message | None = field(default_factory=lambda: None, metadata=LATER)
    left_out: tuple[Proven, ...] = field(default_factory=tuple, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ReleaseState(PlanState):
    """Approval of the plan.

    Attributes:
        watched: people before whom the plan was played to its end.
        watched_elsewhere: those of them of whom only a client program states it.
        votes: each person's approval; `approval` is set once they are enough.
    """

    watched: tuple[str, ...] = ()
    watched_elsewhere: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    votes: tuple[Vote, ...] = ()
    approval: Approval | None = None


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RunState(ReleaseState):
    """State that a new sending replaces: what the robot did with the plan.

    While a row is sent, `plan` and `proof` are the current ones.  Receipts and steps concern the
    current plan, outcomes and placed parts the whole row.

    Attributes:
        part_reports: the controller's report on each part.
        outcomes: result of each pick, from people or grippers.
        waits: stepped sending: step that the robot waits to start; 0 while it moves.
        let: stepped sending: last step that a person allowed.
        let_until: deadline for allowing it [s since the epoch].
        is_over: whether the current plan has ended without a fault.
        stopped_by: person who stopped the sending; the rest of the row is not sent.
        ahead: work for the next cycle; its plan takes effect only after the end of the sending.
        may_have_moved: indices of parts that a missed grip may have moved; None: rescan needed.
    """

    receipts: tuple[Receipt, ...] = ()
    parts_placed: int = 0
    part_reports: tuple[PartReport, ...] = ()
    outcomes: tuple[Outcome, ...] = ()
    waits: int = 0
    let: int = 0
    let_until: float = 0.0
    sent_before: tuple[Proven, ...] = field(default_factory=tuple, metadata=LATER)
    stopped_by: str = field(default_factory=str, metadata=LATER)
    ahead: Ahead | None = field(default_factory=lambda: None, metadata=LATER)
    may_have_moved: tuple[int, ...] | None = field(default_factory=lambda: None, metadata=LATER)
    is_over: bool = field(default_factory=bool, metadata=LATER)

    @property
    def whole_row(self) -> tuple[Proven, ...]:
        """The plans carried out, the current one and those to follow; empty without a proof."""
        if self.plan is None or self.proof is None:
            return ()
        return (*self.sent_before, Proven(self.plan, self.proof), *self.row)

    @property
    def plans(self) -> tuple[Plan, ...]:
        """The plans of the whole row, in order."""
        if self.plan is None:
            return ()
        before = (proven_plan.plan for proven_plan in self.sent_before)
        return (*before, self.plan, *(proven_plan.plan for proven_plan in self.row))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class State(RunState):
    """The complete state of the workbench.

    The base classes are the stages of a cycle: session, scan, parts, plan, release, run.  Each
    stage is derived from the one before.  `begin_stage` resets a stage and all later stages, so
    the fields always belong together.

    Attributes:
        phase: phase of the cycle.
        fault: cause of the fault; empty except in phase `FAULT`.
        message: the last event, for people.
    """

    phase: Phase = field(default=Phase.IDLE, kw_only=False)
    job: Job | None = None
    fault: Message | str = ""
    message: Message | str = ""


def begin_stage(state: State, stage: type[SessionState], **fields: Any) -> State:
    """Reset a stage and all later stages to their defaults, then set `fields`."""
    earlier = cast(type[SessionState], stage.__base__)
    kept = {
        known_field.name: getattr(state, known_field.name)
        for known_field in dataclasses.fields(earlier)
    }
    return State(**kept | fields)


def stale_by(state: State, why: Message) -> Message | None:
    """The message that a plan is no longer valid; None without a plan."""
    return None if state.plan is None else StaleText.PLAN(plan=state.plan.digest[:12], why=why)


def format_count(number: int, noun: str) -> str:
    """A count with its noun, in the plural unless it is 1."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def without_approval(state: State) -> State:
    """The state without approval and without votes."""
    phase = Phase.PLANNED if state.phase is Phase.APPROVED else state.phase
    return replace(state, phase=phase, approval=None, votes=())


def sent_for(state: State) -> SentFor | None:
    """The sent plans whose outcomes people can still report; None: nothing was sent."""
    if is_remembered(state):
        return state.unscanned
    return SentFor(plans_begun(state), state.outcomes, state.is_over, state.parts_placed)


def is_remembered(state: State) -> bool:
    """Whether the parts sent for last are those in `unscanned`, not those of the plan."""
    return state.plan is None or not state.plan.picks


def before_a_scan(state: State) -> State:
    """The state with `unscanned` set, when its plan goes and no scan has followed the sending."""
    if state.phase not in (Phase.DONE, Phase.FAULT):
        return state
    return replace(state, unscanned=sent_for(state))


def plans_begun(state: State) -> tuple[Plan, ...]:
    """The plans that were sent, including the current one."""
    return state.plans[: len(state.sent_before) + 1]


def row_message(state: State) -> Message:
    """The message that names the plan and the length of its row."""
    plan = "" if state.plan is None else state.plan.digest[:12]
    if not state.row:
        return StateText.PLAN(plan=plan)
    return StateText.PLAN_AND_ROW(plan=plan, count=len(state.row))
