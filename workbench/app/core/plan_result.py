"""What came of one planning: the value that a planning job brings."""

from dataclasses import dataclass

from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import PlannerName
from workbench.model.plan import Plan, Proof
from workbench.model.scan import Obstacle


@dataclass(frozen=True, slots=True, eq=False)
class PlanResult:
    """What a planning job brings: every candidate judged, and the plan or why there is none.

    `beside` is what the other strategy brought, where both were asked for.
    """

    candidates: tuple[Candidate, ...]
    plan: Plan | None
    proof: Proof | None
    verdict: Verdict
    seconds: dict[str, float]
    obstacles: tuple[Obstacle, ...] = ()
    planner: PlannerName = "rrtconnect"
    beside: "tuple[PlanResult, ...]" = ()
