"""What a PLC may ask for: a row a method; each answers whether it was done, and a sentence.

Acknowledging a fault is a person's act: the role of the login that calls decides.  Approvals are
not here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from asyncua import ua

from workbench.app.core.cell.bins import ChooseBin, NewBin
from workbench.app.core.cell.kits import NewKit
from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.cell.views import ChooseView
from workbench.app.core.command import Command
from workbench.app.core.control import ReleaseControl, TakeControl
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.outcomes import AcknowledgeFault, ReportPick
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan, Stop


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a method."""

    name: str
    kind: ua.VariantType
    says: str

    def describe(self) -> ua.Argument:
        """The description that clients get."""
        argument = ua.Argument()
        argument.Name = self.name
        argument.DataType = ua.NodeId(ua.Int32(self.kind.value))
        argument.ValueRank = ua.Int32(-1)
        argument.ArrayDimensions = []
        argument.Description = ua.LocalizedText(self.says)
        return argument


@dataclass(frozen=True, slots=True)
class Method:
    """A command by its name; `make` makes it of the arguments."""

    name: str
    make: Callable[[Sequence[Any]], Command]
    arguments: tuple[Argument, ...] = ()


SEED = Argument("Seed", ua.VariantType.UInt32, "the same seed gives the same result")

PARTS = Argument("Parts", ua.VariantType.UInt32, "in the simulated pile")
STRATEGY = Argument(
    "Strategy",
    ua.VariantType.String,
    "which arms work: one of the variable Strategies; empty: the recipe's, or auto",
)
THRESHOLD = Argument(
    "Threshold", ua.VariantType.Double, "[m]; below 0: that of the recipe, or of the cell"
)

BIN = Argument("Bin", ua.VariantType.String, "one of the variable Bins")


def _plan(seed: int, strategy: str, threshold: float) -> MakePlan:
    return MakePlan(strategy, None if threshold < 0.0 else threshold, seed)


METHODS: tuple[Method, ...] = (
    Method("Scan", lambda given: TakeScan(given[0], given[1], stays=True), (SEED, PARTS)),
    Method("FindParts", lambda given: FindParts(given[0]), (SEED,)),
    Method(
        "MakePlan",
        lambda given: _plan(given[0], given[1], given[2]),
        (SEED, STRATEGY, THRESHOLD),
    ),
    Method(
        "Send",
        lambda given: SendPlan(given[0]),
        (Argument("Plan", ua.VariantType.String, "digest of the approved plan"),),
    ),
    Method(
        "GoOn",
        lambda given: GoOn(
            TakeScan(given[0], given[1], stays=True),
            FindParts(given[0]),
            _plan(given[0], given[2], given[3]),
        ),
        (SEED, PARTS, STRATEGY, THRESHOLD),
    ),
    Method(
        "ChooseRecipe",
        lambda given: ChooseRecipe(given[0]),
        (Argument("Recipe", ua.VariantType.UInt32, "one of the variable Recipes; 0: none"),),
    ),
    Method("ChooseBin", lambda given: ChooseBin(given[0]), (BIN,)),
    Method("NewBin", lambda given: NewBin(given[0]), (BIN,)),
    Method(
        "ChooseView",
        lambda given: ChooseView(given[0]),
        (Argument("View", ua.VariantType.String, "one of the variable Views"),),
    ),
    Method(
        "PlanView",
        lambda given: PlanView(given[0]),
        (Argument("View", ua.VariantType.String, "the chosen one, or empty; home: back from it"),),
    ),
    Method("NewKit", lambda given: NewKit()),
    Method("Stop", lambda given: Stop()),
    Method("Cancel", lambda given: CancelJob()),
    Method("Acknowledge", lambda given: AcknowledgeFault()),
    Method(
        "Report",
        lambda given: ReportPick(given[0], given[1], given[2]),
        (
            Argument("Detection", ua.VariantType.UInt32, "index of the part in the plan"),
            Argument("IsPicked", ua.VariantType.Boolean, "whether it was"),
            Argument("Why", ua.VariantType.String, "what is known about a failure"),
        ),
    ),
    Method("TakeControl", lambda given: TakeControl()),
    Method("ReleaseControl", lambda given: ReleaseControl()),
)
"""Approvals are not here: they are a person's."""
