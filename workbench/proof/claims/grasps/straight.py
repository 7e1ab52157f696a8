"""Whether a hand goes straight."""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.proof.claims.motion import dense_path
from workbench.proof.claims.stages import in_hand, tcp
from workbench.proof.claims.tolerances import OFF_ARC, OFF_LINE, farthest, largest_turn
from workbench.proof.engine.robot import Tree

STRETCH = 256
"""Places of a hand that are checked together."""


def straight_violations(
    tree: Tree,
    arm: Arm,
    leg: str,
    path: Floats,
    way: Floats | None = None,
    *,
    reach: float,
    may_be_off: tuple[float, float] = (OFF_LINE, OFF_ARC),
) -> Iterator[Violation]:
    """Whether a hand goes straight, and, where `way` (3,) [m] in the world is given, that way.

    `may_be_off` [m]: how far the TCP may be off the line at waypoints, and between them.  It backs
    up by no more than the first of them, and turns no more than `largest_turn`.

    `reach` [m] is how far its part extends from the TCP: a long part limits how the hand may turn.

    Joints between two waypoints (m, n) [rad] move in proportion, and the hand then on a curve: it
    is checked so finely that it is less than 0.3 mm off the chord of two neighbours.
    """
    rows, at = dense_path(path)
    start = tcp(tree, tree.rest, arm, rows[0])
    gone = tcp(tree, tree.rest, arm, rows[-1]).translation - start.translation
    if way is not None and np.linalg.norm(gone - way) > OFF_LINE:
        yield Violation(ProofText.OTHER_DIRECTION(), arm.name, leg)
    length = float(np.linalg.norm(gone))
    along = gone / length if length > 0 else gone
    most_along, is_waypoint = -np.inf, np.diff(at, prepend=-1).astype(bool)
    for k in range(0, len(rows), STRETCH):
        poses = [tcp(tree, tree.rest, arm, q) for q in rows[k : k + STRETCH]]
        off = np.array([T.translation for T in poses]) - start.translation
        far = off @ along
        aside = np.linalg.norm(off - far[:, None] * along, axis=1)
        most = np.maximum.accumulate(np.maximum(far, most_along))
        # The cosine of a turn is (trace - 1) / 2.
        turns = np.array([T.rotation for T in poses])
        cosines = (np.einsum("ij,kij->k", start.rotation, turns) - 1.0) / 2.0
        is_off = aside > np.where(is_waypoint[k : k + STRETCH], *may_be_off)
        is_off |= (most - far > may_be_off[0]) | (cosines < np.cos(largest_turn(reach)))
        if is_off.any():
            yield Violation(ProofText.NOT_STRAIGHT(), arm.name, leg, int(at[k + is_off.argmax()]))
            return
        most_along = most[-1]


def part_reach(cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan) -> float:
    """How far [m] the part in a hand extends from the TCP."""
    points = np.asarray(cell.part(plan.detections[arm_plan.detection].part).mesh.points)
    return farthest(points, in_hand(cell, tree, plan, arm_plan).inverse().translation)
