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
    """Long work under way in the worker process.

    `number` is that of the entry that began it, `at` [s since the epoch] when.  A planning has its
    `strategy`, `threshold` [m], `seed`, and as `planning` what it wants otherwise than the cell; a
    search its `seed` and `overrides`, and `is_compared`: what it finds is not taken at once.
    `then`: what it brings is gone on with, as is wanted there; None where a person decides.
    `arm` is for which a tool is made, `by` who has a part corrected, `pile` what a scan shows.
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
    """What came of one planning, to be compared with the next.

    `planning` and `cycle` [s]; `apart` [m] the smallest distance between the arms; `verdict` says
    why there is no plan, or what speaks against it.  Of so many `plans` in a row all this is that
    of all together, `digest` that of the first one.  Who asks for it again by the strategy
    `asked`, with `threshold` [m], `seed` and `overrides`, gets the same plan.
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
    """What is worked on for the next cycle while a plan is sent.

    `wanted` says how it is gone on; `brought` are the tasks that have ended, each with its result
    and when that came [s since the epoch].
    """

    wanted: "GoOn"
    brought: tuple[tuple[Job, Any, float], ...] = ()


class EditedCell(NamedTuple):
    """A cell that an undo or a redo goes back to, and the change that is undone or made again."""

    cell: Cell
    change: Message


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SessionState:
    """What only the end of the session ends.

    `number` is that of the last entry.  `before` are the cells that an undo goes back to, the last
    one first to be taken, `undone` those of a redo; `saved` is the digest of the cell as its file
    has it, and `cell_problem` says why the file cannot be used as it is now.
    `placed` are parts on pallets, in the order in which they were put there; one with a score of 0
    may be there, or not, since a fault or since its pick has failed.  `failures` counts failed
    picks in a row, over all cycles, and `avoided` says where.
    `observations` are those of a calibration that is being made.
    `emptying` is what came of the piles that were emptied in simulation last, in whichever cell.
    `ran` is what runs since the last start; `changed` says how that differs from the start before,
    the session `changed_since`, until somebody has acknowledged it.
    `control` is the name of who is in control, empty while nobody is; `asking` are those who have
    asked for it, the first one first.
    `unscanned` is what was sent where no scan has followed and the plan is gone already: after a
    fault that was acknowledged, or another cell.
    `whole` is the cell as its file has it while a recipe or another than its first bin is chosen;
    `cell` is the cell by these.
    `unapproved_by` is the engineer who has switched approval off, empty while it is on; it counts
    only while the robot link sends poses alone.
    `kit` is how far kits by the recipe that is chosen have come.
    `empty_bins` names those of several bins in which nothing is left to take, as last seen;
    `views_without` the views of a scanner on an arm from which nothing could be taken since
    something was, in the chosen bin.
    `earlier` is a scan from other views, which the next one is merged with.
    `stirs` counts how often the parts in the bin were stirred since a plan could take some.
    `tools_unknown`: arms whose change of tool has ended with a fault, until a person has stated
    what they carry.
    `hands_emptied`: arms whose hands are empty, since parts were sent for, by a drop back or by a
    person who has looked.
    `largest_sent`: length [m] of the longest part and mass [kg] of the heaviest one in the cell in
    which parts were sent for.
    `hands_open`: arms that may hold a part since a stop, though a scan has come since.
    `pile` is what the last simulated scan has shown of parts that stay where they are.
    `ball_scans` and `touches` check the calibrated scanner, up to `check_limits` [m] of spacings
    and touches; 0: as the calibration predicts.
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
        """Whether the cell is as its file has it, whichever recipe is chosen."""
        return self.saved == (self.whole or self.cell).digest


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ScanState(SessionState):
    """What a new scan makes void: the scan and the searches in it, the latest last.

    `disturbed` are parts of the scan that a missed grip may have moved.
    """

    scan: Scan | None = None
    searches: tuple[SearchRecord, ...] = ()
    disturbed: tuple[Detection, ...] = field(default_factory=tuple, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PartsState(ScanState):
    """What other parts found make void.

    `scene_digest` is what a plan must have been made from: that of the scan, or of the detections
    when they came from outside.  `remarks` say what people have done to what was found, and
    `parts_before` are the parts that an undo of that goes back to, the last ones first.
    """

    detections: tuple[Detection, ...] | None = None
    scene_digest: str = ""
    remarks: tuple[Remark, ...] = ()
    parts_before: tuple[tuple[Detection, ...], ...] = ()


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlanState(PartsState):
    """What a new planning makes void.

    `stale` says what the last plan was overtaken by.  `planned_threshold` [m] is that of the plan,
    `wanted_threshold` the one that is wanted now.  `outlines` are of all plannings for these
    parts, the latest last; each plan stands there once, where it was made first.  `bound` [s] is
    what no plan for the parts of this one can be quicker than, 0 where nobody has asked.

    `row` are proven plans to be carried out after the plan, and `row_ends` says why there are no
    more.  `left_out` were after those, until a person has shortened the row.
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
    """What lets the plan out.

    `watched` names those before whose eyes it was played to its end, `watched_elsewhere` those of
    them of whom only a program says so; `votes` are given for it, enough of them or not.
    """

    watched: tuple[str, ...] = ()
    watched_elsewhere: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)
    votes: tuple[Vote, ...] = ()
    approval: Approval | None = None


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RunState(ReleaseState):
    """What a new sending makes void: what the robot did with the plan.

    `part_reports` say what the controller told of each part, `outcomes` what people or grippers
    said became of it.  Of a plan sent step by step: `waits` is the step that the robot stands
    before, 0 while it moves, `let` the last one that a person has let run, and `let_until` [s since
    the epoch] when nobody may let one run any more.

    Of a row `plan` and `proof` are those that are carried out now, and `sent_before` those before;
    what is said of messages and steps is of the plan alone, outcomes and parts placed are of the
    whole row.
    `is_over`: the plan has ended without a fault.
    `stopped_by` names who has stopped the sending: nothing of the row follows.
    `ahead` is what is worked on for the next cycle meanwhile; no plan of it is here before the end.
    `may_have_moved`: after a missed grip the parts, by their indices in the plan's list, that may
    lie otherwise now; None where only a new scan can tell.
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
        """What was carried out, the plan, and what is to follow; empty without a proven plan."""
        if self.plan is None or self.proof is None:
            return ()
        return (*self.sent_before, Proven(self.plan, self.proof), *self.row)

    @property
    def plans(self) -> tuple[Plan, ...]:
        """The plans of the whole row in order; the same row has the same values here."""
        if self.plan is None:
            return ()
        before = (proven_plan.plan for proven_plan in self.sent_before)
        return (*before, self.plan, *(proven_plan.plan for proven_plan in self.row))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class State(RunState):
    """All that an auditor would ask for.

    Its stages are the classes above, in the order in which one is made from the other: what a
    stage holds stays until one before it, or the same, begins anew (`begin_stage`), so that what is
    here always belongs together.  A field belongs to the stage whose class it stands in.

    What stands here is of this moment: `fault` is set exactly in phase fault; `message` tells a
    person what happened last.
    """

    phase: Phase = field(default=Phase.IDLE, kw_only=False)
    job: Job | None = None
    fault: Message | str = ""
    message: Message | str = ""


def begin_stage(state: State, stage: type[SessionState], **fields: Any) -> State:
    """The state as a stage begins anew: it and all after it are void, but for `fields`."""
    earlier = cast(type[SessionState], stage.__base__)
    kept = {
        known_field.name: getattr(state, known_field.name)
        for known_field in dataclasses.fields(earlier)
    }
    return State(**kept | fields)


def stale_by(state: State, why: Message) -> Message | None:
    """The message about the plan that goes, if there was one."""
    return None if state.plan is None else StaleText.PLAN(plan=state.plan.digest[:12], why=why)


def format_count(number: int, noun: str) -> str:
    """So many of something, as sentences have it."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def without_approval(state: State) -> State:
    """The state without approval: who asks for something newer takes back every vote given."""
    phase = Phase.PLANNED if state.phase is Phase.APPROVED else state.phase
    return replace(state, phase=phase, approval=None, votes=())


def sent_for(state: State) -> SentFor | None:
    """The plans of whose parts people can say what became of them; None where nothing was sent."""
    if is_remembered(state):
        return state.unscanned
    return SentFor(plans_begun(state), state.outcomes, state.is_over, state.parts_placed)


def is_remembered(state: State) -> bool:
    """Whether the parts that were sent for last are not those of the plan, but `unscanned`."""
    return state.plan is None or not state.plan.picks


def before_a_scan(state: State) -> State:
    """The state that remembers what was sent when its plan goes and no scan has come since."""
    if state.phase not in (Phase.DONE, Phase.FAULT):
        return state
    return replace(state, unscanned=sent_for(state))


def plans_begun(state: State) -> tuple[Plan, ...]:
    """The plans that were sent, the one on its way among them."""
    return state.plans[: len(state.sent_before) + 1]


def row_message(state: State) -> Message:
    """The plan and those after it, for people."""
    plan = "" if state.plan is None else state.plan.digest[:12]
    if not state.row:
        return StateText.PLAN(plan=plan)
    return StateText.PLAN_AND_ROW(plan=plan, count=len(state.row))
