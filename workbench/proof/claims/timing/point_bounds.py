"""How fast points of an arm, its tool and the part in its hand get along a leg, bounded from above.

With q(s) as in `fastest`, a point p moves by p'(s) ds/dt.  At a mark p' is known for every point of
a body: its square is convex, so that the corners of the body's hull say all.  Between two marks p'
is off the line between its values there by at most an eighth of h2 |p'''|.  How far joints turn and
how long the arm is bounds |p'''|.  So the greater of two neighbouring marks, each with
that much added, bounds the speed of every point in all of the piece.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats, Ints, Sphere
from workbench.model.plan import Plan
from workbench.proof.claims.stages import MovingArm, MovingStep, find_carried
from workbench.proof.claims.stirring import bodies_of
from workbench.proof.engine.bodies import CheckedBody
from workbench.proof.engine.frames import BodyPoses, poses
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import hull
from workbench.proof.engine.space import arrays_of, chain_of

ALL = slice(None)

SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, slots=True, eq=False)
class Hasty:
    """A body as corners (m, 3) [m] seen from its centre, with balls of a radius [m] around them."""

    number: int
    corners: Floats
    radius: float


class PointBounds:
    """The bodies of a plan, and how fast they get on its legs.

    Concurrency: one thread at a time.
    """

    def __init__(self, cell: Cell, tree: Tree, plan: Plan) -> None:
        self._cell, self._tree, self._plan = cell, tree, plan
        dots = [
            CheckedBody("tool", "", "", arm.name, -1, joint, T * arm.tool.T_flange_tcp, Sphere(0.0))
            for arm in cell.arms
            for joint, T in [tree.flange(arm)]
        ]
        self._tcps = {arm.name: number for number, arm in enumerate(cell.arms)}
        self._bodies = (*dots, *bodies_of(cell, tree, plan))
        self._chain = chain_of(tree)
        self._joint_of = {int(self._chain.columns[j]): j for j in tree.joints}
        self._arrays = arrays_of(self._bodies, np.zeros(len(self._bodies), bool))
        self._hasty = [_hasty(number, body) for number, body in enumerate(self._bodies)]

    def marks(
        self, step: MovingStep, arm_motion: MovingArm, q: Floats, slopes: Floats, widths: Floats
    ) -> tuple[Floats, float]:
        """Bounds (k, 2) [m] of |p'| at marks, of the TCP and of all points: see above.

        And the largest share of them that stands for what lies between the marks.

        Args:
            step: of the plan.
            arm_motion: the leg.
            q: configurations of the arm (k, n) [rad, m].
            slopes: q' there (k, n) [rad, m].
            widths: of the pieces between them (k - 1,); 0 between two that are no piece.
        """
        columns = self._tree.columns[arm_motion.arm.name]
        self._put_parts(step)
        whole, rates = np.tile(step.base, (len(q), 1)), np.zeros((len(q), len(step.base)))
        whole[:, columns] = arm_motion.path[0]
        whole[:, columns[: q.shape[1]]] = q
        rates[:, columns[: q.shape[1]]] = slopes
        carries = np.asarray(self._tree.ancestors[:, columns[: q.shape[1]]].any(axis=1))
        moved = carries[self._arrays.joints]
        world = poses(self._chain, self._arrays, whole, np.zeros_like(whole), moved)
        twists = self._twists(world, rates)
        some = [body for body in self._hasty if moved[body.number]]
        tcp = self._speeds(world, twists, self._hasty[self._tcps[arm_motion.arm.name]], ALL)
        found = tcp.copy()
        # The corners of a box around a body are no slower: most bodies need no more than these.
        boxed = [self._speeds(world, twists, _boxed(body), ALL) for body in some]
        for number in np.argsort([-box.max() for box in boxed]).tolist():
            open_ = np.flatnonzero(boxed[number] > found)
            if len(open_):
                fast = self._speeds(world, twists, some[number], open_)
                found[open_] = np.maximum(found[open_], fast)
        joints = [self._joint_of[int(column)] for column in columns[: q.shape[1]]]
        slides = np.array([self._chain.slides[j] for j in joints])
        extra = _between(slopes, widths, slides, *self._lengths(whole, joints, some))
        most = max(float(found.max()), 1e-12)
        return np.column_stack([tcp, found]) + extra[:, None], float(extra.max()) / most

    def _put_parts(self, step: MovingStep) -> None:
        """Parts in a hand hang on it."""
        where = find_carried(self._cell, self._tree, self._plan, step)
        for number, body in enumerate(self._bodies):
            if body.part >= 0:
                T_world_part = self._plan.detections[body.part].T_world_part
                joint, T = where.get(body.part, (0, T_world_part))
                there: pin.SE3 = T * T_world_part.actInv(body.T_joint_body)
                self._arrays.joints[number] = joint
                self._arrays.turns[number] = there.rotation
                self._arrays.centres[number] = there.act(hull(body.shape).centre)

    def _twists(self, world: BodyPoses, rates: Floats) -> tuple[list[Floats], list[Floats]]:
        """Of each joint (k, 3): how its points at the world's origin move, and how it turns."""
        v, w = [np.zeros((len(rates), 3))], [np.zeros((len(rates), 3))]
        for j in range(1, len(self._chain.parents)):
            before = int(self._chain.parents[j])
            turn = rates[:, int(self._chain.columns[j]), None] * world.axes[:, j]
            if self._chain.slides[j]:
                v.append(v[before] + turn)
                w.append(w[before])
            else:
                v.append(v[before] + _cross(world.places[:, j], turn))
                w.append(w[before] + turn)
        return v, w

    def _speeds(
        self,
        world: BodyPoses,
        twists: tuple[list[Floats], list[Floats]],
        body: Hasty,
        at: Ints | slice,
    ) -> Floats:
        """The greatest |p'| (k,) [m] of a body at marks."""
        v, w = (some[int(self._arrays.joints[body.number])][at] for some in twists)
        v = v + _cross(w, world.centres[at, body.number])
        R = world.turns[at, body.number]
        a, b = np.einsum("kij,ki->kj", R, v), np.einsum("kij,ki->kj", R, w)
        x, y, z = body.corners.T
        parts = (
            a[:, :1] + b[:, 1:2] * z - b[:, 2:] * y,
            a[:, 1:2] + b[:, 2:] * x - b[:, :1] * z,
            a[:, 2:] + b[:, :1] * y - b[:, 1:2] * x,
        )
        fast = np.sqrt((parts[0] ** 2 + parts[1] ** 2 + parts[2] ** 2).max(axis=1))
        return np.asarray(fast + body.radius * np.sqrt((b * b).sum(axis=1)))

    def _lengths(
        self, whole: Floats, joints: list[int], some: list[Hasty]
    ) -> tuple[Floats, Floats]:
        """How far [m] at most it is from each joint (n,) of an arm to the next, and to any point.

        The points are those of the bodies that hang on it before the next one.
        """
        onward, out = np.zeros(len(joints)), np.zeros(len(joints))
        for k in range(len(joints) - 1):
            _, onward[k] = self._down_to(joints[: k + 1], joints[k + 1], whole)
        for body in some:
            far = float(np.linalg.norm(self._arrays.centres[body.number])) + body.radius
            far += float(np.linalg.norm(body.corners, axis=1).max())
            joint = int(self._arrays.joints[body.number])
            if joint not in joints:
                joint, more = self._down_to(joints, joint, whole)
                far += more
            out[joints.index(joint)] = max(out[joints.index(joint)], far)
        return onward, out

    def _down_to(self, joints: list[int], joint: int, whole: Floats) -> tuple[int, float]:
        """The nearest of some joints before a joint, and how far [m] it is at most to that."""
        far = 0.0
        while True:
            far += float(np.linalg.norm(self._chain.places[joint]))
            if self._chain.slides[joint]:
                far += float(np.abs(whole[:, int(self._chain.columns[joint])]).max())
            joint = int(self._chain.parents[joint])
            if joint in joints:
                return joint, far


def _hasty(number: int, body: CheckedBody) -> Hasty:
    convex = hull(body.shape)
    corners = convex.points
    if np.any(convex.box):
        corners = (corners[:, None] + SIGNS * convex.box).reshape(-1, 3)
    return Hasty(number, np.asarray(corners), convex.disc + convex.ball)


def _cross(a: Floats, b: Floats) -> Floats:
    """The cross products of vectors (k, 3)."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )


def _boxed(body: Hasty) -> Hasty:
    """The box around a body, in its own directions."""
    low, high = body.corners.min(axis=0), body.corners.max(axis=0)
    if len(body.corners) <= len(SIGNS):
        return body
    return Hasty(body.number, (low + high) / 2 + SIGNS * (high - low) / 2, body.radius)


def _between(slopes: Floats, widths: Floats, slides: Bools, onward: Floats, out: Floats) -> Floats:
    """What |p'| may be more by (k,) [m] in the pieces on both sides of each mark.

    A point is at the end of a chain of lengths, each turned by the joints before it.  Let w be the
    sum of their rates and c that of their bends.  The first three derivatives of a product of turns
    are at most w, w2 + c and w3 + 3 w c.  A slide has its rate and bend along its own length.
    """
    steep = np.maximum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
    bends = np.abs(np.diff(slopes, axis=0)) / np.where(widths > 0.0, widths, 1.0)[:, None]
    w, c = np.cumsum(steep * ~slides, axis=1), np.cumsum(bends * ~slides, axis=1)
    turned = w**3 + 3 * w * c
    before = np.cumsum(turned * onward, axis=1)
    before = np.column_stack([np.zeros(len(widths)), before[:, :-1]])
    third = (before + turned * out).max(axis=1)
    third += ((3 * (w**2 + c) * steep + 3 * w * bends) * slides).sum(axis=1)
    off = widths**2 / 8 * third
    return np.maximum(np.append(off, 0.0), np.append(0.0, off))
