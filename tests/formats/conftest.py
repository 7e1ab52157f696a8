"""Values that files are made of."""

import numpy as np
import pytest

from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import ArmPlan, Guarantee, Leg, Plan, Proof, Step, Strategy, Violation
from workbench.model.scan import Detection


@pytest.fixture(scope="session")
def detections() -> tuple[Detection, ...]:
    return (
        Detection(
            "keyed_cylinder",
            pose_from_rpy([0.41, -0.07, 0.0165], (np.pi / 2, 0, 0.4)),
            score=0.93,
            visible=0.41,
            gap=0.12,
            residual=0.0004,
            roll_known=False,
        ),
        Detection("keyed_cylinder", pose_from_rpy([0.4, 0.07, 0.0165], (1.2, -0.3, -0.6))),
    )


@pytest.fixture(scope="session")
def plan(detections: tuple[Detection, ...]) -> Plan:
    """A plan of the right form; nobody asks here whether an arm could move like that."""
    draw = np.random.default_rng(3)
    arms = tuple(
        ArmPlan(
            arm,
            number,
            "side-1-2",
            pose_from_rpy([0.0, 0.002, 0.031], draw.uniform(-3, 3, 3)),
            tuple(f"{arm}_joint_{k}" for k in range(1, 8)),
            tuple(
                Leg(
                    name,
                    "linear" if name in ("approach", "extract") else "joint",
                    name in ("extract", "return", "place"),
                    0.04,
                    draw.uniform(-2, 2, (5, 7)),
                    np.linspace(0, 1.3, 5),
                )
                for name in LEG_NAMES
            ),
        )
        for number, arm in enumerate(("right", "left"))
    )
    return Plan(
        "yumi",
        "c" * 64,
        "5" * 64,
        7,
        Strategy.ALTERNATED,
        Guarantee.ONE_AT_A_TIME,
        detections,
        arms,
        tuple(Step(((arm.arm, leg.name),)) for arm in arms for leg in arm.legs),
        note="the parts lie 140 mm apart — nearer than the threshold",
        seconds={"resolve": 0.031, "route": 0.02},
    )


@pytest.fixture(scope="session")
def proof(plan: Plan) -> Proof:
    nearest = Violation(
        ProofText.NEAREST(),
        "right",
        "reach",
        3,
        ("right_link_5", "bin_wall_left"),
        0.0074,
        np.zeros(7),
    )
    return Proof(
        plan.digest,
        plan.cell_digest,
        plan.scan_digest,
        4321,
        0.001,
        0.0074,
        nearest,
        (),
        (("right", "reach", np.array([0.02, 0.0074])),),
    )
