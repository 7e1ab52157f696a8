"""A cell small enough to be made in a moment, and values of every stage that belong to it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.core.state import Phase, State
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell, Policy, ScannerMount, Tool
from workbench.model.geometry import Box, Mesh, Solid
from workbench.model.messages.message import plain
from workbench.model.messages.plans import RowEnd
from workbench.model.part import Bin, Grasp, GraspLibrary, Part
from workbench.model.plan import (
    ArmPlan,
    Guarantee,
    Leg,
    Plan,
    PlanResult,
    Proof,
    Proven,
    Step,
    Strategy,
    Violation,
)
from workbench.model.release import Approval
from workbench.model.robot import Joint, Link, Robot
from workbench.model.scan import Detection, Scan
from workbench.model.symmetry import Symmetry
from workbench.plugins.robot_link import controller_by

HERE = pin.SE3.Identity()


@dataclass(frozen=True)
class Samples:
    """Makes values that belong together; equal arguments give equal digests.

    `always`: each planning whose proof holds brings three plans in a row.
    """

    cell: Cell
    always: bool = False

    def scan(self, seed: int = 0, points: int = 50) -> Scan:
        drawn = np.random.default_rng(seed).normal(size=(points, 3))
        return Scan(drawn, HERE, "sample", pixels=np.arange(points), resolution=(64, 48))

    def detections(self, seed: int = 0) -> tuple[Detection, ...]:
        place = np.random.default_rng(seed).uniform(size=3)
        return (Detection("peg", pin.SE3(np.eye(3), place), score=0.9, gap=0.1),)

    def plan(self, scan_digest: str, seed: int = 0, cell: Cell | None = None) -> Plan:
        cell = cell or self.cell
        times = np.array([0.0, 1.0])
        reach = Leg("reach", "joint", False, 0.03, np.deg2rad([[0.0], [30.0]]), times)
        place = Leg("place", "joint", True, 0.03, np.deg2rad([[30.0], [60.0]]), times)
        arm = ArmPlan("right", 0, "top", HERE, ("joint_1",), (reach, place))
        return Plan(
            cell.name,
            cell.digest,
            scan_digest,
            seed,
            Strategy.single("right"),
            Guarantee.ONE_AT_A_TIME,
            self.detections(),
            (arm,),
            (Step((("right", "reach"),)), Step((("right", "place"),))),
            seconds={"route": 0.1},
        )

    def proof(self, plan: Plan, *, holds: bool = True) -> Proof:
        violation = Violation(
            plain("too close"), "right", "reach", 1, ("link", "bin_floor"), -0.002
        )
        return Proof(
            plan.digest,
            plan.cell_digest,
            plan.scan_digest,
            100,
            0.001,
            0.006,
            None,
            () if holds else (violation,),
            (("right", "reach", np.array([0.02, 0.006])),),
            zone=0.2,
        )

    def planned(self, scan_digest: str, seed: int = 0, *, holds: bool = True) -> PlanResult:
        plan = self.plan(scan_digest, seed)
        if self.always and holds:
            return replace(self, always=False).row(scan_digest, seed)
        verdict = Verdict(Reason.OK, Stage.ROUTE)
        return PlanResult(
            (self.candidate(verdict),),
            plan,
            self.proof(plan, holds=holds),
            verdict,
            dict(plan.seconds),
        )

    def row(self, scan_digest: str, seed: int = 0, picks: int = 3) -> PlanResult:
        """A plan and those after it, each in what the one before leaves."""
        lying = (*self.detections(), *self.detections(1), *self.detections(2))[:picks]
        plans = [
            replace(self.plan(scan_digest, seed), detections=lying[number:])
            for number in range(picks)
        ]
        first, *rest = (Proven(plan, self.proof(plan)) for plan in plans)
        result = self.planned(scan_digest, seed)
        ends = RowEnd.NO_PART() if picks < 4 else None
        return replace(result, plan=first.plan, proof=first.proof, row=tuple(rest), row_ends=ends)

    def approved(self, cell: Cell) -> State:
        """A cell with an approved plan; what is planned for is the samples' own cell."""
        scan = self.scan()
        planned = self.planned(scan.digest)
        assert planned.plan is not None and planned.proof is not None
        approval = Approval(
            planned.plan.digest, planned.proof.digest, cell.digest, scan.digest, "ada", 0.0, 1e9
        )
        return State(
            cell,
            Phase.APPROVED,
            scan=scan,
            detections=self.detections(),
            scene_digest=scan.digest,
            candidates=planned.candidates,
            plan=planned.plan,
            proof=planned.proof,
            approval=approval,
            saved=cell.digest,
        )

    def refused(self) -> PlanResult:
        verdict = Verdict(
            Reason.IN_COLLISION, Stage.GRASP, ("link", "bin_floor"), -0.002, np.array([0.1])
        )
        return PlanResult((self.candidate(verdict),), None, None, verdict, {"resolve": 0.05})

    def candidate(self, verdict: Verdict) -> Candidate:
        return Candidate(0, Grasp("top", HERE, 0.04, 0.03), "right", HERE, 0.5, verdict)


def told_cell() -> Cell:
    """The cell by a robot link that tells what became of each part."""
    policy = Policy(approval_minutes=5.0, pair_gap=0.01, picks=3)
    return replace(made_cell(), policy=policy, controller=controller_by("abb-socket/2"))


def made_cell(name: str = "sample", port: int = 1025) -> Cell:
    body = Solid("body", Box(np.array([0.1, 0.1, 0.1])), HERE)
    joint = Joint("joint_1", "revolute", "base", "hand", HERE, np.array([0, 0, 1.0]), -3, 3, 2)
    robot = Robot("sample", (Link("base", (body,)), Link("hand", (body,))), (joint,))
    arm = Arm(
        "right",
        "R",
        "hand",
        ("joint_1",),
        (0,),
        (1,),
        np.array([0.0]),
        np.array([4.0]),
        Tool("gripper", HERE, (), stroke=(0.0, 0.05)),
        (HERE,),
    )
    mesh = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
    part = Part(
        "peg", mesh, (body,), 0.1, Symmetry(), GraspLibrary((Grasp("top", HERE, 0.04, 0.03),))
    )
    return Cell(
        name,
        robot,
        HERE,
        (arm,),
        Bin(HERE, np.array([0.4, 0.3, 0.2])),
        ScannerMount(HERE),
        controller_by("abb-socket", port=port),
        (part,),
        policy=Policy(approval_minutes=5.0),
    )


@pytest.fixture(scope="session")
def cell() -> Cell:
    return made_cell()


@pytest.fixture(scope="session")
def samples(cell: Cell) -> Samples:
    return Samples(cell)


@pytest.fixture(scope="session")
def make_cell() -> Callable[..., Cell]:
    return made_cell


@pytest.fixture(scope="session")
def in_rows() -> Samples:
    """Samples of a cell that can have rows of plans."""
    return Samples(told_cell())
