"""What a PLC may ask for: a row a method; each answers whether it was done, and a sentence."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from asyncua import ua

from workbench.app.core import commands


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a method."""

    name: str
    kind: ua.VariantType
    says: str

    def described(self) -> ua.Argument:
        """As clients are told it."""
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
    make: Callable[[Sequence[Any]], commands.Command]
    arguments: tuple[Argument, ...] = ()


SEED = Argument("Seed", ua.VariantType.UInt32, "the same seed gives the same result")

PARTS = Argument("Parts", ua.VariantType.UInt32, "in the simulated pile")
STRATEGY = Argument(
    "Strategy", ua.VariantType.String, "which arms work: one of the variable Strategies"
)
THRESHOLD = Argument("Threshold", ua.VariantType.Double, "[m]")

METHODS: tuple[Method, ...] = (
    Method("Scan", lambda given: commands.TakeScan(given[0], given[1]), (SEED, PARTS)),
    Method("FindParts", lambda given: commands.FindParts(given[0]), (SEED,)),
    Method(
        "MakePlan",
        lambda given: commands.MakePlan(given[1], given[2], given[0]),
        (SEED, STRATEGY, THRESHOLD),
    ),
    Method(
        "Send",
        lambda given: commands.SendPlan(given[0]),
        (Argument("Plan", ua.VariantType.String, "digest of the approved plan"),),
    ),
    Method(
        "GoOn",
        lambda given: commands.GoOn(
            commands.TakeScan(given[0], given[1]),
            commands.FindParts(given[0]),
            commands.MakePlan(given[2], given[3], given[0]),
        ),
        (SEED, PARTS, STRATEGY, THRESHOLD),
    ),
    Method("Stop", lambda given: commands.Stop()),
    Method("Cancel", lambda given: commands.CancelJob()),
    Method("Acknowledge", lambda given: commands.AcknowledgeFault()),
    Method(
        "Report",
        lambda given: commands.ReportPick(given[0], given[1], given[2]),
        (
            Argument("Detection", ua.VariantType.UInt32, "index of the part in the plan"),
            Argument("IsPicked", ua.VariantType.Boolean, "whether it was"),
            Argument("Why", ua.VariantType.String, "what is known about a failure"),
        ),
    ),
    Method("TakeControl", lambda given: commands.TakeControl()),
    Method("ReleaseControl", lambda given: commands.ReleaseControl()),
)
"""Approvals are not here: they are a person's."""
