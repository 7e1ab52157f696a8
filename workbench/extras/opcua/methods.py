"""What a PLC may ask for: a row a method; each answers whether it was done, and a sentence.

Acknowledging a fault is a person's act: the role of the login that calls decides.  Approvals are
not here.
"""

from collections.abc import Callable
from dataclasses import dataclass

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
    """A command by its name; `make` makes it of the arguments, in their order."""

    name: str
    make: Callable[..., Command]
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


def _scan(seed: int, parts: int) -> TakeScan:
    return TakeScan(seed, parts, stays=True)


def _plan(seed: int, strategy: str, threshold: float) -> MakePlan:
    return MakePlan(strategy, None if threshold < 0.0 else threshold, seed)


def _go_on(seed: int, parts: int, strategy: str, threshold: float) -> GoOn:
    return GoOn(_scan(seed, parts), FindParts(seed), _plan(seed, strategy, threshold))


METHODS: tuple[Method, ...] = (
    Method("Scan", _scan, (SEED, PARTS)),
    Method("FindParts", FindParts, (SEED,)),
    Method("MakePlan", _plan, (SEED, STRATEGY, THRESHOLD)),
    Method(
        "Send",
        SendPlan,
        (Argument("Plan", ua.VariantType.String, "digest of the approved plan"),),
    ),
    Method("GoOn", _go_on, (SEED, PARTS, STRATEGY, THRESHOLD)),
    Method(
        "ChooseRecipe",
        ChooseRecipe,
        (Argument("Recipe", ua.VariantType.UInt32, "one of the variable Recipes; 0: none"),),
    ),
    Method("ChooseBin", ChooseBin, (BIN,)),
    Method("NewBin", NewBin, (BIN,)),
    Method(
        "ChooseView",
        ChooseView,
        (Argument("View", ua.VariantType.String, "one of the variable Views"),),
    ),
    Method(
        "PlanView",
        PlanView,
        (Argument("View", ua.VariantType.String, "the chosen one, or empty; home: back from it"),),
    ),
    Method("NewKit", NewKit),
    Method("Stop", Stop),
    Method("Cancel", CancelJob),
    Method("Acknowledge", AcknowledgeFault),
    Method(
        "Report",
        ReportPick,
        (
            Argument("Detection", ua.VariantType.UInt32, "index of the part in the plan"),
            Argument("IsPicked", ua.VariantType.Boolean, "whether it was"),
            Argument("Why", ua.VariantType.String, "what is known about a failure"),
        ),
    ),
    Method("TakeControl", TakeControl),
    Method("ReleaseControl", ReleaseControl),
)
"""Approvals are not here: they are a person's."""
