"""What can be asked of the workbench over HTTP: one table, a row a command."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from workbench.app.core.cell.bins import ChooseBin, NewBin
from workbench.app.core.cell.changes import EmptyPallets, RedoCell, SaveCell, UndoCell
from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.cell.kits import NewKit
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cell.views import ChooseView
from workbench.app.core.command import Command
from workbench.app.core.control import (
    AskForControl,
    DenyControl,
    GiveControl,
    ReleaseControl,
    TakeControl,
)
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.correcting import CorrectPart
from workbench.app.core.cycle.empty_hand import PlanStir, PlanToolChange, PlanView
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ForgetAvoided, ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.rows import ShortenRow
from workbench.app.core.cycle.scanning import USUAL_PARTS, TakeScan
from workbench.app.core.cycle.sending import NextStep, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import ConfirmHandsEmpty, PlanDropBack
from workbench.app.core.session import AcknowledgeChanges, WriteNote
from workbench.app.core.value_checks import (
    DETAIL,
    LARGEST_MARGIN,
    LONGEST_NAME,
    LONGEST_TEXT,
    MOST_ITERATIONS,
    MOST_PARTS,
    MOST_PILES,
    SEED_LIMIT,
)
from workbench.model.cell import MOST_PICKS, ORDER_NAMES, PlanOverrides
from workbench.model.prediction import CHANGE_KINDS, TOGETHER, Seen
from workbench.model.recipes.recipe import HIGHEST_NUMBER, NO_RECIPE
from workbench.model.release import SLOWEST, PickResult
from workbench.model.scan import ALL_KINDS, SearchOverrides
from workbench.model.tools.held_body import HeldAmount
from workbench.plugins.planner import planner_names
from workbench.web.api.fields import Field, number_schema, text_schema, whole_schema
from workbench.web.api.schemas import FLAG

Values = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Call:
    """A command that a POST to `path` gives; `kind` is its type, `fields` those of the body.

    `begins`: it begins something that goes on after the answer (202).  `make` makes the command of
    the values of the body where these are not the command's own.
    """

    path: str
    says: str
    kind: type
    fields: tuple[Field, ...] = ()
    begins: bool = False
    make: Callable[[Values], Command] | None = None

    def command(self, values: Values) -> Command:
        """The command that a body with these values gives."""
        return self.kind(**values) if self.make is None else self.make(values)


SEED = Field("seed", "the same seed gives the same result", whole_schema(0, SEED_LIMIT - 1), 0)
DIGEST: Values = {"type": "string", "pattern": "^[0-9a-f]{64}$"}
PLAN = Field("plan", "digest of the plan that is meant", DIGEST)
ROW = Field(
    "row",
    "digests of the plans after it, in their order; empty: it stands alone",
    {"type": "string", "pattern": r"^([0-9a-f]{64}(\+[0-9a-f]{64}){0,8})?$"},
    "",
    DIGEST,
    9,
)
RAN = Field("ran", "digest of what runs now, as the state has it", DIGEST)
BIN = Field("name", "of one of the `bins` of the state", text_schema(LONGEST_NAME))
VIEW = Field("name", "of one of the `views` of the state", text_schema(LONGEST_NAME))
TO = Field("to", "name of somebody who has asked for control", text_schema(LONGEST_NAME))

OVERRIDES = ("planner", "order", "iterations", "margin", "metric", "picks")


def _find(values: Values) -> FindParts:
    overrides = SearchOverrides(values["detail"], values["least_score"])
    return FindParts(values["seed"], overrides)


def _plan(values: Values) -> MakePlan:
    overrides = PlanOverrides(**{key: values[key] for key in OVERRIDES})
    return MakePlan(values["strategy"], values["threshold"], values["seed"], overrides)


def _emptying(values: Values) -> Command:
    kinds, changes = values["part"], values["changes"]
    return TryEmptying(
        () if kinds in ("", ALL_KINDS) else tuple(kinds.split(TOGETHER)),
        values["parts"],
        values["piles"],
        values["seed"],
        values["seen"],
        CHANGE_KINDS if changes == "all" else tuple(filter(None, changes.split(TOGETHER))),
    )


def _go_on(values: Values) -> Command:
    scan = TakeScan(values["seed"], values["parts"], stays=values["stays"])
    return GoOn(scan, _find(values), _plan(values))


def _row(values: Values) -> tuple[str, ...]:
    return tuple(filter(None, values["row"].split(TOGETHER)))


def _report(values: Values) -> Command:
    result = PickResult(values["result"]) if values["result"] else None
    return ReportPick(values["detection"], values["is_picked"], values["why"], result)


def _watch(values: Values) -> Command:
    return WatchPlan(values["plan"], is_reported=True, row=_row(values))


def _approve(values: Values) -> Command:
    manner = values["speed_share"], values["is_stepped"]
    return Approve(values["plan"], *manner, _row(values))


TOOL = (
    Field("tool", "its name; it stands in its slot", text_schema(LONGEST_NAME)),
    Field("arm", "its name; empty: the first one with that slot", text_schema(LONGEST_NAME), ""),
    SEED,
)

DROP_SAYS = "Plan and prove how an arm drops back what it holds, from where it stands."
DROP = (
    Field("held", "what the hand holds", {"type": "string", "enum": tuple(HeldAmount)}, "unknown"),
    Field("arm", "its name; empty: the one that is not at home", text_schema(LONGEST_NAME), ""),
    SEED,
)
SCAN_FIELDS = (
    SEED,
    Field("parts", "in the simulated pile", whole_schema(0, MOST_PARTS), USUAL_PARTS),
    Field("stays", "simulated parts left stay, if seed and parts are those before", FLAG, True),
)

FIND_FIELDS = (
    SEED,
    Field("detail", "share of the usual detail", number_schema(*DETAIL), 1.0),
    Field("least_score", "parts below are not taken", number_schema(0.0, 1.0), 0.0),
)

PLAN_FIELDS = (
    SEED,
    Field(
        "strategy",
        "which arms work: one of the `strategies` of the state; empty: the recipe's, or auto",
        text_schema(LONGEST_NAME),
        "",
    ),
    Field(
        "threshold",
        "[m] parts nearer to each other are taken one after the other; the recipe's or the cell's "
        "where it is not given",
        number_schema(0.0, 1.0),
        None,
    ),
    Field("planner", "of free legs", {"type": "string", "enum": planner_names()}, default=None),
    Field("order", "of the parts", {"type": "string", "enum": ORDER_NAMES}, default=None),
    Field("iterations", "of the planner", whole_schema(1, MOST_ITERATIONS), default=None),
    Field(
        "margin",
        "[m] kept from everything; not less than the cell's",
        number_schema(0.0, LARGEST_MARGIN),
        default=None,
    ),
    Field("metric", "how much each joint counts of the one before", number_schema(0.05, 1.0), None),
    Field("picks", "plans in a row after this scan, at most", whole_schema(1, MOST_PICKS), None),
)

CALLS: tuple[Call, ...] = (
    Call("/scan", "Take a scan.", TakeScan, SCAN_FIELDS, begins=True),
    Call("/localize", "Find the parts in the scan.", FindParts, FIND_FIELDS, True, _find),
    Call("/plan", "Judge candidates, plan and prove.", MakePlan, PLAN_FIELDS, True, _plan),
    Call(
        "/view",
        "Plan and prove the path of an arm's scanner to the chosen view, or back.",
        PlanView,
        (
            SEED,
            Field(
                "view", "its name; empty: that of the cell; `home`", text_schema(LONGEST_NAME), ""
            ),
        ),
        begins=True,
    ),
    Call("/stir", "Plan and prove how an arm stirs the parts.", PlanStir, (SEED,), begins=True),
    Call("/drop-back", DROP_SAYS, PlanDropBack, DROP, begins=True),
    Call("/tool", "Plan and prove how an arm changes its tool.", PlanToolChange, TOOL, begins=True),
    Call(
        "/emptying",
        "Empty piles in simulation, in the cell as it is; no robot moves.",
        TryEmptying,
        (
            Field(
                "part",
                "which of the cell's fall, joined by +; all of them in turn where none is named",
                text_schema(LONGEST_TEXT),
                "",
            ),
            Field("parts", "in a pile", whole_schema(1, MOST_PARTS), 15),
            Field("piles", "each with the next seed", whole_schema(1, MOST_PILES), 3),
            Field("seed", "of the first pile", whole_schema(0, SEED_LIMIT - MOST_PILES), 0),
            Field(
                "seen",
                "planned with true poses, or with those found in simulated scans",
                {"type": "string", "enum": get_args(Seen)},
                "truth",
            ),
            Field(
                "changes",
                "of the cell, tried one at a time on the same piles: all, or kinds joined by + of "
                + ", ".join(CHANGE_KINDS),
                text_schema(LONGEST_TEXT),
                "",
            ),
        ),
        begins=True,
        make=_emptying,
    ),
    Call(
        "/go-on",
        "When a cycle has ended, or beside its end: scan, find and plan, each after the other; "
        "a person approves.",
        GoOn,
        # One seed for all of it.
        (*SCAN_FIELDS, *FIND_FIELDS[1:], *PLAN_FIELDS[1:]),
        begins=True,
        make=_go_on,
    ),
    Call(
        "/threshold",
        "Want another threshold; a plan made with the one before is stale.",
        WantThreshold,
        (Field("threshold", "[m]", number_schema(0.0, 1.0)),),
    ),
    Call(
        "/row",
        "Carry out only so many plans of the row; a larger number brings back what was left out.",
        ShortenRow,
        (
            PLAN,
            Field("picks", "plans in all, the first one among them", whole_schema(1, MOST_PICKS)),
        ),
        make=lambda values: ShortenRow(values["plan"], values["picks"]),
    ),
    Call(
        "/watch",
        "Say that the plan was played to its end before whoever asks, and those after it; it is "
        "on record as told.",
        WatchPlan,
        (PLAN, ROW),
        make=_watch,
    ),
    Call(
        "/approve",
        "Approve the plan and those after it: a person's vote.",
        Approve,
        (
            PLAN,
            ROW,
            Field("speed_share", "of the planned speed", number_schema(SLOWEST, 1.0), 1.0),
            Field("is_stepped", "wait before each step", FLAG, default=False),
        ),
        make=_approve,
    ),
    Call(
        "/send",
        "Send the approved plan to the robot, which moves then, and those after it in their turn.",
        SendPlan,
        (PLAN,),
        make=lambda values: SendPlan(values["plan"]),
        begins=True,
    ),
    Call(
        "/step",
        "Let the step run that the robot waits before, of a plan that is sent step by step.",
        NextStep,
        (Field("number", "of the step, from 1 on", whole_schema(0, SEED_LIMIT - 1)),),
    ),
    Call("/stop", "Send nothing more and close the link.", Stop),
    Call("/cancel", "End the running task.", CancelJob),
    Call("/acknowledge", "Say that the fault was seen and the cell cleared.", AcknowledgeFault),
    Call(
        "/acknowledge-changes",
        "Say that what has changed since the start before was seen; an engineer's word.",
        AcknowledgeChanges,
        (RAN,),
    ),
    Call(
        "/report",
        "Say what became of a part of the plan.",
        ReportPick,
        (
            Field("detection", "index in the plan, or the first part", whole_schema(0, 10_000)),
            Field("is_picked", "whether it was", FLAG),
            Field("why", "what is known about a failure", text_schema(LONGEST_TEXT), ""),
            Field(
                "result",
                "what became of it, where more is known than `is_picked` says",
                {"type": "string", "enum": ["", *PickResult]},
                "",
            ),
        ),
        make=_report,
    ),
    Call("/forget-avoided", "Avoid no part any more because its pick has failed.", ForgetAvoided),
    Call("/empty-pallets", "Say that what was put down has been taken away.", EmptyPallets),
    Call(
        "/hands-empty",
        "Say that somebody has looked and hands hold nothing.",
        ConfirmHandsEmpty,
        (Field("arm", "whose; all without it", text_schema(LONGEST_TEXT), ""),),
    ),
    Call(
        "/note",
        "Write into the session what somebody saw or did at the cell.",
        WriteNote,
        (Field("text", "the note", text_schema(LONGEST_TEXT)),),
    ),
    Call(
        "/recipe",
        "Go on by a recipe of the cell; detections, plan and approval are void then.",
        ChooseRecipe,
        (
            Field(
                "number",
                "of one of the `recipes` of the state; 0: none, the cell is as its file states it",
                whole_schema(NO_RECIPE, HIGHEST_NUMBER),
            ),
        ),
    ),
    Call(
        "/bin",
        "Take parts from another bin; scan, detections, plan and approval are void then.",
        ChooseBin,
        (BIN,),
    ),
    Call("/choose-view", "Take scans from another view of an arm's scanner.", ChooseView, (VIEW,)),
    Call(
        "/new-bin",
        "Say that a bin was refilled, or another one stands in its place.",
        NewBin,
        (BIN,),
    ),
    Call(
        "/kit",
        "Say that the kit has been taken away, complete or not, and an empty one stands there.",
        NewKit,
    ),
    Call("/cell/undo", "Take back the last change.", UndoCell),
    Call("/cell/redo", "Take back the last undo.", RedoCell),
    Call(
        "/cell/save",
        "Write the changes of the cell and its parts to their files.",
        SaveCell,
        (Field("remark", "why it was changed", text_schema(LONGEST_TEXT), ""),),
    ),
    Call(
        "/part/correct",
        "Have a part as large as the scan shows it, and search again; written as by Save.",
        CorrectPart,
        (Field("part", "one of the `wrong_parts` of the state", text_schema(LONGEST_NAME)),),
        begins=True,
    ),
    Call("/control/ask", "Ask for control.", AskForControl),
    Call("/control/take", "Take control.", TakeControl),
    Call("/control/give", "Hand control over to somebody who has asked.", GiveControl, (TO,)),
    Call("/control/deny", "Keep control, though somebody has asked.", DenyControl, (TO,)),
    Call("/control/release", "Give control back.", ReleaseControl),
)
"""Commands that come with files or poses, and those of the page's editors, are not here."""
