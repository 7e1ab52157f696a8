"""What can be asked of the workbench over HTTP: one table, a row a command."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from workbench.app.core.commands import (
    AcknowledgeFault,
    Approve,
    AskForControl,
    CancelJob,
    Command,
    DenyControl,
    EmptyPallets,
    FindParts,
    ForgetAvoided,
    GiveControl,
    MakePlan,
    RedoCell,
    ReleaseControl,
    ReportPick,
    SaveCell,
    SendPlan,
    Stop,
    TakeControl,
    TakeScan,
    UndoCell,
    WantThreshold,
    WatchPlan,
)
from workbench.app.core.value_checks import (
    DETAIL,
    LARGEST_MARGIN,
    LONGEST_NAME,
    LONGEST_TEXT,
    MOST_ITERATIONS,
    MOST_PARTS,
    SEED_LIMIT,
)
from workbench.model.cell import ORDER_NAMES, Wishes
from workbench.model.scan import SearchWishes
from workbench.plugins.planner import planner_names
from workbench.web.api.fields import Field

Values = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Call:
    """A command that a POST to `path` gives; `kind` is its type, `make` makes it of the body."""

    path: str
    says: str
    kind: type
    make: Callable[[Values], Command]
    fields: tuple[Field, ...] = ()
    begins: bool = False
    """Whether it begins something that goes on after the answer (202)."""


def _number(low: float, high: float) -> Values:
    return {"type": "number", "minimum": low, "maximum": high}


def _whole(low: int, high: int) -> Values:
    return {"type": "integer", "minimum": low, "maximum": high}


def _text(longest: int) -> Values:
    return {"type": "string", "maxLength": longest}


SEED = Field("seed", "the same seed gives the same result", _whole(0, SEED_LIMIT - 1), 0)
PLAN = Field(
    "plan", "digest of the plan that is meant", {"type": "string", "pattern": "^[0-9a-f]{64}$"}
)
TO = Field("to", "name of somebody who has asked for control", _text(LONGEST_NAME))


WISHES = ("planner", "order", "iterations", "margin", "metric")


def _scan(values: Values) -> Command:
    return TakeScan(values["seed"], values["parts"])


def _localize(values: Values) -> Command:
    return FindParts(values["seed"], SearchWishes(values["detail"], values["least_score"]))


def _plan(values: Values) -> Command:
    wishes = Wishes(**{key: values[key] for key in WISHES})
    return MakePlan(values["strategy"], values["threshold"], values["seed"], wishes)


def _report(values: Values) -> Command:
    return ReportPick(values["detection"], values["is_picked"], values["why"])


CALLS: tuple[Call, ...] = (
    Call(
        "/scan",
        "Take a scan.",
        TakeScan,
        _scan,
        (SEED, Field("parts", "in the simulated pile", _whole(1, MOST_PARTS), 2)),
        begins=True,
    ),
    Call(
        "/localize",
        "Find the parts in the scan.",
        FindParts,
        _localize,
        (
            SEED,
            Field("detail", "share of the usual detail", _number(*DETAIL), 1.0),
            Field("least_score", "parts below are not taken", _number(0.0, 1.0), 0.0),
        ),
        begins=True,
    ),
    Call(
        "/plan",
        "Judge all candidates, make a plan and prove it.",
        MakePlan,
        _plan,
        (
            SEED,
            Field(
                "strategy",
                "which arms work: one of the `strategies` of the state",
                _text(LONGEST_NAME),
                "auto",
            ),
            Field(
                "threshold",
                "[m] parts nearer to each other are taken one after the other",
                _number(0.0, 1.0),
                0.2,
            ),
            Field(
                "planner", "of free legs", {"type": "string", "enum": planner_names()}, default=None
            ),
            Field("order", "of the parts", {"type": "string", "enum": ORDER_NAMES}, default=None),
            Field("iterations", "of the planner", _whole(1, MOST_ITERATIONS), default=None),
            Field(
                "margin",
                "[m] kept from everything; not less than the cell's",
                _number(0.0, LARGEST_MARGIN),
                default=None,
            ),
            Field(
                "metric",
                "how much each joint counts of the one before",
                _number(0.05, 1.0),
                None,
            ),
        ),
        begins=True,
    ),
    Call(
        "/threshold",
        "Want another threshold; a plan made with the one before is stale.",
        WantThreshold,
        lambda values: WantThreshold(values["threshold"]),
        (Field("threshold", "[m]", _number(0.0, 1.0)),),
    ),
    Call(
        "/watch",
        "Say that the plan was played to its end before whoever asks; it is on record as told.",
        WatchPlan,
        lambda values: WatchPlan(values["plan"], is_told=True),
        (PLAN,),
    ),
    Call(
        "/approve",
        "Approve the plan: a person's vote.",
        Approve,
        lambda values: Approve(values["plan"]),
        (PLAN,),
    ),
    Call(
        "/send",
        "Send the approved plan to the robot, which moves then.",
        SendPlan,
        lambda values: SendPlan(values["plan"]),
        (PLAN,),
        begins=True,
    ),
    Call("/stop", "Send nothing more and close the link.", Stop, lambda values: Stop()),
    Call("/cancel", "End the running task.", CancelJob, lambda values: CancelJob()),
    Call(
        "/acknowledge",
        "Say that the fault was seen and the cell cleared.",
        AcknowledgeFault,
        lambda values: AcknowledgeFault(),
    ),
    Call(
        "/report",
        "Say what became of a part of the plan.",
        ReportPick,
        _report,
        (
            Field("detection", "index of the part in the plan", _whole(0, 10_000)),
            Field("is_picked", "whether it was", {"type": "boolean"}),
            Field("why", "what is known about a failure", _text(LONGEST_TEXT), ""),
        ),
    ),
    Call(
        "/forget-avoided",
        "Avoid no part any more because its pick has failed.",
        ForgetAvoided,
        lambda values: ForgetAvoided(),
    ),
    Call(
        "/empty-pallets",
        "Say that what was put down has been taken away.",
        EmptyPallets,
        lambda values: EmptyPallets(),
    ),
    Call("/cell/undo", "Take back the last change.", UndoCell, lambda values: UndoCell()),
    Call("/cell/redo", "Take back the last undo.", RedoCell, lambda values: RedoCell()),
    Call(
        "/cell/save",
        "Write the changes of the cell and its parts to their files.",
        SaveCell,
        lambda values: SaveCell(values["remark"]),
        (Field("remark", "why it was changed", _text(LONGEST_TEXT), ""),),
    ),
    Call("/control/ask", "Ask for control.", AskForControl, lambda values: AskForControl()),
    Call("/control/take", "Take control.", TakeControl, lambda values: TakeControl()),
    Call(
        "/control/give",
        "Hand control over to somebody who has asked.",
        GiveControl,
        lambda values: GiveControl(values["to"]),
        (TO,),
    ),
    Call(
        "/control/deny",
        "Keep control, though somebody has asked.",
        DenyControl,
        lambda values: DenyControl(values["to"]),
        (TO,),
    ),
    Call("/control/release", "Give control back.", ReleaseControl, lambda values: ReleaseControl()),
)
"""Commands that come with files or poses, and those of the page's editors, are not here."""
