"""All texts by their ids, and the way back from JSON to a message."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, cast

from workbench.model.messages.calibration import (
    BinText,
    DriftText,
    FirstScanText,
    ObjectionText,
    PlateText,
    PoseText,
    ScaleText,
    ScanText,
    VerifyText,
)
from workbench.model.messages.cells import (
    AssemblyText,
    BinChoiceText,
    CellText,
    CommissioningText,
    DifferenceText,
    InventoryText,
    KitText,
    LoadText,
    RecipeText,
    SeenBaseText,
    SlotText,
    ViewChoiceText,
)
from workbench.model.messages.changes import (
    ChangeKindText,
    ChangeText,
    FillText,
    GraspChange,
    RemainText,
)
from workbench.model.messages.commands import (
    CommandText,
    EditText,
    GraspEditText,
    MannerText,
    NameText,
    RoleText,
    StaleText,
)
from workbench.model.messages.devices import DeviceText, ScannerText
from workbench.model.messages.files import FileProblem, FileText
from workbench.model.messages.grasps import BudgetText, FixText, GripText
from workbench.model.messages.message import GROUPED, UNITS, FoundPart, Message, Others, Text, plain
from workbench.model.messages.parts import (
    DrawnText,
    PalletText,
    PileText,
    StationText,
    SymmetryText,
)
from workbench.model.messages.plans import (
    ArmText,
    CycleText,
    GuaranteeText,
    LegText,
    MotionText,
    OrderText,
    PlanNote,
    RowEnd,
    StepText,
    StrategyText,
)
from workbench.model.messages.proofs import ProofText, ViolationText
from workbench.model.messages.refusals import (
    ChangeRefusal,
    ControlRefusal,
    PosesRefusal,
    Refusal,
    ValueRefusal,
)
from workbench.model.messages.states import (
    AheadText,
    ClearanceText,
    ControlText,
    HeldText,
    LeftText,
    NextText,
    PosesText,
    RowStop,
    StateText,
    TaskText,
)
from workbench.model.messages.verdicts import (
    ReasonText,
    StageText,
    StationNote,
    VerdictNote,
    VerdictText,
)
from workbench.model.messages.work import (
    AskText,
    CancelText,
    CaseRefusal,
    JobText,
    LinkPhase,
    LinkText,
    ProgressText,
    StopText,
)

SUBJECTS: tuple[type[Text], ...] = (
    Others,
    ReasonText,
    StageText,
    VerdictText,
    VerdictNote,
    StationNote,
    LegText,
    StrategyText,
    OrderText,
    GuaranteeText,
    MotionText,
    PlanNote,
    RowEnd,
    ViolationText,
    ProofText,
    HeldText,
    TaskText,
    StateText,
    ClearanceText,
    LeftText,
    ControlText,
    RowStop,
    NextText,
    Refusal,
    PosesRefusal,
    ChangeRefusal,
    ControlRefusal,
    ValueRefusal,
    ChangeKindText,
    ChangeText,
    FillText,
    RemainText,
    PlateText,
    PoseText,
    DriftText,
    VerifyText,
    FirstScanText,
    BinText,
    DifferenceText,
    CellText,
    CommissioningText,
    LoadText,
    SlotText,
    RecipeText,
    BinChoiceText,
    ViewChoiceText,
    AssemblyText,
    KitText,
    SeenBaseText,
    InventoryText,
    CommandText,
    RoleText,
    MannerText,
    NameText,
    EditText,
    GraspEditText,
    StaleText,
    GripText,
    FixText,
    BudgetText,
    PileText,
    DrawnText,
    PalletText,
    StationText,
    StepText,
    ArmText,
    CycleText,
    FileText,
    ScanText,
    ObjectionText,
    ScaleText,
    PosesText,
    AheadText,
    JobText,
    LinkText,
    AskText,
    StopText,
    LinkPhase,
    CaseRefusal,
    ProgressText,
    CancelText,
    DeviceText,
    ScannerText,
    FileProblem,
    GraspChange,
    SymmetryText,
)

TEXTS: Mapping[str, Text] = MappingProxyType(
    {text.id: text for subject in SUBJECTS for text in subject}
)


MOST_LEVELS = 12
"""Messages within messages that are read."""


def message_of(form: Any, depth: int = MOST_LEVELS) -> Message:
    """The message whose JSON this is: a text without an id, or one with its arguments.

    One whose id or arguments this version does not know reads as both.

    Raises:
        KeyError, TypeError, ValueError: it is no form of a message.
    """
    if isinstance(form, str):
        return plain(form)
    if depth == 0:
        raise ValueError("messages lie too deep in each other")
    args = {str(name): _arg(arg, depth) for name, arg in dict(form["args"]).items()}
    text = TEXTS.get(form["id"])
    if text is None or not _fits(text, args):
        shown = ", ".join(f"{name} {arg}" for name, arg in args.items())
        return plain(f"{form['id']}: {shown}" if shown else str(form["id"]))
    return Message(text, args)


def _fits(text: Text, args: Mapping[str, Any]) -> bool:
    """Whether arguments are those of a text, with numbers where it shows numbers."""
    is_number = {name: isinstance(arg, int | float) for name, arg in args.items()}
    return args.keys() == text.places.keys() and all(
        is_number[name] or not how & {*UNITS, GROUPED, "|"} for name, how in text.places.items()
    )


def _arg(form: Any, depth: int) -> Any:
    match form:
        case {"part": int(index)}:
            return FoundPart(index)
        case {"id": _}:
            return message_of(form, depth - 1)
        case list():
            return tuple(_arg(item, depth - 1) for item in cast(list[Any], form))
        case str() | int() | float():
            return form
        case _:
            raise TypeError(f"{form!r:.60} is no argument of a message")
